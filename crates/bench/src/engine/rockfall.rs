//! Our engine.

use super::Engine;
use crate::Error;
use crate::motion;
use crate::scene::{self, Scene};
use rockfall::math::{Pose, Vec3, rotation};
use rockfall::{Body, BodyId, Kind, Material, STAGES, Settings, World};

pub(super) struct Rockfall {
    world: World,
    ids: Vec<BodyId>,
    driven: Vec<Driven>,
    /// Bodies that are not dynamic have the first ids.
    first: usize,
}

struct Driven {
    id: BodyId,
    /// Centre of mass in the body's frame.
    center: Vec3,
}

impl Rockfall {
    pub(super) fn new(scene: &Scene, threads: usize) -> Result<Self, Error> {
        let gravity = Vec3::new(0.0, 0.0, -scene.gravity);
        let settings =
            Settings { gravity, rate: scene::RATE, sleeping: false, threads, ..Settings::default() };
        let mut world = World::new(settings)?;
        let rock = world.add_material(Material {
            density: scene.density,
            friction: scene::FRICTION,
            restitution: scene::RESTITUTION,
            ..Material::default()
        })?;
        let shapes =
            scene.shapes.iter().map(|s| world.add_shape(s.clone())).collect::<Result<Vec<_>, _>>()?;
        world.spawn_all(scene.fixed.iter().map(|p| Body::fixed(shapes[p.shape], rock, p.pose)))?;
        let moving = scene
            .driven
            .iter()
            .map(|d| Body { kind: Kind::Kinematic, ..Body::fixed(shapes[d.shape], rock, d.after(0)) });
        let ids = world.spawn_all(moving)?;
        let center = |shape: usize| scene.shapes[shape].mass_properties(1.0).map_or(Vec3::ZERO, |m| m.center);
        let driven =
            scene.driven.iter().zip(ids).map(|(d, id)| Driven { id, center: center(d.shape) }).collect();
        let ids = world.spawn_all(scene.bodies.iter().map(|p| Body::new(shapes[p.shape], rock, p.pose)))?;
        Ok(Rockfall { world, ids, driven, first: scene.fixed.len() + scene.driven.len() })
    }
}

impl Engine for Rockfall {
    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error> {
        for (Driven { id, center }, target) in self.driven.iter().zip(targets) {
            let now = self.world.pose(*id)?;
            let velocity = (target.point(*center) - now.point(*center)).as_vec3() * scene::RATE;
            let turn = rotation::compose(target.rotation, rotation::inverse(now.rotation));
            let spin = motion::rotation_vector(turn).as_vec3() * scene::RATE;
            self.world.set_velocity(*id, velocity, spin)?;
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        self.world.step();
        Ok(())
    }

    fn poses(&self) -> Vec<Pose> {
        self.world.poses().split_off(self.first)
    }

    fn mass(&self) -> f64 {
        self.ids.iter().filter_map(|&id| self.world.mass(id).ok()).map(f64::from).sum()
    }

    fn stages(&self) -> Vec<(&'static str, f64)> {
        let times = self.world.report().times.iter().map(|time| 1e3 * time.as_secs_f64());
        STAGES.into_iter().zip(times).collect()
    }
}
