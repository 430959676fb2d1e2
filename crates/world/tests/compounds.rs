//! Compounds: bodies of several shapes come to rest, stay there, and hold what they hold.

mod common;

use common::{G, Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Quat, Vec3, rotation};
use rockfall::shape::{Compound, Mesh};
use rockfall::snapshot::{Reader, Writer};
use rockfall::{Body, BodyId, Cast, Filter, Material, Ray, Settings, Shape, Watch};
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

fn compound(parts: Vec<(Shape, Pose)>) -> Shape {
    Shape::Compound(Arc::new(Compound::new(parts).expect("the parts make sense")))
}

fn cuboid(x: f32, y: f32, z: f32) -> Shape {
    Shape::Box { half: Vec3::new(x, y, z) }
}

fn turned(axis: Vec3, angle: f32) -> Quat {
    rotation::from_rotation_vector(axis * angle)
}

/// Three capsules along the axes.
fn jack() -> Shape {
    let rod = Shape::Capsule { half_length: 0.25, radius: 0.08 };
    let along = |rotation: Quat| (rod.clone(), Pose { rotation, ..Pose::default() });
    compound(vec![
        along(Quat::IDENTITY),
        along(turned(Vec3::X, FRAC_PI_2)),
        along(turned(Vec3::Y, FRAC_PI_2)),
    ])
}

/// Two balls and a rod along x.
fn dumbbell() -> Shape {
    let ball = Shape::Sphere { radius: 0.2 };
    let rod = Shape::Cylinder { half_length: 0.4, radius: 0.05 };
    let lying = Pose { rotation: turned(Vec3::Y, FRAC_PI_2), ..Pose::default() };
    compound(vec![(ball.clone(), at(-0.4, 0.0, 0.0)), (rod, lying), (ball, at(0.4, 0.0, 0.0))])
}

/// Two boxes, the corner of the L at the origin.
fn ell() -> Shape {
    compound(vec![(cuboid(0.4, 0.1, 0.1), at(0.3, 0.0, 0.0)), (cuboid(0.1, 0.1, 0.3), at(0.0, 0.0, 0.4))])
}

/// A top on four legs, its feet at z = 0.
fn table() -> Shape {
    let leg = cuboid(0.05, 0.05, 0.35);
    let corners = [(-0.4, -0.25), (0.4, -0.25), (0.4, 0.25), (-0.4, 0.25)];
    let mut parts: Vec<_> = corners.iter().map(|&(x, y)| (leg.clone(), at(x, y, 0.35))).collect();
    parts.push((cuboid(0.5, 0.35, 0.03), at(0.0, 0.0, 0.73)));
    compound(parts)
}

/// Two unit cubes side by side, which touch.
fn pair_of_cubes() -> Shape {
    compound(vec![(cuboid(0.5, 0.5, 0.5), at(-0.5, 0.0, 0.0)), (cuboid(0.5, 0.5, 0.5), at(0.5, 0.0, 0.0))])
}

/// Floors whose top is z = 0, with names: a plane, triangles, and boxes side by side.
fn floors() -> Vec<(&'static str, Shape)> {
    let n = 12;
    let place = |i: u32| i as f32 - 0.5 * n as f32;
    let corners: Vec<Vec3> =
        (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(place(i), place(j), 0.0))).collect();
    let cell = |i: u32, j: u32| {
        let (a, b) = (j * (n + 1) + i, (j + 1) * (n + 1) + i);
        [[a, a + 1, b + 1], [a, b + 1, b]]
    };
    let triangles: Vec<[u32; 3]> = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    let mesh = Mesh::from_triangles(&corners, &triangles).expect("a floor");
    let tile = |k: u32| {
        let place = at(f64::from(place(k % n)) + 0.5, f64::from(place(k / n)) + 0.5, -0.25);
        (cuboid(0.5, 0.5, 0.25), place)
    };
    vec![
        ("plane", Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }),
        ("mesh", Shape::Mesh(Arc::new(mesh))),
        ("tiles", compound((0..n * n).map(tile).collect())),
    ]
}

fn on_floor(floor: &Shape, material: Material) -> Stage {
    let mut stage = Stage::new(frames(), material);
    let shape = stage.shape(floor.clone());
    stage.put(Body::fixed(shape, stage.material, Pose::default()));
    stage
}

/// Speed of the fastest point of a body, m/s.
fn speed(stage: &Stage, id: BodyId) -> f32 {
    let (v, w) = stage.velocity(id);
    v.length() + w.length() * 0.6
}

