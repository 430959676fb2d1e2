//! Floors of triangles, which have to be like the plane that they are in.

use crate::common::Random;
use crate::{about_z, all_shapes, at, core, level, lowest_along, shapes, touch};
use rockfall_collide::Manifold;
use rockfall_math::{Isometry, Quat, Vec2, Vec3, rotation, trig};
use rockfall_shape::{Mesh, Shape};

/// A grid of cells × cells squares of the given side around the origin, corners moved sideways by up to `jitter`
/// sides, in the plane z = 0.
fn floor(cells: u32, side: f32, jitter: f32) -> Mesh {
    let mut random = Random(5);
    let samples = cells + 1;
    let vertices: Vec<Vec3> = (0..samples * samples)
        .map(|k| {
            let (i, j) = (k % samples, k / samples);
            let inner = i > 0 && j > 0 && i < cells && j < cells;
            let push = if inner {
                Vec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) * jitter
            } else {
                Vec2::ZERO
            };
            let half = 0.5 * cells as f32;
            Vec3::new((i as f32 - half + push.x) * side, (j as f32 - half + push.y) * side, 0.0)
        })
        .collect();
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * samples + i;
            let [b, c, d] = [a + 1, a + samples + 1, a + samples];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a floor")
}

/// Floors of very fine, middling and very coarse triangles, regular and not.
fn floors() -> Vec<Mesh> {
    vec![
        floor(60, 0.1, 0.0),
        floor(12, 0.5, 0.0),
        floor(12, 0.5, 0.35),
        floor(2, 3.0, 0.0),
        floor(2, 1000.0, 0.0),
    ]
}

/// The contacts must be those on the half-space z ≤ 0: one manifold, straight up, with the depths of the shape's own
/// points, and with every point of the shape that is among the lowest inside what the manifold spans.
fn check_like_half_space(what: &str, shape: &Shape, pose: &Isometry, manifolds: &[Manifold], margin: f32) {
    let (points, radius) = core(shape);
    let lowest = lowest_along(shape, pose, Vec3::Z);
    if lowest > margin {
        assert!(manifolds.is_empty(), "{what}: contact out of reach");
        return;
    }
    assert_eq!(manifolds.len(), 1, "{what}: {manifolds:#?}");
    let manifold = &manifolds[0];
    let up = pose.vector(-manifold.normal);
    assert!((up - Vec3::Z).length() < 1e-5, "{what}: normal {up}");
    let off = (manifold.deepest() - lowest).abs();
    assert!(off < 1e-5 + level(shape), "{what}: {} is not {lowest}", manifold.deepest());
    let placed: Vec<Vec3> = manifold.points().iter().map(|p| pose.point(p.position)).collect();
    for (p, q) in manifold.points().iter().zip(&placed) {
        assert!((q.z - 0.5 * p.distance).abs() < 1e-5, "{what}: a point at {q} for depth {}", p.distance);
    }
    for &p in &points {
        let p = pose.point(p);
        if p.z - radius < lowest + 1e-4 {
            // Within the span: no direction in the plane has it further out than all points of the manifold.
            for k in 0..16 {
                let (sin, cos) = trig::sin_cos(k as f32 * 0.4);
                let out = Vec3::new(cos, sin, 0.0);
                let reach = placed.iter().map(|q| q.dot(out)).fold(f32::NEG_INFINITY, f32::max);
                assert!(p.dot(out) < reach + 1e-5 || points.len() > 8, "{what}: {p} hangs over");
            }
        }
    }
}

#[test]
fn a_floor_of_triangles_is_a_plane() {
    let mut random = Random(2);
    for mesh in &floors() {
        for shape in &all_shapes() {
            let (points, _) = core(shape);
            for round in 0..60 {
                let turn = match round % 3 {
                    0 => about_z(random.between(0.0, 6.0)),
                    1 => rotation::compose(about_z(0.3 * round as f32), rotation::between(Vec3::Z, Vec3::X)),
                    _ => random.turn(),
                };
                // Over corners and edges of the triangles, and anywhere.
                let mut over = match round % 4 {
                    0 => mesh.vertices[mesh.vertices.len() / 2],
                    1 => {
                        0.5 * (mesh.triangle(mesh.triangles.len() / 2)[0]
                            + mesh.triangle(mesh.triangles.len() / 2)[2])
                    }
                    _ => random.point(1.0),
                };
                over = over.clamp(Vec3::splat(-1.0), Vec3::splat(1.0));
                let corner = points[round % points.len()];
                if round % 2 == 0 {
                    over -= rotation::rotate(turn, corner);
                }
                over.z = 0.0;
                let mut pose = at(over, turn);
                let lowest = lowest_along(shape, &pose, Vec3::Z);
                pose.translation.z = random.between(-0.06, 0.02) - lowest;
                let what = format!("round {round}, {} triangles, {shape:?}, {pose:?}", mesh.triangles.len());
                check_like_half_space(&what, shape, &pose, &touch(shape, mesh, &pose, 0.01), 0.01);
            }
        }
    }
}

