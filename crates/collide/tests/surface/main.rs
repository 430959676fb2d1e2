//! Convex shapes on meshes and height fields.

mod against_exact;
#[path = "../common/mod.rs"]
mod common;
mod flat;
mod oracle;
mod relief;
mod rim;
mod terrain;

use common::Random;
use rockfall_collide::{Manifold, convex_mesh};
use rockfall_math::{Isometry, Mat3, Quat, Vec3, rotation, trig};
use rockfall_shape::{Hull, Mesh, Shape};
use std::sync::Arc;

fn at(position: Vec3, turn: Quat) -> Isometry {
    Isometry { rotation: Mat3::from_quat(turn), translation: position }
}

fn about_z(angle: f32) -> Quat {
    rotation::from_rotation_vector(Vec3::Z * angle)
}

/// The closed mesh of a hull.
fn mesh_of(hull: &Hull) -> Mesh {
    let fan = |f: usize| {
        let face = hull.face(f);
        (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]])
    };
    let triangles: Vec<[u32; 3]> = (0..hull.normals.len()).flat_map(fan).collect();
    Mesh::from_triangles(&hull.vertices, &triangles).expect("a hull")
}

fn boulder(seed: u64, radius: f32) -> Shape {
    let mut random = Random(seed);
    let points: Vec<Vec3> = (0..24).map(|_| random.point(1.0).normalize_or(Vec3::X) * radius).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).expect("a boulder")))
}

fn shapes() -> Vec<Shape> {
    vec![
        Shape::Sphere { radius: 0.4 },
        Shape::Capsule { half_length: 0.6, radius: 0.2 },
        Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) },
        boulder(1, 0.5),
    ]
}

/// Those, and shapes that are collided by their support points alone.
fn all_shapes() -> Vec<Shape> {
    let Shape::Hull(hull) = boulder(2, 0.4) else { unreachable!("a boulder is a hull") };
    let mut all = shapes();
    all.extend([
        Shape::Cylinder { half_length: 0.3, radius: 0.4 },
        Shape::Cone { half_length: 0.4, lower: 0.4, upper: 0.0 },
        Shape::Cone { half_length: 0.3, lower: 0.2, upper: 0.5 },
        Shape::Ellipsoid { half: Vec3::new(0.5, 0.4, 0.3) },
        Shape::RoundedBox { half: Vec3::new(0.4, 0.3, 0.2), radius: 0.1 },
        Shape::RoundedHull { hull, radius: 0.15 },
    ]);
    all
}

/// How far the lowest point of a shape is along `out`.
fn lowest_along(shape: &Shape, pose: &Isometry, out: Vec3) -> f32 {
    let point = shape.support(-pose.inverse_vector(out)).expect("a bounded convex shape");
    pose.point(point).dot(out)
}

/// What the points of a disc may hide of the deepest place of its rim.
fn level(shape: &Shape) -> f32 {
    match shape {
        Shape::Cylinder { radius, .. } => 1e-4 * radius,
        Shape::Cone { lower, upper, .. } => 1e-4 * lower.max(*upper),
        _ => 0.0,
    }
}

/// The points that carry the shape, and the radius around them; of a round shape many of its surface.
fn core(shape: &Shape) -> (Vec<Vec3>, f32) {
    match shape {
        Shape::Sphere { radius } => (vec![Vec3::ZERO], *radius),
        Shape::Capsule { half_length, radius } => {
            (vec![Vec3::Z * *half_length, Vec3::Z * -*half_length], *radius)
        }
        Shape::Box { half } => {
            let corners = (0..8).map(|i| {
                let sign = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
                *half * Vec3::new(sign(1), sign(2), sign(4))
            });
            (corners.collect(), 0.0)
        }
        Shape::Hull(hull) => (hull.vertices.clone(), 0.0),
        _ => {
            let towards = (0..32).map(|k| {
                let (sin, cos) = trig::sin_cos(2.4 * k as f32);
                Vec3::new(cos, sin, k as f32 / 16.0 - 1.0)
            });
            (towards.filter_map(|d| shape.support(d)).collect(), 0.0)
        }
    }
}

fn touch(shape: &Shape, mesh: &Mesh, pose: &Isometry, margin: f32) -> Vec<Manifold> {
    let mut out = Vec::new();
    convex_mesh(shape, mesh, &pose.inverse(), margin, &mut out);
    out
}
