//! A large ball among small ones that are shaken.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Thing, WITH_COULOMB};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "brazil-nut",
    group: GROUP,
    title: "A large ball among small ones comes up when they are shaken",
    source: Source::Published(
        "Rosato, Strandburg, Prinz and Swendsen 1987: small balls fall into the gaps below the large one, which rises",
    ),
    setup: "A ball of 3 m on the floor below balls of 1 m, μ = 0.5, all of 1000 kg/m³, 8 m deep in a box 8 m across (quick: 6 m) with smooth walls; the floor goes up and down by half a metre, Γ = A ω² / g = 3, for 60 s (quick: 40 s).",
    engines: WITH_COULOMB,
    long: false,
    run,
};

/// Amplitude, m, and the largest acceleration of the floor over gravity.
const AMPLITUDE: f64 = 0.5;
const STRENGTH: f64 = 3.0;

fn run(rig: &Rig) -> Result<Findings, Error> {
    let (width, seconds) = if rig.quick { (6.0, 40.0) } else { (8.0, 60.0) };
    let (rubs, smooth) = (Surface::new(0.5, 0.0), Surface::new(0.0, 0.0));
    let (mut stage, _) = heap::walls(rig, heap::TERMS, width, smooth)?;
    let floor = Thing::new(cuboid(2.0 * width as f32, 2.0 * width as f32, 2.0), rubs, DVec3::Z * -1.0);
    let floor = stage.put(&floor.driven())?;
    let nut = stage.put(&Thing::new(ball(1.5), rubs, DVec3::Z * 1.5))?;
    let count = (8.0 * width * width * 0.55 / core::f64::consts::FRAC_PI_6) as usize;
    let ids = heap::pour(&mut stage, width, 3.0, count, &heap::grain(rubs), 1.0, 10)?;
    heap::settle(&mut stage, &ids, 6.0)?;
    let below = |stage: &crate::stage::Stage| -> Result<f64, Error> {
        let height = stage.position(nut)?.z;
        Ok(heap::places(stage, &ids)?.iter().filter(|p| p.z < height).count() as f64 / count as f64)
    };
    let start = stage.position(nut)?.z;
    let deep = below(&stage)?;
    let frequency = libm::sqrt(STRENGTH * stage.terms.g() / AMPLITUDE);
    // Whole periods, so that the floor ends where it began.
    let period = core::f64::consts::TAU / frequency;
    let steps = stage.terms.steps_in((seconds / period).round() * period);
    let mut curve = Vec::new();
    for step in 0..steps {
        // From where it is at the beginning of the step to where it ought to be at its end.
        let at = |step: usize| AMPLITUDE * libm::sin(frequency * stage.terms.dt() * step as f64);
        let speed = (at(step + 1) - at(step)) / stage.terms.dt();
        stage.set_velocity(floor, Vec3::Z * speed as f32, Vec3::ZERO)?;
        stage.step()?;
        if step % 15 == 0 {
            curve.push((step as f64 * stage.terms.dt(), stage.position(nut)?.z));
        }
    }
    stage.set_velocity(floor, Vec3::ZERO, Vec3::ZERO)?;
    heap::settle(&mut stage, &ids, 4.0)?;
    let mut findings = Findings::default();
    findings
        .at_least(
            "the large ball rises",
            "m",
            stage.position(nut)?.z - start,
            1.0,
            "the sign alone is known: more than a small ball's diameter",
        )
        .shown("small balls below its centre before", "of all", deep)
        .shown("small balls below its centre after", "of all", below(&stage)?)
        .draw(Figure::linear("The large ball", "time, s", "height, m").ours("", curve));
    Ok(findings)
}
