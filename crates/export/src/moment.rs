//! Where bodies are at a frame, and how they move.
//!
//! Where the run has velocities, they are those of the frame: at that moment, moved from the centre of mass to the frame of the shape, whose position the
//! store has. Where it has poses alone, a velocity is the mean over the step that led to the frame: the difference of two poses by the difference of their times. Of a
//! body that has just come it is the mean over the step that follows; of one that is there at a single frame it is zero. Where positions are in the hundreds
//! of metres their last bit of single precision, some 0.03 mm, makes some 2 mm/s at 60 frames per second.

use rockfall_cache::{Poses, Values, Velocities, mean_velocities};
use rockfall_math::{Quat, Vec3, rotation::rotate};

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
    /// The columns of the run ([`Run::columns`](crate::Run::columns)). Empty where nobody asked for them.
    pub columns: Vec<Values>,
}

/// Poses at a frame of the run, in the order of its table, and their time.
pub(crate) type Timed<'a> = (f64, &'a Poses);

impl Moment {
    /// Those of `rows` that are there at frame `frame`, without motion.
    pub(crate) fn still(frame: u64, (time, poses): Timed<'_>, rows: &[u32]) -> Self {
        let mut moment = Moment { frame, time, ..Moment::default() };
        for &row in rows {
            if let Some((position, rotation)) = poses.at(row as usize) {
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
                let (position, rotation) = poses.at(row as usize)?;
                Some((time, position, rotation))
            };
            let (velocity, spin) = match (other(before), other(after)) {
                (Some(before), _) => mean_velocities(before, here),
                (None, Some(after)) => mean_velocities(here, after),
                (None, None) => (Vec3::ZERO, Vec3::ZERO),
            };
            self.velocities.push(velocity.to_array());
            self.spins.push(spin.to_array());
        }
    }

    /// Adds the motion that the run has, of centres of mass, which lie at `centers` in the frames of the shapes.
    pub(crate) fn move_with(&mut self, velocities: &Velocities, centers: &[Vec3]) {
        for (&row, rotation) in self.rows.iter().zip(&self.rotations) {
            let (velocity, spin) = velocities.at(row as usize).unwrap_or_default();
            let arm = rotate(Quat::from_array(*rotation), centers[row as usize]);
            self.velocities.push((velocity - spin.cross(arm)).to_array());
            self.spins.push(spin.to_array());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::rotation;

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
    fn stored_motion_is_moved_from_the_centre_of_mass_to_the_frame_of_the_shape() {
        // A quarter of a turn about z takes the arm from x to y.
        let quarter = Quat::from_xyzw(0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt());
        let here = poses(&[None, Some((Vec3::ONE, quarter))]);
        let velocities = Velocities {
            linear: vec![f32::NAN, f32::NAN, f32::NAN, 1.0, 0.0, 0.0],
            angular: vec![0.0, 0.0, 0.0, 0.0, 0.0, 2.0],
        };
        let mut moment = Moment::still(0, (0.0, &here), &[0, 1]);
        moment.move_with(&velocities, &[Vec3::ZERO, 0.5 * Vec3::X]);
        let [[x, y, z]] = moment.velocities[..] else { panic!("one body is there") };
        // The frame's origin lies half a metre below the centre of mass, and is faster by 2 rad/s times that.
        assert!((Vec3::new(x, y, z) - Vec3::new(2.0, 0.0, 0.0)).length() < 1e-6);
        assert_eq!(moment.spins, [[0.0, 0.0, 2.0]]);
    }
}
