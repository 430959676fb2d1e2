//! What a run says of one moment.

use crate::{Contacts, Error, Event, Values};
use rockfall::{BodyId, StepReport, World};
use rockfall_math::{DVec3, Pose, Quat, Vec3};

/// What stays the same of each body during a run. A body's row here is its row in every frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyTable {
    /// Ascending, without repetition.
    pub ids: Vec<u64>,
    /// Empty where a body has none.
    pub names: Vec<String>,
    /// Index of the shape; bodies of another scale have another one.
    pub shapes: Vec<u32>,
    /// Factor between the shape that the scene describes and the body's.
    pub scales: Vec<f32>,
}

impl BodyTable {
    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }
}

/// The poses of all bodies of a table; NaN where a body is not in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Poses {
    /// Metres from the run's origin: x, y, z of each body.
    pub positions: Vec<f32>,
    /// Unit quaternions, body to world: x, y, z, w of each body.
    pub orientations: Vec<f32>,
}

impl Poses {
    /// Takes the poses of a world, `ids` ascending as [`rockfall::World::ids`] gives them, into the rows of a table.
    /// Positions lose all but single precision relative to `origin`.
    ///
    /// # Errors
    /// [`Error::UnknownBody`] where the table lacks one of the ids; `self` is of no use then.
    pub fn gather(
        &mut self,
        table: &BodyTable,
        origin: DVec3,
        ids: &[BodyId],
        poses: &[Pose],
    ) -> Result<(), Error> {
        self.positions.clear();
        self.orientations.clear();
        self.positions.resize(3 * table.len(), f32::NAN);
        self.orientations.resize(4 * table.len(), f32::NAN);
        for (row, pose) in rows(table, ids).zip(poses) {
            let row = row?;
            let position = (pose.position - origin).as_vec3();
            self.positions[3 * row..3 * row + 3].copy_from_slice(&position.to_array());
            self.orientations[4 * row..4 * row + 4].copy_from_slice(&pose.rotation.to_array());
        }
        Ok(())
    }

    /// [`Poses::gather`] of what `world` holds, whose ids are `ids`; by all of its threads where all bodies of the table are there.
    ///
    /// # Errors
    /// As [`Poses::gather`].
    pub fn take(
        &mut self,
        world: &World,
        ids: &[BodyId],
        table: &BodyTable,
        origin: DVec3,
    ) -> Result<(), Error> {
        if !ids.iter().map(|id| &id.0).eq(&table.ids) {
            return self.gather(table, origin, ids, &world.poses());
        }
        self.positions.resize(3 * table.len(), f32::NAN);
        self.orientations.resize(4 * table.len(), f32::NAN);
        world.single_poses(origin, &mut self.positions, &mut self.orientations);
        Ok(())
    }

    /// Position, metres from the run's origin, and rotation of the body in a row; `None` where it is not there.
    pub fn at(&self, row: usize) -> Option<(Vec3, Quat)> {
        let position = Vec3::from_slice(self.positions.get(3 * row..3 * row + 3)?);
        let rotation = Quat::from_slice(self.orientations.get(4 * row..4 * row + 4)?);
        position.is_finite().then_some((position, rotation))
    }
}

/// The velocities of all bodies of a table; NaN where a body is not in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Velocities {
    /// Metres per second, of the centre of mass: x, y, z of each body.
    pub linear: Vec<f32>,
    /// Radians per second: x, y, z of each body.
    pub angular: Vec<f32>,
}

impl Velocities {
    /// Takes the velocities of a world, linear and angular, `ids` ascending as [`rockfall::World::ids`] gives them, into the rows of a table.
    ///
    /// # Errors
    /// [`Error::UnknownBody`] where the table lacks one of the ids; `self` is of no use then.
    pub fn gather(
        &mut self,
        table: &BodyTable,
        ids: &[BodyId],
        velocities: &[(Vec3, Vec3)],
    ) -> Result<(), Error> {
        for values in [&mut self.linear, &mut self.angular] {
            values.clear();
            values.resize(3 * table.len(), f32::NAN);
        }
        for (row, (linear, angular)) in rows(table, ids).zip(velocities) {
            let row = row?;
            self.linear[3 * row..3 * row + 3].copy_from_slice(&linear.to_array());
            self.angular[3 * row..3 * row + 3].copy_from_slice(&angular.to_array());
        }
        Ok(())
    }

