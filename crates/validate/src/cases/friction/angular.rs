//! A cube spins on the ground until friction stops it.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "spinning-cube",
    group: GROUP,
    title: "A cube spins on its four corners",
    source: Source::Suite("Jolt's angular friction; α = μ √2 m g / I"),
    setup: "Cube of 2 m at 10 rad/s about the vertical, μ = √0.06 = 0.244949, at 1 ms and at 60 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mu = 0.06_f32.sqrt();
    let surface = Surface::new(mu, 0.0);
    // I = 2/3 m for edges of 2 m; the corners are √2 m from the axis.
    let slowing = f64::from(mu) * core::f64::consts::SQRT_2 * Terms::FINE.g() / (2.0 / 3.0);
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Spin", "time, s", "angular velocity, rad/s");
    for (terms, name) in [(Terms::FINE, "1 ms"), (Terms::FRAMES, "60 Hz")] {
        let mut stage = rig.on_ground(terms, surface)?;
        let cube = Thing::new(cuboid(2.0, 2.0, 2.0), surface, DVec3::Z).moving(Vec3::ZERO, Vec3::Z * 10.0);
        let cube = stage.put(&cube)?;
        let mut curve = vec![(0.0, 10.0)];
        for i in 1..=20 {
            stage.seconds(0.05)?;
            curve.push((0.05 * f64::from(i), stage.spin(cube)?.z));
        }
        let spin = stage.spin(cube)?.z;
        findings.near(
            format!("spin after 1 s, {name}"),
            "rad/s",
            spin,
            (10.0 - slowing, 5e-3),
            "Jolt's own tolerance",
        );
        figure = figure.ours(name, curve);
    }
    findings.draw(figure.expected("formula", [(0.0, 10.0), (1.0, 10.0 - slowing)]));
    Ok(findings)
}
