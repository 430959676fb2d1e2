//! Contacts and sensors as data, step by step.

use super::World;
use super::query::{Filter, Movers};
use crate::events::{Events, Presence, Watch};
use crate::{BodyId, Error};
use rayon::prelude::*;
use rockfall_collide::overlaps;
use rockfall_math::share::Share;

impl World {
    /// Has the world tell of contacts from the next step on; see [`World::events`]. Motion is the same with it and without.
    ///
    /// # Errors
    /// [`Error::Value`] where the impulse is negative or not a number.
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose, Vec3};
    /// use rockfall::{Body, Material, Settings, Shape, Watch, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let rock = world.add_material(Material { density: 1000.0, ..Material::default() })?;
    /// let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
    /// let cube = world.add_shape(Shape::Box { half: Vec3::splat(0.5) })?;
    /// let ground = world.spawn(Body::fixed(ground, rock, Pose::default()))?;
    /// let cube = world.spawn(Body::new(cube, rock, Pose::at(DVec3::new(0.0, 0.0, 0.6))))?;
    /// world.watch(Watch { contacts: true, forces: true, ..Watch::default() })?;
    /// let mut begun = 0;
    /// for _ in 0..120 {
    ///     world.step();
    ///     begun += world.events().begun.len();
    /// }
    /// assert_eq!((begun, world.events().persisting.len()), (1, 1));
    /// let force = &world.events().forces[0];
    /// assert_eq!((force.pair.a, force.pair.b), (ground, cube));
    /// assert!((force.normal_force - 9810.0).abs() < 10.0, "a tonne weighs 9810 N");
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn watch(&mut self, watch: Watch) -> Result<(), Error> {
        if let Some(impulse) = watch.impulse.filter(|impulse| impulse.is_nan() || *impulse < 0.0) {
            let (value, expected) = (impulse.to_string(), "a number, 0 or larger");
            return Err(Error::Value { what: "impulse to watch for", value, expected });
        }
        self.contacts.keep_totals(watch.impulse.is_some());
        self.watch = watch;
        Ok(())
    }

    /// What happened in the last step: contacts as far as they are watched ([`World::watch`]), and who is in sensors ([`Body::sensor`](crate::Body::sensor)).
    pub fn events(&self) -> &Events {
        &self.events
    }

    /// Part of the stage *report*.
    pub(crate) fn tell(&mut self) {
        let World { events, watch, bodies, touches, contacts, settings, .. } = self;
        if *watch != Watch::default() || !events.begun.is_empty() || !events.persisting.is_empty() {
            events.tell_contacts(watch, bodies, touches, contacts, settings);
        } else {
            events.ended.clear();
            events.hits.clear();
            events.forces.clear();
        }
        let sensors = &mut self.sensors;
        sensors.retain(|&id, _| self.slots.get(id).is_some());
        if !self.sensors.is_empty() || !self.events.present.is_empty() || !self.events.left.is_empty() {
            let now = self.presence();
            self.events.tell_presence(now);
        }
    }

    /// Who is in which sensor, ascending.
    fn presence(&self) -> Vec<Presence> {
        let sensors: Vec<(u64, u32)> = self.sensors.iter().map(|(&id, &mask)| (id, mask)).collect();
        let in_one = |&(id, mask): &(u64, u32)| {
            let mut found: Vec<Presence> = Vec::new();
            let Ok(row) = self.row(BodyId(id)) else { return found };
            let Some(shape) = self.shapes.get(self.bodies.shapes[row] as usize) else { return found };
            let pose = self.bodies.shape_pose(row);
            let filter = Filter { mask, movers: Movers::Only, except: Some(BodyId(id)) };
            let group = self.bodies.filters[row][0];
            let view = self.view(&filter);
            view.within(&shape.placed_bounds(&pose), |other, body| {
                let (other_id, [_, other_mask]) = (self.bodies.ids[other], self.bodies.filters[other]);
                let there = self.bodies.shape_pose(other);
                let is_in = other_mask & group != 0
                    && (overlaps(shape, body, &pose.see(&there)) || overlaps(body, shape, &there.see(&pose)));
                if is_in {
                    found.push(Presence { sensor: BodyId(id), body: BodyId(other_id) });
                }
            });
            found.sort_unstable();
            found
        };
        sensors.par_iter().shared().flat_map_iter(in_one).collect()
    }
}
