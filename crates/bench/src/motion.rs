//! From two poses to velocities.

use rockfall::math::{DVec3, Quat};

/// Axis times angle of a rotation by at most half a turn, rad. Exact for small angles too, where the cosine says nothing.
pub(crate) fn rotation_vector(turn: Quat) -> DVec3 {
    let [x, y, z, w] = turn.to_array().map(f64::from);
    let axis = DVec3::new(x, y, z);
    // |axis| is the sine and w the cosine of half the angle; q and −q are one rotation.
    let angle = 2.0 * axis.length().atan2(w.abs());
    axis.normalize_or_zero() * (angle * if w < 0.0 { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_quaternions_of_a_turn_give_its_vector() {
        for angle in [1e-6f64, 0.3, 3.0] {
            let (sin, cos) = (0.5 * angle).sin_cos();
            let turn = Quat::from_xyzw(0.0, -sin as f32, 0.0, cos as f32);
            for q in [turn, -turn] {
                let vector = rotation_vector(q);
                assert!((vector - DVec3::NEG_Y * angle).length() < 1e-6 * angle, "{vector}");
            }
        }
    }
}
