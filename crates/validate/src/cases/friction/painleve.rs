//! A rod scrapes over the ground: rigid friction has no solution there beyond μ = 4/3 (Painlevé).

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid, turn};
use rockfall::math::{DVec3, Pose, Vec3};

pub(super) const CASE: Case = Case {
    name: "painleve",
    group: GROUP,
    title: "A rod scrapes over the ground",
    source: Source::ClosedForm(
        "a uniform rod has Painlevé's paradox only where μ > 4/3; whatever an engine makes of it, energy must not rise",
    ),
    setup: "Rod 2 × 0.1 × 0.1 m, 45° off the ground, one end on it, 3 m/s towards that end; μ = 1 and 2; 2 s at 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Energy", "time, s", "share of the start");
    for mu in [1.0_f32, 2.0] {
        let surface = Surface::new(mu, 0.0);
        let mut stage = rig.on_ground(Terms::FINE, surface)?;
        let angle = core::f64::consts::FRAC_PI_4;
        // Of the box that is turned about y the lowest corner is half the sum of the edges' shadows below the middle.
        let height = 0.5 * (2.0 + 0.1) * libm::sin(angle);
        let pose = Pose { position: DVec3::Z * height, rotation: turn(Vec3::Y, angle) };
        let rod = Thing::new(cuboid(2.0, 0.1, 0.1), surface, DVec3::ZERO).mass(1.0).pose(pose);
        stage.put(&rod.moving(Vec3::X * 3.0, Vec3::ZERO))?;
        let start = stage.energy()?;
        // Semi-implicit Euler measures the energy of free flight ½ m g h v off.
        let half = 0.5 * stage.terms.g() * stage.terms.dt();
        let kept =
            |stage: &crate::stage::Stage| Ok::<f64, Error>(stage.energy()? + half * stage.momentum()?.z);
        let (mut lowest, mut gain, mut curve) = (start, 0.0_f64, Vec::new());
        for step in 0..2000 {
            stage.step()?;
            let energy = kept(&stage)?;
            gain = gain.max(energy - lowest);
            lowest = lowest.min(energy);
            if step % 20 == 0 {
                curve.push((stage.time(), energy / start));
            }
        }
        findings.at_most(
            format!("largest gain of energy, μ = {mu}"),
            "of the start",
            gain / start,
            5e-3,
            "none; 0.5 % for a corner whose arm is kept during a step",
        );
        figure = figure.ours(&format!("μ = {mu}"), curve);
    }
    findings.draw(figure);
    Ok(findings)
}
