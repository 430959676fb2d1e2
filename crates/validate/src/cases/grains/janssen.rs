//! A silo carries most of what is in it by its walls.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "janssen",
    group: GROUP,
    title: "A silo carries what is in it by its walls",
    source: Source::ClosedForm("Janssen 1895: the floor feels M_s (1 − e^(−M / M_s)), M_s = ρ w³ / (4 μ K)"),
    setup: "Balls of 1 m in a square silo 8 m across, μ = 0.5; fills of 300 to 3,600 balls (quick: 200 to 1,200); the floor goes down at 5 cm/s for 8 s, which brings the friction \
            of the walls to its limit, and its force is the mean over the last 5.",
    engines: DEFAULT,
    long: false,
    run,
};

/// Weight of the fill and force on the floor, N.
fn fill(rig: &Rig, count: usize) -> Result<(f64, f64), Error> {
    let (width, rough) = (8.0, Surface::new(0.5, 0.0));
    let (mut stage, _) = heap::walls(rig, heap::TERMS, width, rough)?;
    let floor = Thing::new(cuboid(12.0, 12.0, 1.0), rough, DVec3::Z * -0.5).driven();
    let floor = stage.put(&floor)?;
    let ids = heap::pour(&mut stage, width, 0.0, count, &heap::grain(rough), 2.0 * heap::R, 2)?;
    heap::settle(&mut stage, &ids, 10.0)?;
    stage.set_velocity(floor, Vec3::Z * -0.05, Vec3::ZERO)?;
    stage.seconds(3.0)?;
    let steps = stage.terms.steps_in(5.0);
    let mut sum = 0.0;
    for _ in 0..steps {
        stage.step()?;
        sum += stage.load(floor).map_or(f64::NAN, |load| -load.z) / steps as f64;
    }
    Ok((ids.iter().map(|&id| stage.mass(id)).sum::<f64>() * stage.terms.g(), sum))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let counts: &[usize] = if rig.quick { &[200, 500, 1200] } else { &[300, 600, 1200, 2400, 3600] };
    let points = counts.iter().map(|&count| fill(rig, count)).collect::<Result<Vec<_>, _>>()?;
    // The M_s with the least sum of squares, by golden section over its logarithm.
    let law = |saturated: f64, weight: f64| saturated * (1.0 - libm::exp(-weight / saturated));
    let misfit = |saturated: f64| points.iter().map(|&(w, f)| (law(saturated, w) - f).powi(2)).sum::<f64>();
    let largest = points.iter().fold(0.0_f64, |most, point| most.max(point.1));
    let (mut low, mut high) = (libm::log(0.3 * largest), libm::log(10.0 * largest));
    for _ in 0..80 {
        let (a, b) = (high - 0.618 * (high - low), low + 0.618 * (high - low));
        if misfit(libm::exp(a)) < misfit(libm::exp(b)) { high = b } else { low = a }
    }
    let saturated = libm::exp(0.5 * (low + high));
    let worst =
        points.iter().fold(0.0_f64, |most, &(w, f)| most.max((law(saturated, w) - f).abs() / saturated));
    // Balls of 1000 kg/m³ that fill 0.6 of the room.
    let k = 600.0 * heap::TERMS.g() * 8.0_f64.powi(3) / (4.0 * 0.5 * saturated);
    let (weight, force) = points[points.len() - 1];
    let mut findings = Findings::default();
    findings
        .at_most("farthest off the law with the best M_s", "of M_s", worst, 0.1, "10 %: a silo of eight balls across, one filling of each height")
        .near("K of the best M_s", "", k, (0.8, 0.5), "between what an angle of friction of 25° lets stand, 0.4, and a liquid's 1, and the room taken as 0.6 full")
        .shown("force on the floor of the highest fill", "of its weight", force / weight);
    let top = points[points.len() - 1].0;
    let curve = (0..=30).map(|i| f64::from(i) / 30.0 * top).map(|w| (w / 1e6, law(saturated, w) / 1e6));
    findings.draw(
        Figure::linear("Force on the floor", "weight of the fill, MN", "force, MN")
            .ours("", points.iter().map(|&(w, f)| (w / 1e6, f / 1e6)))
            .expected("Janssen with the best M_s", curve)
            .expected("without friction", [(0.0, 0.0), (top / 2e6, top / 2e6)]),
    );
    Ok(findings)
}
