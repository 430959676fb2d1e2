//! Two balls meet head-on.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "head-on",
    group: GROUP,
    title: "Two balls meet head-on",
    source: Source::Suite("Chrono's cor_normal; Jolt's ElasticDynamic and MinVelocityForRestitution"),
    setup: "Balls of radius 0.5 m, 1 kg, 1 m/s towards each other, e from 0 to 1; of radius 1 m at 5 and −10 m/s, e = 1; 1 m/s on one at rest, e = 1 and \
            restitution from 0.99 and 1.01 m/s on. No gravity, 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Velocities along x afterwards, m/s.
fn meet(rig: &Rig, threshold: f32, radius: f32, [a, b]: [f32; 2], e: f32) -> Result<[f64; 2], Error> {
    let terms = Terms { gravity: Vec3::ZERO, threshold, ..Terms::FINE };
    let mut stage = rig.stage(terms)?;
    let mut put = |x: f32, v: f32| {
        let thing = Thing::new(ball(radius), Surface::new(0.0, e), DVec3::X * f64::from(x)).mass(1.0);
        stage.put(&thing.moving(Vec3::X * v, Vec3::ZERO))
    };
    let (left, right) = (put(-1.25 * radius, a)?, put(1.25 * radius, b)?);
    stage.seconds(f64::from(radius / (a - b)) + 0.25)?;
    Ok([stage.velocity(left)?.x, stage.velocity(right)?.x])
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut curve = Vec::new();
    for e in [0.0_f32, 0.25, 0.5, 0.75, 1.0] {
        let [a, b] = meet(rig, 0.1, 0.5, [1.0, -1.0], e)?;
        findings.near(
            format!("share of the approach that comes back, e = {e}"),
            "",
            0.5 * (b - a),
            (f64::from(e), 1e-3),
            "Chrono's own tolerance",
        );
        curve.push((f64::from(e), 0.5 * (b - a)));
    }
    let rounding = "Jolt's own tolerance, 1e-5 of the approach";
    let [a, b] = meet(rig, 0.1, 1.0, [5.0, -10.0], 1.0)?;
    findings.near("first of 5 and −10 m/s afterwards", "m/s", a, (-10.0, 1.5e-4), rounding);
    findings.near("second of 5 and −10 m/s afterwards", "m/s", b, (5.0, 1.5e-4), rounding);
    // `impulse` bounces whatever the speed, as the report has it.
    if rig.engine == crate::EngineName::SoftStep {
        for (threshold, exact) in [(0.99, 1.0), (1.01, 0.5)] {
            let [_, b] = meet(rig, threshold, 1.0, [1.0, 0.0], 1.0)?;
            findings.near(
                format!("speed of the one that was hit, threshold {threshold} m/s"),
                "m/s",
                b,
                (exact, 1e-5),
                rounding,
            );
        }
    }
    findings.draw(
        Figure::linear("Share of the approach that comes back", "coefficient of restitution", "share")
            .ours("", curve)
            .expected("e", [(0.0, 0.0), (1.0, 1.0)]),
    );
    Ok(findings)
}
