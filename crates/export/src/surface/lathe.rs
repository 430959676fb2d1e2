//! Surfaces of revolution around the z axis.

use super::{QUARTER, SEGMENTS, Surface, Weld, turned};
use rockfall_math::Vec3;

/// A line that is turned around the axis, from below: distance from the axis, height, and normal, its part away from the axis and its part along it.
/// The outside lies to the right of the line. Strips that meet at an angle make an edge.
pub(super) type Strip = Vec<(f32, f32, (f32, f32))>;

/// A part of a circle around the point at height `z` on the axis, from the latitude `from` to `to`, in segments: -6 and 6 are the poles.
pub(super) fn arc(radius: f32, from: i32, to: i32, z: f32) -> Strip {
    let point = |k: i32| {
        // A pole lies on the axis, to the last bit.
        let (sin, cos) = if k.abs() == QUARTER { (k.signum() as f32, 0.0) } else { turned(k) };
        (radius * cos, z + radius * sin, (cos, sin))
    };
    (from..=to).map(point).collect()
}

/// Turns lines around the axis.
pub(super) fn turn(strips: &[Strip]) -> Surface {
    let mut weld = Weld::default();
    let circle: Vec<(f32, f32)> = (0..SEGMENTS).map(turned).collect();
    let point = |&(radius, z, (across, along)): &(f32, f32, (f32, f32)), k: usize| {
        let (sin, cos) = circle[k % circle.len()];
        (Vec3::new(radius * cos, radius * sin, z), Vec3::new(across * cos, across * sin, along))
    };
    for strip in strips {
        for ends in strip.windows(2) {
            for k in 0..circle.len() {
                let [a, b] = [point(&ends[0], k), point(&ends[0], k + 1)];
                let [d, c] = [point(&ends[1], k), point(&ends[1], k + 1)];
                // One of the two is nothing where the line meets the axis.
                if ends[0].0 > 0.0 {
                    weld.add([a, b, c]);
                }
                if ends[1].0 > 0.0 {
                    weld.add([a, c, d]);
                }
            }
        }
    }
    weld.surface
}