/// Twice the sine of half the angle between two poses.
fn turn(a: &Pose, b: &Pose) -> f32 {
    let q = rotation::compose(b.rotation, rotation::inverse(a.rotation));
    2.0 * Vec3::new(q.x, q.y, q.z).length()
}

/// Promise: what is dropped comes to rest on a floor of any kind within six seconds and is calm: under 1 mm/s for the next two, not deep in the floor.
#[test]
fn what_is_dropped_comes_to_rest() {
    let shapes = [("jack", jack()), ("dumbbell", dumbbell()), ("L", ell()), ("table", table())];
    for (floor_name, floor) in floors() {
        // Balls would roll for ever.
        let material = Material { rolling_friction: 0.005, twisting_friction: 0.002, ..rubs(0.5, 0.0) };
        let mut stage = on_floor(&floor, material);
        let mut random = Numbers(17);
        let mut ids = Vec::new();
        for (k, (name, shape)) in shapes.iter().enumerate() {
            let shape = stage.shape(shape.clone());
            for j in 0..3_u8 {
                let position = DVec3::new(2.6 * k as f64 - 4.1, 3.0 * f64::from(j) - 3.2, 1.2);
                let body = stage.body(shape, Pose { position, rotation: random.rotation() });
                ids.push((*name, stage.put(body)));
            }
        }
        stage.steps(360);
        let mut fastest = vec![0.0_f32; ids.len()];
        for _ in 0..120 {
            stage.steps(1);
            for (fastest, (_, id)) in fastest.iter_mut().zip(&ids) {
                *fastest = fastest.max(speed(&stage, *id));
            }
        }
        let depth = stage.world.report().deepest_penetration;
        println!("{floor_name}: {fastest:?} depth {depth}");
        for ((name, id), fastest) in ids.iter().zip(fastest) {
            assert!(fastest < 1e-3, "{name} on {floor_name}: {fastest} m/s at {}", stage.position(*id));
            assert!((0.0..0.8).contains(&stage.position(*id).z), "{name} on {floor_name}");
        }
        assert!(depth < 2e-3, "{floor_name}: {depth}");
    }
}

/// Promise: what stands stands still for ten seconds: from the second second on to 10 µm and 10 µrad. Two cubes in one, side by side, a
/// table, a table on a table, an L.
#[test]
fn what_stands_stands_still() {
    for (floor_name, floor) in floors() {
        let mut stage = on_floor(&floor, rubs(0.5, 0.0));
        let mut ids = Vec::new();
        let mut put = |stage: &mut Stage, name: &'static str, shape: Shape, position: DVec3, angle: f32| {
            let shape = stage.shape(shape);
            let pose = Pose { position, rotation: turned(Vec3::Z, angle) };
            ids.push((name, stage.put(stage.body(shape, pose))));
        };
        put(&mut stage, "cubes", pair_of_cubes(), DVec3::new(-3.0, 0.2, 0.5), 0.3);
        put(&mut stage, "table", table(), DVec3::new(0.0, 0.3, 0.0), 0.2);
        put(&mut stage, "table on a table", table(), DVec3::new(0.02, 0.3, 0.76), 0.25);
        put(&mut stage, "L", ell(), DVec3::new(3.0, 0.1, 0.1), 0.4);
        stage.steps(60);
        let before: Vec<Pose> =
            ids.iter().map(|(_, id)| stage.world.pose(*id).expect("it is there")).collect();
        stage.steps(540);
        for ((name, id), before) in ids.iter().zip(&before) {
            let after = stage.world.pose(*id).expect("it is there");
            let (far, turned) = ((after.position - before.position).length(), turn(before, &after));
            println!("{name} on {floor_name}: {far:e} m {turned:e} rad");
            assert!(far < 1e-5 && turned < 1e-5, "{name} on {floor_name}: {far} m, {turned} rad");
        }
    }
}

/// Promise: a dumbbell that is thrown without gravity turns as a body of its closed-form inertia does: about its long axis by the small moment, and
/// its centre goes straight.
#[test]
fn a_compound_turns_about_its_centre_of_mass() {
    let mut stage = Stage::new(Settings { gravity: Vec3::ZERO, ..frames() }, rubs(0.5, 0.0));
    let off_centre = compound(vec![
        (Shape::Sphere { radius: 0.2 }, at(0.0, 0.0, 0.0)),
        (Shape::Sphere { radius: 0.2 }, at(1.0, 0.0, 0.0)),
    ]);
    let shape = stage.shape(off_centre);
    let body = stage.body(shape, at(0.0, 0.0, 0.0));
    let id = stage.put(Body { velocity: Vec3::Y, angular_velocity: Vec3::Z * 3.0, ..body });
    stage.steps(60);
    let pose = stage.world.pose(id).expect("it is there");
    let center = pose.point(Vec3::X * 0.5);
    assert!((center - DVec3::new(0.5, 1.0, 0.0)).length() < 1e-4, "{center}");
    let expected = turned(Vec3::Z, 3.0);
    assert!(turn(&pose, &Pose { rotation: expected, ..pose }) < 1e-3, "{:?}", pose.rotation);
}

