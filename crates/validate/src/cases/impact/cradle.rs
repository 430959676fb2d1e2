//! Newton's cradle, with gaps.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "cradle",
    group: GROUP,
    title: "Five balls in a row are hit by a sixth",
    source: Source::ClosedForm(
        "with gaps each ball passes all it has to the next. (Touching, rigid balls under Newton's law share −3/5 and 2/5 v instead; so gaps.)",
    ),
    setup: "Balls of radius 0.1 m, 2 cm apart, the first at 2 m/s, e = 1, no gravity, 1 s at 1 ms.",
    engines: ALL,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.0, 1.0);
    let mut stage = rig.stage(Terms { gravity: Vec3::ZERO, threshold: 0.0, ..Terms::FINE })?;
    for i in 0..6 {
        let thing = Thing::new(ball(0.1), surface, DVec3::X * (0.22 * f64::from(i)));
        let v = if i == 0 { 2.0 } else { 0.0 };
        stage.put(&thing.moving(Vec3::X * v, Vec3::ZERO))?;
    }
    stage.seconds(1.0)?;
    let speeds = (0..6).map(|i| Ok(stage.velocity(i)?.x)).collect::<Result<Vec<f64>, Error>>()?;
    let rest = speeds[..5].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let mut findings = Findings::default();
    findings
        .near(
            "speed of the last ball",
            "m/s",
            speeds[5],
            (2.0, 2e-4),
            "1e-4 of the speed: five roundings, and a step of gap",
        )
        .at_most("largest speed of the others", "m/s", rest, 2e-4, "as above")
        .draw(
            Figure::linear("Speed in the end", "ball", "speed, m/s")
                .ours("", speeds.into_iter().zip(1..).map(|(v, i)| (f64::from(i), v)))
                .expected(
                    "formula",
                    [0.0, 0.0, 0.0, 0.0, 0.0, 2.0].into_iter().zip(1..).map(|(v, i)| (f64::from(i), v)),
                ),
        );
    Ok(findings)
}
