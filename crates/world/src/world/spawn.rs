//! Bodies come, go, and are pushed.

use super::World;
use crate::bodies::{BodyRow, Mass, State};
use crate::{Body, BodyId, Error, Kind, Shape};
use rockfall_math::{Pose, Vec3, rotation};

impl World {
    /// Adds a body; it takes part from the next step.
    ///
    /// # Errors
    /// Says what is wrong with the body; the world is left as it was.
    pub fn spawn(&mut self, body: Body) -> Result<BodyId, Error> {
        let (id, mass) = self.admit(&body, |id| self.slots.get(id).is_some(), self.next_id)?;
        self.enter(body, id, &mass);
        Ok(BodyId(id))
    }

    /// Adds bodies in bulk; all of them or none. The ids are in the order of the bodies.
    ///
    /// # Errors
    /// That of the first body that can't be added.
    pub fn spawn_all(&mut self, bodies: impl IntoIterator<Item = Body>) -> Result<Vec<BodyId>, Error> {
        let bodies: Vec<Body> = bodies.into_iter().collect();
        let mut admitted = Vec::with_capacity(bodies.len());
        let mut taken = std::collections::HashSet::with_capacity(bodies.len());
        let mut next = self.next_id;
        for body in &bodies {
            let (id, mass) =
                self.admit(body, |id| self.slots.get(id).is_some() || taken.contains(&id), next)?;
            taken.insert(id);
            next = next.max(id.saturating_add(1));
            admitted.push((id, mass));
        }
        for (body, (id, mass)) in bodies.into_iter().zip(&admitted) {
            self.enter(body, *id, mass);
        }
        Ok(admitted.into_iter().map(|(id, _)| BodyId(id)).collect())
    }

    /// Checks a body; its id is the one that it asks for or `next`.
    fn admit(&self, body: &Body, taken: impl Fn(u64) -> bool, next: u64) -> Result<(u64, Mass), Error> {
        body.check()?;
        let id = body.id.map_or(next, |id| id.0);
        if id == u64::MAX {
            return Err(Error::Value { what: "id", value: id.to_string(), expected: "0 to 2^64 - 2" });
        }
        if taken(id) {
            return Err(Error::Duplicate(BodyId(id)));
        }
        Ok((id, self.mass_of(body)?))
    }

    fn enter(&mut self, body: Body, id: u64, mass: &Mass) {
        self.handled = true;
        let slot = self.vacant.pop().unwrap_or(self.rows.len() as u32);
        if slot as usize == self.rows.len() {
            self.rows.push(0);
        }
        self.rows[slot as usize] = self.bodies.rows() as u32;
        self.slots.insert(id, slot);
        self.bodies.push(BodyRow::of(&body, id, slot, mass));
        if body.sensor {
            self.sensors.insert(id, body.mask);
        }
        self.next_id = self.next_id.max(id.saturating_add(1));
        self.fresh += 1;
        self.sorted.take();
        self.late.take();
        if let Some(name) = body.name {
            self.names.insert(id, name);
        }
    }

    /// Mass properties of a body: those of shape and density unless overridden.
    fn mass_of(&self, body: &Body) -> Result<Mass, Error> {
        let index = body.shape.index();
        let shape = self.shapes.get(index).ok_or(Error::Unknown { what: "shape", index: index as u32 })?;
        let material = self
            .materials
            .get(body.material.index())
            .ok_or(Error::Unknown { what: "material", index: body.material.0 })?;
        let sphere = matches!(shape, Shape::Sphere { .. });
        // Partners reach for a surface that they don't move, as large as it may be beside them.
        let is_ground = body.kind != Kind::Dynamic && matches!(shape, Shape::Mesh(_));
        let inner_radius =
            Some(shape.contact_scale()).filter(|r| r.is_finite() && !is_ground).unwrap_or_default();
        if body.kind != Kind::Dynamic {
            let radius = shape.radius_about(Vec3::ZERO);
            return Ok(Mass { radius, inner_radius, sphere, ..Mass::default() });
        }
        let unit = self.masses.get(&index).copied().or_else(|| shape.mass_properties(1.0));
        let solid = unit.filter(|_| shape.can_move());
        let unit = solid.ok_or(Error::Immovable { shape: immovable(shape) })?;
        let mut mass = unit.with_mass(unit.mass * material.density);
        if let Some(other) = &body.mass {
            if let Some(center) = other.center {
                if !center.is_finite() {
                    let value = center.to_string();
                    return Err(Error::Value {
                        what: "centre of mass",
                        value,
                        expected: "three finite numbers",
                    });
                }
                // The inertia is about the centre of mass, wherever that is.
                mass.center = center;
            }
            mass = mass.with_mass(other.mass);
            if let Some(inertia) = other.inertia {
                mass.inertia = inertia;
            }
        }
        if !(mass.mass.is_finite() && mass.mass > 0.0 && (1.0 / mass.mass).is_finite()) {
            let value = mass.mass.to_string();
            return Err(Error::Value { what: "mass", value, expected: "a positive number" });
        }
        let (moments, frame) = mass.principal();
        let inverse_moments = 1.0 / moments;
        if !(moments.is_finite() && moments.min_element() > 0.0 && inverse_moments.is_finite()) {
            let value = mass.inertia.to_string();
            return Err(Error::Value {
                what: "inertia",
                value,
                expected: "a symmetric positive definite matrix",
            });
        }
        Ok(Mass {
            inverse_mass: 1.0 / mass.mass,
            inverse_moments,
            frame,
            center: mass.center,
            radius: shape.radius_about(mass.center),
            inner_radius,
            sphere,
        })
    }

