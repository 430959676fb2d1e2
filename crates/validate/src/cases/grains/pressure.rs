//! Balls without friction in a box without friction.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface};
use crate::finding::{Figure, Findings};
use crate::stage::Rig;
use rockfall::math::Vec3;

pub(super) const CASE: Case = Case {
    name: "hydrostatic",
    group: GROUP,
    title: "Balls without friction weigh on the floor and press the walls",
    source: Source::ClosedForm(
        "upright walls without friction carry no weight: the floor has all of it. Frictionless balls are nearly a liquid: their angle of friction is 5.8° (Peyneau and Roux 2008)",
    ),
    setup: "4,000 balls of 1 m (quick: 800) in a box 10 m across, no friction, 60 Hz in four sub-steps; means over two seconds.",
    engines: DEFAULT,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let (width, count) = (10.0, if rig.quick { 800 } else { 4000 });
    let smooth = Surface::new(0.0, 0.0);
    let (mut stage, walls) = heap::walls(rig, heap::TERMS, width, smooth)?;
    let floor = stage.plane(Vec3::Z, smooth)?;
    let ids = heap::pour(&mut stage, width, 0.0, count, &heap::grain(smooth), 2.0 * heap::R, 1)?;
    let unrest = heap::settle(&mut stage, &ids, 20.0)?;
    let weight = ids.iter().map(|&id| stage.mass(id)).sum::<f64>() * stage.terms.g();
    let steps = stage.terms.steps_in(2.0);
    let (mut sum, mut worst, mut sides, mut curve) = (0.0, 0.0_f64, 0.0, Vec::new());
    for _ in 0..steps {
        stage.step()?;
        let load = stage.load(floor).map_or(f64::NAN, |load| -load.z);
        sum += load / steps as f64;
        worst = worst.max((load / weight - 1.0).abs());
        curve.push((stage.time(), load / weight));
        let side = walls.iter().filter_map(|&wall| stage.load(wall)).map(|load| load.length()).sum::<f64>();
        sides += side / 4.0 / steps as f64;
    }
    // A liquid of the same weight and the same centre of mass presses a wall with ρ g h² w / 2 = (weight / w²) (h / 2) w, h / 2 the height of the centre.
    let places = heap::places(&stage, &ids)?;
    let center = places.iter().map(|p| p.z).sum::<f64>() / count as f64;
    let liquid = weight / width * center;
    let (first, last) = (curve[0].0, stage.time());
    let mut findings = Findings::default();
    findings
        .near(
            "mean force on the floor",
            "of the weight",
            sum / weight,
            (1.0, 1e-3),
            "0.1 %, the aim of the project: it is exact",
        )
        .at_most(
            "farthest off the weight in a step",
            "of the weight",
            worst,
            1e-2,
            "1 %: what still trembles",
        )
        .near(
            "mean force on a wall",
            "of a liquid's",
            sides / liquid,
            (1.0, 0.2),
            "an angle of friction of 5.8° lets the ratio of the stresses be 0.82 to 1.22",
        )
        .shown("mean kinetic energy of a ball over m g R when it begins", "", unrest)
        .draw(
            Figure::linear("Force on the floor", "time, s", "share of the weight")
                .ours("", curve)
                .expected("weight", [(first, 1.0), (last, 1.0)]),
        );
    Ok(findings)
}
