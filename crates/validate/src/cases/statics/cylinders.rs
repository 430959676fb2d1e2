//! A cylinder lies on two others.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, turn};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Mix, Shape};

pub(super) const CASE: Case = Case {
    name: "three-cylinders",
    group: GROUP,
    title: "A cylinder lies on two others",
    source: Source::ClosedForm(
        "μ ≥ tan 15° = 0.267949 between cylinders, and a third of it, 0.089316, on the floor",
    ),
    setup: "Radius 0.5 m, length 1 m, the two below touch each other. The least μ at which the upper one sinks by less than 1 cm in 3 s, by bisection, at \
            240 Hz in four sub-steps; the other μ is 1.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// How far the upper one sinks, m.
fn sink(rig: &Rig, between: f64, floor: f64) -> Result<f64, Error> {
    let surface = |mu: f64| Surface { mix: Mix::Minimum, ..Surface::new(mu as f32, 0.0) };
    let mut stage = rig.on_ground(Terms { rate: 240.0, substeps: 4, ..Terms::FINE }, surface(floor))?;
    let mut put = |x: f64, z: f64| {
        let shape = Shape::Cylinder { half_length: 0.5, radius: 0.5 };
        let pose =
            Pose { position: DVec3::new(x, 0.0, z), rotation: turn(Vec3::X, core::f64::consts::FRAC_PI_2) };
        stage.put(&Thing::new(shape, surface(between), DVec3::ZERO).pose(pose))
    };
    put(-0.5, 0.5)?;
    put(0.5, 0.5)?;
    let height = 0.5 + libm::sqrt(0.75);
    let upper = put(0.0, height)?;
    stage.seconds(3.0)?;
    Ok(height - stage.position(upper)?.z)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let limit = libm::tan(15_f64.to_radians());
    let between = Search::around(limit).least(|mu| Ok(sink(rig, mu, 1.0)? < 0.01))?;
    let floor = Search::around(limit / 3.0).least(|mu| Ok(sink(rig, 1.0, mu)? < 0.01))?;
    let mut findings = Findings::default();
    let reason = "1 %, the aim of the project";
    findings.near("least μ between cylinders", "", between, (limit, 0.01 * limit), reason).near(
        "least μ on the floor",
        "",
        floor,
        (limit / 3.0, 0.01 * limit / 3.0),
        reason,
    );
    Ok(findings)
}
