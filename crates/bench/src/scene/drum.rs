//! Stones in a closed drum that turns about a level axis, with four vanes that lift them. It is as long as the cube of stones that
//! falls in it at the start, and fills to about a third.
//!
//! The drum is bodies that turn together, because not every engine here makes one body of many shapes. Nothing is around it: what
//! gets out falls, and counts as escaped.

use super::driven::{Driven, Path};
use super::{Scene, pile, stones};
use rockfall::Shape;
use rockfall::math::{DVec3, Vec3};
use rockfall::shape::Hull;
use std::f64::consts::PI;
use std::sync::Arc;

/// Staves, and of which a vane stands on each ninth.
const STAVES: usize = 36;
const VANE_EVERY: usize = 9;

/// Inner radius of the staves, radius to which vanes stand up, and outer radius, by the edge of the cube. The corners of the
/// cube are √½ from the axis.
const INNER: f64 = 0.85;
const VANES: f64 = 0.75;
const OUTER: f64 = 0.95;

/// Between the cube and the ends of the drum, metres.
const GAP: f64 = 0.1;

/// Centrifugal acceleration at the staves by that of gravity (the Froude number of drums): the stones cascade.
const FROUDE: f64 = 0.1;

pub(super) fn drum(count: usize, seed: u64) -> Result<Scene, crate::Error> {
    let side = (1..).find(|n: &usize| n * n * n >= count).unwrap_or(1);
    let edge = side as f64 * f64::from(stones::PITCH);
    let [inner, vanes, outer] = [INNER, VANES, OUTER].map(|share| share * edge);
    let half_length = 0.5 * edge + GAP;
    let mut scene = Scene { half_width: outer, ..Scene::empty() };

    let middle = DVec3::new(0.0, 0.0, inner);
    let rate = (FROUDE * f64::from(scene.gravity) / inner).sqrt();
    let path = |middle| Path::Spin { middle, velocity: DVec3::ZERO, axis: -Vec3::Y, rate };
    // Between two angles, in staves, and two radii.
    let part = |from: f64, to: f64, low: f64, high: f64| {
        let corner = |i: usize| {
            let (sin, cos) = (if i & 1 == 0 { from } else { to } * 2.0 * PI / STAVES as f64).sin_cos();
            let radius = if i & 2 == 0 { low } else { high };
            DVec3::new(radius * cos, if i & 4 == 0 { -half_length } else { half_length }, radius * sin)
                .as_vec3()
        };
        Hull::from_points(&(0..8).map(corner).collect::<Vec<_>>())
    };
    for stave in 0..STAVES {
        let from = stave as f64;
        let mut parts = vec![part(from - 0.1, from + 1.1, inner, outer)?];
        if stave % VANE_EVERY == 0 {
            parts.push(part(from, from + 1.0, vanes, inner)?);
        }
        for hull in parts {
            scene.driven.push(Driven { shape: scene.shapes.len(), path: path(middle) });
            scene.shapes.push(Shape::Hull(Arc::new(hull)));
        }
    }
    let thick = 0.5 * (outer - inner);
    for side in [-1.0, 1.0] {
        let end = middle + DVec3::Y * (side * (half_length + thick));
        scene.driven.push(Driven { shape: scene.shapes.len(), path: path(end) });
        scene.shapes.push(Shape::Box { half: DVec3::new(outer, thick, outer).as_vec3() });
    }
    let low = (inner - 0.5 * edge) as f32;
    pile::drop(&mut scene, stones::stones(1.0, seed), count, side, stones::PITCH, low, seed);
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::super::Placed;
    use super::*;
    use rockfall::math::Pose;

    #[test]
    fn the_drum_is_closed() {
        let scene = drum(1000, 1).expect("a scene");
        assert_eq!(scene.driven.len(), STAVES + STAVES / VANE_EVERY + 2);
        // From the middle in any direction there is a wall at the radius or at the end of the drum.
        let edge = 10.0 * f64::from(stones::PITCH);
        for i in 0..360 {
            let (sin, cos) = f64::from(i).to_radians().sin_cos();
            let wall = DVec3::new(cos, 0.0, sin) * (0.9 * edge);
            let end = DVec3::new(0.8 * edge * cos, 0.5 * edge + GAP + 0.01, 0.8 * edge * sin);
            for place in [wall, end, end * DVec3::new(1.0, -1.0, 1.0)] {
                let pose = Pose::at(place + DVec3::Z * (INNER * edge));
                let probe = Shape::Sphere { radius: 0.005 };
                let inside = |p: Placed| {
                    let apart =
                        rockfall_collide::distance(&probe, &scene.shapes[p.shape], &pose.see(&p.pose));
                    apart.is_some_and(|d| d.distance < 0.0)
                };
                assert!(scene.immovable(0).into_iter().any(inside), "{place}");
            }
        }
    }
}
