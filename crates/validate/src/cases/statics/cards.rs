//! Two cards lean against each other.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid, turn};
use rockfall::Mix;
use rockfall::math::{DVec3, Pose, Vec3};

pub(super) const CASE: Case = Case {
    name: "cards",
    group: GROUP,
    title: "Two cards lean against each other",
    source: Source::ClosedForm(
        "moments about a foot: μ ≥ ½ tan φ on the floor, φ from the vertical, less half the thickness over the length",
    ),
    setup: "Cards 1 × 0.6 × 0.01 m at 20° from the vertical, friction 1 between them. The least μ on the floor at which the top sinks by less than 5 mm in 2 s, by \
            bisection, at 240 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Length and thickness, m.
const L: f64 = 1.0;
const T: f64 = 0.01;

/// How far the cards sink, m.
fn sink(rig: &Rig, floor: f64) -> Result<f64, Error> {
    let surface = |mu: f64| Surface { mix: Mix::Minimum, ..Surface::new(mu as f32, 0.0) };
    let mut stage = rig.on_ground(Terms { rate: 240.0, substeps: 4, ..Terms::FINE }, surface(floor))?;
    let (sin, cos) = libm::sincos(20_f64.to_radians());
    // The inner faces go from the feet to where the cards meet, over x = 0.
    let mut ids = Vec::new();
    for side in [-1.0, 1.0] {
        let x = side * (0.5 * L * sin + 0.5 * T * cos);
        let pose = Pose {
            position: DVec3::new(x, 0.0, 0.5 * L * cos + 0.5 * T * sin),
            rotation: turn(Vec3::Y, -side * 20_f64.to_radians()),
        };
        let card = Thing::new(cuboid(T as f32, 0.6, L as f32), surface(1.0), DVec3::ZERO).pose(pose);
        ids.push(stage.put(&card)?);
    }
    let start = stage.position(ids[0])?.z;
    stage.seconds(2.0)?;
    Ok(start - stage.position(ids[0])?.z)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let limit = 0.5 * libm::tan(20_f64.to_radians()) - 0.5 * T / L;
    let found = Search::around(limit).least(|mu| Ok(sink(rig, mu)? < 0.005))?;
    let mut findings = Findings::default();
    findings.near("least μ on the floor", "", found, (limit, 0.01 * limit), "1 %, the aim of the project");
    Ok(findings)
}
