//! A stone is thrown.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, EngineName, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "projectile",
    group: GROUP,
    title: "A ball is thrown",
    source: Source::ClosedForm("the parabola; Chrono's and Jolt's suites have the same"),
    setup: "A ball at (3, −2, 40) m/s under g = 9.81 m/s² for 10 s at 1 ms, and a cube that falls from 10 m for 2 s at 60 Hz in one sub-step \
            (Jolt's `FreeFall`); and one at (2, 2, 0) m/s under g = 9.80665 m/s² for 1,000 steps of 10 µs (Chrono's `gravity`).",
    engines: ALL,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.5, 0.0);
    let mut stage = rig.stage(Terms::FINE)?;
    let (v, g) = (Vec3::new(3.0, -2.0, 40.0), stage.terms.g());
    let stone = stage.put(&Thing::new(ball(0.1), surface, DVec3::ZERO).moving(v, Vec3::ZERO))?;
    let exact = |t: f64| v.as_dvec3() * t - DVec3::Z * (0.5 * g * t * t);
    let (mut worst, mut off) = (0.0_f64, Vec::new());
    for step in 1..=10_000 {
        stage.step()?;
        let t = f64::from(step) * stage.terms.dt();
        let error = (stage.position(stone)? - exact(t)).length();
        worst = worst.max(error);
        if step % 100 == 0 {
            off.push((t, error));
        }
    }
    let euler = 0.5 * g * 10.0 * stage.terms.dt();
    let side = stage.position(stone)? - exact(10.0);
    let (limit, reason) = if rig.engine == EngineName::SoftStep {
        (
            1e-4,
            "positions are of second order, exact under gravity; 2e-6 of 50 m/s for 10 s by velocities of single precision",
        )
    } else {
        (
            1.05 * euler,
            "semi-implicit Euler ends ½ g T h = 0.049 m lower; 5 % for velocities of single precision",
        )
    };
    let mut findings = Findings::default();
    findings
        .at_most("largest distance from the parabola", "m", worst, limit, reason)
        .beside(&[("ODE", 0.049), ("Bullet", 0.049), ("Simbody", 0.0245), ("DART", 0.049)])
        .at_most(
            "sideways off after 10 s",
            "m",
            side.x.hypot(side.y),
            1e-5,
            "nothing acts sideways; positions are of double precision",
        )
        .draw(
            Figure::linear("Distance from the parabola", "time, s", "distance, m")
                .ours("", off)
                .expected("semi-implicit Euler, ½ g h t", [(0.0, 0.0), (10.0, euler)]),
        );

    let mut stage = rig.stage(Terms { rate: 60.0, ..Terms::FINE })?;
    let cube = Thing::new(crate::stage::cuboid(2.0, 2.0, 2.0), surface, DVec3::Z * 10.0);
    let cube = stage.put(&cube)?;
    stage.seconds(2.0)?;
    findings
        .near(
            "speed of the cube after 2 s",
            "m/s",
            stage.velocity(cube)?.z,
            (-19.62, 1e-4),
            "Jolt's own tolerance",
        )
        .near(
            "height of the cube after 2 s",
            "m",
            stage.position(cube)?.z,
            (10.0 - 19.62, 0.165),
            "the parabola; semi-implicit Euler is ½ g T h = 0.1635 m lower",
        )
        .beside(&[("Jolt", -9.7835)]);

    let gravity = Vec3::Z * -9.80665;
    let mut stage = rig.stage(Terms { gravity, rate: 1e5, ..Terms::FINE })?;
    let v = Vec3::new(2.0, 2.0, 0.0);
    let stone = stage.put(&Thing::new(ball(0.1), surface, DVec3::ZERO).moving(v, Vec3::ZERO))?;
    for _ in 0..1000 {
        stage.step()?;
    }
    let exact = v.as_dvec3() * 0.01 + gravity.as_dvec3() * 5e-5;
    findings.at_most(
        "distance from the parabola after 1,000 steps of 10 µs",
        "m",
        (stage.position(stone)? - exact).length(),
        1e-6,
        "Chrono's own tolerance",
    );
    Ok(findings)
}
