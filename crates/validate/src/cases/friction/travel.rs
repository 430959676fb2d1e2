//! A cube slides until it stops.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "sliding-stops",
    group: GROUP,
    title: "A cube slides until it stops",
    source: Source::Suite("Chrono's sliding_gravity; closed form v² / (2 μ g)"),
    setup: "Cube of 0.5 m, 1 kg, μ = 0.5, 5 m/s, at 1 ms and at 60 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.5, 0.0);
    let exact = 25.0 / (2.0 * 0.5 * Terms::FINE.g());
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Way", "time, s", "way, m");
    for (terms, name) in [(Terms::FINE, "1 ms"), (Terms::FRAMES, "60 Hz")] {
        let mut stage = rig.on_ground(terms, surface)?;
        let cube = Thing::new(cuboid(0.5, 0.5, 0.5), surface, DVec3::Z * 0.25).mass(1.0);
        let cube = stage.put(&cube)?;
        stage.seconds(0.5)?;
        let start = stage.position(cube)?;
        stage.set_velocity(cube, Vec3::X * 5.0, Vec3::ZERO)?;
        let mut curve = vec![(0.0, 0.0)];
        for i in 1..=40 {
            stage.seconds(0.05)?;
            curve.push((0.05 * f64::from(i), stage.position(cube)?.x - start.x));
        }
        // Semi-implicit Euler takes the speed at the end of each sub-step h for all of it.
        let h = terms.dt() / f64::from(terms.substeps);
        let tolerance = 5e-3 * exact + 2.5 * h;
        let way = (stage.position(cube)? - start).x;
        findings
            .near(
                format!("way, {name}"),
                "m",
                way,
                (exact, tolerance),
                "Chrono's 0.5 %, and v h / 2 of a sub-step",
            )
            .at_most(
                format!("speed after 2 s, {name}"),
                "m/s",
                stage.velocity(cube)?.length(),
                1e-4,
                "it stands",
            );
        figure = figure.ours(name, curve);
    }
    let t = 5.0 / (0.5 * Terms::FINE.g());
    let parabola =
        (0..=20).map(|i| f64::from(i) * t / 20.0).map(|t| (t, 5.0 * t - 0.25 * Terms::FINE.g() * t * t));
    findings.draw(figure.expected("formula", parabola.chain([(2.0, exact)])));
    Ok(findings)
}
