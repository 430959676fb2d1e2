//! The promises of ray casts, shape casts, overlaps and distances of points.

mod cast;
#[path = "../common/mod.rs"]
mod common;
mod point;
mod ray;

use common::Random;
use parry3d::math::{Pose, Rotation};
use parry3d::shape::SharedShape;
use rockfall_math::{Isometry, Vec2, Vec3};
use rockfall_shape::{HeightField, Hull, Mesh, Shape};
use std::sync::Arc;

fn boulder(seed: u64) -> Hull {
    let mut random = Random(seed);
    let points: Vec<Vec3> =
        (0..24).map(|_| random.point(1.0).normalize_or(Vec3::X) * random.between(0.5, 1.0)).collect();
    Hull::from_points(&points).expect("a boulder")
}

fn convex() -> Vec<Shape> {
    vec![
        Shape::Sphere { radius: 0.7 },
        Shape::Box { half: Vec3::new(0.4, 0.9, 0.6) },
        Shape::Capsule { half_length: 0.6, radius: 0.3 },
        Shape::Capsule { half_length: 0.0, radius: 0.5 },
        Shape::Hull(Arc::new(boulder(1))),
        Shape::Hull(Arc::new(boulder(2))),
    ]
}

/// Those that `parry3d` lacks or has along another axis.
fn turned_on_a_lathe() -> Vec<Shape> {
    vec![
        Shape::Cylinder { half_length: 0.5, radius: 0.7 },
        Shape::Cone { half_length: 0.8, lower: 0.6, upper: 0.0 },
        Shape::Cone { half_length: 0.3, lower: 0.4, upper: 0.9 },
        Shape::Ellipsoid { half: Vec3::new(0.4, 0.9, 0.6) },
        Shape::RoundedBox { half: Vec3::new(0.3, 0.7, 0.5), radius: 0.15 },
        Shape::RoundedHull { hull: Arc::new(boulder(1)), radius: 0.1 },
    ]
}

/// A hull as a closed mesh.
fn mesh_of(hull: &Hull) -> Mesh {
    let mut triangles = Vec::new();
    for f in 0..hull.normals.len() {
        let face = hull.face(f);
        triangles.extend((2..face.len()).map(|k| [face[0], face[k - 1], face[k]]));
    }
    Mesh::from_triangles(&hull.vertices, &triangles).expect("a closed mesh")
}

/// A closed surface with dents.
fn star() -> Mesh {
    let mut random = Random(77);
    let mut vertices = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..3 {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |vertices: &mut Vec<Vec3>, a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [d, e, f] =
                    [middle(&mut vertices, a, b), middle(&mut vertices, b, c), middle(&mut vertices, c, a)];
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    for v in &mut vertices {
        *v *= random.between(0.7, 1.3);
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a star")
}

fn terrain(columns: u32, rows: u32, height: f32) -> HeightField {
    let mut random = Random(5);
    let heights = (0..columns * rows).map(|_| random.between(0.0, height)).collect();
    HeightField::new(columns, rows, Vec2::new(0.5, 0.3), heights).expect("a terrain")
}

/// The same surface as triangles; triangle k of the one is triangle k of the other.
fn mesh_of_field(field: &HeightField) -> Mesh {
    let at = |i: u32, j: u32| j * field.columns + i;
    let vertices: Vec<Vec3> = field.samples().collect();
    let mut triangles = Vec::new();
    for j in 0..field.rows - 1 {
        for i in 0..field.columns - 1 {
            let (a, b) = (at(i, j), at(i + 1, j + 1));
            triangles.extend([[a, at(i + 1, j), b], [a, b, at(i, j + 1)]]);
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a terrain")
}

fn parry(shape: &Shape) -> SharedShape {
    match shape {
        Shape::Sphere { radius } => SharedShape::ball(*radius),
        Shape::Capsule { half_length, radius } => SharedShape::capsule_z(*half_length, *radius),
        Shape::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
        Shape::Hull(hull) => SharedShape::convex_hull(&hull.vertices).expect("a hull"),
        Shape::HalfSpace { normal, offset } => {
            assert_eq!(*offset, 0.0, "parry3d has none");
            SharedShape::halfspace(*normal)
        }
        Shape::Mesh(mesh) => {
            SharedShape::trimesh(mesh.vertices.clone(), mesh.triangles.clone()).expect("a mesh")
        }
        Shape::HeightField(field) => parry(&Shape::Mesh(Arc::new(mesh_of_field(field)))),
        _ => panic!("parry3d is not asked about a {}", shape.name()),
    }
}

fn parry_pose(pose: &Isometry) -> Pose {
    Pose::from_parts(pose.translation, Rotation::from_mat3(&pose.rotation))
}
