//! How far apart do heaps end that begin a micrometre apart?

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Numbers, Rig, cuboid};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "spread",
    group: GROUP,
    title: "Heaps that begin a micrometre apart",
    source: Source::Published(
        "the method of Chung and Pollard 2016, \"Predictable behavior during contact simulation\"",
    ),
    setup: "64 cubes of 0.5 m fall into a heap, eight times, each cube moved at random by up to 1 µm; 4 s at 60 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Where the cubes end.
fn heap(rig: &Rig, seed: u64) -> Result<Vec<DVec3>, Error> {
    let surface = Surface::new(0.6, 0.0);
    let mut stage = rig.on_ground(Terms::FRAMES, surface)?;
    let (mut same, mut other) = (Numbers(1), Numbers(1000 * (seed + 1)));
    for i in 0..64 {
        let cell = DVec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64);
        let place = (cell + same.vector() * 0.3) * 0.75 + DVec3::Z * 0.5 + (other.vector() - 0.5) * 2e-6;
        stage.put(&Thing::new(cuboid(0.5, 0.5, 0.5), surface, place))?;
    }
    stage.seconds(4.0)?;
    stage.movers().map(|body| stage.position(body)).collect()
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let runs = (0..8).map(|seed| heap(rig, seed)).collect::<Result<Vec<_>, _>>()?;
    let n = runs.len() as f64;
    // Root mean square distance of a cube from its mean place over the runs.
    let mut squares = 0.0;
    for body in 0..64 {
        let mean = runs.iter().map(|run| run[body]).sum::<DVec3>() / n;
        squares += runs.iter().map(|run| (run[body] - mean).length_squared()).sum::<f64>() / n / 64.0;
    }
    let heights: Vec<f64> = runs.iter().map(|run| run.iter().map(|p| p.z).sum::<f64>() / 64.0).collect();
    let mean = heights.iter().sum::<f64>() / n;
    let deviation = libm::sqrt(heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / n);
    let mut findings = Findings::default();
    findings
        .shown("spread of a cube's place", "m", libm::sqrt(squares))
        .shown("mean height of the centres", "m", mean)
        .at_most(
            "standard deviation of that height",
            "of it",
            deviation / mean,
            0.05,
            "single cubes go their own ways, the heap does not: 64 cubes average to an eighth of what one does",
        );
    Ok(findings)
}
