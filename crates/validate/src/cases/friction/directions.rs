//! A cube slides in twelve directions: is the friction cone round?

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, cuboid};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "directions",
    group: GROUP,
    title: "A cube slides in twelve directions",
    source: Source::Suite("Jolt's friction test; v = v₀ − μ g t"),
    setup: "Cube of 2 m at 20 m/s, μ = √(0.9 · 0.8) = 0.848528, 1 s at 60 Hz in four sub-steps, every 30°.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mu = 0.848_528;
    let surface = Surface::new(mu, 0.0);
    let exact = 20.0 - f64::from(mu) * Terms::FRAMES.g();
    let (mut worst, mut sideways, mut curve) = (0.0_f64, 0.0_f64, Vec::new());
    for k in 0..12 {
        let mut stage = rig.on_ground(Terms::FRAMES, surface)?;
        let (sin, cos) = libm::sincos(f64::from(k) * core::f64::consts::TAU / 12.0);
        let direction = DVec3::new(cos, sin, 0.0);
        let cube = Thing::new(cuboid(2.0, 2.0, 2.0), surface, DVec3::Z);
        let cube = stage.put(&cube.moving(direction.as_vec3() * 20.0, Vec3::ZERO))?;
        stage.seconds(1.0)?;
        let v = stage.velocity(cube)?;
        worst = worst.max((v.dot(direction) - exact).abs());
        sideways = sideways.max((v - direction * v.dot(direction)).length());
        curve.push((30.0 * f64::from(k), v.dot(direction)));
    }
    let mut findings = Findings::default();
    findings
        .at_most(
            "speed after 1 s off 11.676 m/s, worst direction",
            "m/s",
            worst,
            1e-2,
            "Jolt's own tolerance",
        )
        .at_most(
            "speed sideways, worst direction",
            "m/s",
            sideways,
            1e-2,
            "a round cone has no direction of its own",
        )
        .draw(
            Figure::linear("Speed after 1 s", "direction, °", "speed, m/s")
                .ours("", curve)
                .expected("v₀ − μ g t", [(0.0, exact), (330.0, exact)]),
        );
    Ok(findings)
}
