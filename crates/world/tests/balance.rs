//! Promises of what each step says of its balances: floors carry weights, contacts give no momentum, energy comes from nowhere, friction has its cone;
//! and what breaks them is found.

mod common;

use common::{Stage, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, Integrator, Invariant, Kind, Settings, Shape, StepReport};

const CUBE: Shape = Shape::Box { half: Vec3::splat(0.5) };

/// Free flight of second order.
fn smooth() -> Settings {
    Settings { integrator: Integrator::SecondOrder, ..frames() }
}

fn broken(report: &StepReport) -> Vec<Invariant> {
    Invariant::ALL.into_iter().filter(|&invariant| report.breaks(invariant)).collect()
}

/// A heap of cubes, dropped a little, whose ground is driven sideways at `belt` m/s.
fn heap(settings: Settings, belt: f32) -> (Stage, Vec<StepReport>) {
    let mut stage = Stage::new(settings, rubs(0.5, 0.0));
    let ground = stage.shape(Shape::Box { half: Vec3::new(20.0, 20.0, 1.0) });
    let cube = stage.shape(CUBE);
    let place = Pose::at(DVec3::new(0.0, 0.0, -1.0));
    let body = Body { kind: Kind::Kinematic, velocity: Vec3::X * belt, ..stage.body(ground, place) };
    stage.put(body);
    for i in 0..64 {
        let at = DVec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)) * 1.05;
        let lean = DVec3::new(0.02 * f64::from(i % 3), 0.0, 0.6);
        let body = stage.body(cube, Pose::at(at + lean));
        stage.put(body);
    }
    let reports = (0..240).map(|_| stage.world.step().clone()).collect();
    (stage, reports)
}

#[test]
fn a_heap_breaks_nothing_and_its_floor_carries_its_weight() {
    for settings in [smooth(), frames()] {
        let (_, reports) = heap(settings, 0.0);
        for report in &reports {
            assert_eq!(broken(report), [], "{report:?}");
            assert!(report.momentum_error < 1e-5, "{}", report.momentum_error);
        }
        assert!(reports.iter().any(|report| report.friction_use > 0.9), "nothing slid");
        let last = reports.last().expect("there are steps");
        let weight = 64.0 * 1000.0 * 9.81;
        assert!((last.weight[2] + weight).abs() < 1e-3 * weight, "{:?}", last.weight);
        assert!((last.support[2] - weight).abs() < 1e-3 * weight, "{:?}", last.support);
    }
}

#[test]
fn a_belt_may_give_energy() {
    let (_, reports) = heap(smooth(), 2.0);
    assert!(reports.iter().all(|report| report.energy_gain == 0.0 && broken(report).is_empty()));
    // The cubes were brought to its speed, but for some that roll, by what it gave.
    let pushed: f64 = reports.iter().map(|report| report.support[0] / 60.0).sum();
    let moved = reports.last().expect("there are steps").momentum[0];
    assert!((moved - 128_000.0).abs() < 4e3, "{moved}");
    // The force of a step is that of its last sub-step.
    assert!((pushed / moved - 1.0).abs() < 0.2, "{pushed} {moved}");
}

#[test]
fn energy_from_nowhere_is_found() {
    let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
    let cube = stage.shape(CUBE);
    let body = stage.body(cube, Pose::default());
    stage.put(body);
    let mut found = Vec::new();
    for _ in 0..30 {
        found.extend(broken(stage.world.step()));
    }
    // Half of it is in the ground, and is lifted out of it.
    assert!(found.contains(&Invariant::Energy), "{found:?}");
    assert!(!found.contains(&Invariant::Momentum) && !found.contains(&Invariant::Friction));
}

#[test]
fn what_the_caller_does_is_work() {
    let mut stage = Stage::new(frames(), rubs(0.5, 0.0));
    let cube = stage.shape(CUBE);
    let body = stage.body(cube, Pose::default());
    let id = stage.put(body);
    stage.world.step();
    stage.world.push(id, Vec3::X * 1e5, DVec3::ZERO).expect("a cube is pushed");
    assert!(stage.world.step().kinetic_energy > 1e6);
    assert_eq!(stage.world.report().energy_gain, 0.0);
}

/// A report is made to break each invariant, and only that.
#[test]
fn each_invariant_has_its_limit() {
    let sound = StepReport { kinetic_energy: 100.0, weight: [0.0, 0.0, -1000.0], ..StepReport::default() };
    assert_eq!(broken(&sound), []);
    let off = StepReport { momentum_error: 2e-3, ..sound.clone() };
    assert_eq!(broken(&off), [Invariant::Momentum]);
    // A hundredth of 100 J and two millimetres of 1000 N are let pass.
    let off = StepReport { energy_gain: 2.9, ..sound.clone() };
    assert_eq!(broken(&off), []);
    let off = StepReport { energy_gain: 3.1, ..sound.clone() };
    assert_eq!(broken(&off), [Invariant::Energy]);
    let off = StepReport { friction_use: 1.001, ..sound };
    assert_eq!(broken(&off), [Invariant::Friction]);
}
