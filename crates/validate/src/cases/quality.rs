//! What the three qualities buy.

use super::simbenchmark::elastic_lattice;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::Quality;
use rockfall::math::DVec3;
use std::time::Instant;

pub(super) const CASE: Case = Case {
    name: "qualities",
    group: "quality",
    title: "The same at draft, default and fine quality",
    source: Source::ClosedForm("what stands stays where it is; elastic balls keep their energy"),
    setup: "At 60 Hz: a pyramid of 136 cubes of 1 m, μ = 0.6, for 10 s; a tower of ten cubes of 0.1 m, μ = 1, for 5 s; 216 elastic balls that fall \
            onto each other and the ground, for 3 s.",
    engines: DEFAULT,
    long: false,
    run,
};

/// What comes out at a quality.
struct Bought {
    /// Metres that the top of the pyramid sinks, and that it goes sideways.
    sunk: f64,
    aside: f64,
    /// Height of the top of the tower, m.
    height: f64,
    /// Share of the energy that the balls lose.
    lost: f64,
    /// s.
    time: f64,
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut before: Option<Bought> = None;
    let mut curve = Vec::new();
    for (quality, name) in [(Quality::Draft, "draft"), (Quality::Default, "default"), (Quality::Fine, "fine")]
    {
        let bought = buy(rig, Terms::of(quality))?;
        let Bought { sunk, aside, height, lost, time } = bought;
        let limit = before.as_ref().map_or([1.0; 2], |b| [b.sunk, b.aside.max(0.01)]);
        let better = "no worse than the quality below; a draft may sink and move by a cube";
        findings
            .at_most(format!("the pyramid's top sinks, {name}"), "m", sunk, limit[0], better)
            .at_most(format!("the pyramid's top goes sideways, {name}"), "m", aside, limit[1], better)
            .shown(format!("energy that the balls lose, {name}"), "of the start", lost)
            .shown(format!("height of the tower's top, 0.95 m at the start, {name}"), "m", height)
            .shown(format!("time, {name}"), "s", time);
        curve.push((time, sunk));
        before = Some(bought);
    }
    findings.draw(
        Figure::logarithmic("What time buys", "time of all three scenes, s", "the pyramid's top sinks, m")
            .ours("", curve),
    );
    Ok(findings)
}

fn buy(rig: &Rig, terms: Terms) -> Result<Bought, Error> {
    let start = Instant::now();
    let (surface, rows) = (Surface::new(0.6, 0.0), 16);
    let mut stage = rig.on_ground(terms, surface)?;
    let mut top = 0;
    for row in 0..rows {
        for i in 0..rows - row {
            let x = f64::from(i) - 0.5 * f64::from(rows - row - 1);
            let place = DVec3::new(x, 0.0, 0.5 + f64::from(row));
            top = stage.put(&Thing::new(cuboid(1.0, 1.0, 1.0), surface, place))?;
        }
    }
    let from = stage.position(top)?;
    stage.seconds(10.0)?;
    let way = stage.position(top)? - from;

    let surface = Surface::new(1.0, 0.0);
    let mut stage = rig.on_ground(terms, surface)?;
    let mut cube = 0;
    for i in 0..10 {
        let place = DVec3::Z * (0.05 + 0.1 * f64::from(i));
        cube = stage.put(&Thing::new(cuboid(0.1, 0.1, 0.1), surface, place))?;
    }
    stage.seconds(5.0)?;
    let height = stage.position(cube)?.z;

    let mut stage = elastic_lattice(rig, Terms { threshold: 0.0, ..terms })?;
    let energy = stage.energy()?;
    stage.seconds(3.0)?;
    let lost = (1.0 - stage.energy()? / energy).abs();
    let time = start.elapsed().as_secs_f64();
    Ok(Bought { sunk: -way.z, aside: way.x.hypot(way.y), height, lost, time })
}