/// A pit of four walls with a floor.
fn pit(stage: &mut Stage, floor: &Shape, half: f32) {
    let shape = stage.shape(floor.clone());
    stage.put(Body::fixed(shape, stage.material, Pose::default()));
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
        let wall = stage.shape(Shape::HalfSpace { normal, offset: -half });
        stage.put(Body::fixed(wall, stage.material, Pose::default()));
    }
}

/// `n`³ compounds of four kinds, turned at random, over the floor.
fn crowd(stage: &mut Stage, n: usize, only_jacks: bool) -> Vec<BodyId> {
    let kinds = if only_jacks { vec![jack()] } else { vec![jack(), dumbbell(), ell(), table()] };
    let shapes: Vec<_> = kinds.into_iter().map(|shape| stage.shape(shape)).collect();
    let mut random = Numbers(31);
    let spread = if only_jacks { 0.7 } else { 1.2 };
    let middle = 0.5 * spread * (n - 1) as f64;
    let body = |i: usize| {
        let place = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) * spread;
        let position = place - DVec3::new(middle, middle, -0.8);
        let pose = Pose { position, rotation: random.rotation() };
        Body { id: Some(BodyId(100 + i as u64)), ..stage.body(shapes[i % shapes.len()], pose) }
    };
    let bodies: Vec<Body> = (0..n * n * n).map(body).collect();
    stage.world.spawn_all(bodies).expect("they make sense")
}

/// Promise: a heap of jacks that falls into a pit never gains energy (as `a_pile_never_gains_energy` measures it), nobody falls through the
/// floor, and it comes to rest, hooked into each other.
#[test]
fn a_heap_of_jacks_gains_no_energy_and_holds() {
    for (name, floor) in floors() {
        let settings = Settings { continuous: true, threads: 2, ..frames() };
        let mut stage = Stage::new(settings, rubs(0.5, 0.0));
        pit(&mut stage, &floor, 1.6);
        let ids = crowd(&mut stage, 4, true);
        let h = f64::from(1.0 / (settings.rate * settings.substeps as f32));
        let energy = |stage: &Stage| {
            let r = stage.world.report();
            r.kinetic_energy + r.potential_energy + 0.5 * h * f64::from(G) * r.momentum[2]
        };
        stage.steps(1);
        let start = energy(&stage);
        let (mut lowest, mut gain) = (start, 0.0_f64);
        for _ in 0..480 {
            stage.steps(1);
            let now = energy(&stage);
            gain = gain.max(now - lowest);
            lowest = lowest.min(now);
        }
        let fastest = ids.iter().map(|&id| speed(&stage, id)).fold(0.0, f32::max);
        let least = ids.iter().map(|&id| stage.position(id).z).fold(f64::INFINITY, f64::min);
        let depth = stage.world.report().deepest_penetration;
        println!(
            "{name}: {start} J to {lowest} J, gained {gain} J; {fastest} m/s, lowest {least} m, depth {depth}"
        );
        assert!(gain < 1e-3 * start, "{name}: gained {gain} J of {start}");
        assert!(least > 0.07, "{name}: somebody is at {least} m");
        assert!(fastest < 0.05 && depth < 0.01, "{name}: {fastest} m/s, depth {depth}");
        assert!(stage.all_finite() && stage.world.report().frozen == 0);
    }
}

/// Promise: the same bits for any number of threads and lanes, and for a world that was saved and loaded on the way.
#[test]
fn compounds_have_the_same_bits_everywhere() {
    let build = |threads: usize, lanes: usize| {
        let settings = Settings { threads, lanes, continuous: true, sleeping: true, ..frames() };
        let mut stage = Stage::new(settings, rubs(0.5, 0.1));
        pit(&mut stage, &floors()[1].1, 2.0);
        crowd(&mut stage, 4, false);
        stage
    };
    let mut first = build(1, 1);
    let mut hashes = Vec::new();
    for _ in 0..150 {
        first.steps(1);
        hashes.push(first.world.hash());
    }
    assert!(first.world.report().contacts > 100, "{}", first.world.report().contacts);
    for (threads, lanes) in [(2, 16), (3, 4), (8, 8)] {
        let mut other = build(threads, lanes);
        for (step, hash) in hashes.iter().enumerate() {
            other.steps(1);
            assert_eq!(other.world.hash(), *hash, "{threads} threads, {lanes} lanes, step {step}");
            if step == 70 {
                let mut bytes = Vec::new();
                let mut writer = Writer::new(&mut bytes).expect("memory takes it");
                other.world.save(&mut writer).expect("memory takes it");
                writer.finish().expect("memory takes it");
                other = build(threads, lanes);
                let mut from = &bytes[..];
                let mut reader = Reader::new(&mut from).expect("it was saved");
                other.world.load(&mut reader).expect("it was saved");
                reader.finish().expect("it was saved");
            }
        }
    }
}

