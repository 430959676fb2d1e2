//! Bricks lean out as far as they can.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "overhang",
    group: GROUP,
    title: "A stack of bricks leans out over the edge",
    source: Source::ClosedForm("half the harmonic number, in lengths of a brick"),
    setup: "n bricks 1 × 0.5 × 0.2 m, μ = 0.6, the lowest on a table; the k-th from the top leans out by f / (2 k) over what is below it. The largest f at which \
            nothing falls by 5 cm in 4 s, by bisection, at 240 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// How far the top brick falls, m.
fn fall(rig: &Rig, n: u32, f: f64) -> Result<f64, Error> {
    let surface = Surface::new(0.6, 0.0);
    let mut stage = rig.stage(Terms { rate: 240.0, substeps: 4, ..Terms::FINE })?;
    // A table whose edge is at x = 0.
    stage.put(&Thing::new(cuboid(4.0, 4.0, 1.0), surface, DVec3::new(-2.0, 0.0, -0.5)).fixed())?;
    let mut x = -0.5;
    let mut top = 0;
    for k in 0..n {
        // The k-th from below has n − k bricks from itself to the top.
        x += f / (2.0 * f64::from(n - k));
        top = stage.put(&Thing::new(
            cuboid(1.0, 0.5, 0.2),
            surface,
            DVec3::new(x, 0.0, 0.1 + 0.2 * f64::from(k)),
        ))?;
    }
    let start = stage.position(top)?.z;
    stage.seconds(4.0)?;
    Ok(start - stage.position(top)?.z)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let numbers: &[u32] = if rig.quick { &[1, 2, 3, 5] } else { &[1, 2, 3, 4, 5, 10, 20, 30] };
    let mut findings = Findings::default();
    let (mut curve, mut exact) = (Vec::new(), Vec::new());
    for &n in numbers {
        let reach: f64 = (1..=n).map(|k| 0.5 / f64::from(k)).sum();
        let search = Search { halvings: 7, ..Search::around(1.0) };
        let found = reach * search.largest(|f| Ok(fall(rig, n, f)? < 0.05))?;
        let bricks = if n == 1 { "brick" } else { "bricks" };
        findings.near(
            format!("overhang of {n} {bricks}"),
            "lengths",
            found,
            (reach, 0.02 * reach),
            "2 %, as the collected set-up has it: a stack at its limit stands on edges, which contacts let sink",
        );
        curve.push((f64::from(n), found));
        exact.push((f64::from(n), reach));
    }
    findings.draw(
        Figure::linear("Overhang", "bricks", "lengths of a brick")
            .ours("", curve)
            .expected("half the harmonic number", exact),
    );
    Ok(findings)
}
