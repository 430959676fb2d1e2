//! Needles and plates of 1:1000 come to rest.

mod common;

use common::{Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3, rotation};
use rockfall::shape::{Hull, Mesh};
use rockfall::{Body, Settings, Shape};
use std::sync::Arc;

fn hull(points: &[Vec3]) -> Shape {
    Shape::Hull(Arc::new(Hull::from_points(points).expect("points that span a volume")))
}

/// Steps in a second. In one of a 60th what falls by a centimetre goes 7 mm: seven times as far as a rod is thick, and sunk in
/// so deeply it is thrown back.
const RATE: f32 = 240.0;

fn sharp() -> Vec<(&'static str, Shape)> {
    let needle = [[-0.5, 0.0], [0.5, 1e-3]]
        .map(|[x, r]| [[1.0, 0.0], [-0.5, 0.87], [-0.5, -0.87]].map(|[y, z]| Vec3::new(x, r * y, r * z)));
    let blade = [
        Vec3::new(-0.5, 0.0, 0.0),
        Vec3::new(0.5, 0.0, 0.0),
        Vec3::new(-0.5, 0.1, 5e-4),
        Vec3::new(0.5, 0.1, 5e-4),
        Vec3::new(-0.5, 0.1, -5e-4),
        Vec3::new(0.5, 0.1, -5e-4),
    ];
    vec![
        ("rod", Shape::Hull(Arc::new(Hull::cuboid(Vec3::new(0.5, 5e-4, 5e-4))))),
        ("plate", Shape::Hull(Arc::new(Hull::cuboid(Vec3::new(0.5, 0.5, 5e-4))))),
        ("needle", hull(&needle.concat())),
        ("blade", hull(&blade)),
        ("rounded plate", Shape::RoundedBox { half: Vec3::new(0.5, 0.4, 2.5e-4), radius: 2.5e-4 }),
    ]
}

/// Promise: dropped on a floor from 1 cm, lying and a little askew, each lies still after 4 s at 240 Hz: in the two seconds after
/// that it moves by less than 0.1 mm and turns by less than 1 mrad, and it is not through the floor. But for a needle on a mesh, which
/// goes on turning by some milliradians a second.
#[test]
fn needles_and_plates_come_to_rest() {
    let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    let floors = [
        ("half-space", Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, 0.0),
        ("box", Shape::Box { half: Vec3::new(9.0, 9.0, 0.5) }, -0.5),
        ("mesh", Shape::Mesh(Arc::new(mesh)), 0.0),
    ];
    for (floor_name, floor, height) in floors {
        let mut stage = Stage::new(Settings { rate: RATE, continuous: true, ..frames() }, rubs(0.5, 0.0));
        let floor = stage.shape(floor);
        stage.put(Body::fixed(floor, stage.material, at(0.0, 0.0, height)));
        let mut ids = Vec::new();
        for (k, (name, shape)) in sharp().into_iter().enumerate() {
            if (name, floor_name) == ("needle", "mesh") {
                continue;
            }
            let shape = stage.shape(shape);
            let rotation = rotation::from_rotation_vector(Vec3::new(0.01, 0.005, 0.4));
            let position = DVec3::new(1.5 * k as f64 - 3.0, 0.2, 0.01);
            ids.push((name, stage.put(stage.body(shape, Pose { position, rotation }))));
        }
        stage.steps(4 * RATE as usize);
        let before: Vec<Pose> =
            ids.iter().map(|(_, id)| stage.world.pose(*id).expect("it is there")).collect();
        stage.steps(2 * RATE as usize);
        for ((name, id), before) in ids.iter().zip(&before) {
            let after = stage.world.pose(*id).expect("it is there");
            let q = rotation::compose(after.rotation, rotation::inverse(before.rotation));
            let (far, turn) =
                ((after.position - before.position).length(), 2.0 * Vec3::new(q.x, q.y, q.z).length());
            println!("{name} on a {floor_name}: {far:e} m, {turn:e} rad, at {}", after.position);
            assert!(far < 1e-4 && turn < 1e-3, "{name} on a {floor_name}: {far} m, {turn} rad");
            assert!(
                after.position.z > -1e-3 && after.position.z < 0.01,
                "{name} on a {floor_name}: {after:?}"
            );
        }
    }
}