/// Promise: fast compounds do not pass through a thin wall, also where one of their parts touches it already.
#[test]
fn fast_compounds_are_stopped_by_thin_walls() {
    let settings = Settings { gravity: Vec3::ZERO, continuous: true, ..frames() };
    for wall in [cuboid(5.0, 5.0, 0.005), compound(vec![(cuboid(5.0, 5.0, 0.005), Pose::default())])] {
        let mut stage = Stage::new(settings, rubs(0.3, 0.0));
        let wall = stage.shape(wall);
        stage.put(Body::fixed(wall, stage.material, Pose::default()));
        let mut random = Numbers(3);
        let shapes = [jack(), ell(), dumbbell()].map(|shape| stage.shape(shape));
        let mut ids = Vec::new();
        for i in 0..24_usize {
            let position =
                DVec3::new((i % 5) as f64 * 1.6 - 3.2, (i / 5) as f64 * 1.6 - 3.2, 1.0 + random.next());
            let body = stage.body(shapes[i % 3], Pose { position, rotation: random.rotation() });
            let velocity = Vec3::NEG_Z * (20.0 + 80.0 * random.next() as f32);
            ids.push(stage.put(Body {
                velocity,
                angular_velocity: random.vector().as_vec3() * 20.0,
                ..body
            }));
        }
        stage.steps(60);
        for id in ids {
            assert!(stage.position(id).z > -0.1, "one is at {}", stage.position(id));
        }
    }
}

/// Promise: rays, shape casts, overlaps and nearest points find a compound's parts, and miss what is between them.
#[test]
fn queries_see_the_parts_and_the_gaps() {
    let mut stage = Stage::new(frames(), rubs(0.5, 0.0));
    let shape = stage.shape(table());
    let id = stage.put(stage.body(shape, at(5.0, 0.0, 0.0)));
    let filter = Filter::default();
    let along = |z: f64, y: f64| Ray::new(DVec3::new(0.0, y, z), Vec3::X);
    assert!(stage.world.cast_ray(&along(0.3, 0.0), &filter).is_none(), "it passes between the legs");
    let leg = stage.world.cast_ray(&along(0.3, 0.25), &filter).expect("a leg");
    assert!(leg.body == id && (leg.distance - 4.55).abs() < 1e-5 && leg.normal == Vec3::NEG_X, "{leg:?}");
    let probe = Shape::Sphere { radius: 0.1 };
    let cast = |y: f64| Cast { pose: at(0.0, y, 0.3), translation: Vec3::X * 10.0 };
    assert_eq!(stage.world.cast_shape(&probe, &cast(0.0), &filter).expect("a good shape"), None);
    let hit = stage.world.cast_shape(&probe, &cast(0.25), &filter).expect("a good shape").expect("a leg");
    assert!((hit.time - 0.445).abs() < 1e-4, "{hit:?}");
    let found =
        stage.world.overlaps(&probe, &[at(5.0, 0.0, 0.3), at(5.0, 0.0, 0.8)], &filter).expect("a good shape");
    assert_eq!((found.get(0), found.get(1)), (&[][..], &[id][..]));
    let near = stage.world.nearest_point(DVec3::new(5.0, 0.0, 0.6), 1.0, &filter).expect("the top");
    assert!((near.distance - 0.1).abs() < 1e-6 && near.normal == Vec3::NEG_Z, "{near:?}");
    // A compound asks as well.
    let frame = compound(vec![
        (cuboid(1.0, 0.1, 0.1), at(0.0, 2.0, 0.0)),
        (cuboid(1.0, 0.1, 0.1), at(0.0, -2.0, 0.0)),
    ]);
    let around = stage.world.overlaps(&frame, &[at(5.0, 0.0, 0.5), at(5.0, 2.0, 0.73)], &filter);
    let around = around.expect("a good shape");
    assert_eq!((around.get(0), around.get(1)), (&[][..], &[id][..]));
}

