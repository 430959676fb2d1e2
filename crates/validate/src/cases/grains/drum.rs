//! A drum turns, and what is in it leans.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_COULOMB};
use crate::finding::{Figure, Findings};
use crate::stage::Rig;
use rockfall::math::{DVec3, Vec3};
use rockfall::shape::Mesh;
use rockfall::{Mix, Shape};
use std::sync::Arc;

pub(super) const CASE: Case = Case {
    name: "drum",
    group: GROUP,
    title: "Balls lean in a drum that turns",
    source: Source::Published(
        "Sunday et al. 2020 (Chrono): the flow is the same at equal Froude number ω² R / g, whatever gravity; glass beads lean by 24° to 28°, and more the faster the drum turns",
    ),
    setup: "A drum 12 m in radius and 8 m long (quick: 5 m), its wall of ribs 0.25 m deep, a third full of balls of 1 m, μ = 0.5, between smooth ends; Froude numbers of 0.002, 0.01 and 0.05, and 0.01 under a \
            sixth of gravity. The angle of the centre of mass from the vertical, mean over a turn by 1 rad (quick) or 2, after one by 1.5.",
    engines: WITH_COULOMB,
    long: false,
    run,
};

/// How far the balls lean, degrees.
fn lean(rig: &Rig, froude: f64, gravity: f64) -> Result<f64, Error> {
    let (radius, length) = (12.0, if rig.quick { 5.0 } else { 8.0 });
    let rubs = |mu: f32| Surface { mix: Mix::Minimum, ..Surface::new(mu, 0.0) };
    let mut stage = rig.stage(Terms { gravity: heap::TERMS.gravity * gravity as f32, ..heap::TERMS })?;
    for normal in [Vec3::Y, Vec3::NEG_Y] {
        stage.wall(normal, (-0.5 * length) as f32, rubs(0.0))?;
    }
    let speed = libm::sqrt(froude * stage.terms.g() / radius);
    let wall = Shape::Mesh(Arc::new(ribbed(radius, 0.5 * length + 1.0)?));
    let drum = Thing::new(wall, rubs(0.5), DVec3::ZERO).driven();
    // About −y the bottom goes towards +x, and with it the balls.
    stage.put(&drum.moving(Vec3::ZERO, Vec3::Y * -speed as f32))?;
    // A box that fits in.
    let half = 0.68 * radius;
    let [along, across] = [heap::layer(2.0 * half, 1.0), heap::layer(length, 1.0)];
    let low = DVec3::new(-half, -0.5 * length, -half);
    let sides = [2.0 * half, length];
    let ids =
        heap::pour_over(&mut stage, low, sides, along * along * across, &heap::grain(rubs(0.5)), 1.0, 8)?;
    stage.seconds(1.5 / speed)?;
    let turn = if rig.quick { 1.0 } else { 2.0 };
    let moments = 60;
    let mut sum = 0.0;
    for _ in 0..moments {
        stage.seconds(turn / speed / f64::from(moments))?;
        let center = heap::places(&stage, &ids)?.into_iter().sum::<DVec3>() / ids.len() as f64;
        sum += libm::atan2(center.x, -center.z).to_degrees() / f64::from(moments);
    }
    Ok(sum)
}

/// A drum along y, open at its ends, seen from inside: a rib a metre or so.
fn ribbed(radius: f64, half_length: f64) -> Result<Mesh, Error> {
    let ribs = (core::f64::consts::TAU * radius) as u32;
    let n = 2 * ribs;
    let corner = |k: u32| {
        let (sin, cos) = libm::sincos(f64::from(k) * core::f64::consts::TAU / f64::from(n));
        let r = if k.is_multiple_of(2) { radius } else { radius - 0.25 };
        [-half_length, half_length].map(|y| DVec3::new(r * cos, y, r * sin).as_vec3())
    };
    let corners: Vec<Vec3> = (0..n).flat_map(corner).collect();
    let side = |k: u32| {
        let (a, b, c, d) = (2 * k, 2 * k + 1, 2 * ((k + 1) % n), 2 * ((k + 1) % n) + 1);
        [[a, c, b], [c, d, b]]
    };
    let triangles: Vec<[u32; 3]> = (0..n).flat_map(side).collect();
    Ok(Mesh::from_triangles(&corners, &triangles).map_err(rockfall::shape::ShapeError::from)?)
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let froudes = [0.002, 0.01, 0.05];
    let mut points = Vec::new();
    for froude in froudes {
        points.push((froude, lean(rig, froude, 1.0)?));
    }
    let weak = lean(rig, 0.01, 1.0 / 6.0)?;
    let least = points.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(f64::INFINITY, f64::min);
    let mut findings = Findings::default();
    findings
        .near(
            "lean at Fr = 0.002",
            "°",
            points[0].1,
            (24.0, 4.0),
            "20° of balls without rolling friction to 28° of glass beads",
        )
        .near(
            "lean at Fr = 0.01 under a sixth of gravity",
            "°",
            weak,
            (points[1].1, 1.0),
            "the same at equal Froude number; 1° for avalanches",
        )
        .at_least("least rise of the lean with Fr", "°", least, 0.0, "it rises")
        .shown("lean at Fr = 0.01", "°", points[1].1)
        .shown("lean at Fr = 0.05", "°", points[2].1)
        .draw(
            Figure::linear("Lean", "Froude number", "angle, °")
                .ours("", points)
                .ours("a sixth of gravity", [(0.01, weak)]),
        );
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drum_looks_inwards_and_has_its_ribs() {
        let mesh = ribbed(8.0, 3.0).expect("a mesh");
        for (t, normal) in mesh.normals.iter().enumerate() {
            let [a, ..] = mesh.triangle(t);
            assert!(normal.dot(Vec3::new(a.x, 0.0, a.z)) < 0.0);
        }
        let r = |v: &Vec3| v.x.hypot(v.z);
        assert!(mesh.vertices.iter().all(|v| (r(v) - 8.0).abs() < 1e-5 || (r(v) - 7.75).abs() < 1e-5));
    }
}
