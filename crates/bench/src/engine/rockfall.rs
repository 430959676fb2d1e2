//! Our engine.

use super::Engine;
use crate::Error;
use crate::scene::{self, Scene};
use rockfall::math::{Pose, Vec3};
use rockfall::{Body, BodyId, Material, STAGES, Settings, World};

pub(super) struct Rockfall {
    world: World,
    ids: Vec<BodyId>,
    /// Immovable bodies have the first ids.
    fixed: usize,
}

impl Rockfall {
    pub(super) fn new(scene: &Scene, threads: usize) -> Result<Self, Error> {
        let gravity = Vec3::new(0.0, 0.0, -scene::GRAVITY);
        let settings =
            Settings { gravity, rate: scene::RATE, sleeping: false, threads, ..Settings::default() };
        let mut world = World::new(settings)?;
        let rock = world.add_material(Material {
            density: scene::DENSITY,
            friction: scene::FRICTION,
            restitution: scene::RESTITUTION,
            ..Material::default()
        })?;
        let shapes =
            scene.shapes.iter().map(|s| world.add_shape(s.clone())).collect::<Result<Vec<_>, _>>()?;
        world.spawn_all(scene.fixed.iter().map(|p| Body::fixed(shapes[p.shape], rock, p.pose)))?;
        let ids = world.spawn_all(scene.bodies.iter().map(|p| Body::new(shapes[p.shape], rock, p.pose)))?;
        Ok(Rockfall { world, ids, fixed: scene.fixed.len() })
    }
}

impl Engine for Rockfall {
    fn step(&mut self) {
        self.world.step();
    }

    fn poses(&self) -> Vec<Pose> {
        self.world.poses().split_off(self.fixed)
    }

    fn mass(&self) -> f64 {
        self.ids.iter().filter_map(|&id| self.world.mass(id).ok()).map(f64::from).sum()
    }

    fn stages(&self) -> Vec<(&'static str, f64)> {
        let times = self.world.report().times.iter().map(|time| 1e3 * time.as_secs_f64());
        STAGES.into_iter().zip(times).collect()
    }
}