    /// Linear and angular velocity of the body in a row; `None` where it is not there.
    pub fn at(&self, row: usize) -> Option<(Vec3, Vec3)> {
        let linear = Vec3::from_slice(self.linear.get(3 * row..3 * row + 3)?);
        let angular = Vec3::from_slice(self.angular.get(3 * row..3 * row + 3)?);
        linear.is_finite().then_some((linear, angular))
    }
}

/// The rows of ids that ascend.
pub(crate) fn rows(table: &BodyTable, ids: &[BodyId]) -> impl Iterator<Item = Result<usize, Error>> {
    let mut row = 0;
    ids.iter().map(move |id| {
        while table.ids.get(row).is_some_and(|&known| known < id.0) {
            row += 1;
        }
        if table.ids.get(row) == Some(&id.0) { Ok(row) } else { Err(Error::UnknownBody(id.0)) }
    })
}

/// One moment of a run.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Simulated seconds.
    pub time: f64,
    /// Where the bodies are.
    pub poses: Poses,
    /// How fast they are; empty in a run that does not write it.
    pub velocities: Velocities,
    /// What the step that led here had to say; `None` for the state at the start, which no step led to.
    pub report: Option<StepReport>,
    /// [`rockfall::World::hash`], where it was taken.
    pub hash: Option<u64>,
    /// [`rockfall::World::memory`], bytes; 0 where nobody asked.
    pub memory: u64,
    /// What touches; empty in a run that does not write it.
    pub contacts: Contacts,
    /// What happened in the step that led here; empty in a run that does not write it.
    pub events: Vec<Event>,
    /// The numbers of [`Contents::columns`](crate::Contents::columns), in that order.
    pub columns: Vec<Values>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(ids: &[u64]) -> BodyTable {
        BodyTable {
            ids: ids.to_vec(),
            names: vec![String::new(); ids.len()],
            shapes: vec![0; ids.len()],
            scales: vec![1.0; ids.len()],
        }
    }

    #[test]
    fn absent_bodies_are_nan_and_the_rest_keep_their_rows() {
        let pose = Pose {
            position: DVec3::new(1.0e7 + 0.5, 2.0, 3.0),
            rotation: Quat::from_xyzw(0.0, 0.0, 0.6, 0.8),
        };
        let mut poses = Poses::default();
        let origin = DVec3::new(1.0e7, 0.0, 0.0);
        poses.gather(&table(&[2, 5, 9]), origin, &[BodyId(5)], &[pose]).unwrap();
        assert!(poses.positions[..3].iter().all(|x| x.is_nan()));
        assert_eq!(poses.positions[3..6], [0.5, 2.0, 3.0]);
        assert_eq!(poses.orientations[4..8], [0.0, 0.0, 0.6, 0.8]);
        assert!(poses.orientations[8..].iter().all(|x| x.is_nan()));
        let mut velocities = Velocities::default();
        velocities.gather(&table(&[2, 5, 9]), &[BodyId(5)], &[(Vec3::X, Vec3::Z)]).unwrap();
        assert_eq!(
            (&velocities.linear[3..6], &velocities.angular[3..6]),
            (&[1.0, 0.0, 0.0][..], &[0.0, 0.0, 1.0][..])
        );
        let others = velocities.linear[..3].iter().chain(&velocities.angular[6..]);
        assert!(others.copied().all(f32::is_nan));
    }

    #[test]
    fn a_body_without_a_row_is_refused() {
        let mut poses = Poses::default();
        for id in [1, 4, 10] {
            let error = poses.gather(&table(&[2, 5, 9]), DVec3::ZERO, &[BodyId(id)], &[Pose::default()]);
            assert!(matches!(error, Err(Error::UnknownBody(unknown)) if unknown == id));
        }
    }
}
