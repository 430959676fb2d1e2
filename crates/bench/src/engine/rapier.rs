//! Rapier with the settings that it comes with: feature `parallel` (its SIMD is always on), a pool of its own, all
//! parameters at their defaults. Friction and restitution mix by its average, which changes nothing where all
//! materials are equal.

use super::Engine;
use crate::Error;
use crate::scene::{self, Placed, Scene};
use rapier3d::math::{Pose as Place, Vector};
use rapier3d::prelude::*;
use rockfall::Shape;
use rockfall::math::{Pose, Quat};

pub(super) struct Rapier {
    world: PhysicsWorld,
    shapes: Vec<SharedShape>,
    density: f32,
    handles: Vec<RigidBodyHandle>,
    driven: Vec<RigidBodyHandle>,
}

impl Rapier {
    pub(super) fn new(scene: &Scene, threads: usize) -> Result<Self, Error> {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -scene.gravity);
        world.integration_parameters.dt = 1.0 / scene::RATE;
        world
            .configure_thread_pool(threads)
            .map_err(|e| Error::Engine { engine: "rapier", reason: e.to_string() })?;
        let shapes = scene.shapes.iter().map(shared).collect::<Result<Vec<_>, _>>()?;
        let collider = |shape: usize| collider(&shapes[shape], scene.density);
        for fixed in &scene.fixed {
            world.insert(RigidBodyBuilder::fixed().pose(place(&fixed.pose)), collider(fixed.shape));
        }
        let driven = scene
            .driven
            .iter()
            .map(|d| {
                let body = RigidBodyBuilder::kinematic_position_based().pose(place(&d.after(0)));
                world.insert(body, collider(d.shape)).0
            })
            .collect();
        Ok(Rapier { world, shapes, density: scene.density, handles: Vec::new(), driven })
    }
}

impl Engine for Rapier {
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error> {
        for p in bodies {
            let body = RigidBodyBuilder::dynamic().pose(place(&p.pose)).can_sleep(false);
            let (handle, _) = self.world.insert(body, collider(&self.shapes[p.shape], self.density));
            self.handles.push(handle);
        }
        Ok(())
    }

    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error> {
        for (&handle, target) in self.driven.iter().zip(targets) {
            self.world.bodies[handle].set_next_kinematic_position(place(target));
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        self.world.step();
        Ok(())
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |handle: &RigidBodyHandle| {
            let place = self.world.bodies[*handle].position();
            let q = place.rotation;
            Pose { position: place.translation.as_dvec3(), rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) }
        };
        self.handles.iter().map(pose).collect()
    }

    fn mass(&self) -> f64 {
        // Before the first step a body does not know its colliders' masses.
        let colliders = |handle: &RigidBodyHandle| self.world.bodies[*handle].colliders();
        self.handles
            .iter()
            .flat_map(colliders)
            .map(|&c| f64::from(self.world.colliders[c].mass_properties().mass()))
            .sum()
    }
}

fn collider(shape: &SharedShape, density: f32) -> ColliderBuilder {
    ColliderBuilder::new(shape.clone())
        .density(density)
        .friction(scene::FRICTION)
        .restitution(scene::RESTITUTION)
}

fn place(pose: &Pose) -> Place {
    Place::from_parts(pose.position.as_vec3(), pose.rotation)
}

fn shared(shape: &Shape) -> Result<SharedShape, Error> {
    let refused = || Error::Engine { engine: "rapier", reason: format!("no such shape: a {}", shape.name()) };
    match shape {
        Shape::Sphere { radius } => Ok(SharedShape::ball(*radius)),
        Shape::Box { half } => Ok(SharedShape::cuboid(half.x, half.y, half.z)),
        Shape::Capsule { half_length, radius } => Ok(SharedShape::capsule_z(*half_length, *radius)),
        Shape::Hull(hull) => SharedShape::convex_hull(&hull.vertices).ok_or_else(refused),
        Shape::Mesh(mesh) => {
            SharedShape::trimesh(mesh.vertices.clone(), mesh.triangles.clone()).map_err(|_| refused())
        }
        _ => Err(refused()),
    }
}
