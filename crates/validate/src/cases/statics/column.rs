//! Five balls fall onto each other and stand.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "column",
    group: GROUP,
    title: "Five balls fall onto each other and stand",
    source: Source::Suite("Chrono's stacking (Asmar 2002, test 4)"),
    setup: "Balls of radius 1 m, 1 kg, at 5 + 2.5 i m, e = 0.3, μ = 0.3, 10 s at 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.3, 0.3);
    let mut stage = rig.on_ground(Terms { threshold: 0.1, ..Terms::FINE }, surface)?;
    for i in 0..5 {
        stage.put(&Thing::new(ball(1.0), surface, DVec3::Z * (5.0 + 2.5 * f64::from(i))).mass(1.0))?;
    }
    stage.seconds(10.0)?;
    let (mut off, mut energy, mut spin, mut height) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
    for (i, id) in stage.movers().enumerate() {
        let place = stage.position(id)?;
        off = off.max(place.x.hypot(place.y));
        height = height.max((place.z - (1.0 + 2.0 * i as f64)).abs());
        energy += stage.kinetic(id)? / 5.0;
        spin = spin.max(stage.spin(id)?.length());
    }
    let mut findings = Findings::default();
    findings
        .at_most("mean kinetic energy after 10 s", "J", energy, 1e-9, "Chrono's own limit")
        .at_most("farthest off the vertical", "m", off, 1e-6, "Chrono's own limit: nothing pushes sideways")
        .at_most("largest spin", "rad/s", spin, 1e-6, "Chrono's own limit")
        .at_most(
            "farthest off R + 2 R i",
            "m",
            height,
            2e-3,
            "contacts give by g / ω², 0.07 mm for each ball that they carry",
        );
    Ok(findings)
}
