//! A box is pushed less hard than friction holds.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "stiction",
    group: GROUP,
    title: "A box is pushed and stays",
    source: Source::Suite("Drake's box stiction: a contact force of (−5, 0, 10) N, a slip below 1e-4 m/s"),
    setup: "Box of 1 m, 1 kg, g = 10, μ = 1, 5 N sideways, 0.5 s at 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(1.0, 0.0);
    let mut stage = rig.on_ground(Terms { gravity: Vec3::Z * -10.0, ..Terms::FINE }, surface)?;
    let cube = stage.put(&Thing::new(cuboid(1.0, 1.0, 1.0), surface, DVec3::Z * 0.5).mass(1.0))?;
    let mut slip = 0.0_f64;
    for step in 0..500 {
        stage.push(cube, Vec3::X * (5.0 * stage.terms.dt()) as f32)?;
        stage.step()?;
        if step >= 250 {
            slip = slip.max(stage.velocity(cube)?.x.abs());
        }
    }
    let mut findings = Findings::default();
    findings.at_most("largest slip in the second half", "m/s", slip, 1e-4, "Drake's own limit").at_most(
        "way",
        "m",
        stage.position(cube)?.x.abs(),
        1e-4,
        "it stays",
    );
    if let Some(load) = stage.load(cube) {
        findings.near("normal force", "N", load.z, (10.0, 0.01), "0.1 %: at rest it is the weight");
    }
    Ok(findings)
}
