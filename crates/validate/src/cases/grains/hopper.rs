//! Balls run out through a hole.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::Rig;
use rockfall::Shape;
use rockfall::math::{DVec3, Vec3};
use rockfall::shape::Mesh;
use std::sync::Arc;

pub(super) const CASE: Case = Case {
    name: "beverloo",
    group: GROUP,
    title: "Balls run out through a hole in the floor",
    source: Source::ClosedForm(
        "Beverloo 1961: W = C ρ √g (D − k d)^(5/2), C = 0.55 to 0.65, k = 1.2 to 1.6 for balls",
    ),
    setup: "5,000 balls of 1 m, μ = 0.5, in a box 16 m across; holes of 5, 6, 7 and 8 m in its flat floor; the balls that run out in the last seven tenths of the time in which \
            1,500 are expected.",
    engines: DEFAULT,
    long: true,
    run,
};

/// Balls per second.
fn flow(rig: &Rig, diameter: f64) -> Result<f64, Error> {
    let (width, rough) = (16.0, Surface::new(0.5, 0.0));
    let (mut stage, _) = heap::walls(rig, heap::TERMS, width, rough)?;
    stage.put(&Thing::new(Shape::Mesh(Arc::new(plate(0.5 * diameter)?)), rough, DVec3::ZERO).fixed())?;
    // A lid on the hole while the box is filled.
    let lid = Thing::new(
        Shape::Cylinder { half_length: 0.5, radius: (0.5 * diameter) as f32 },
        rough,
        DVec3::Z * -0.5,
    )
    .driven();
    let lid = stage.put(&lid)?;
    let ids = heap::pour(&mut stage, width, 0.0, 5000, &heap::grain(rough), 2.0 * heap::R, 3)?;
    heap::settle(&mut stage, &ids, 8.0)?;
    stage.set_velocity(lid, Vec3::Z * -60.0, Vec3::ZERO)?;
    let out = |stage: &crate::stage::Stage| {
        Ok::<usize, Error>(heap::places(stage, &ids)?.iter().filter(|p| p.z < -1.0).count())
    };
    // About 1,500 balls at the flow that is expected.
    let seconds = 1500.0
        / (0.58 * 0.6 / (core::f64::consts::PI / 6.0)
            * libm::sqrt(stage.terms.g())
            * libm::pow(diameter - 1.4, 2.5));
    stage.seconds(0.3 * seconds)?;
    let start = out(&stage)?;
    stage.seconds(0.7 * seconds)?;
    Ok((out(&stage)? - start) as f64 / (0.7 * seconds))
}

/// A flat ring around a hole.
fn plate(radius: f64) -> Result<Mesh, Error> {
    const SIDES: u32 = 48;
    let ring = |r: f64| {
        (0..SIDES).map(move |i| {
            let (sin, cos) = libm::sincos(f64::from(i) * core::f64::consts::TAU / f64::from(SIDES));
            Vec3::new((r * cos) as f32, (r * sin) as f32, 0.0)
        })
    };
    let corners: Vec<Vec3> = ring(radius).chain(ring(20.0)).collect();
    let side = |i: u32| {
        let j = (i + 1) % SIDES;
        [[i, i + SIDES, j + SIDES], [i, j + SIDES, j]]
    };
    let triangles: Vec<[u32; 3]> = (0..SIDES).flat_map(side).collect();
    Ok(Mesh::from_triangles(&corners, &triangles).map_err(rockfall::shape::ShapeError::from)?)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let diameters = [5.0, 6.0, 7.0, 8.0];
    let flows = diameters.map(|diameter| flow(rig, diameter));
    let mut points = Vec::new();
    for (diameter, flow) in diameters.into_iter().zip(flows) {
        points.push((diameter, flow?));
    }
    // W^(2/5) over D is a straight line.
    let line: Vec<(f64, f64)> = points.iter().map(|&(d, w)| (d, libm::pow(w, 0.4))).collect();
    let (slope, offset, r_squared) = super::line::through(&line);
    let per_ball = 0.6 / (core::f64::consts::PI / 6.0) * libm::sqrt(heap::TERMS.g());
    let c = libm::pow(slope, 2.5) / per_ball;
    let mut findings = Findings::default();
    findings
        .at_least("R² of W^(2/5) over D", "", r_squared, 0.99, "the law's exponent")
        .near("C", "", c, (0.58, 0.08), "0.55 to 0.65 in the literature; and the room, taken as 0.6 full")
        .near("k", "", -offset / slope, (1.4, 0.4), "1.2 to 1.6 for balls; from four holes");
    let law = |d: f64| 0.58 * per_ball * libm::pow(d - 1.4, 2.5);
    findings.draw(
        Figure::linear("Balls a second", "diameter of the hole over that of a ball", "balls/s")
            .ours("", points)
            .expected("C = 0.58, k = 1.4", (0..=12).map(|i| 5.0 + 0.25 * f64::from(i)).map(|d| (d, law(d)))),
    );
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plate_has_its_hole() {
        let mesh = plate(3.0).expect("a mesh");
        assert!(mesh.vertices.iter().all(|v| v.length() > 2.999) && mesh.normals.iter().all(|n| n.z > 0.999));
    }
}
