//! Eight balls on a floor weigh what they weigh.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball, cuboid};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "eight-balls",
    group: GROUP,
    title: "Eight balls press the floor by their weight",
    source: Source::Suite("Chrono's compute_contact"),
    setup: "8 balls of 5 kg, radius 0.05 m, μ = 0.4, e = 0, on a box; 3 s at 5 ms without sub-steps. The solvers `impulse` and `reflect` keep no forces.",
    engines: DEFAULT,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.4, 0.0);
    let mut stage = rig.stage(Terms { rate: 200.0, ..Terms::FINE })?;
    let floor = stage.put(&Thing::new(cuboid(2.0, 2.0, 0.2), surface, DVec3::Z * -0.1).fixed())?;
    for i in 0..8 {
        let place = DVec3::new(0.12 * f64::from(i % 4), 0.12 * f64::from(i / 4), 0.05);
        stage.put(&Thing::new(ball(0.05), surface, place).mass(5.0))?;
    }
    let weight = 40.0 * stage.terms.g();
    let (mut worst, mut curve) = (0.0_f64, Vec::new());
    for _ in 0..600 {
        stage.step()?;
        let load = stage.load(floor).map_or(f64::NAN, |load| -load.z);
        curve.push((stage.time(), load));
        if stage.time() > 0.25 {
            worst = worst.max((load - weight).abs());
        }
    }
    let mut findings = Findings::default();
    findings
        .at_most(
            "farthest off 392.4 N after 0.25 s, any step",
            "N",
            worst,
            1e-3 * weight,
            "0.1 %, Chrono's own tolerance",
        )
        .draw(
            Figure::linear("Force on the floor", "time, s", "force, N")
                .ours("", curve.into_iter().step_by(4))
                .expected("weight", [(0.0, weight), (3.0, weight)]),
        );
    Ok(findings)
}
