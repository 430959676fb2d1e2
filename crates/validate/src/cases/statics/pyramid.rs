//! A ball lies on two others.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Terms, Thing};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "ball-pyramid",
    group: GROUP,
    title: "A ball lies on two others",
    source: Source::Suite("Chrono's DEM pyramid"),
    setup: "Balls of radius 0.5 m that touch; μ = 0.5 with a rolling friction of 0.2 m holds, μ = 0.01 does not; 5 s at 1 ms.",
    engines: DEFAULT,
    long: false,
    run,
};

/// Height of the upper ball after 5 s, m.
fn height(rig: &Rig, surface: Surface) -> Result<f64, Error> {
    let mut stage = rig.on_ground(Terms::FINE, surface)?;
    for place in [DVec3::new(-0.5, 0.0, 0.5), DVec3::new(0.5, 0.0, 0.5)] {
        stage.put(&Thing::new(ball(0.5), surface, place))?;
    }
    let upper = stage.put(&Thing::new(ball(0.5), surface, DVec3::Z * TOP))?;
    stage.seconds(5.0)?;
    Ok(stage.position(upper)?.z)
}

/// (1 + √3) R.
const TOP: f64 = 0.5 * 2.732_050_807_568_877;

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rough = Surface { rolling: 0.2, ..Surface::new(0.5, 0.0) };
    let mut findings = Findings::default();
    findings.near("height, rough", "m", height(rig, rough)?, (TOP, 1e-3), "Chrono's own tolerance").near(
        "height, smooth",
        "m",
        height(rig, Surface::new(0.01, 0.0))?,
        (0.5, 1e-3),
        "Chrono's own tolerance: it has come down",
    );
    Ok(findings)
}
