//! A stand on three feet is twisted.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, ball, cuboid};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::Compound;
use std::sync::Arc;

pub(super) const CASE: Case = Case {
    name: "three-feet",
    group: GROUP,
    title: "A stand on three feet is twisted",
    source: Source::Suite("Drake's \"pizza saver\": it sticks where M < μ m g R"),
    setup: "Three feet at R from the axis; m = 1 kg, R = 1 m, μ = 0.5, g = 10, and m = 3 kg, R = 1.5 m, μ = 2/3. The largest torque under which it turns \
            by less than 1 mrad in a second, by bisection, at 1 ms.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// How far it turns in a second, rad.
fn twist(rig: &Rig, mass: f32, radius: f32, mu: f32, torque: f64) -> Result<f64, Error> {
    let surface = Surface::new(mu, 0.0);
    let mut stage = rig.on_ground(Terms { gravity: Vec3::Z * -10.0, ..Terms::FINE }, surface)?;
    let foot = |i: u8| {
        let (sin, cos) = libm::sincos(f64::from(i) * core::f64::consts::TAU / 3.0);
        let r = f64::from(radius);
        (ball(0.1), Pose::at(DVec3::new(r * cos, r * sin, -0.1)))
    };
    let plate = (cuboid(0.2, 0.2, 0.1), Pose::at(DVec3::ZERO));
    let parts = [foot(0), foot(1), foot(2), plate];
    let stand = Compound::new(parts).map_err(|error| Error::Shape(error.into()))?;
    // Low, so that it can't tip; its moments are those of three masses on a circle.
    let moment = mass * radius * radius;
    let thing = Thing::new(Shape::Compound(Arc::new(stand)), surface, DVec3::Z * 0.2).mass(mass);
    let thing = Thing { moments: Some(Vec3::new(0.5, 0.5, 1.0) * moment), ..thing };
    let id = stage.put(&thing)?;
    stage.seconds(0.2)?;
    let mut turned = 0.0;
    for _ in 0..1000 {
        let (v, w) = (stage.velocity(id)?, stage.spin(id)?);
        let w = w + DVec3::Z * (torque * stage.terms.dt() / f64::from(moment));
        stage.set_velocity(id, v.as_vec3(), w.as_vec3())?;
        stage.step()?;
        turned += stage.spin(id)?.z * stage.terms.dt();
    }
    Ok(turned)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    for (mass, radius, mu) in [(1.0_f32, 1.0_f32, 0.5_f32), (3.0, 1.5, 2.0 / 3.0)] {
        let exact = f64::from(mu * mass * radius) * 10.0;
        let found =
            Search::around(exact).largest(|torque| Ok(twist(rig, mass, radius, mu, torque)?.abs() < 1e-3))?;
        findings.near(
            format!("largest torque that is held, m = {mass} kg"),
            "N m",
            found,
            (exact, 0.01 * exact),
            "1 %, the aim of the project; Drake's is exact",
        );
    }
    Ok(findings)
}
