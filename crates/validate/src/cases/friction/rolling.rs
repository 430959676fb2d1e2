//! Sliding turns to rolling, and rolling and twisting friction stop what rolls and spins.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "sliding-to-rolling",
    group: GROUP,
    title: "A ball slides, rolls, and is stopped by rolling friction",
    source: Source::ClosedForm(
        "t = 2 v₀ / (7 μ g), 5/7 v₀, s = 12 v₀² / (49 μ g); and Chrono's rolling_gravity and spinning_gravity",
    ),
    setup: "Ball of radius 0.5 m on the ground, μ = 0.3: thrown at 7 m/s; pushed at 1 m/s with a rolling friction of 0.2 m; spun at 1 rad/s with a \
            twisting friction of 0.2 m. 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.3, 0.0);
    let terms = Terms::FINE;
    let g = terms.g();
    let put = |surface: Surface, v: Vec3, w: Vec3| -> Result<_, Error> {
        let mut stage = rig.on_ground(terms, surface)?;
        let id = stage.put(&Thing::new(ball(0.5), surface, DVec3::Z * 0.5).mass(1.0).moving(v, w))?;
        Ok((stage, id))
    };
    let (mut stage, id) = put(surface, Vec3::X * 7.0, Vec3::ZERO)?;
    let (mut speeds, mut rims) = (Vec::new(), Vec::new());
    let mut start = None;
    for step in 0..1500 {
        stage.step()?;
        let (v, rim) = (stage.velocity(id)?.x, 0.5 * stage.spin(id)?.y);
        if start.is_none() && (v - rim).abs() < 1e-3 {
            start = Some((stage.time(), stage.position(id)?.x));
        }
        if step % 20 == 0 {
            speeds.push((stage.time(), v));
            rims.push((stage.time(), rim));
        }
    }
    let (time, way) = start.unwrap_or((f64::INFINITY, f64::INFINITY));
    let (t, s) = (14.0 / (7.0 * 0.3 * g), 12.0 * 49.0 / (49.0 * 0.3 * g));
    let mut findings = Findings::default();
    findings
        .near("begins to roll", "s", time, (t, 2e-3), "a step, and the slip of 1 mm/s that counts as none")
        .near("way until then", "m", way, (s, 0.01), "5 m/s for two steps")
        .near("speed when it rolls", "m/s", stage.velocity(id)?.x, (5.0, 5e-3), "0.1 %")
        .draw(
            Figure::linear("Speed of the centre and of the rim", "time, s", "speed, m/s")
                .ours("centre", speeds)
                .ours("rim", rims)
                .expected("centre", [(0.0, 7.0), (t, 5.0), (1.5, 5.0)])
                .expected("rim", [(0.0, 0.0), (t, 5.0), (1.5, 5.0)]),
        );
    if rig.engine == crate::EngineName::SoftStep {
        let resists = Surface { rolling: 0.2, twisting: 0.2, ..surface };
        let (mut stage, id) = put(resists, Vec3::X, Vec3::ZERO)?;
        stage.seconds(1.0)?;
        findings.at_most(
            "spin of the pushed ball after 1 s",
            "rad/s",
            stage.spin(id)?.length(),
            1e-3,
            "Chrono's own limit",
        );
        let (mut stage, id) = put(resists, Vec3::ZERO, Vec3::Z)?;
        stage.seconds(4.0)?;
        findings.at_most(
            "spin of the spun ball after 4 s",
            "rad/s",
            stage.spin(id)?.length(),
            1e-3,
            "Chrono's own limit",
        );
        let (mut stage, id) = put(resists, Vec3::ZERO, Vec3::Z * 50.0)?;
        stage.seconds(1.0)?;
        let exact = 50.0 - 0.2 * g / (0.4 * 0.25);
        findings.near(
            "spin of a ball that began with 50 rad/s after 1 s",
            "rad/s",
            stage.spin(id)?.z,
            (exact, 0.01 * exact),
            "1 % of 0.2 m · m g / I",
        );
    }
    Ok(findings)
}
