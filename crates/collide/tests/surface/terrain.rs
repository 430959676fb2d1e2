//! Rough ground, as a mesh and as a height field.

use crate::common::{Random, at_size};
use crate::{all_shapes, at, touch};
use rockfall_collide::{Manifold, convex_height_field};
use rockfall_math::{Vec2, Vec3};
use rockfall_shape::{HeightField, Mesh, Shape};

/// Gentle random hills.
pub(crate) fn hills(columns: u32, spacing: f32, roughness: f32, seed: u64) -> HeightField {
    let mut random = Random(seed);
    let heights = (0..columns * columns).map(|_| random.between(-0.5, 0.5) * roughness * spacing).collect();
    HeightField::new(columns, columns, Vec2::splat(spacing), heights).expect("hills")
}

pub(crate) fn as_mesh(field: &HeightField) -> Mesh {
    let vertices: Vec<Vec3> = field.samples().collect();
    let mut triangles = Vec::new();
    for j in 0..field.rows - 1 {
        for i in 0..field.columns - 1 {
            let a = j * field.columns + i;
            let c = a + field.columns + 1;
            triangles.extend([[a, a + 1, c], [a, c, c - 1]]);
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("hills")
}

#[test]
fn a_height_field_collides_like_its_mesh() {
    let mut random = Random(21);
    let field = hills(24, 0.3, 0.8, 4);
    let mesh = as_mesh(&field);
    let mut contacts = 0;
    for shape in &all_shapes() {
        for _ in 0..300 {
            let over = random.point(2.0);
            let ground = field.height_at(over.x, over.y).expect("over the field");
            let pose = at(Vec3::new(over.x, over.y, ground + random.between(0.2, 0.7)), random.turn());
            let by_mesh = touch(shape, &mesh, &pose, 0.02);
            let mut by_field = Vec::new();
            convex_height_field(shape, &field, &pose.inverse(), 0.02, &mut by_field);
            let summary = |list: &[Manifold]| {
                let mut list: Vec<(i32, u32)> =
                    list.iter().map(|m| ((m.deepest() * 1e4).round() as i32, m.count)).collect();
                list.sort_unstable();
                list
            };
            contacts += by_mesh.len();
            // Deep points are treated otherwise where all below is solid: also those of a sharp rim that went through a ridge.
            let shallow = |list: &[Manifold]| list.iter().all(|m| m.deepest() > -0.02);
            let sharp = matches!(shape, Shape::Cylinder { .. } | Shape::Cone { .. });
            if shallow(&by_mesh) && (!sharp || shallow(&by_field)) {
                assert_eq!(summary(&by_mesh), summary(&by_field), "{shape:?} {pose:?}");
            }
        }
    }
    assert!(contacts > 500);
}

#[test]
fn a_surface_a_thousand_times_larger_or_smaller_has_the_same_contacts() {
    let mut random = Random(23);
    let mesh = as_mesh(&hills(9, 0.5, 0.6, 4));
    for by in [1e-3, 1e3] {
        let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| *v * by).collect();
        let other = Mesh::from_triangles(&vertices, &mesh.triangles).expect("hills");
        let mut met = 0;
        for shape in &all_shapes() {
            let scaled = at_size(shape, by);
            for _ in 0..60 {
                let turn = random.turn();
                let place = random.point(1.2).with_z(random.between(0.2, 0.7));
                let here = touch(shape, &mesh, &at(place, turn), 0.05);
                let there = touch(&scaled, &other, &at(place * by, turn), 0.05 * by);
                let deepest = |manifolds: &[Manifold]| {
                    manifolds.iter().fold(f32::INFINITY, |low, m| low.min(m.deepest()))
                };
                let (depth, scaled_depth) = (deepest(&here), deepest(&there) / by);
                if here.is_empty() || there.is_empty() {
                    // At the margin rounding decides.
                    assert!(
                        depth.min(scaled_depth) > 0.05 - 1e-4,
                        "{} {place} {depth} {scaled_depth}",
                        shape.name()
                    );
                    continue;
                }
                met += 1;
                let off = (depth - scaled_depth).abs();
                assert!(off < 1e-4, "{} at {place}: {depth} is {scaled_depth}", shape.name());
            }
        }
        assert!(met > 100, "{met}");
    }
}

#[test]
fn whatever_is_below_a_height_field_is_pushed_up() {
    let mut random = Random(31);
    let field = hills(24, 0.3, 0.8, 4);
    for shape in &all_shapes() {
        for _ in 0..200 {
            let over = random.point(2.0);
            let pose = at(Vec3::new(over.x, over.y, random.between(-50.0, -0.3)), random.turn());
            let mut manifolds = Vec::new();
            convex_height_field(shape, &field, &pose.inverse(), 0.02, &mut manifolds);
            assert!(!manifolds.is_empty(), "{shape:?} {pose:?} fell for ever");
            assert!(manifolds.iter().all(|m| pose.vector(-m.normal).z > 0.3));
            let deepest = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
            assert!(deepest < 0.3 * pose.translation.z + 0.5);
        }
    }
}
