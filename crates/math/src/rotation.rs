//! Quaternions with a fixed order of operations.
//!
//! `glam` picks another instruction sequence for `Quat` on each processor family; these functions spell out
//! every product and sum, so that the bits are the same on all of them.

use crate::trig;
use glam::{DVec3, Quat, Vec3};

/// Rotates `v` by the unit quaternion `q`: v + 2w (u × v) + 2u × (u × v).
#[inline]
pub fn rotate(q: Quat, v: Vec3) -> Vec3 {
    let u = Vec3::new(q.x, q.y, q.z);
    let t = 2.0 * u.cross(v);
    v + q.w * t + u.cross(t)
}

/// Rotates `v` by the inverse of the unit quaternion `q`.
#[inline]
pub fn rotate_back(q: Quat, v: Vec3) -> Vec3 {
    let u = Vec3::new(-q.x, -q.y, -q.z);
    let t = 2.0 * u.cross(v);
    v + q.w * t + u.cross(t)
}

/// [`rotate_back`] in double precision. Linear in `v` whatever the length of `q`: a line stays the line, and its parameter too.
#[inline]
pub fn rotate_back_double(q: Quat, v: DVec3) -> DVec3 {
    let u = DVec3::new(f64::from(-q.x), f64::from(-q.y), f64::from(-q.z));
    let t = 2.0 * u.cross(v);
    v + f64::from(q.w) * t + u.cross(t)
}

/// The rotation `b`, then `a`.
#[inline]
pub fn compose(a: Quat, b: Quat) -> Quat {
    Quat::from_xyzw(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )
}

/// The opposite rotation of a unit quaternion.
#[inline]
pub fn inverse(q: Quat) -> Quat {
    Quat::from_xyzw(-q.x, -q.y, -q.z, q.w)
}

/// `q` at unit length; the identity where `q` has no length.
#[inline]
pub fn normalize(q: Quat) -> Quat {
    let squared = (q.x * q.x + q.y * q.y) + (q.z * q.z + q.w * q.w);
    let inverse = 1.0 / squared.sqrt();
    if inverse.is_finite() && squared > 0.0 {
        Quat::from_xyzw(q.x * inverse, q.y * inverse, q.z * inverse, q.w * inverse)
    } else {
        Quat::IDENTITY
    }
}

/// The quaternion as it is where its length is one to rounding, else [`normalize`]d: once more would change last bits, and a state that is put back has to be what it was.
pub fn unit(q: Quat) -> Quat {
    let squared = (q.x * q.x + q.y * q.y) + (q.z * q.z + q.w * q.w);
    if (squared - 1.0).abs() <= 4.0 * f32::EPSILON { q } else { normalize(q) }
}

/// The rotation about `v` by `|v|` radians: the exponential map, exact for a constant angular velocity.
#[inline]
pub fn from_rotation_vector(v: Vec3) -> Quat {
    let angle_squared = v.length_squared();
    let (s, w) = if angle_squared < 1e-6 {
        // sin(θ/2)/θ and cos(θ/2) as series; the next terms are below the last bit.
        (0.5 - angle_squared / 48.0, 1.0 - angle_squared / 8.0)
    } else {
        let angle = angle_squared.sqrt();
        let (sin, cos) = trig::sin_cos(0.5 * angle);
        (sin / angle, cos)
    };
    Quat::from_xyzw(v.x * s, v.y * s, v.z * s, w)
}

/// Axis times angle, radians, of a unit quaternion: the inverse of [`from_rotation_vector`] up to half a turn; beyond that the way round is shorter
/// on the other side.
pub fn to_rotation_vector(q: Quat) -> Vec3 {
    let v = Vec3::new(q.x, q.y, q.z) * q.w.signum();
    let sin = v.length();
    if sin > 0.0 { v * (2.0 * trig::atan2(sin, q.w.abs()) / sin) } else { Vec3::ZERO }
}

/// The shortest rotation that takes the unit vector `a` to the unit vector `b`.
pub fn between(a: Vec3, b: Vec3) -> Quat {
    let dot = a.dot(b);
    if dot < -0.999_999 {
        let side = if a.x.abs() < 0.5 { Vec3::X } else { Vec3::Y };
        let axis = a.cross(side).normalize();
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let c = a.cross(b);
    normalize(Quat::from_xyzw(c.x, c.y, c.z, 1.0 + dot))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn close(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn agrees_with_glam() {
        let a = normalize(Quat::from_xyzw(0.1, -0.4, 0.3, 0.8));
        let b = normalize(Quat::from_xyzw(-0.6, 0.2, 0.1, 0.2));
        let v = Vec3::new(1.0, 2.0, -3.0);
        assert!(close(rotate(a, v), a * v));
        assert!(close(rotate_back(a, rotate(a, v)), v));
        assert!(close(rotate_back_double(a, v.as_dvec3()).as_vec3(), rotate_back(a, v)));
        assert!(close(rotate(compose(a, b), v), rotate(a, rotate(b, v))));
        assert!(close(rotate(compose(a, inverse(a)), v), v));
    }

    #[test]
    fn exponential_map_turns_by_its_length() {
        for angle in [1e-4_f32, 1e-3, 0.01, 1.0, 3.0] {
            let q = from_rotation_vector(Vec3::Z * angle);
            assert!(close(rotate(q, Vec3::X), Vec3::new(trig::cos(angle), trig::sin(angle), 0.0)));
        }
    }

    #[test]
    fn a_rotation_vector_comes_back_as_the_shorter_way_round() {
        let axis = Vec3::new(0.6, 0.0, -0.8);
        for (angle, back) in
            [(0.0, 0.0), (1e-6, 1e-6), (0.01, 0.01), (1.0, 1.0), (3.0, 3.0), (4.0, 4.0 - 2.0 * PI)]
        {
            let v = to_rotation_vector(from_rotation_vector(axis * angle));
            assert!(v.distance(axis * back) < 1e-6, "{angle}: {v}");
        }
        for v in [Vec3::X * 1e-9, Vec3::new(0.1, -0.2, 0.3), Vec3::Y * 3.1, Vec3::Z * -2.0] {
            assert!((to_rotation_vector(from_rotation_vector(v)) - v).length() < 2e-6, "{v}");
        }
    }

    #[test]
    fn between_takes_a_to_b() {
        for (a, b) in [(Vec3::X, Vec3::Y), (Vec3::Z, -Vec3::Z), (Vec3::X, Vec3::X), (Vec3::X, -Vec3::X)] {
            assert!(close(rotate(between(a, b), a), b));
        }
    }

    #[test]
    fn no_length_gives_the_identity() {
        assert_eq!(normalize(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)), Quat::IDENTITY);
    }

    #[test]
    fn what_is_normalized_is_a_unit_and_stays() {
        for k in 0..1000 {
            let x = k as f32 * 0.37;
            let q = normalize(Quat::from_xyzw(trig::sin_cos(x).0, 0.3, trig::sin_cos(2.3 * x).1, 1.7));
            assert_eq!(unit(q), q);
        }
        assert_eq!(unit(Quat::from_xyzw(0.0, 0.0, 0.0, 2.0)), Quat::IDENTITY);
    }
}
