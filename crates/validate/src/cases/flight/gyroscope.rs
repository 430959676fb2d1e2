//! MuJoCo's tests of free bodies: what turns freely must not gain energy.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, EngineName, Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, Slope, cuboid};
use rockfall::Shape;
use rockfall::math::{DVec3, Vec3};

const BASE: Case = Case {
    name: "gyroscope-stable",
    group: GROUP,
    title: "A box spins for 100 s about its unstable and its stable axis",
    source: Source::Suite("MuJoCo's FreeBodyGyroStable"),
    setup: "Box 0.2 × 0.4 × 0.6 m, 1 kg, no gravity, 5 ms; (0.05, 5, 0.05) and (20, 0.05, 0.05) rad/s.",
    engines: ALL,
    long: false,
    run: stable,
};

pub(super) const CASES: [Case; 3] = [
    BASE,
    Case {
        name: "gyroscope-conservation",
        title: "A box tumbles for 5 s",
        source: Source::Suite("MuJoCo's FreeBodyConservation"),
        setup: "Box 0.2 × 0.4 × 0.6 m, 1 kg, no gravity, 10 ms; (1, 2, 3) rad/s.",
        run: conservation,
        ..BASE
    },
    Case {
        name: "gyroscope-contact",
        title: "An ellipsoid spins down a slope",
        source: Source::Suite("MuJoCo's FreeBodyGyroStableContact"),
        setup: "Ellipsoid of half axes 0.05, 0.1 and 0.15 m, 1 kg, 30 rad/s about the first, 0.2 m over a slope of 15°, μ = 1, 10 s at 2 ms. Speed is √(v² + ω²), as MuJoCo adds them, m and rad alike.",
        engines: WITH_FRICTION,
        run: contact,
        ..BASE
    },
];

/// Kinetic energies and angular momenta relative to their start, over time.
fn spin(rig: &Rig, rate: f32, seconds: f64, spin: Vec3) -> Result<Vec<(f64, f64, f64)>, Error> {
    let mut stage = rig.stage(Terms { gravity: Vec3::ZERO, rate, ..Terms::FINE })?;
    let thing = Thing::new(cuboid(0.2, 0.4, 0.6), Surface::new(0.0, 0.0), DVec3::ZERO).mass(1.0);
    let body = stage.put(&thing.moving(Vec3::ZERO, spin))?;
    let (energy, momentum) = (stage.energy()?, stage.spun(body)?);
    let mut curve = Vec::new();
    for _ in 0..stage.terms.steps_in(seconds) {
        stage.step()?;
        let drift = (stage.spun(body)? - momentum).length() / momentum.length();
        curve.push((stage.time(), stage.energy()? / energy, drift));
    }
    Ok(curve)
}

fn stable(rig: &Rig) -> Result<Findings, Error> {
    let seconds = if rig.quick { 30.0 } else { 100.0 };
    let mut findings = Findings::default();
    let mut figure = Figure::linear("Kinetic energy", "time, s", "share of the start");
    for (name, w) in
        [("unstable axis", Vec3::new(0.05, 5.0, 0.05)), ("stable axis", Vec3::new(20.0, 0.05, 0.05))]
    {
        let curve = spin(rig, 200.0, seconds, w)?;
        let most = curve.iter().fold(0.0_f64, |most, point| most.max(point.1));
        let least = curve.iter().fold(f64::INFINITY, |least, point| least.min(point.1));
        findings.at_most(
            format!("largest kinetic energy, {name}"),
            "of the start",
            most,
            1.01,
            "MuJoCo's own limit",
        );
        findings.at_least(
            format!("least kinetic energy, {name}"),
            "of the start",
            least,
            0.99,
            "the splitting does not drift",
        );
        figure = figure.ours(name, curve.iter().step_by(50).map(|&(t, energy, _)| (t, energy)));
    }
    findings.draw(figure.expected("kept", [(0.0, 1.0), (seconds, 1.0)]));
    Ok(findings)
}

fn conservation(rig: &Rig) -> Result<Findings, Error> {
    let curve = spin(rig, 100.0, 5.0, Vec3::new(1.0, 2.0, 3.0))?;
    let (mut rise, mut before) = (0.0_f64, 1.0_f64);
    let mut drift = 0.0_f64;
    for &(_, energy, off) in &curve {
        rise = rise.max(energy - before);
        before = energy;
        drift = drift.max(off);
    }
    let mut findings = Findings::default();
    findings
        .at_least("kinetic energy after 5 s", "of the start", before, 0.7, "MuJoCo's own limit")
        .at_most("largest angular momentum drift", "of the start", drift, 0.05, "MuJoCo's own limit")
        .at_most(
            "largest rise of the energy in a step",
            "of the start",
            rise,
            1e-3,
            "MuJoCo asks for 1e-9 of an implicit integrator, which loses energy; ours swings about the start by the square of the turn in a step",
        );
    Ok(findings)
}

fn contact(rig: &Rig) -> Result<Findings, Error> {
    let (slope, surface) = (Slope::new(15_f64.to_radians()), Surface::new(1.0, 0.0));
    let mut stage = rig.stage(Terms { rate: 500.0, ..Terms::FINE })?;
    let plane = stage.plane(slope.normal, surface)?;
    let shape = Shape::Ellipsoid { half: Vec3::new(0.05, 0.1, 0.15) };
    let thing = Thing::new(shape, surface, DVec3::Z * 0.2).mass(1.0);
    let body = stage.put(&thing.moving(Vec3::ZERO, Vec3::X * 30.0))?;
    let start = stage.energy()?;
    let (mut fastest, mut loaded, mut gain, mut least) = (0.0_f64, 0, 0.0_f64, start);
    let mut curve = Vec::new();
    for step in 0..stage.terms.steps_in(10.0) {
        stage.step()?;
        let (v, w) = (stage.velocity(body)?, stage.spin(body)?);
        let speed = (v.length_squared() + w.length_squared()).sqrt();
        fastest = fastest.max(speed);
        loaded += usize::from(stage.load(plane).is_some_and(|load| load != DVec3::ZERO));
        let energy = stage.energy()?;
        gain = gain.max(energy - least);
        least = least.min(energy);
        if step % 50 == 0 {
            curve.push((stage.time(), speed));
        }
    }
    let mut findings = Findings::default();
    findings
        .at_most("largest speed", "of the start", fastest / 30.0, 2.0, "MuJoCo's own limit")
        .at_most(
            "largest gain of energy",
            "of the start",
            gain / start,
            0.01,
            "it only falls; a hundredth for the splitting, which swings by the square of the turn in a step, 0.06 rad",
        )
        .draw(Figure::linear("Speed", "time, s", "√(v² + ω²)").ours("", curve));
    // Peers and the simple solvers don't tell their forces.
    if rig.engine == EngineName::SoftStep {
        findings.at_least("steps in contact, of 5,000", "", loaded as f64, 1000.0, "MuJoCo's own limit");
    }
    Ok(findings)
}
