//! A box and a sphere: the closed form.

use crate::closest::{CONCENTRIC, Closest};
use crate::feature;
use rockfall_math::Vec3;

/// The box around the origin with half extents `half`, and a point.
pub(crate) fn point(half: Vec3, p: Vec3) -> Closest {
    let on_box = p.clamp(-half, half);
    let between = p - on_box;
    let distance = between.length();
    if distance > CONCENTRIC {
        let feature = feature::pair(region(between), 0);
        return Closest { distance, normal: between / distance, on_a: on_box, on_b: p, feature };
    }
    // Inside: out through the nearest face.
    let depths = half - p.abs();
    let (axis, name) = if depths.x <= depths.y && depths.x <= depths.z {
        (Vec3::X, 12)
    } else if depths.y <= depths.z {
        (Vec3::Y, 10)
    } else {
        (Vec3::Z, 4)
    };
    let positive = axis.dot(p) >= 0.0;
    let normal = if positive { axis } else { -axis };
    let depth = axis.dot(depths);
    // The name that the region beyond that face has.
    let name = if positive { 26 - name } else { name };
    Closest { distance: -depth, normal, on_a: p + depth * normal, on_b: p, feature: feature::pair(name, 0) }
}

/// Names where a point is, by the way to it from the box: each coordinate is below, within or above, which makes 27 regions.
pub(crate) fn region(between: Vec3) -> usize {
    let side = |x: f32| if x < 0.0 { 0 } else { 1 + usize::from(x > 0.0) };
    side(between.x) + 3 * side(between.y) + 9 * side(between.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Vec3 = Vec3::new(1.0, 2.0, 3.0);

    #[test]
    fn face_edge_corner_and_inside_by_hand() {
        let c = point(HALF, Vec3::new(1.5, 0.0, 0.0));
        assert_eq!((c.distance, c.normal, c.on_a), (0.5, Vec3::X, Vec3::X));
        let c = point(HALF, Vec3::new(4.0, 6.0, 0.0));
        assert_eq!((c.distance, c.on_a), (5.0, Vec3::new(1.0, 2.0, 0.0)));
        let c = point(HALF, Vec3::new(-0.75, 0.0, 0.0));
        assert_eq!((c.distance, c.normal, c.on_a), (-0.25, -Vec3::X, -Vec3::X));
        let c = point(HALF, Vec3::ZERO);
        assert_eq!((c.distance, c.normal.length()), (-1.0, 1.0));
    }

    #[test]
    fn the_name_stays_when_the_point_sinks_into_a_face() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            let surface = axis * HALF.dot(axis.abs());
            let (outside, inside) = (point(HALF, surface * 1.01), point(HALF, surface * 0.99));
            assert_eq!(outside.feature, inside.feature);
            assert_eq!(outside.normal, inside.normal);
        }
    }
}
