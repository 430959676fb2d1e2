//! Where bodies are at a frame, and how they move.
//!
//! The store has poses. A velocity is the mean over the step that led to the frame: the difference of two poses by the difference of their times. Of a
//! body that has just come it is the mean over the step that follows; of one that is there at a single frame it is zero. So the velocity is that of the
//! frame of the shape, whose position the store has, and not that of the centre of mass; and where positions are in the hundreds of metres their last bit
//! of single precision, some 0.03 mm, makes some 2 mm/s at 60 frames per second.

use rockfall_cache::Poses;
use rockfall_math::{Quat, Vec3, rotation, trig};

/// Bodies at a frame: those that are there, of those that were asked for. All columns have a row for each of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Number of the frame in the run.
    pub frame: u64,
    /// Simulated seconds.
    pub time: f64,
    /// Rows in the run's table of bodies, ascending.
    pub rows: Vec<u32>,
    /// Metres from the run's origin.
    pub positions: Vec<[f32; 3]>,
    /// Unit quaternions x, y, z, w, body to world.
    pub rotations: Vec<[f32; 4]>,
    /// Of the frame of the shape, m/s. Empty where nobody asked for motion.
    pub velocities: Vec<[f32; 3]>,
    /// Angular velocities, rad/s, world axes. Empty where nobody asked for motion.
    pub spins: Vec<[f32; 3]>,
}

/// Poses at a frame of the run, in the order of its table, and their time.
pub(crate) type Timed<'a> = (f64, &'a Poses);

impl Moment {
    /// Those of `rows` that are there at frame `frame`, without motion.
    pub(crate) fn still(frame: u64, (time, poses): Timed<'_>, rows: &[u32]) -> Self {
        let mut moment = Moment { frame, time, ..Moment::default() };
        for &row in rows {
            if let Some((position, rotation)) = pose(poses, row) {
                moment.rows.push(row);
                moment.positions.push(position.to_array());
                moment.rotations.push(rotation.to_array());
            }
        }
        moment
    }

    /// Adds the motion, from the frames just before and just after in the run.
    pub(crate) fn move_by(&mut self, before: Option<Timed<'_>>, after: Option<Timed<'_>>) {
        for ((&row, position), rotation) in self.rows.iter().zip(&self.positions).zip(&self.rotations) {
            let here = (self.time, Vec3::from_array(*position), Quat::from_array(*rotation));
            let other = |at: Option<Timed<'_>>| {
                let (time, poses) = at?;
                let (position, rotation) = pose(poses, row)?;
                Some((time, position, rotation))
            };
            let (velocity, spin) = match (other(before), other(after)) {
                (Some(before), _) => mean(before, here),
                (None, Some(after)) => mean(here, after),
                (None, None) => (Vec3::ZERO, Vec3::ZERO),
            };
            self.velocities.push(velocity.to_array());
            self.spins.push(spin.to_array());
        }
    }
}

/// Position and rotation of a body that is there.
fn pose(poses: &Poses, row: u32) -> Option<(Vec3, Quat)> {
    let row = row as usize;
    let position = Vec3::from_slice(poses.positions.get(3 * row..3 * row + 3)?);
    let rotation = Quat::from_slice(poses.orientations.get(4 * row..4 * row + 4)?);
    position.is_finite().then_some((position, rotation))
}

/// Mean velocity and angular velocity between two poses at two times.
fn mean(from: (f64, Vec3, Quat), to: (f64, Vec3, Quat)) -> (Vec3, Vec3) {
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

    fn poses(bodies: &[Option<(Vec3, Quat)>]) -> Poses {
        let absent = (Vec3::NAN, Quat::NAN);
        let bodies = || bodies.iter().map(|body| body.unwrap_or(absent));
        Poses {
            positions: bodies().flat_map(|(p, _)| p.to_array()).collect(),
            orientations: bodies().flat_map(|(_, q)| q.to_array()).collect(),
        }
    }

    #[test]
    fn motion_is_that_of_the_step_before_or_of_the_first_one_after() {
        let spin = Vec3::new(3.0, -2.0, 1.0);
        let at = |t: f32| {
            let rotation = rotation::compose(
                rotation::from_rotation_vector(spin * t),
                Quat::from_xyzw(0.5, 0.5, 0.5, 0.5),
            );
            // Another sign is the same rotation.
            Some((Vec3::new(2.0 * t, 0.0, t * t), if t > 0.1 { -rotation } else { rotation }))
        };
        let (before, here, after) = (
            poses(&[at(0.0), None, None, None]),
            poses(&[at(0.125), at(0.125), at(0.125), None]),
            poses(&[at(0.25), at(0.25), None, at(0.25)]),
        );
        let mut moment = Moment::still(7, (0.125, &here), &[0, 1, 2, 3]);
        moment.move_by(Some((0.0, &before)), Some((0.25, &after)));
        assert_eq!((moment.frame, &moment.rows[..]), (7, &[0, 1, 2][..]));
        assert_eq!(moment.velocities, [[2.0, 0.0, 0.125], [2.0, 0.0, 0.375], [0.0; 3]]);
        for found in &moment.spins[..2] {
            assert!((Vec3::from_array(*found) - spin).length() < 1e-5, "{found:?}");
        }
        assert_eq!(moment.spins[2], [0.0; 3]);
    }

    #[test]
    fn a_rotation_vector_is_the_inverse_of_the_exponential_map() {
        for v in [Vec3::ZERO, Vec3::X * 1e-9, Vec3::new(0.1, -0.2, 0.3), Vec3::Y * 3.1, Vec3::Z * -2.0] {
            assert!((rotation_vector(rotation::from_rotation_vector(v)) - v).length() < 2e-6, "{v}");
        }
    }
}
