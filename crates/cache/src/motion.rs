//! How bodies move, from two poses.

use rockfall_math::{Quat, Vec3, rotation, trig};

/// Mean velocity, m/s, and angular velocity, rad/s, between two poses at two times: seconds, metres and unit quaternions. It is that of the frame
/// of the shape, whose position a pose has, and not that of the centre of mass.
///
/// # Examples
/// ```
/// use rockfall_cache::mean_velocities;
/// use rockfall_math::{Quat, Vec3};
///
/// let (v, w) = mean_velocities((1.0, Vec3::ZERO, Quat::IDENTITY), (1.5, Vec3::X, Quat::IDENTITY));
/// assert_eq!((v, w), (2.0 * Vec3::X, Vec3::ZERO));
/// ```
pub fn mean_velocities(from: (f64, Vec3, Quat), to: (f64, Vec3, Quat)) -> (Vec3, Vec3) {
    let rate = 1.0 / (to.0 - from.0) as f32;
    // Two equal times: a store that says so is damaged; no number that follows from it makes sense.
    if !rate.is_finite() {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    let turn = rotation::compose(to.2, rotation::inverse(from.2));
    ((to.1 - from.1) * rate, rotation_vector(turn) * rate)
}

/// The axis of a rotation times its angle, radians, the short way round.
fn rotation_vector(q: Quat) -> Vec3 {
    let (axis, w) = if q.w < 0.0 { (-q.xyz(), -q.w) } else { (q.xyz(), q.w) };
    let sine = axis.length();
    // Where the sine of half the angle vanishes, so does its difference from the angle.
    let factor = if sine > 1e-12 { 2.0 * trig::atan2(sine, w) / sine } else { 2.0 };
    axis * factor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_vector_is_the_inverse_of_the_exponential_map() {
        for v in [Vec3::ZERO, Vec3::X * 1e-9, Vec3::new(0.1, -0.2, 0.3), Vec3::Y * 3.1, Vec3::Z * -2.0] {
            assert!((rotation_vector(rotation::from_rotation_vector(v)) - v).length() < 2e-6, "{v}");
        }
    }
}
