//! What no engine may make from nothing: energy and momentum.

mod common;

use common::{Numbers, Stage, fine, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::Hull;
use rockfall::{Body, Integrator, Material, Settings, Shape, ShapeId};
use std::sync::Arc;

/// One of each convex shape, about half a metre across.
fn shapes(stage: &mut Stage) -> Vec<ShapeId> {
    let mut random = Numbers(77);
    let points: Vec<Vec3> = (0..24).map(|_| random.vector().as_vec3().normalize() * 0.3).collect();
    let hull = Hull::from_points(&points).expect("the points span a hull");
    vec![
        stage.ball(0.25),
        stage.cuboid(0.3, 0.2, 0.25),
        stage.shape(Shape::Capsule { half_length: 0.2, radius: 0.15 }),
        stage.shape(Shape::Hull(Arc::new(hull))),
    ]
}

/// `n`³ bodies of mixed shapes, turned at random, 0.8 m apart, the lowest 0.5 m above z = 0.
fn crowd(stage: &mut Stage, n: usize, seed: u64, speed: f32) {
    let shapes = shapes(stage);
    let mut random = Numbers(seed);
    for i in 0..n * n * n {
        let place = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) * 0.8;
        let middle = DVec3::new(0.4 * (n - 1) as f64, 0.4 * (n - 1) as f64, -0.5);
        let pose = Pose { position: place - middle, rotation: random.rotation() };
        let body = stage.body(shapes[i % shapes.len()], pose);
        let velocity = random.vector().as_vec3() * speed;
        stage.put(Body { velocity, angular_velocity: random.vector().as_vec3() * speed, ..body });
    }
}

/// Four walls around the origin, 2 × `half` metres apart, and the ground.
fn pit(stage: &mut Stage, half: f32) {
    stage.plane(Vec3::Z);
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
        let shape = stage.shape(Shape::HalfSpace { normal, offset: -half });
        stage.put(Body::fixed(shape, stage.material, Pose::default()));
    }
}

/// Promise: a random pile that falls into a pit (e = 0; with and without friction) never gains energy: kinetic plus potential of
/// any step is at most that of any step before, to 0.1 % of the energy it started with. Energy is that of the leapfrog
/// scheme, E − ½ h g · p (p the momentum), which a free flight keeps; E itself swings by that term in every bounce.
#[test]
fn a_pile_never_gains_energy() {
    for (friction, rate) in [(0.0, 60.0), (0.6, 60.0), (0.6, 240.0)] {
        let settings = Settings { rate, ..frames() };
        let mut stage = Stage::new(settings, rubs(friction, 0.0));
        pit(&mut stage, 2.2);
        crowd(&mut stage, 5, 5, 1.0);
        let h = f64::from(1.0 / (settings.rate * settings.substeps as f32));
        let energy = |stage: &Stage| {
            let r = stage.world.report();
            r.kinetic_energy + r.potential_energy + 0.5 * h * f64::from(common::G) * r.momentum[2]
        };
        stage.steps(1);
        let start = energy(&stage);
        let (mut lowest, mut gain) = (start, 0.0_f64);
        for _ in 0..(4.0 * settings.rate) as usize {
            stage.steps(1);
            let now = energy(&stage);
            gain = gain.max(now - lowest);
            lowest = lowest.min(now);
        }
        let rest = stage.world.report().kinetic_energy;
        println!("μ {friction} {rate} Hz: {start} J to {lowest} J, gained {gain} J, moves with {rest} J");
        assert!(gain < 1e-3 * start, "gained {gain} J of {start}");
        assert!(lowest < 0.6 * start, "it has fallen");
        assert!(stage.all_finite() && stage.world.report().frozen == 0);
    }
}

