//! A tall box on a slope tips or slides.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, Slope, cuboid};
use rockfall::math::{DVec3, Vec3, rotation};

pub(super) const CASE: Case = Case {
    name: "tipping",
    group: GROUP,
    title: "A tall box on a slope tips or slides",
    source: Source::ClosedForm(
        "it tips at tan θ = b / h where μ is larger, and slides at tan θ = μ where not",
    ),
    setup: "Box 0.5 × 0.5 × 1 m. The steepest slope on which it neither moves by 2 cm nor tilts by 1° in 3 s, by bisection over tan θ, at 240 Hz in four \
            sub-steps; μ = 1 and μ = 0.3.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn stays(rig: &Rig, mu: f32, tangent: f64) -> Result<bool, Error> {
    let slope = Slope::new(libm::atan(tangent));
    let surface = Surface::new(mu, 0.0);
    let mut stage = rig.stage(Terms { rate: 240.0, substeps: 4, ..Terms::FINE })?;
    stage.plane(slope.normal, surface)?;
    let id = stage.put(&Thing::new(cuboid(0.5, 0.5, 1.0), surface, DVec3::ZERO).pose(slope.pose(0.5)))?;
    let start = stage.position(id)?;
    stage.seconds(3.0)?;
    let axis = rotation::rotate(stage.rotation(id)?, Vec3::Z);
    let tilt = axis.cross(slope.normal).length();
    Ok((stage.position(id)? - start).length() < 0.02 && tilt < 0.0175)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    for (name, mu, limit) in [("tips", 1.0, 0.5), ("slides", 0.3, f64::from(0.3_f32))] {
        let found = Search::around(limit).largest(|tangent| stays(rig, mu, tangent))?;
        findings.near(
            format!("tangent of the slope on which it {name}"),
            "",
            found,
            (limit, 0.01 * limit),
            "1 %, the aim of the project",
        );
    }
    Ok(findings)
}
