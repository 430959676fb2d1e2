//! The engines, behind one face.

#[cfg(feature = "box3d")]
#[allow(unsafe_code)]
mod box3d;
#[cfg(feature = "jolt")]
#[allow(unsafe_code)]
mod jolt;
#[cfg(feature = "physx")]
#[allow(unsafe_code)]
mod physx;
#[cfg(feature = "peers")]
mod rapier;
mod rockfall;

use crate::Error;
use crate::scene::{Placed, Scene};
use ::rockfall::math::Pose;
#[cfg(feature = "physx")]
use physx_sys::PxSolverType;

/// An engine that holds a scene.
pub(crate) trait Engine {
    /// Adds dynamic bodies, behind those that are there.
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error>;

    /// Tells the driven bodies, in the order of [`Scene::driven`], where they are after the next step.
    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error>;

    /// One frame. An error where the engine tells that it left out contacts or failed.
    fn step(&mut self) -> Result<(), Error>;

    /// Pose of the shape frame of each dynamic body that is there, in the order of [`Scene::bodies`].
    fn poses(&self) -> Vec<Pose>;

    /// Of all dynamic bodies together, as the engine has it, kg.
    fn mass(&self) -> f64;

    /// Names of the stages of the last step and their times in milliseconds, where the engine tells them.
    fn stages(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Bytes that the solver must have read in the last step, at least, where the engine tells.
    fn solver_bytes(&self) -> Option<f64> {
        None
    }
}

/// Which engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Kind {
    /// Ours.
    Rockfall,
    /// `rapier3d`; only with the feature `peers`.
    Rapier,
    /// Box3D; only with the feature `box3d`, which is among the `peers`.
    Box3d,
    /// Jolt; only with the feature `jolt`.
    Jolt,
    /// PhysX with projected Gauss-Seidel, its default; only with the feature `physx`.
    PhysxPgs,
    /// PhysX with temporal Gauss-Seidel; only with the feature `physx`.
    PhysxTgs,
}

