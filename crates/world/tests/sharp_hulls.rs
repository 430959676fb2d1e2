//! Needles and plates of 1:1000, and heaps of coins, come to rest.

mod common;

use common::{Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3, rotation, trig};
use rockfall::shape::{Hull, Mesh};
use rockfall::{Body, BodyId, Material, Settings, Shape};
use std::f32::consts::TAU;
use std::sync::Arc;

fn hull(points: &[Vec3]) -> Shape {
    Shape::Hull(Arc::new(Hull::from_points(points).expect("points that span a volume")))
}

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
    let (rod, plate) = (Vec3::new(0.5, 5e-4, 5e-4), Vec3::new(0.5, 0.5, 5e-4));
    vec![
        ("rod", Shape::Box { half: rod }),
        ("rod of a hull", Shape::Hull(Arc::new(Hull::cuboid(rod)))),
        ("plate", Shape::Box { half: plate }),
        ("plate of a hull", Shape::Hull(Arc::new(Hull::cuboid(plate)))),
        ("needle", hull(&needle.concat())),
        ("blade", hull(&blade)),
        ("rounded plate", Shape::RoundedBox { half: Vec3::new(0.5, 0.4, 2.5e-4), radius: 2.5e-4 }),
    ]
}

/// A half-space, a box and a mesh whose tops are at z = 0, and where their shapes lie.
fn floors() -> [(&'static str, Shape, f64); 3] {
    let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    [
        ("half-space", Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, 0.0),
        ("box", Shape::Box { half: Vec3::new(9.0, 9.0, 0.5) }, -0.5),
        ("mesh", Shape::Mesh(Arc::new(mesh)), 0.0),
    ]
}

fn stage_on(floor: Shape, height: f64, rate: f32) -> Stage {
    let mut stage = Stage::new(Settings { rate, continuous: true, ..frames() }, rubs(0.5, 0.0));
    let floor = stage.shape(floor);
    stage.put(Body::fixed(floor, stage.material, at(0.0, 0.0, height)));
    stage
}

/// The fastest that each body is in so many steps, m/s and rad/s.
fn fastest(stage: &mut Stage, ids: &[BodyId], steps: usize) -> Vec<[f32; 2]> {
    let mut fastest = vec![[0.0_f32; 2]; ids.len()];
    for _ in 0..steps {
        stage.steps(1);
        for (most, id) in fastest.iter_mut().zip(ids) {
            let (v, w) = stage.velocity(*id);
            *most = [most[0].max(v.length()), most[1].max(w.length())];
        }
    }
    fastest
}

/// Promise: dropped on a floor from 1 cm, lying and a little askew, each lies still after 4 s, at 60 Hz as at 240: in the two seconds after
/// that it moves by less than 0.1 mm and turns by less than 1 mrad, no faster than 0.1 mm/s and 0.05 rad/s, which is 25 µm/s at the surface of a rod; it is not through the floor,
/// and nothing was frozen on the way. But for a needle on a mesh, which trembles about its axis by 1 rad/s.
#[test]
fn needles_and_plates_come_to_rest() {
    for rate in [60.0, 240.0] {
        for (floor_name, floor, height) in floors() {
            let mut stage = stage_on(floor, height, rate);
            let (mut names, mut ids) = (Vec::new(), Vec::new());
            for (k, (name, shape)) in sharp().into_iter().enumerate() {
                if (name, floor_name) == ("needle", "mesh") {
                    continue;
                }
                let shape = stage.shape(shape);
                let rotation = rotation::from_rotation_vector(Vec3::new(0.01, 0.005, 0.4));
                let position = DVec3::new(1.5 * k as f64 - 4.5, 0.2, 0.01);
                ids.push(stage.put(stage.body(shape, Pose { position, rotation })));
                names.push(name);
            }
            stage.steps(4 * rate as usize);
            let before: Vec<Pose> =
                ids.iter().map(|id| stage.world.pose(*id).expect("it is there")).collect();
            let fastest = fastest(&mut stage, &ids, 2 * rate as usize);
            assert_eq!(stage.world.report().frozen, 0, "on a {floor_name} at {rate} Hz");
            for (k, id) in ids.iter().enumerate() {
                let after = stage.world.pose(*id).expect("it is there");
                let q = rotation::compose(after.rotation, rotation::inverse(before[k].rotation));
                let far = (after.position - before[k].position).length();
                let turn = 2.0 * Vec3::new(q.x, q.y, q.z).length();
                let [v, w] = fastest[k];
                let what = format!(
                    "{} on a {floor_name} at {rate} Hz: {v:.1e} m/s, {w:.1e} rad/s, {far:.1e} m, {turn:.1e} rad, {after:?}",
                    names[k]
                );
                println!("{what}");
                assert!(v < 1e-4 && w < 0.05, "{what}");
                assert!(far < 1e-4 && turn < 1e-3, "{what}");
                assert!(after.position.z > -1e-3 && after.position.z < 0.01, "{what}");
            }
        }
    }
}

/// Twenty that fall on each other from up to 6 m onto a box: what is measured while they do.
struct Heap {
    frozen: usize,
    /// Over the energy at the start.
    energy: f64,
    /// m/s.
    fastest: f32,
    /// Of the middle of a body, metres.
    lowest: f64,
    /// Of a point of a body in the last second, m/s: the fastest of each, in order.
    late: Vec<f32>,
}

fn heap(shape: &Shape, flat: bool, seed: u64, rate: f32, seconds: usize) -> Heap {
    let (_, floor, height) = floors()[1].clone();
    let mut stage = stage_on(floor, height, rate);
    let shape = stage.shape(shape.clone());
    let mut numbers = Numbers(seed * 1000);
    let ids: Vec<BodyId> = (0..20)
        .map(|k| {
            let v = numbers.vector();
            let any = numbers.rotation();
            let askew = rotation::from_rotation_vector((numbers.vector() * 0.6).as_vec3());
            let position = DVec3::new(0.5 * v.x, 0.5 * v.y, 0.6 + 0.27 * f64::from(k));
            stage.put(stage.body(shape, Pose { position, rotation: if flat { askew } else { any } }))
        })
        .collect();
    stage.steps(1);
    let start = stage.total_energy();
    let mut heap = Heap { frozen: 0, energy: 0.0, fastest: 0.0, lowest: f64::INFINITY, late: vec![0.0; 20] };
    let steps = seconds * rate as usize;
    for step in 0..steps {
        stage.steps(1);
        heap.energy = heap.energy.max(stage.total_energy() / start);
        for (k, &id) in ids.iter().enumerate() {
            let (v, w) = stage.velocity(id);
            heap.fastest = heap.fastest.max(v.length());
            heap.lowest = heap.lowest.min(stage.position(id).z);
            if step + rate as usize >= steps {
                let along = rotation::rotate(stage.rotation(id), Vec3::X);
                let across =
                    0.5 * w.cross(along).length() + if flat { 0.5 } else { 5e-4 } * w.dot(along).abs();
                heap.late[k] = heap.late[k].max(v.length() + across);
            }
        }
    }
    heap.frozen = stage.world.report().frozen;
    heap.late.sort_by(f32::total_cmp);
    heap
}

/// A coin of 10 cm with a round rim of 3 cm, of 32 corners.
fn coin() -> Shape {
    let rim = (0..39).flat_map(|i| (0..64).map(move |k| (i, k))).map(|(i, k)| {
        let (up, out) = trig::sin_cos(TAU * i as f32 / 39.0);
        let (y, x) = trig::sin_cos(TAU * k as f32 / 64.0);
        let radius = 0.035 + 0.015 * out;
        Vec3::new(radius * x, radius * y, 0.015 * up)
    });
    Shape::Hull(Arc::new(Hull::from_points_at_most(&rim.collect::<Vec<_>>(), 32).expect("a coin")))
}

/// Promise: coins that are poured into a well, thirty layers, come to lie: they don't press each other in by more than half of their thickness, and don't go on
/// rocking (1 J), as they did while deep overlaps were held at one spot.
#[test]
fn coins_come_to_rest_in_a_well() {
    let settings = Settings { substeps: 4, threads: 2, sleeping: false, ..Settings::default() };
    let mut stage = Stage::new(settings, Material::default());
    let walls = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y].map(|normal| (normal, -0.185));
    for (normal, offset) in walls.into_iter().chain([(Vec3::Z, 0.0)]) {
        let wall = stage.shape(Shape::HalfSpace { normal, offset });
        stage.put(Body::fixed(wall, stage.material, Pose::default()));
    }
    let shape = stage.shape(coin());
    let mut numbers = Numbers(1000);
    for k in 0..270_u32 {
        let place = [k % 3, k / 3 % 3, k / 9].map(f64::from);
        let position = DVec3::new(0.11 * (place[0] - 1.0), 0.11 * (place[1] - 1.0), 0.08 + 0.11 * place[2]);
        let rotation = numbers.rotation();
        stage.put(stage.body(shape, Pose { position, rotation }));
    }
    stage.steps(600);
    let report = stage.world.report();
    let (energy, deepest) = (report.kinetic_energy, report.deepest_penetration);
    println!("{energy:.1e} J, {:.1} mm", 1e3 * deepest);
    assert!(energy < 1e-2 && deepest < 0.018, "{energy} J, {deepest} m");
}

