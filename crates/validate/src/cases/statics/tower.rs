//! A tower of twenty cubes.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "tower",
    group: GROUP,
    title: "A tower of twenty cubes",
    source: Source::Suite("MuJoCo's AlignedTowerStands, in double precision"),
    setup: "20 cubes of 0.1 m, 1 mm apart, μ = 1, 3 s at 2 ms without sub-steps and in four; and in four with contacts of 240 Hz in place of the default's 60.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Largest speed in the tower", "time, s", "log₁₀ of the speed in m/s");
    for (substeps, hertz) in [(1, 60.0), (4, 60.0), (4, 240.0)] {
        let surface = Surface::new(1.0, 0.0);
        let mut stage = rig.on_ground(Terms { rate: 500.0, substeps, hertz, ..Terms::FINE }, surface)?;
        let mut top = 0;
        for i in 0..20 {
            let place = DVec3::Z * (0.051 + 0.101 * f64::from(i));
            top = stage.put(&Thing::new(cuboid(0.1, 0.1, 0.1), surface, place))?;
        }
        let (mut fastest, mut curve) = (0.0_f64, Vec::new());
        for step in 0..1500 {
            stage.step()?;
            let speed = stage.fastest()?;
            if step >= 1000 {
                fastest = fastest.max(speed);
            }
            if step % 20 == 0 {
                curve.push((stage.time(), libm::log10(speed.max(1e-12))));
            }
        }
        let of = format!("{substeps} × {hertz} Hz");
        findings
            .near(
                format!("height of the top cube, {of}"),
                "m",
                stage.position(top)?.z,
                (1.95, 0.01),
                "it stands; a tenth of a cube",
            )
            .at_most(
                format!("largest speed after 2 s, {of}"),
                "m/s",
                fastest,
                1e-6,
                "MuJoCo's limit, of double precision. In single precision gravity alone adds 0.02 m/s in a step to within 1e-9",
            );
        figure = figure.ours(&of, curve);
    }
    findings.draw(figure.expected("MuJoCo's limit", [(2.0, -6.0), (3.0, -6.0)]));
    Ok(findings)
}
