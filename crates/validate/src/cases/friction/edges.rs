//! A cube slides over the seams of a triangle mesh.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid};
use rockfall::Shape;
use rockfall::math::{DVec3, Vec3};
use rockfall::shape::{Mesh, ShapeError};
use std::sync::Arc;

pub(super) const CASE: Case = Case {
    name: "seams",
    group: GROUP,
    title: "A cube slides over a flat floor of triangles",
    source: Source::Suite("Jolt's active edges"),
    setup: "Cube of 0.2 m at 3 m/s, 17° off the rows of a mesh with squares of 1 m, no friction, 2 s at 60 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// A flat floor of 20 × 20 squares, two triangles each.
fn floor() -> Result<Mesh, ShapeError> {
    let corner = |i: u32| Vec3::new((i % 21) as f32 - 10.0, (i / 21) as f32 - 10.0, 0.0);
    let corners: Vec<Vec3> = (0..21 * 21).map(corner).collect();
    let square = |i: u32| {
        let a = i % 20 + 21 * (i / 20);
        [[a, a + 1, a + 22], [a, a + 22, a + 21]]
    };
    let triangles: Vec<[u32; 3]> = (0..400).flat_map(square).collect();
    Ok(Mesh::from_triangles(&corners, &triangles)?)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let smooth = Surface::new(0.0, 0.0);
    let mut stage = rig.stage(Terms::FRAMES)?;
    stage.put(&Thing::new(Shape::Mesh(Arc::new(floor()?)), smooth, DVec3::ZERO).fixed())?;
    let (sin, cos) = libm::sincos(17_f64.to_radians());
    let v = DVec3::new(3.0 * cos, 3.0 * sin, 0.0);
    let start = DVec3::new(-5.0, -3.0, 0.1);
    let cube = Thing::new(cuboid(0.2, 0.2, 0.2), smooth, start).moving(v.as_vec3(), Vec3::ZERO);
    let cube = stage.put(&cube)?;
    let mut jolt = 0.0_f64;
    for _ in 0..stage.terms.steps_in(2.0) {
        stage.step()?;
        jolt = jolt.max((stage.velocity(cube)? - v).length());
    }
    let off = (stage.position(cube)? - start - v * 2.0).length();
    let mut findings = Findings::default();
    let reason = "Jolt's own tolerance";
    findings.at_most("place off after 2 s", "m", off, 1e-3, reason).at_most(
        "largest change of the velocity",
        "m/s",
        jolt,
        2e-3,
        reason,
    );
    Ok(findings)
}