/// Promise: a crowd that collides in free space (e from 0 to 1, friction and rolling friction on) keeps its linear momentum to 1e-5 and its
/// angular momentum about the origin to 1 %, both of the sum of the single ones, and never gains kinetic energy beyond
/// 0.1 %. (Angular: arms are those of the start of the step, so that a step of h errs by v h in an arm.)
#[test]
fn collisions_in_free_space_keep_momentum() {
    for e in [0.0, 0.5, 1.0] {
        let settings = Settings { gravity: Vec3::ZERO, ..frames() };
        let material = Material { rolling_friction: 0.01, twisting_friction: 0.01, ..rubs(0.5, e) };
        let mut stage = Stage::new(settings, material);
        crowd(&mut stage, 4, 11, 2.0);
        // Everyone flies inwards.
        for (id, pose) in stage.world.ids().into_iter().zip(stage.world.poses()) {
            let (v, w) = stage.velocity(id);
            let inwards = (DVec3::Z * 1.7 - pose.position).as_vec3() * 2.0;
            stage.world.set_velocity(id, v + inwards, w).expect("the body is there");
        }
        stage.steps(1);
        let sizes: (f64, f64) = stage.world.ids().iter().fold((0.0, 0.0), |(p, l), &id| {
            let mass = f64::from(stage.world.mass(id).expect("the body is there"));
            let momentum = stage.velocity(id).0.as_dvec3() * mass;
            (p + momentum.length(), l + stage.position(id).cross(momentum).length())
        });
        let first = stage.world.report().clone();
        let (mut lowest, mut gain) = (first.kinetic_energy, 0.0_f64);
        for _ in 0..180 {
            stage.steps(1);
            let now = stage.world.report().kinetic_energy;
            gain = gain.max(now - lowest);
            lowest = lowest.min(now);
        }
        let last = stage.world.report();
        let off = |a: [f64; 3], b: [f64; 3]| (DVec3::from_array(a) - DVec3::from_array(b)).length();
        let linear = off(last.momentum, first.momentum) / sizes.0;
        let angular = off(last.angular_momentum, first.angular_momentum) / sizes.1;
        let (start, end) = (first.kinetic_energy, last.kinetic_energy);
        println!("e {e}: linear {linear:e}, angular {angular:e}, {start} J to {end} J, gained {gain} J");
        assert!(linear < 1e-5 && angular < 1e-2, "{linear} {angular}");
        assert!(gain < 1e-3 * start, "gained {gain} J of {start}");
        assert!(end < 0.95 * start, "nobody met");
    }
}

/// Promise: 64 elastic balls that fall onto each other and the ground keep their energy to 0.1 % where restitution goes on until nothing bounces, and
/// not where it is one sweep.
#[test]
fn elastic_balls_that_meet_at_once_keep_their_energy() {
    let lost = [1, 64].map(|bounce_sweeps| {
        let integrator = Integrator::SecondOrder;
        let settings = Settings { bounce_sweeps, integrator, restitution_threshold: 0.0, ..fine() };
        let mut stage = Stage::on_ground(settings, rubs(0.0, 1.0));
        let ball = stage.ball(0.1);
        let mut random = Numbers(42);
        for i in 0..64 {
            let place = DVec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)) * 0.21;
            let place = place + random.vector() * 1e-3 + DVec3::Z * 0.6;
            stage.put(stage.body(ball, Pose::at(place)));
        }
        stage.steps(1);
        let start = stage.total_energy();
        stage.steps(1500);
        (1.0 - stage.total_energy() / start).abs()
    });
    println!("one sweep loses {:e} of the energy, many {:e}", lost[0], lost[1]);
    assert!(lost[1] < 1e-3 && lost[0] > 4.0 * lost[1], "{lost:?}");
}

#[test]
fn the_energy_of_all_is_the_sum_of_that_of_each() {
    let mut stage = Stage::new(frames(), rubs(0.6, 0.0));
    stage.plane(Vec3::Z);
    crowd(&mut stage, 3, 9, 2.0);
    stage.steps(20);
    let (each, all) = (stage.world.kinetic_energies(), stage.world.report().kinetic_energy);
    assert_eq!((each.len(), each[0]), (28, 0.0));
    assert!(each[1..].iter().all(|&energy| energy > 0.0));
    assert!((each.iter().sum::<f64>() / all - 1.0).abs() < 1e-12);
}

/// Promise: a column of elastic balls that meets the ground and itself, all of it in a few steps, keeps its energy to 1e-4 of it, as the second-order
/// integrator does in free flight: with as many sweeps of restitution as it takes, and without sub-steps.
#[test]
fn a_column_that_bounces_keeps_its_energy() {
    let settings = Settings {
        integrator: Integrator::SecondOrder,
        bounce_sweeps: 500,
        restitution_threshold: 0.0,
        ..fine()
    };
    let mut stage = Stage::on_ground(settings, rubs(0.0, 1.0));
    let ball = stage.ball(0.1);
    for i in 0..8 {
        stage.put(stage.body(ball, Pose::at(DVec3::Z * (1.1 + 0.201 * f64::from(i)))));
    }
    stage.steps(1);
    let start = stage.total_energy();
    let mut worst = 0.0_f64;
    for _ in 0..2000 {
        stage.steps(1);
        worst = worst.max((stage.total_energy() / start - 1.0).abs());
    }
    println!("{start} J, off by {worst} of it");
    assert!(worst < 1e-4, "off by {worst}");
}
