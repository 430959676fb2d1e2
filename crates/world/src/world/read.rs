//! What can be read of a world, in bulk and one by one.

use super::query::late::Late;
use super::{Contact, ShapeId, World};
use crate::bodies::State;
use crate::measure;
use crate::touches::rows;
use crate::{BodyId, Error, Kind, Shape, StepReport};
use rayon::prelude::*;
use rockfall_math::{DVec3, Pose, Quat, Vec3};
use rockfall_solve::row_of;
use std::sync::Arc;

/// Rows of bodies that are alive, and their ids, which ascend.
#[derive(Debug)]
pub(super) struct Sorted {
    rows: Vec<u32>,
    /// Kept as well, since they lie far apart in the columns.
    ids: Vec<BodyId>,
}

impl Sorted {
    fn memory(&self) -> usize {
        self.rows.capacity() * size_of::<u32>() + self.ids.capacity() * size_of::<BodyId>()
    }
}

impl World {
    /// The threads that the world steps with. What else is given to them is done where a step leaves them without work.
    pub fn threads(&self) -> Arc<rayon::ThreadPool> {
        Arc::clone(&self.pool)
    }

    /// What the last step had to say.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// All bodies, sorted by id.
    fn sorted(&self) -> &Sorted {
        self.sorted.get_or_init(|| {
            let alive = |row: &u32| self.bodies.states[*row as usize] != State::Dead;
            let mut rows: Vec<u32> = (1..self.bodies.rows() as u32).filter(alive).collect();
            self.pool.install(|| rows.par_sort_unstable_by_key(|&row| self.bodies.ids[row as usize]));
            let ids = rows.iter().map(|&row| BodyId(self.bodies.ids[row as usize])).collect();
            Sorted { rows, ids }
        })
    }

    /// Rows that follow each other by id lie far apart in memory: a walk over them waits for memory most of the time, so all threads share it.
    fn by_id<T: Send>(&self, read: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
        let rows = &self.sorted().rows;
        self.pool.install(|| rows.par_iter().with_min_len(1024).map(|&row| read(row as usize)).collect())
    }

    /// Ids of all bodies, ascending; the order of [`World::poses`] and the other readers in that order.
    pub fn ids(&self) -> Vec<BodyId> {
        self.sorted().ids.clone()
    }

    /// Poses of the bodies' shape frames, in the order of [`World::ids`].
    pub fn poses(&self) -> Vec<Pose> {
        self.by_id(|row| self.bodies.shape_pose(row))
    }

    /// [`World::poses`] in single precision, written into arrays that are there: metres from `origin`, x, y, z of each body, and x, y, z, w of its
    /// rotation. What has no room is left out.
    pub fn single_poses(&self, origin: DVec3, positions: &mut [f32], rotations: &mut [f32]) {
        let rows = &self.sorted().rows;
        let places = positions.as_chunks_mut::<3>().0.par_iter_mut().zip(rotations.as_chunks_mut::<4>().0);
        self.pool.install(|| {
            places.zip(rows).with_min_len(1024).for_each(|((position, rotation), &row)| {
                let pose = self.bodies.shape_pose(row as usize);
                *position = (pose.position - origin).as_vec3().to_array();
                *rotation = pose.rotation.to_array();
            });
        });
    }

    /// All shapes, by their ids.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Shape of each body, in the order of [`World::ids`].
    pub fn shapes_of_bodies(&self) -> Vec<ShapeId> {
        self.by_id(|row| ShapeId(self.bodies.shapes[row]))
    }

    /// Kind of each body, in the order of [`World::ids`].
    pub fn kinds(&self) -> Vec<Kind> {
        self.by_id(|row| self.bodies.kinds[row])
    }

    /// Whether each body is asleep, in the order of [`World::ids`].
    pub fn sleeping(&self) -> Vec<bool> {
        self.by_id(|row| self.bodies.states[row] == State::Asleep)
    }

    /// Linear (m/s) and angular (rad/s) velocity of each body, in the order of [`World::ids`].
    pub fn velocities(&self) -> Vec<(Vec3, Vec3)> {
        self.by_id(|row| (self.bodies.lines[row].velocity(), self.bodies.lines[row].angular_velocity()))
    }

    /// Kinetic energy of each body, J, in the order of [`World::ids`]; 0 of one that is not dynamic.
    pub fn kinetic_energies(&self) -> Vec<f64> {
        let dynamic = |row: usize| self.bodies.kinds[row] == Kind::Dynamic;
        self.by_id(|row| if dynamic(row) { measure::kinetic(&self.bodies, row) } else { 0.0 })
    }