/// Promise: a compound is in a sensor when a part of it is, a sensor may be a compound, and a compound that lies on the ground by many
/// contacts is one pair that touches, pressed by its weight.
#[test]
fn sensors_and_events_see_compounds() {
    let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
    let shape = stage.shape(table());
    let id = stage.put(stage.body(shape, at(0.0, 0.0, 0.0)));
    let between = stage.cuboid(0.1, 0.1, 0.1);
    let frame = stage.shape(compound(vec![
        (cuboid(0.1, 0.1, 0.1), at(0.0, 0.0, 0.3)),
        (cuboid(0.1, 0.1, 0.1), at(0.4, 0.25, 0.3)),
    ]));
    let free = stage.put(Body { sensor: true, ..Body::fixed(between, stage.material, at(0.0, 0.0, 0.3)) });
    let taken = stage.put(Body { sensor: true, ..Body::fixed(frame, stage.material, at(0.0, 0.0, 0.0)) });
    stage.world.watch(Watch { contacts: true, forces: true, ..Watch::default() }).expect("a good watch");
    stage.steps(120);
    let events = stage.world.events();
    assert!(events.present.iter().any(|p| p.sensor == taken && p.body == id));
    assert!(!events.present.iter().any(|p| p.sensor == free));
    assert_eq!(events.persisting.len(), 1);
    let weight = stage.world.mass(id).expect("it is there") * G;
    let pressed: f32 = events.forces.iter().map(|force| force.normal_force).sum();
    assert!((pressed - weight).abs() < 1e-2 * weight, "{pressed} N of {weight}");
}

/// Promise: what has a part without an inside can't be dynamic, and the error says which.
#[test]
fn a_compound_with_a_surface_is_immovable() {
    let mut stage = Stage::new(frames(), rubs(0.5, 0.0));
    let shape = stage.shape(compound(vec![
        (cuboid(1.0, 1.0, 1.0), Pose::default()),
        (floors()[1].1.clone(), Pose::default()),
    ]));
    let refused = stage.world.spawn(stage.body(shape, Pose::default())).expect_err("it has no inside");
    assert_eq!(refused.to_string(), "a mesh that is not closed can't be dynamic, only static or kinematic");
    stage.put(Body::fixed(shape, stage.material, Pose::default()));
    let ball = stage.ball(0.2);
    let on_box = stage.put(stage.body(ball, at(0.0, 0.0, 1.3)));
    let on_mesh = stage.put(stage.body(ball, at(3.0, 0.3, 0.3)));
    stage.steps(120);
    assert!((stage.position(on_box).z - 1.2).abs() < 2e-3 && (stage.position(on_mesh).z - 0.2).abs() < 2e-3);
}

/// How many of 480 blocks of a shape that is 2 × 1 × 1 m, thrown into a deep pit turned at random, are faster than 5 cm/s after ten seconds.
fn restless(shape: Shape) -> usize {
    let mut stage = Stage::new(Settings { threads: 2, ..frames() }, rubs(0.5, 0.0));
    pit(&mut stage, &floors()[0].1, 4.7);
    let shape = stage.shape(shape);
    let mut random = Numbers(12);
    let bodies: Vec<Body> = (0..480)
        .map(|k| {
            let [x, y] = [k % 4, k / 4 % 4].map(|i| 2.3 * f64::from(i) - 3.45);
            let pose = Pose { rotation: random.rotation(), ..at(x, y, 1.5 + 2.3 * f64::from(k / 16)) };
            stage.body(shape, pose)
        })
        .collect();
    let ids = stage.world.spawn_all(bodies).expect("they make sense");
    // The last fall for three seconds before they arrive.
    stage.steps(180 + 600);
    let deepest = stage.world.report().deepest_penetration;
    let speeds = ids.iter().map(|&id| {
        let (v, w) = stage.velocity(id);
        v.length() + w.length() * 1.2
    });
    let fast = speeds.clone().filter(|&speed| speed > 0.05).count();
    println!(
        "{fast} faster than 5 cm/s, the fastest {} m/s, deepest {deepest} m",
        speeds.fold(0.0, f32::max)
    );
    fast
}

/// Promise: blocks that are compounds of boxes calm down in a deep pile as boxes do. Of two cubes side by side, 11 rattled when their parts alone had a memory, and not the manifold that theirs are merged to.
#[test]
fn blocks_calm_down_in_a_deep_pile() {
    let one = compound(vec![(cuboid(1.0, 0.5, 0.5), Pose::default())]);
    for (name, shape) in [("box", cuboid(1.0, 0.5, 0.5)), ("one box", one), ("two cubes", pair_of_cubes())] {
        let fast = restless(shape);
        assert!(fast <= 2, "{name}: {fast} of 480");
    }
}
