//! Bodies with thousands of neighbours are solved by all threads, and as well as others.

mod common;

use common::{G, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, BodyId, Kind, Settings, Shape};

/// Balls so many along x and y, 0.25 m apart, on the ground, of radius 0.1 m less what `smaller` says, or none; 0.2 m above the ground a slab
/// that covers them.
fn slab_on_balls(
    settings: Settings,
    nx: i32,
    ny: i32,
    smaller: impl Fn(i32, i32) -> Option<f32>,
) -> (Stage, BodyId) {
    let mut stage = Stage::on_ground(settings, rubs(0.6, 0.0));
    for (x, y) in (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y))) {
        if let Some(less) = smaller(x, y) {
            let ball = stage.ball(0.1 - less);
            let place = |i: i32, n: i32| 0.25 * (f64::from(i) - 0.5 * f64::from(n - 1));
            stage.put(stage.body(ball, at(place(x, nx), place(y, ny), f64::from(0.1 - less))));
        }
    }
    let slab = stage.cuboid(0.125 * nx as f32 + 0.1, 0.125 * ny as f32 + 0.1, 0.1);
    let slab = stage.put(stage.body(slab, at(0.0, 0.0, 0.3)));
    (stage, slab)
}

/// The sum of the vertical forces of the contacts on a body, N.
fn lift(stage: &Stage, body: BodyId) -> f32 {
    let on_it = stage.world.contacts().filter(|c| c.a == body || c.b == body);
    on_it.map(|c| c.impulse * if c.b == body { c.normal.z } else { -c.normal.z }).sum::<f32>() * 240.0
}

/// Promise: a slab on 10,000 balls is split, no contact is left to one thread, and the slab is carried: its weight to 0.1 %, at its height
/// to 1 mm.
#[test]
fn a_slab_on_ten_thousand_balls_is_carried_in_parallel() {
    let (mut stage, slab) = slab_on_balls(frames(), 100, 100, |_, _| Some(0.0));
    for _ in 0..100 {
        let report = stage.world.step();
        assert_eq!((report.manifolds, report.split, report.serial), (20_000, 1, 0), "step {}", report.step);
    }
    let weight = stage.world.mass(slab).expect("the slab is there") * G;
    let (z, force) = (stage.position(slab).z, lift(&stage, slab));
    println!("{z} m, {force} of {weight} N");
    assert!((force - weight).abs() < 1e-3 * weight && (z - 0.3).abs() < 1e-3);
}

/// Promise: where three of a thousand neighbours carry a slab and the others are 1 mm away, within the reach of contacts, it lies on the
/// three as on nothing else: as high as without the others, to 0.05 mm.
#[test]
fn few_of_many_neighbours_carry() {
    let run = |all: bool| {
        let (mut stage, slab) = slab_on_balls(frames(), 40, 25, |_, _| all.then_some(5e-4));
        let post = stage.cuboid(0.02, 0.02, 0.1);
        for (x, y) in [(-4.0, -2.0), (4.0, -2.0), (0.125, 2.0)] {
            stage.put(Body::fixed(post, stage.material, at(x, y, 0.1)));
        }
        stage.steps(120);
        assert_eq!(stage.world.report().split, usize::from(all));
        (stage.position(slab).z, stage.world.velocity(slab).expect("the slab is there").0)
    };
    let ((few, few_speed), (many, many_speed)) = (run(false), run(true));
    println!("{few} m, {few_speed} alone, {many} m, {many_speed} among a thousand");
    assert!((many - few).abs() < 5e-5 && (few - 0.3).abs() < 1e-3);
    assert!(few_speed.length() < 1e-3 && many_speed.length() < 1e-3);
}

