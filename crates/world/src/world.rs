//! The world: bodies, shapes, materials, and `step()`.

use crate::{Body, BodyId, Error, Kind, Material, Settings, Shape, StepReport};
use rockfall_math::{DVec3, Pose, Vec3};

/// A shape of a [`World`], shared by any number of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(pub(crate) u32);

/// A material of a [`World`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub(crate) u32);

impl ShapeId {
    /// Shapes are numbered from 0 in the order in which they were added.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl MaterialId {
    /// Materials are numbered from 0 in the order in which they were added.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// One contact point, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The body with the normal's tail.
    pub a: BodyId,
    /// The body that the normal points into.
    pub b: BodyId,
    /// Half-way between the surfaces, metres.
    pub position: DVec3,
    /// Unit vector from `a` to `b`.
    pub normal: Vec3,
    /// Signed distance, metres; negative where the bodies overlap.
    pub distance: f32,
    /// Normal impulse of the last sub-step, N s.
    pub impulse: f32,
}

/// Bodies, shapes, materials, and the state that goes on from one step to the next.
#[derive(Debug)]
pub struct World {
    settings: Settings,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first setting that is out of range; [`Error::Threads`].
    pub fn new(settings: Settings) -> Result<Self, Error> {
        Ok(World { settings })
    }

    /// The settings, as given.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Adds a shape.
    pub fn add_shape(&mut self, _shape: Shape) -> ShapeId {
        todo!()
    }

    /// Adds a material.
    ///
    /// # Errors
    /// [`Error::Value`] where a number is out of range.
    pub fn add_material(&mut self, _material: Material) -> Result<MaterialId, Error> {
        todo!()
    }

    /// Adds a body; it takes part from the next step.
    ///
    /// # Errors
    /// Says what is wrong with the body; the world is left as it was.
    pub fn spawn(&mut self, _body: Body) -> Result<BodyId, Error> {
        todo!()
    }

    /// Adds bodies in bulk; all of them or none.
    ///
    /// # Errors
    /// That of the first body that can't be added.
    pub fn spawn_all(&mut self, _bodies: impl IntoIterator<Item = Body>) -> Result<Vec<BodyId>, Error> {
        todo!()
    }

    /// Removes a body.
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn remove(&mut self, _id: BodyId) -> Result<(), Error> {
        todo!()
    }

    /// Advances the world by one step of `1 / rate` seconds.
    pub fn step(&mut self) -> &StepReport {
        todo!()
    }

    /// What the last step had to say.
    pub fn report(&self) -> &StepReport {
        todo!()
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        todo!()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Ids of all bodies, ascending; the order of [`World::poses`] and the other bulk readers.
    pub fn ids(&self) -> Vec<BodyId> {
        todo!()
    }

    /// Poses of the bodies' shape frames, in the order of [`World::ids`].
    pub fn poses(&self) -> Vec<Pose> {
        todo!()
    }

    /// Shape of each body, in the order of [`World::ids`].
    pub fn shapes_of_bodies(&self) -> Vec<ShapeId> {
        todo!()
    }

    /// Kind of each body, in the order of [`World::ids`].
    pub fn kinds(&self) -> Vec<Kind> {
        todo!()
    }

    /// A body's name.
    pub fn name(&self, _id: BodyId) -> Option<&str> {
        todo!()
    }

    /// The contacts of the last step, in a canonical order.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        std::iter::empty()
    }

    /// A hash of the id, pose and velocity of every body: equal for equal states, whatever the number of threads
    /// or lanes and the order in which bodies were added.
    pub fn hash(&self) -> u64 {
        todo!()
    }

    /// Bytes that the world holds.
    pub fn memory(&self) -> usize {
        todo!()
    }
}
