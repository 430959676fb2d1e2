//! A cylinder or a cone and a point: the closed form, in the half plane through the axis and the point.

use crate::closest::Closest;
use crate::feature;
use rockfall_math::{DVec3, Vec3};
use rockfall_shape::Frustum;

/// Names of the parts of the surface.
const LOWER_END: usize = 0;
const SIDE: usize = 1;
const UPPER_END: usize = 2;
const LOWER_RIM: usize = 3;
const UPPER_RIM: usize = 4;

/// A frustum and a point.
pub(crate) fn point(a: &Frustum, p: Vec3) -> Closest {
    let to = p.as_dvec3();
    let away = (to.x * to.x + to.y * to.y).sqrt();
    // On the axis all sides are the same.
    let radial = if away > 0.0 { DVec3::new(to.x / away, to.y / away, 0.0) } else { DVec3::X };
    let (h, lower, upper) = (f64::from(a.half_length), f64::from(a.lower), f64::from(a.upper));
    let (across, along) = a.side();
    let (over_lower, over_upper) = (-h - to.z, to.z - h);
    let over_side = across * (away - lower) + along * (to.z + h);

    // Distance, normal and name, in the half plane: (away from the axis, along it).
    let (distance, normal, name) = if over_lower <= 0.0 && over_upper <= 0.0 && over_side <= 0.0 {
        // Inside: the nearest of the three lines.
        if over_side >= over_lower && over_side >= over_upper {
            (over_side, (across, along), SIDE)
        } else if over_lower >= over_upper {
            (over_lower, (0.0, -1.0), LOWER_END)
        } else {
            (over_upper, (0.0, 1.0), UPPER_END)
        }
    } else {
        // How far up the side the point is: from 0 at the lower rim to its length.
        let up = -along * (away - lower) + across * (to.z + h);
        let length = ((upper - lower) * (upper - lower) + 4.0 * h * h).sqrt();
        if over_lower > 0.0 && away <= lower {
            (over_lower, (0.0, -1.0), LOWER_END)
        } else if over_upper > 0.0 && away <= upper {
            (over_upper, (0.0, 1.0), UPPER_END)
        } else if up > 0.0 && up < length {
            (over_side, (across, along), SIDE)
        } else {
            let (radius, z, name) = if up <= 0.0 { (lower, -h, LOWER_RIM) } else { (upper, h, UPPER_RIM) };
            let (dx, dz) = (away - radius, to.z - z);
            let distance = (dx * dx + dz * dz).sqrt();
            if distance > 0.0 {
                (distance, (dx / distance, dz / distance), name)
            } else {
                (0.0, (across, along), name)
            }
        }
    };
    let normal = radial * normal.0 + DVec3::Z * normal.1;
    Closest {
        distance: distance as f32,
        normal: normal.as_vec3(),
        on_a: (to - distance * normal).as_vec3(),
        on_b: p,
        feature: feature::pair(name, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_side_rims_and_inside_by_hand() {
        let drum = Frustum { half_length: 1.0, lower: 2.0, upper: 2.0 };
        let at = |x: f32, z: f32| point(&drum, Vec3::new(0.0, x, z));
        let c = at(1.0, 3.0);
        assert_eq!((c.distance, c.normal, c.on_a), (2.0, Vec3::Z, Vec3::new(0.0, 1.0, 1.0)));
        assert_eq!((at(1.0, -3.0).distance, at(1.0, -3.0).normal), (2.0, -Vec3::Z));
        assert_eq!((at(5.0, 0.5).distance, at(5.0, 0.5).normal), (3.0, Vec3::Y));
        let c = at(5.0, -5.0);
        assert_eq!((c.distance, c.on_a), (5.0, Vec3::new(0.0, 2.0, -1.0)));
        assert_eq!((at(0.0, 0.75).distance, at(0.0, 0.75).normal), (-0.25, Vec3::Z));
        assert_eq!((at(1.5, 0.0).distance, at(1.5, 0.0).normal), (-0.5, Vec3::Y));

        let cone = Frustum { half_length: 1.0, lower: 2.0, upper: 0.0 };
        let c = point(&cone, Vec3::new(0.0, 0.0, 4.0));
        assert_eq!((c.distance, c.on_a), (3.0, Vec3::Z));
        // The side is at 45 degrees through (2, -1) and (0, 1).
        let c = point(&cone, Vec3::new(2.0, 0.0, 1.0));
        assert!((c.distance - 2.0_f32.sqrt()).abs() < 1e-6 && (c.on_a - Vec3::X).length() < 1e-6);
        // Beyond the tip, but nearer to the lower rim.
        let c = point(&cone, Vec3::new(2.5, 0.0, -1.25));
        assert_eq!(c.on_a, Vec3::new(2.0, 0.0, -1.0));
    }
}
