//! Our engine.

use super::Engine;
use crate::Error;
use crate::motion;
use crate::scene::{self, Placed, Scene};
use rockfall::math::{Pose, Vec3, rotation};
use rockfall::{Body, BodyId, Kind, Material, MaterialId, STAGES, Settings, ShapeId, World};
use rockfall_solve::line::{Drift, Line};

pub(super) struct Rockfall {
    world: World,
    shapes: Vec<ShapeId>,
    rock: MaterialId,
    ids: Vec<BodyId>,
    driven: Vec<Driven>,
    /// Bodies that are not dynamic have the first ids.
    first: usize,
    substeps: u32,
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
        let substeps = settings.substeps;
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
        let first = scene.fixed.len() + scene.driven.len();
        Ok(Rockfall { world, shapes, rock, ids: Vec::new(), driven, first, substeps })
    }
}

impl Engine for Rockfall {
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error> {
        let body = |p: &Placed| Body::new(self.shapes[p.shape], self.rock, p.pose);
        self.ids.extend(self.world.spawn_all(bodies.iter().map(body))?);
        Ok(())
    }

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

    fn solver_bytes(&self) -> Option<f64> {
        let report = self.world.report();
        Some(read_in_a_step(report.swept_bytes, report.awake, self.substeps))
    }
}

/// Bytes that the sweeps of a step read, at least: all blocks in each sweep, of which a step of n sub-steps has 2 n + 1; of each
/// awake body its line once in each sweep, and its drift in all but the first, which knows none.
fn read_in_a_step(blocks: usize, awake: usize, substeps: u32) -> f64 {
    let sweeps = f64::from(2 * substeps + 1);
    sweeps * (blocks + awake * size_of::<Line>()) as f64
        + (sweeps - 1.0) * (awake * size_of::<Drift>()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_four_sub_steps_reads_the_blocks_nine_times() {
        assert_eq!(read_in_a_step(1000, 0, 4), 9000.0);
        // Ten lines of 64 bytes nine times, ten drifts of 32 bytes eight times.
        assert_eq!(read_in_a_step(1000, 10, 4), 9000.0 + 5760.0 + 2560.0);
    }
}
