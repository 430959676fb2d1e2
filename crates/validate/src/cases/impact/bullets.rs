//! Boxes meet faster than their size in a step.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "bullets",
    group: GROUP,
    title: "Boxes meet faster than their size in a step",
    source: Source::Suite("Jolt's linear casts and speculative contacts"),
    setup: "Boxes of 1 m, 2 m a step at 60 Hz in one sub-step, no gravity; e = 1, where they turn round, and e = 0, where they stop. One at 120 m/s, 45° off a wall, which takes \
            the part of it across; one that is 18 mm over the ground at 60 m/s down, where it stops.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    for (e, name) in [(1.0_f32, "elastic"), (0.0, "inelastic")] {
        let terms = Terms { gravity: Vec3::ZERO, rate: 60.0, ..Terms::FINE };
        let mut stage = rig.stage(terms)?;
        let mut put = |x: f64, v: f32| {
            let thing = Thing::new(cuboid(1.0, 1.0, 1.0), Surface::new(0.0, e), DVec3::X * x);
            stage.put(&thing.moving(Vec3::X * v, Vec3::ZERO))
        };
        let (left, right) = (put(-4.3, 120.0)?, put(4.4, -120.0)?);
        for _ in 0..12 {
            stage.step()?;
        }
        let (a, b) = (stage.velocity(left)?.x, stage.velocity(right)?.x);
        let exact = -120.0 * f64::from(e);
        let reason = "1e-3 of the speed";
        findings
            .near(format!("speed of the left box, {name}"), "m/s", a, (exact, 0.12), reason)
            .near(format!("speed of the right box, {name}"), "m/s", b, (-exact, 0.12), reason)
            .at_most(
                format!("left box right of the right one, {name}"),
                "m",
                stage.position(left)?.x - stage.position(right)?.x,
                -0.98,
                "nobody goes through anybody; 2 % of overlap",
            );
    }
    for (e, name) in [(1.0_f32, "elastic"), (0.0, "inelastic")] {
        let terms = Terms { gravity: Vec3::ZERO, rate: 60.0, ..Terms::FINE };
        let (mut stage, surface) = (rig.stage(terms)?, Surface::new(0.0, e));
        stage.put(&Thing::new(cuboid(1.0, 60.0, 60.0), surface, DVec3::X * 0.5).fixed())?;
        let speed = 120.0 * core::f32::consts::FRAC_1_SQRT_2;
        let thing = Thing::new(cuboid(1.0, 1.0, 1.0), surface, DVec3::new(-3.3, -10.0, 0.0));
        let id = stage.put(&thing.moving(Vec3::new(speed, speed, 0.0), Vec3::ZERO))?;
        for _ in 0..8 {
            stage.step()?;
        }
        let exact = DVec3::new(-f64::from(speed * e), f64::from(speed), 0.0);
        findings.at_most(
            format!("velocity off the exact one, 45° off a wall, {name}"),
            "m/s",
            (stage.velocity(id)? - exact).length(),
            0.12,
            "1e-3 of the speed",
        );
    }
    let terms = Terms { gravity: Vec3::ZERO, rate: 60.0, ..Terms::FINE };
    let mut stage = rig.on_ground(terms, Surface::new(0.0, 0.0))?;
    let thing = Thing::new(cuboid(1.0, 1.0, 1.0), Surface::new(0.0, 0.0), DVec3::Z * 0.518);
    let id = stage.put(&thing.moving(Vec3::Z * -60.0, Vec3::ZERO))?;
    stage.step()?;
    findings.near(
        "height of the box that is stopped within the step",
        "m",
        stage.position(id)?.z,
        (0.5, 1e-3),
        "Jolt's own tolerance",
    );
    Ok(findings)
}