/// Promise: of twenty rods, plates, needles or blades that fall on each other nobody is frozen, all together never have more energy than when they
/// began to fall, and nobody moves much faster than one that falls freely from the highest place, 10.6 m/s; the middle of none is farther in the floor than 0.1 m, or on its way
/// through it.
#[test]
fn heaps_of_needles_and_plates_gain_no_energy() {
    for (name, shape) in sharp() {
        if !["rod of a hull", "plate of a hull", "needle", "blade"].contains(&name) {
            continue;
        }
        for seed in 1..=3 {
            let flat = ["plate of a hull", "blade"].contains(&name);
            let Heap { frozen, energy, fastest, lowest, .. } = heap(&shape, flat, seed, 60.0, 3);
            let what = format!(
                "{name}, seed {seed}: {frozen} frozen, {energy} of the energy, {fastest} m/s, {lowest} m"
            );
            println!("{what}");
            assert!(frozen == 0 && energy < 1.001 && fastest < 12.0 && lowest > -0.1, "{what}");
        }
    }
}

/// Heaps of which somebody goes faster than 5 mm/s after ten seconds.
fn restless(names: &[&'static str]) -> Vec<(&'static str, u64)> {
    let mut restless = Vec::new();
    for (name, shape) in sharp().into_iter().filter(|(name, _)| names.contains(name)) {
        for seed in 1..=3 {
            let flat = ["plate of a hull", "blade"].contains(&name);
            let late = heap(&shape, flat, seed, 60.0, 12).late;
            println!("{name}, seed {seed}: {:.1e} m/s, half of them {:.1e}", late[19], late[9]);
            if late[19] >= 5e-3 {
                restless.push((name, seed));
            }
        }
    }
    restless
}

/// Promise: twenty rods that fall on each other are at rest after ten seconds.
#[test]
fn heaps_of_rods_come_to_rest() {
    assert_eq!(restless(&["rod of a hull"]), []);
}

#[test]
#[ignore = "missed at 60 Hz: plates go on at 8 to 78 mm/s, in one heap of three a needle at 10 and a blade at 40"]
fn heaps_of_needles_and_plates_come_to_rest() {
    assert_eq!(restless(&["plate of a hull", "needle", "blade"]), []);
}
