//! How bodies move, from two poses.

use rockfall_math::{Quat, Vec3, rotation};

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
    ((to.1 - from.1) * rate, rotation::to_rotation_vector(turn) * rate)
}