    /// Removes a body. Bodies that rested on it wake with the next step.
    ///
    /// # Errors
    /// [`Error::NoBody`].
    pub fn remove(&mut self, id: BodyId) -> Result<(), Error> {
        let row = self.row(id)?;
        self.handled = true;
        self.bodies.states[row] = State::Dead;
        self.vacant.extend(self.slots.remove(id.0));
        self.names.remove(&id.0);
        self.sensors.remove(&id.0);
        self.sorted.take();
        Ok(())
    }

    /// Sets the velocities of a dynamic or kinematic body, m/s and rad/s, and wakes it.
    ///
    /// # Errors
    /// [`Error::NoBody`]; [`Error::Value`] for numbers that are not finite.
    pub fn set_velocity(&mut self, id: BodyId, velocity: Vec3, angular: Vec3) -> Result<(), Error> {
        let row = self.row(id)?;
        check_finite("velocity", velocity)?;
        check_finite("angular velocity", angular)?;
        self.handled = true;
        if self.bodies.is_mover(row) {
            self.bodies.lines[row].set_velocities(velocity, angular);
            self.wake(row);
        }
        Ok(())
    }

    /// Puts a body somewhere else, and wakes it. Bodies that it touched wake with the next step. A rotation whose length is one to rounding is taken as it is.
    ///
    /// # Errors
    /// [`Error::NoBody`]; [`Error::Value`] for a pose that no body can have.
    pub fn set_pose(&mut self, id: BodyId, pose: Pose) -> Result<(), Error> {
        let row = self.row(id)?;
        Body::check_pose(&pose)?;
        self.handled = true;
        let rotation = rotation::unit(pose.rotation);
        let center = rotation::rotate(rotation, self.bodies.centers[row]);
        self.bodies.positions[row] = pose.position + center.as_dvec3();
        self.bodies.rotations[row] = rotation;
        self.wake(row);
        self.stirred.insert(row as u32);
        self.late.take();
        Ok(())
    }

    /// Gives a dynamic body an impulse (N s) at a point of the world, and wakes it.
    ///
    /// # Errors
    /// [`Error::NoBody`]; [`Error::Value`] for numbers that are not finite.
    pub fn push(&mut self, id: BodyId, impulse: Vec3, at: rockfall_math::DVec3) -> Result<(), Error> {
        let row = self.row(id)?;
        check_finite("impulse", impulse)?;
        check_finite("point", at.as_vec3())?;
        self.handled = true;
        let inverse_inertia = self.bodies.world_inverse_inertia(row);
        let arm = (at - self.bodies.positions[row]).as_vec3();
        let line = &mut self.bodies.lines[row];
        let v = line.velocity() + impulse * line.inverse_mass();
        let w = line.angular_velocity() + inverse_inertia * arm.cross(impulse);
        line.set_velocities(v, w);
        self.wake(row);
        Ok(())
    }
}

/// What keeps a shape from being dynamic.
fn immovable(shape: &Shape) -> &'static str {
    let parts = match shape {
        Shape::Compound(compound) => compound.parts(),
        _ => &[],
    };
    match parts.iter().map(|part| &part.shape).find(|part| !part.can_move()).unwrap_or(shape) {
        Shape::Mesh(mesh) if mesh.closed => "mesh that is inside out",
        Shape::Mesh(_) => "mesh that is not closed",
        shape => shape.name(),
    }
}

fn check_finite(what: &'static str, v: Vec3) -> Result<(), Error> {
    if v.is_finite() {
        Ok(())
    } else {
        Err(Error::Value { what, value: v.to_string(), expected: "three finite numbers" })
    }
}
