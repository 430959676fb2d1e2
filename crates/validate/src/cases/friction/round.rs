//! What is round rolls down a slope: a ball, a cylinder, a ring.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, Slope, ball, turn};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3, rotation};

pub(super) const CASE: Case = Case {
    name: "round-on-slope",
    group: GROUP,
    title: "A ball, a cylinder and a ring on a slope of 15°",
    source: Source::Suite(
        "Drake's rolling sphere; closed form a = g sin θ / (1 + k), rolls where μ ≥ tan θ k / (1 + k), I = k m R²",
    ),
    setup: "Radius 0.05 m, 0.1 kg, 15°, 1 s at 1 ms and at 60 Hz in four sub-steps. The least μ at which it rolls without slip, by bisection.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Radius, m.
const R: f32 = 0.05;

/// What rolls: a name, k, and the thing.
fn things(surface: Surface) -> [(&'static str, f64, Thing); 3] {
    let cylinder =
        Thing::new(Shape::Cylinder { half_length: 0.05, radius: R }, surface, DVec3::ZERO).mass(0.1);
    let ring = Thing { moments: Some(Vec3::splat(0.1 * R * R)), ..cylinder.clone() };
    [
        ("ball", 0.4, Thing::new(ball(R), surface, DVec3::ZERO).mass(0.1)),
        ("cylinder", 0.5, cylinder),
        ("ring", 1.0, ring),
    ]
}

/// Speed and slip after a second, m/s.
fn roll(rig: &Rig, terms: Terms, mu: f64, which: usize) -> Result<(f64, f64), Error> {
    let slope = Slope::new(15_f64.to_radians());
    let surface = Surface::new(mu as f32, 0.0);
    let mut stage = rig.stage(terms)?;
    stage.plane(slope.normal, surface)?;
    // The axis of a cylinder lies across the slope.
    let across = rotation::compose(slope.rotation, turn(Vec3::X, -core::f64::consts::FRAC_PI_2));
    let pose = Pose { position: slope.normal.as_dvec3() * f64::from(R), rotation: across };
    let (_, _, thing) = things(surface)[which].clone();
    let id = stage.put(&thing.pose(pose))?;
    stage.seconds(1.0)?;
    let speed = stage.velocity(id)?.dot(slope.down);
    let spin = stage.spin(id)?.dot(slope.normal.as_dvec3().cross(slope.down));
    Ok((speed, speed - f64::from(R) * spin))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let (sin, cos) = libm::sincos(15_f64.to_radians());
    for (terms, name) in [(Terms::FINE, "1 ms"), (Terms::FRAMES, "60 Hz")] {
        for (which, (what, k, _)) in things(Surface::new(0.0, 0.0)).into_iter().enumerate() {
            let exact = terms.g() * sin / (1.0 + k);
            let (speed, _) = roll(rig, terms, 1.0, which)?;
            findings.near(
                format!("speed of the {what} after 1 s, {name}"),
                "m/s",
                speed,
                (exact, 1e-3 * exact),
                "0.1 %; Drake asks 0.055 %",
            );
            let limit = sin / cos * k / (1.0 + k);
            // Just below the limit the slip after a second is small: (1 + 1 / k) g cos θ Δμ.
            let found = Search::around(limit).least(|mu| Ok(roll(rig, terms, mu, which)?.1 < 1e-3))?;
            findings.near(
                format!("least μ at which the {what} rolls, {name}"),
                "",
                found,
                (limit, 0.01 * limit),
                "1 %, the aim of the project",
            );
        }
    }
    Ok(findings)
}
