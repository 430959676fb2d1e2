//! Two balls meet, each given in another way.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_COULOMB};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::Shape;
use rockfall::math::{DVec3, Vec2, Vec3, trig};
use rockfall::shape::{Hull, Mesh, ShapeError};
use std::sync::Arc;

pub(super) const CASE: Case = Case {
    name: "ball-pairings",
    group: GROUP,
    title: "Balls meet as primitives, hulls and meshes",
    source: Source::Suite("Chrono's sphere-sphere, nine pairings of collision models"),
    setup: "Balls of radius 0.5 m, 1 kg, a gap of 1 m between them, 1 m/s each, e = 0.5, μ = 0.3, no gravity, 1 s at 1 ms; each a ball, a hull or a mesh of 362 corners, of which two meet.",
    engines: WITH_COULOMB,
    long: false,
    run,
};

/// A ball of radius 0.5 m as a primitive, a hull and a mesh, with a corner on the x axis.
fn balls() -> Result<[(&'static str, Shape); 3], Error> {
    const ROWS: u32 = 16;
    let corner = |k: u32| {
        let (sin, cos) = trig::sin_cos(core::f32::consts::PI * k as f32 / ROWS as f32);
        // The poles have to be on the axis to the last digit.
        let x = if k.is_multiple_of(ROWS) { 0.0 } else { 0.5 * sin };
        Vec2::new(x, -0.5 * cos)
    };
    let mesh = Mesh::turned(&(0..=ROWS).map(corner).collect::<Vec<_>>(), 24).map_err(ShapeError::from)?;
    let hull = Hull::from_points(&mesh.vertices)?;
    Ok([("ball", ball(0.5)), ("hull", Shape::Hull(Arc::new(hull))), ("mesh", Shape::Mesh(Arc::new(mesh)))])
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let (surface, balls) = (Surface::new(0.3, 0.5), balls()?);
    for (first, a) in &balls {
        for (second, b) in &balls {
            let mut stage = rig.stage(Terms { gravity: Vec3::ZERO, ..Terms::FINE })?;
            let mut put = |shape: &Shape, side: f64| {
                let thing = Thing::new(shape.clone(), surface, DVec3::X * side).mass(1.0);
                stage.put(&thing.moving(Vec3::X * -side as f32, Vec3::ZERO))
            };
            let (right, left) = (put(a, 1.0)?, put(b, -1.0)?);
            stage.seconds(1.0)?;
            let reason = "Chrono's own limit; 0.75 m where both are balls to the last digit";
            let [x, y] = [stage.position(right)?.x, -stage.position(left)?.x];
            findings
                .at_least(format!("way back of the right one, {first} and {second}"), "m", x, 0.6, reason)
                .at_least(format!("way back of the left one, {first} and {second}"), "m", y, 0.6, reason)
                .at_least(
                    format!("the slower of both, outwards, {first} and {second}"),
                    "m/s",
                    stage.velocity(right)?.x.min(-stage.velocity(left)?.x),
                    0.0,
                    "Chrono's own limit: both turn round",
                );
        }
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_are_balls_and_two_have_362_corners() {
        for (name, shape) in balls().expect("shapes") {
            let solid = shape.mass_properties(1000.0).expect("solid");
            let exact = 1000.0 * core::f32::consts::PI / 6.0;
            assert!((solid.mass / exact - 1.0).abs() < 0.03, "{name}: {}", solid.mass);
            assert!((shape.bounds().max.x - 0.5).abs() < 1e-6, "{name}");
            if let Shape::Mesh(mesh) = &shape {
                assert_eq!(mesh.vertices.len(), 362);
                assert!(mesh.closed);
            }
        }
    }
}
