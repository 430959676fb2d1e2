//! Very many boxes fall into a pit: what must hold at any scale?

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::Mix;
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "boxes-at-scale",
    group: GROUP,
    title: "Very many boxes fall into a pit",
    source: Source::ClosedForm(
        "no work is done on them, so energy never rises; smooth walls carry no weight, so the floor has all of it; what the walls push from one side they push from the other",
    ),
    setup: "100,000 cubes of 0.5 m (quick: 2,000) fall into a pit 30 m (8 m) across with smooth walls and a rough floor, μ = 0.6; 12 s at 60 Hz in four sub-steps, forces are means \
            over the last two.",
    engines: DEFAULT,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let (width, count) = if rig.quick { (8.0, 2000) } else { (30.0, 100_000) };
    let threads = if rig.quick { 1 } else { 0 };
    let surface = |mu: f32| Surface { mix: Mix::Minimum, ..Surface::new(mu, 0.0) };
    let terms = Terms { threads, ..heap::TERMS };
    let (mut stage, _) = heap::walls(rig, terms, width, surface(0.0))?;
    let floor = stage.plane(Vec3::Z, surface(0.6))?;
    let cube = Thing::new(cuboid(0.5, 0.5, 0.5), surface(0.6), DVec3::ZERO);
    let ids = heap::pour(&mut stage, width, 0.0, count, &cube, 0.5, 7)?;
    let start = stage.energy()?;
    let (mut lowest, mut gain, mut curve) = (start, 0.0_f64, Vec::new());
    for _ in 0..100 {
        stage.seconds(0.1)?;
        let energy = stage.energy()?;
        gain = gain.max(energy - lowest);
        lowest = lowest.min(energy);
        curve.push((stage.time(), energy / start));
    }
    let weight = ids.iter().map(|&id| stage.mass(id)).sum::<f64>() * terms.g();
    let steps = terms.steps_in(2.0);
    let mut sum = 0.0;
    for _ in 0..steps {
        stage.step()?;
        sum += stage.load(floor).map_or(f64::NAN, |load| -load.z) / steps as f64;
    }
    let momentum = stage.momentum()?;
    let mass = weight / terms.g();
    let mut findings = Findings::default();
    findings
        .at_most(
            "largest gain of energy, a tenth of a second apart",
            "of the start",
            gain / start,
            1e-3,
            "none; 0.1 % as in the tests of the engine: overlaps are pushed apart",
        )
        .near(
            "mean force on the floor",
            "of the weight",
            sum / weight,
            (1.0, 1e-3),
            "0.1 %, the aim of the project",
        )
        .at_most(
            "mean velocity of all in the end",
            "m/s",
            momentum.length() / mass,
            1e-3,
            "the heap stays where it is",
        )
        .draw(Figure::linear("Energy", "time, s", "share of the start").ours("", curve));
    Ok(findings)
}