/// Promise: a slab that slides over a thousand balls in all directions keeps the momentum of both together, but for what gravity
/// and nothing else gives: no ground here.
#[test]
fn split_bodies_keep_momentum() {
    let settings = Settings { gravity: Vec3::ZERO, ..frames() };
    let mut stage = Stage::new(settings, rubs(0.6, 0.0));
    let ball = stage.ball(0.1);
    for i in 0..1000 {
        let (x, y) = (f64::from(i % 40) - 19.5, f64::from(i / 40) - 12.0);
        stage.put(stage.body(ball, at(0.25 * x, 0.25 * y, 0.1)));
    }
    let slab = stage.cuboid(5.0, 3.2, 0.1);
    let mut slab = stage.body(slab, at(0.0, 0.0, 0.3));
    (slab.velocity, slab.angular_velocity) = (Vec3::new(1.0, 0.5, -2.0), Vec3::new(0.0, 0.0, 0.3));
    let slab = stage.put(slab);
    let mass = stage.world.mass(slab).expect("the slab is there");
    let start = Vec3::new(1.0, 0.5, -2.0) * mass;
    for _ in 0..30 {
        let report = stage.world.step();
        let off = (DVec3::from_array(report.momentum) - start.as_dvec3()).length();
        assert!(off < 1e-5 * f64::from(start.length()), "step {}: {off}", report.step);
    }
    assert!(stage.world.report().split <= 1 && stage.all_finite());
    let speed = stage.world.velocity(slab).expect("the slab is there").0;
    assert!(speed.z > -2.0, "the balls have been hit: {speed}");
}

/// Promise: a slab that comes down on a bed, is split, is lifted off, and is whole again leaves nobody behind: counts stay true.
#[test]
fn a_body_is_split_and_made_whole_again() {
    let (mut stage, slab) = slab_on_balls(frames(), 30, 30, |_, _| Some(0.0));
    stage.steps(10);
    assert_eq!(stage.world.report().split, 1);
    stage.world.set_velocity(slab, Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO).expect("the slab is there");
    // Rows, and with them contacts, are sorted every 64 steps.
    stage.steps(60);
    let report = stage.world.report();
    assert_eq!((report.split, report.serial), (0, 0));
    stage.steps(120);
    assert!(stage.all_finite());
    assert_eq!(stage.world.report().split, 1, "the slab has come down again");
}

/// Promise: balls of sizes 1 : 100, poured into a box, come together as well as equal ones: everybody stays in the box, the largest has
/// hundreds of neighbours and is split, no contact is left to one thread, and overlaps are a few percent of the smallest ball on the average.
#[test]
fn sizes_of_one_to_a_hundred_are_poured() {
    let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
    for (normal, offset) in [(Vec3::X, -1.5), (Vec3::NEG_X, -1.5), (Vec3::Y, -1.5), (Vec3::NEG_Y, -1.5)] {
        let wall = stage.shape(Shape::HalfSpace { normal, offset });
        stage.put(Body::fixed(wall, stage.material, Pose::default()));
    }
    let mut balls = Vec::new();
    // Layers of one size each, the largest lowest; so many balls that each layer holds a like volume.
    let mut z = 0.0;
    for (radius, n) in [(1.0_f32, 1), (0.1, 12), (0.03, 40), (0.01, 60)] {
        let ball = stage.ball(radius);
        let pitch = 2.9 / n as f64;
        z += f64::from(radius);
        for i in 0..n * n {
            let place = |i: i32| pitch * (f64::from(i) - 0.5 * f64::from(n - 1));
            balls.push(stage.put(stage.body(ball, at(place(i % n), place(i / n), z))));
        }
        z += 1.2 * f64::from(radius);
    }
    let (mut split, mut serial) = (0, 0);
    for _ in 0..240 {
        let report = stage.world.step();
        (split, serial) = (split.max(report.split), serial.max(report.serial));
    }
    let report = stage.world.report();
    println!("{report:?}");
    assert!(split > 0 && serial == 0 && stage.all_finite());
    for ball in balls {
        let p = stage.position(ball);
        assert!(p.z > 0.0 && p.x.abs() < 1.5 && p.y.abs() < 1.5, "{p}");
    }
    assert!(report.mean_penetration < 5e-4, "{}", report.mean_penetration);
}

/// Promise: a plane that moves, whose size is infinite, carries what lies on it.
#[test]
fn a_plane_that_moves_carries() {
    let mut stage = Stage::new(frames(), rubs(0.6, 0.0));
    let plane = stage.shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
    let velocity = Vec3::new(0.0, 0.0, 0.5);
    let still = Body::fixed(plane, stage.material, Pose::default());
    stage.put(Body { kind: Kind::Kinematic, velocity, ..still });
    let ball = stage.ball(0.1);
    let ball = stage.put(stage.body(ball, at(0.0, 0.0, 0.1)));
    stage.steps(60);
    let z = stage.position(ball).z;
    assert!((z - 0.6).abs() < 1e-2, "{z}");
}
