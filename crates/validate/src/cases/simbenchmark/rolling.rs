//! A force drags a plate over the ground with 25 balls on it: how round is the friction cone?

use super::GROUP;
use super::sweep::Run;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings, Points};
use crate::stage::{Rig, ball, cuboid};
use rockfall::math::{DVec3, Vec3};

const BASE: Case = Case {
    name: "rolling-y",
    group: GROUP,
    title: "A plate with 25 balls is dragged along y",
    source: Source::Published("SimBenchmark, rolling"),
    setup: "Box 20 × 20 × 1 m, 10 kg, friction 0.4 on the ground; 25 balls of radius 0.5 m, 1 kg, friction 0.8 on the box; 150 N on the \
            box; 4 s at 1 ms. The mean over the steps of |v_ball − exact|² + |v_box − exact|². Standing still scores 3.146.",
    engines: WITH_FRICTION,
    long: false,
    run: |rig| run(rig, 0),
};

pub(super) const CASES: [Case; 2] = [
    BASE,
    Case {
        name: "rolling-60",
        title: "A plate with 25 balls is dragged at 60° to x",
        run: |rig| run(rig, 1),
        ..BASE
    },
];

/// Along y, and at 60° to x, N.
const FORCES: [Vec3; 2] = [Vec3::new(0.0, 150.0, 0.0), Vec3::new(75.0, 129.904, 0.0)];

/// Error, m²/s², by direction.
const PUBLISHED: [&[(&str, f64)]; 2] = [
    &[("RaiSim", 4.13e-7), ("Bullet", 4.93e-9), ("ODE", 7.67e-9), ("MuJoCo", 2.4e-3), ("DART", 0.426)],
    &[("RaiSim", 4.14e-7), ("Bullet", 5.71e-9), ("ODE", 3.145), ("MuJoCo", 2.45e-3), ("DART", 3.145)],
];

/// What came of dragging the plate.
struct Drag {
    /// The mean square error of both velocities, m²/s².
    run: Run,
    /// Of the plate's velocity off the force, degrees.
    astray: f64,
    /// Of the plate, and what it should be, m/s².
    acceleration: [f64; 2],
    /// What the balls' should be, m/s².
    on_balls: f64,
    /// Speeds of the plate and of the first ball along the force.
    curves: [Points; 2],
}

fn run(rig: &Rig, direction: usize) -> Result<Findings, Error> {
    let Drag { run, astray, acceleration: [a, expected], on_balls, curves: [plates, balls] } =
        drag(rig, direction)?;
    let mut findings = Findings::default();
    findings
        .at_most(
            "mean square error of both velocities",
            "m²/s²",
            run.error,
            1e-6,
            "an exact cone leaves rounding; the best published is 5e-9",
        )
        .beside(PUBLISHED[direction])
        .at_most(
            "direction of the box off the force's",
            "°",
            astray,
            0.01,
            "a round cone has no direction of its own; a pyramid errs by degrees",
        )
        .near("acceleration of the box", "m/s²", a, (expected, 1e-3 * expected), "0.1 % over 4 s")
        .draw(
            Figure::linear("Speed along the force", "time, s", "speed, m/s")
                .ours("box", plates)
                .ours("ball", balls)
                .expected("box, exact", [(0.0, 0.0), (4.0, 4.0 * expected)])
                .expected("ball, exact", [(0.0, 0.0), (4.0, 4.0 * on_balls)]),
        );
    Ok(findings)
}

/// The mean square error of both velocities, m²/s², along y (0) or at 60° (1).
pub(super) fn roll(rig: &Rig, direction: usize) -> Result<Run, Error> {
    Ok(drag(rig, direction)?.run)
}

fn drag(rig: &Rig, direction: usize) -> Result<Drag, Error> {
    let force = FORCES[direction];
    let mut stage = rig.on_ground(Terms::FINE, Surface::new(0.4, 0.0))?;
    let plate = Thing::new(cuboid(20.0, 20.0, 1.0), Surface::new(0.4, 0.0), DVec3::new(0.0, 0.0, 0.5 - 2e-5));
    let plate = stage.put(&plate.mass(10.0))?;
    let mut first = None;
    for i in 0..25 {
        let place = DVec3::new((i % 5) as f64, (i / 5) as f64, 0.0) * 2.0;
        let place = place + DVec3::new(-4.0, -4.0, 1.5 - 6e-5);
        let id = stage.put(&Thing::new(ball(0.5), Surface::new(0.8, 0.0), place).mass(1.0))?;
        first.get_or_insert(id);
    }
    let first = first.unwrap_or(plate);

    // Friction on the ground f₁ = μ₁ (M + n m) g, on each ball f₂ = (F − f₁) / M / (3.5 / m + n / M).
    let (mass, n, g, f) = (10.0, 25.0, stage.terms.g(), f64::from(force.length()));
    let dragged = f - 0.4 * (mass + n) * g;
    let on_ball = dragged / mass / (3.5 + n / mass);
    let (a_ball, a_plate) = (on_ball, 3.5 * on_ball);
    let along = force.as_dvec3().normalize();

    let dt = stage.terms.dt();
    let steps = stage.terms.steps_in(4.0);
    let (mut sum, mut plates, mut balls) = (0.0, Vec::new(), Vec::new());
    for step in 0..steps {
        let t = step as f64 * dt;
        let (v_ball, v_plate) = (stage.velocity(first)?, stage.velocity(plate)?);
        sum += (v_ball - along * (a_ball * t)).length_squared();
        sum += (v_plate - along * (a_plate * t)).length_squared();
        if step % 100 == 0 {
            plates.push((t, v_plate.dot(along)));
            balls.push((t, v_ball.dot(along)));
        }
        stage.push(plate, force * dt as f32)?;
        stage.step()?;
    }
    let v = stage.velocity(plate)?;
    let astray = libm::atan2(v.cross(along).length(), v.dot(along)).to_degrees();
    Ok(Drag {
        run: Run { error: sum / steps as f64, processor: stage.processor() },
        astray,
        acceleration: [v.dot(along) / (steps as f64 * dt), a_plate],
        on_balls: a_ball,
        curves: [plates, balls],
    })
}