#[test]
fn a_box_on_triangles_has_the_four_corners_that_it_has_on_a_plane() {
    let half = Vec3::new(0.5, 0.4, 0.3);
    let shape = Shape::Box { half };
    for mesh in &floors() {
        for k in 0..50 {
            let turn = about_z(0.13 * k as f32);
            let pose = at(Vec3::new(0.05 * k as f32 - 1.25, 0.02 * k as f32 - 0.5, 0.299), turn);
            let manifolds = touch(&shape, mesh, &pose, 0.01);
            assert_eq!(manifolds.len(), 1);
            assert_eq!(manifolds[0].count, 4);
            for x in [-0.5, 0.5] {
                for y in [-0.4, 0.4] {
                    let corner = Vec3::new(x, y, -0.2995);
                    let found = manifolds[0]
                        .points()
                        .iter()
                        .any(|p| p.position.distance(corner) < 1e-5 && (p.distance + 0.001).abs() < 1e-5);
                    assert!(found, "{corner} at {k}: {:#?}", manifolds[0]);
                }
            }
        }
    }
}

/// Promise: what has sunk in by a line or by a point touches there only, not where its sides go through other triangles of the same floor.
#[test]
fn what_rolls_on_triangles_touches_where_it_does_on_a_plane() {
    let lying = rotation::between(Vec3::Z, Vec3::Y);
    let cylinder = Shape::Cylinder { half_length: 0.3, radius: 0.4 };
    let ellipsoid = Shape::Ellipsoid { half: Vec3::new(0.3, 0.5, 0.4) };
    let ends = [-0.3, 0.3].map(|y| Vec3::new(0.0, y, -0.3995));
    for (shape, turn, expected) in
        [(cylinder, lying, &ends[..]), (ellipsoid, Quat::IDENTITY, &[Vec3::Z * -0.3995])]
    {
        for mesh in &floors() {
            for k in 0..50 {
                let turn = rotation::compose(about_z(0.13 * k as f32), turn);
                let pose = at(Vec3::new(0.05 * k as f32 - 1.25, 0.02 * k as f32 - 0.5, 0.399), turn);
                let manifolds = touch(&shape, mesh, &pose, 0.01);
                assert_eq!(manifolds.len(), 1);
                let points = manifolds[0].points();
                let what = format!("{} at {k} on {} triangles", shape.name(), mesh.triangles.len());
                assert_eq!(points.len(), expected.len(), "{what}: {points:#?}");
                for &p in expected {
                    let heading = about_z(0.13 * k as f32);
                    let p = rotation::rotate(heading, p) + pose.translation;
                    let found = points.iter().any(|q| {
                        pose.point(q.position).distance(p) < 1e-4 && (q.distance + 0.001).abs() < 1e-5
                    });
                    assert!(found, "{what}: {p}, {points:#?}");
                }
            }
        }
    }
}

#[test]
fn a_sliding_body_feels_no_seams() {
    for mesh in &floors()[..3] {
        for (k, shape) in all_shapes().iter().enumerate() {
            // Hundreds of small triangles under one body take milliseconds.
            let stride = if k >= shapes().len() && mesh.triangles.len() > 5000 { 8 } else { 1 };
            for tilt in [0.0, 1e-4, 3e-3, 0.03, 0.2] {
                let lean = rotation::from_rotation_vector(Vec3::new(tilt, 0.7 * tilt, 0.4));
                let mut pose = at(Vec3::ZERO, lean);
                let lowest = lowest_along(shape, &pose, Vec3::Z);
                for k in (0..200).step_by(stride) {
                    let t = k as f32 * 0.0074;
                    pose.translation = Vec3::new(t - 0.7, 0.31 * t, -lowest - 0.003);
                    let what = format!("step {k}, tilt {tilt}, {}", shape.name());
                    check_like_half_space(&what, shape, &pose, &touch(shape, mesh, &pose, 0.02), 0.02);
                }
            }
        }
    }
}

#[test]
fn corners_keep_their_names_while_they_slide() {
    let mesh = floor(12, 0.5, 0.35);
    let shape = Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) };
    let names = |x: f32| {
        let manifolds = touch(&shape, &mesh, &at(Vec3::new(x, 0.1, 0.299), about_z(0.2)), 0.01);
        let mut names: Vec<u32> = manifolds[0].points().iter().map(|p| p.feature).collect();
        names.sort_unstable();
        names
    };
    let first = names(0.0);
    assert!(first.windows(2).all(|pair| pair[0] != pair[1]));
    for k in 1..100 {
        assert_eq!(names(0.01 * k as f32), first);
    }
}