    /// Ids in the order of the rows in memory: the order of [`World::centers_of_mass`] and [`World::rotations`], which
    /// cost nothing. Rows keep their order until the next step. Row 0 is the world itself and has the id 2⁶⁴ − 1.
    pub fn row_ids(&self) -> &[u64] {
        &self.bodies.ids
    }

    /// Centres of mass (metres) row by row; see [`World::row_ids`].
    pub fn centers_of_mass(&self) -> &[DVec3] {
        &self.bodies.positions
    }

    /// Rotations row by row; see [`World::row_ids`].
    pub fn rotations(&self) -> &[Quat] {
        &self.bodies.rotations
    }

    /// Pose of a body's shape frame.
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn pose(&self, id: BodyId) -> Result<Pose, Error> {
        Ok(self.bodies.shape_pose(self.row(id)?))
    }

    /// Linear velocity of a body's centre of mass (m/s) and angular velocity (rad/s).
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn velocity(&self, id: BodyId) -> Result<(Vec3, Vec3), Error> {
        let line = &self.bodies.lines[self.row(id)?];
        Ok((line.velocity(), line.angular_velocity()))
    }

    /// Mass of a dynamic body, kg; infinite for others.
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn mass(&self, id: BodyId) -> Result<f32, Error> {
        Ok(1.0 / self.bodies.lines[self.row(id)?].inverse_mass())
    }

    /// The shape of a body.
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn shape(&self, id: BodyId) -> Result<&Shape, Error> {
        Ok(&self.shapes[self.bodies.shapes[self.row(id)?] as usize])
    }

    /// A body's name.
    pub fn name(&self, id: BodyId) -> Option<&str> {
        self.names.get(&id.0).map(String::as_str)
    }

    /// Bodies whose state was not finite; they stay where they were. In ascending order.
    pub fn frozen(&self) -> Vec<BodyId> {
        let frozen = |row: &&u32| self.bodies.states[**row as usize] == State::Frozen;
        self.sorted().rows.iter().filter(frozen).map(|&row| BodyId(self.bodies.ids[row as usize])).collect()
    }

    /// The contacts of the last step, those within the speculative margin included, in the order of the rows of their
    /// bodies. Not to be called between [`World::spawn`] or [`World::remove`] and the next step, when it is empty.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let id = |marked: u32| BodyId(self.bodies.ids[row_of(marked)]);
        let whole = |row: u32| self.bodies.states[row_of(row)] != State::Dead;
        let pairs = self.touches.contacts().filter(move |&(key, _)| {
            let (a, b) = rows(key);
            whole(a) && whole(b)
        });
        pairs.flat_map(move |(key, lane)| {
            let (m, memory) = self.contacts.read(lane);
            let (a, b) = rows(key);
            // Bodies have moved since the contact was found; the arms are those of the start of the step.
            let row = row_of(a);
            let start = self.bodies.positions[row] - self.bodies.drifts[row].translation().as_dvec3();
            let pressed = memory.normals.iter().take(m.count as usize).sum::<f32>();
            let share = move |impulse: f32| if pressed > 0.0 { impulse / pressed } else { 0.0 };
            (0..m.count as usize).map(move |p| Contact {
                a: id(a),
                b: id(b),
                position: start + m.arms[p].as_dvec3(),
                normal: m.normal,
                distance: m.distances[p],
                impulse: memory.normals[p],
                friction: memory.friction * share(memory.normals[p]),
            })
        })
    }

    /// A hash of the id, pose and velocity of every body: equal for equal states, whatever the number of threads
    /// or lanes and the order in which bodies were added. It is the sum, modulo 2⁶⁴, over all bodies of the XXH3 (64 bits, without a seed) of 72 bytes
    /// each: the id, the centre of mass x, y, z in double precision, the rotation x, y, z, w, the linear and the angular velocity in
    /// single precision, lowest byte first.
    pub fn hash(&self) -> u64 {
        self.pool.install(|| measure::hash(&self.bodies))
    }

    /// Bytes that the world holds, without shapes.
    pub fn memory(&self) -> usize {
        self.bodies.memory()
            + self.index.memory()
            + self.touches.memory()
            + self.islands.memory()
            + self.contacts.memory()
            + self.moved.capacity()
            + self.starts.capacity() * size_of::<Quat>()
            + self.late.get().map_or(0, Late::memory)
            + (self.rows.capacity() + self.vacant.capacity()) * size_of::<u32>()
            + self.sorted.get().map_or(0, Sorted::memory)
            + self.slots.memory()
    }
}
