//! Five balls fall onto each other and stand.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{EngineName, Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASES: [Case; 2] = [CASE, SMALL];

const CASE: Case = Case {
    name: "column",
    group: GROUP,
    title: "Five balls fall onto each other and stand",
    source: Source::Suite("Chrono's stacking (Asmar 2002, test 4)"),
    setup: "Balls of radius 1 m, 1 kg, at 5 + 2.5 i m, e = 0.3, μ = 0.3, 10 s at 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

const SMALL: Case = Case {
    name: "small-column",
    title: "Five small balls fall onto each other and stand",
    source: Source::Suite("Chrono's DEM stack"),
    setup: "Balls of radius 5 mm, 1530 kg/m³, their middles at 5 + 15 i mm, μ = 0.5, rolling friction 4 µm, e = 0, g = 9.8; 3 s at 1 ms, with contacts of 60 Hz as they come and of 240 Hz.",
    run: small,
    ..CASE
};

fn small(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let surface = Surface { rolling: 4e-6, ..Surface::new(0.5, 0.0) };
    let stiffnesses: &[(f32, &str)] =
        if rig.engine == EngineName::SoftStep { &[(60.0, ""), (240.0, ", 240 Hz")] } else { &[(60.0, "")] };
    for &(hertz, name) in stiffnesses {
        let gravity = Vec3::Z * -9.8;
        let mut stage = rig.on_ground(Terms { gravity, hertz, ..Terms::FINE }, surface)?;
        for i in 0..5 {
            let place = DVec3::Z * (0.005 + 0.015 * f64::from(i));
            let mass = 1530.0 * 4.0 / 3.0 * core::f32::consts::PI * 0.005_f32.powi(3);
            stage.put(&Thing::new(ball(0.005), surface, place).mass(mass))?;
        }
        stage.seconds(3.0)?;
        let (mut off, mut energy) = (0.0_f64, 0.0);
        for (i, id) in stage.movers().enumerate() {
            let exact = DVec3::Z * (0.005 + 0.01 * i as f64);
            off = off.max((stage.position(id)? - exact).abs().max_element());
            energy += stage.kinetic(id)?;
        }
        findings
            .at_most(
                format!("farthest off R + 2 R i along an axis{name}"),
                "m",
                off,
                1e-4,
                "Chrono's own tolerance, 0.1 mm; contacts of 60 Hz give by 0.07 mm for each ball that they carry, of 240 Hz by a sixteenth of that",
            )
            .at_most(format!("kinetic energy of all after 3 s{name}"), "J", energy, 1e-12, "Chrono's own limit, 1e-5 erg");
    }
    Ok(findings)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(0.3, 0.3);
    let mut stage = rig.on_ground(Terms { threshold: 0.1, ..Terms::FINE }, surface)?;
    for i in 0..5 {
        stage.put(&Thing::new(ball(1.0), surface, DVec3::Z * (5.0 + 2.5 * f64::from(i))).mass(1.0))?;
    }
    stage.seconds(10.0)?;
    let (mut off, mut energy, mut spin, mut height) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
    for (i, id) in stage.movers().enumerate() {
        let place = stage.position(id)?;
        off = off.max(place.x.hypot(place.y));
        height = height.max((place.z - (1.0 + 2.0 * i as f64)).abs());
        energy += stage.kinetic(id)? / 5.0;
        spin = spin.max(stage.spin(id)?.length());
    }
    let mut findings = Findings::default();
    findings
        .at_most("mean kinetic energy after 10 s", "J", energy, 1e-9, "Chrono's own limit")
        .at_most("farthest off the vertical", "m", off, 1e-6, "Chrono's own limit: nothing pushes sideways")
        .at_most("largest spin", "rad/s", spin, 1e-6, "Chrono's own limit")
        .at_most(
            "farthest off R + 2 R i",
            "m",
            height,
            2e-3,
            "contacts give by g / ω², 0.07 mm for each ball that they carry",
        );
    Ok(findings)
}
