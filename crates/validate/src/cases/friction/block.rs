//! A block on a slope: it stays where μ ≥ tan θ, and slides with g (sin θ − μ cos θ) where not.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings, Points};
use crate::stage::{Rig, Slope, cuboid};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "block-on-slope",
    group: GROUP,
    title: "A block on a slope",
    source: Source::ClosedForm("sticks where μ ≥ tan θ, else a = g (sin θ − μ cos θ)"),
    setup: "Block 1 × 1 × 0.5 m on slopes of 20° and 30°, at 1 ms and at 60 Hz in four sub-steps. The least μ at which it moves by less than 1 mm in \
            two seconds, after half a second in which it settles, by bisection; the acceleration with μ = 0.2 between 0.5 and 1.5 s.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// How far it gets in the two seconds after the first half, and what it gains in the first of them.
fn slide(rig: &Rig, terms: Terms, degrees: f64, mu: f64) -> Result<(f64, f64, Points), Error> {
    let slope = Slope::new(degrees.to_radians());
    let surface = Surface::new(mu as f32, 0.0);
    let mut stage = rig.stage(terms)?;
    stage.plane(slope.normal, surface)?;
    let block = stage.put(&Thing::new(cuboid(1.0, 1.0, 0.5), surface, DVec3::ZERO).pose(slope.pose(0.25)))?;
    stage.seconds(0.5)?;
    let (place, speed) = (stage.position(block)?, stage.velocity(block)?);
    let mut curve = Vec::new();
    for _ in 0..20 {
        stage.seconds(0.05)?;
        curve.push((stage.time() - 0.5, (stage.velocity(block)? - speed).dot(slope.down)));
    }
    let gained = (stage.velocity(block)? - speed).dot(slope.down);
    stage.seconds(1.0)?;
    Ok(((stage.position(block)? - place).length(), gained, curve))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Speed gained on 30° with μ = 0.2", "time, s", "speed, m/s");
    for (terms, name) in [(Terms::FINE, "1 ms"), (Terms::FRAMES, "60 Hz")] {
        for degrees in [20.0_f64, 30.0] {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let limit = sin / cos;
            let found = Search::around(limit).least(|mu| Ok(slide(rig, terms, degrees, mu)?.0 < 1e-3))?;
            findings.near(
                format!("least μ that holds at {degrees}°, {name}"),
                "",
                found,
                (limit, 0.01 * limit),
                "1 %, the aim of the project; the search itself is good to 0.1 %",
            );
            let (_, a, curve) = slide(rig, terms, degrees, 0.2)?;
            let exact = terms.g() * (sin - 0.2 * cos);
            findings.near(
                format!("acceleration at {degrees}°, {name}"),
                "m/s²",
                a,
                (exact, 1e-3 * exact),
                "0.1 %",
            );
            if degrees == 30.0 {
                figure = figure.ours(name, curve);
            }
        }
    }
    let exact = Terms::FINE.g() * (0.5 - 0.2 * libm::sqrt(0.75));
    findings.draw(figure.expected("g (sin θ − μ cos θ) t", [(0.0, 0.0), (1.0, exact)]));
    Ok(findings)
}