impl Kind {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Rockfall => "rockfall",
            Kind::Rapier => "rapier",
            Kind::Box3d => "box3d",
            Kind::Jolt => "jolt",
            Kind::PhysxPgs => "physx-pgs",
            Kind::PhysxTgs => "physx-tgs",
        }
    }

    /// Those that run where nobody says which: Rockfall and, where it is built, Rapier.
    pub(crate) fn usual() -> Vec<Kind> {
        [Kind::Rockfall, Kind::Rapier].into_iter().filter(|kind| kind.is_built()).collect()
    }

    /// What to tell who asks for it where it is not built.
    pub(crate) fn missing(self) -> Error {
        let feature = match self {
            Kind::Rockfall | Kind::Rapier => "peers",
            Kind::Box3d => "box3d",
            Kind::Jolt => "jolt",
            Kind::PhysxPgs | Kind::PhysxTgs => "physx",
        };
        Error::NotBuilt { engine: self.name(), feature }
    }

    /// Whether this build has it.
    pub(crate) fn is_built(self) -> bool {
        match self {
            Kind::Rockfall => true,
            Kind::Rapier => cfg!(feature = "peers"),
            Kind::Box3d => cfg!(feature = "box3d"),
            Kind::Jolt => cfg!(feature = "jolt"),
            Kind::PhysxPgs | Kind::PhysxTgs => cfg!(feature = "physx"),
        }
    }

    /// Of the engine in this build.
    pub(crate) fn version(self) -> String {
        match self {
            Kind::Rockfall => env!("CARGO_PKG_VERSION").to_owned(),
            #[cfg(feature = "peers")]
            Kind::Rapier => rapier3d::VERSION.to_owned(),
            #[cfg(feature = "box3d")]
            Kind::Box3d => box3d::version(),
            #[cfg(feature = "jolt")]
            Kind::Jolt => jolt::VERSION.to_owned(),
            #[cfg(feature = "physx")]
            Kind::PhysxPgs | Kind::PhysxTgs => physx::VERSION.to_owned(),
            #[allow(unreachable_patterns)]
            _ => "not built".to_owned(),
        }
    }

    /// The engine with its own defaults, but sleeping off, and in it of the scene what is there from the start.
    pub(crate) fn build(self, scene: &Scene, threads: usize) -> Result<Box<dyn Engine>, Error> {
        let mut engine = self.around(scene, threads)?;
        engine.spawn(&scene.bodies[..scene.present(0)])?;
        Ok(engine)
    }

    /// The engine with what dynamic bodies can't move.
    fn around(self, scene: &Scene, threads: usize) -> Result<Box<dyn Engine>, Error> {
        match self {
            Kind::Rockfall => Ok(Box::new(rockfall::Rockfall::new(scene, threads)?)),
            #[cfg(feature = "peers")]
            Kind::Rapier => Ok(Box::new(rapier::Rapier::new(scene, threads)?)),
            #[cfg(feature = "box3d")]
            Kind::Box3d => Ok(Box::new(box3d::Box3d::new(scene, threads)?)),
            #[cfg(feature = "jolt")]
            Kind::Jolt => Ok(Box::new(jolt::Jolt::new(scene, threads)?)),
            #[cfg(feature = "physx")]
            Kind::PhysxPgs => Ok(Box::new(physx::Physx::new(scene, threads, PxSolverType::Pgs)?)),
            #[cfg(feature = "physx")]
            Kind::PhysxTgs => Ok(Box::new(physx::Physx::new(scene, threads, PxSolverType::Tgs)?)),
            #[allow(unreachable_patterns)]
            _ => Err(self.missing()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{quality, scene};
    use ::rockfall::math::DVec3;
    use clap::ValueEnum;

    /// Mass of the scene from its shapes alone, kg.
    fn mass_of(scene: &Scene) -> f64 {
        let mass = |shape: usize| scene.shapes[shape].mass_properties(scene.density).expect("a solid").mass;
        scene.bodies.iter().map(|b| f64::from(mass(b.shape))).sum()
    }

    fn built() -> impl Iterator<Item = Kind> {
        Kind::value_variants().iter().copied().filter(|kind| kind.is_built())
    }

    #[test]
    fn engines_build_the_same_scene() {
        for kind in scene::Kind::value_variants() {
            let scene = kind.build(kind.few(), 7).expect("a scene");
            let expected = mass_of(&scene);
            for engine in built() {
                let mut world = engine.build(&scene, 1).expect("an engine");
                world.spawn(&scene.bodies[scene.present(0)..]).expect("spawned");
                let mass = world.mass();
                assert!(
                    (mass / expected - 1.0).abs() < 1e-4,
                    "{engine:?} {kind:?}: {mass} kg, not {expected}"
                );
                for (pose, body) in world.poses().iter().zip(&scene.bodies) {
                    assert!((pose.position - body.pose.position).length() < 1e-5, "{engine:?} {kind:?}");
                    assert!(pose.rotation.dot(body.pose.rotation).abs() > 1.0 - 1e-6, "{engine:?} {kind:?}");
                }
                assert_eq!(world.poses().len(), scene.bodies.len());
            }
        }
    }

    #[test]
    fn every_scene_runs_and_loses_nobody() {
        for kind in scene::Kind::value_variants() {
            let scene = kind.build(kind.few(), 7).expect("a scene");
            let mut world = Kind::Rockfall.build(&scene, 2).expect("an engine");
            let mut there = scene.present(0);
            for steps in 0..120 {
                world.spawn(&scene.bodies[there..scene.present(steps)]).expect("spawned");
                there = scene.present(steps);
                let targets: Vec<Pose> = scene.driven.iter().map(|d| d.after(steps + 1)).collect();
                world.drive(&targets).expect("driven");
                world.step().expect("a step");
            }
            let poses = world.poses();
            let quality = quality::measure(&scene, 120, &poses, &poses);
            assert_eq!(poses.len(), there, "{kind:?}");
            assert_eq!(quality.escaped, 0, "{kind:?} {quality:?}");
            assert!(poses.iter().all(|p| p.position.is_finite() && p.rotation.is_finite()), "{kind:?}");
        }
    }

    #[test]
    fn engines_fall_alike_before_anything_touches() {
        let scene = scene::Kind::Pyramid.build(1, 0).expect("a scene");
        let mut scene = scene;
        scene.bodies[0].pose.position.z = 100.0;
        for engine in built() {
            let mut world = engine.build(&scene, 1).expect("an engine");
            for _ in 0..60 {
                world.step().expect("a step");
            }
            let fallen = 100.0 - world.poses()[0].position.z;
            // g t²/2 up to what a sub-step of 1/240 s or a step of 1/60 s adds.
            assert!((4.9..5.0).contains(&fallen), "{engine:?} {fallen}");
        }
    }

    #[test]
    fn driven_bodies_push_what_is_in_their_way() {
        let mut scene = scene::Kind::Box3dJunkyard.build(1, 0).expect("a scene");
        // Where the pillar arrives within a second: its radius is 4 m, and it goes 3.7 m/s.
        scene.bodies[0].pose.position = DVec3::new(34.5, 6.5, 1.5);
        for engine in built() {
            let mut world = engine.build(&scene, 1).expect("an engine");
            for steps in 1..=90 {
                let targets: Vec<Pose> = scene.driven.iter().map(|d| d.after(steps)).collect();
                world.drive(&targets).expect("driven");
                world.step().expect("a step");
            }
            let gone = world.poses()[0].position - scene.bodies[0].pose.position;
            assert!((2.0..8.0).contains(&gone.y), "{engine:?} {gone}");
        }
    }

    #[test]
    fn a_drum_turns_what_lies_in_it() {
        let mut scene = scene::Kind::Box3dWasher.build(1, 0).expect("a scene");
        scene.bodies[0].pose.position = DVec3::new(0.0, 0.0, 21.0 - 15.7);
        for engine in built() {
            let mut world = engine.build(&scene, 1).expect("an engine");
            for steps in 1..=45 {
                let targets: Vec<Pose> = scene.driven.iter().map(|d| d.after(steps)).collect();
                world.drive(&targets).expect("driven");
                world.step().expect("a step");
            }
            // The drum goes 7 m/s, friction speeds the cube up by 6 m/s²: 1.7 m in 0.75 s.
            let gone = world.poses()[0].position - scene.bodies[0].pose.position;
            assert!((1.2..3.0).contains(&gone.x) && gone.z.abs() < 1.5, "{engine:?} {gone}");
        }
    }

    #[test]
    fn what_falls_on_a_terrain_stays_on_it() {
        let scene = scene::Kind::MixedTerrain.build(60, 7).expect("a scene");
        for engine in built() {
            let mut world = engine.build(&scene, 2).expect("an engine");
            for _ in 0..300 {
                world.step().expect("a step");
            }
            let poses = world.poses();
            let quality = quality::measure(&scene, 300, &poses, &poses);
            assert_eq!(quality.escaped, 0, "{engine:?}");
            assert!(quality.overlapping > 30 && quality.mean_mm < 15.0, "{engine:?} {quality:?}");
        }
    }

    #[test]
    fn a_small_pile_comes_to_rest_in_its_room() {
        let scene = scene::Kind::BoxPile.build(60, 7).expect("a scene");
        for engine in built() {
            let mut world = engine.build(&scene, 2).expect("an engine");
            for _ in 0..300 {
                world.step().expect("a step");
            }
            let before = world.poses();
            world.step().expect("a step");
            let quality = quality::measure(&scene, 301, &before, &world.poses());
            assert_eq!(quality.escaped, 0, "{engine:?}");
            assert!(quality.overlapping > 60 && quality.mean_mm < 10.0, "{engine:?} {quality:?}");
            assert!(quality.rms_speed < 0.1, "{engine:?} {quality:?}");
        }
    }
}
