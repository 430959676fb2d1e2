//! Rapier with the settings that it comes with, but for the length of a step; nobody sleeps, and fast bodies are stopped, as ours are. Mass and inertia are
//! the same numbers as ours. It knows no rolling friction and no threshold of restitution.

use super::{DENSITY, Engine, Terms, Thing};
use crate::Error;
use rapier3d::math::{Pose as Place, Vector};
use rapier3d::prelude::*;
use rockfall::math::{DVec3, Mat3, Pose, Quat, Vec3};
use rockfall::{Kind, Mix, Shape};

pub(super) struct Rapier {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
}

impl Rapier {
    pub(super) fn new(terms: &Terms) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = terms.gravity;
        world.integration_parameters.dt = 1.0 / terms.rate;
        Rapier { world, handles: Vec::new() }
    }

    fn body(&self, body: usize) -> &RigidBody {
        &self.world.bodies[self.handles[body]]
    }
}

impl Engine for Rapier {
    fn put(&mut self, thing: &Thing) -> Result<(), Error> {
        let builder = match thing.kind {
            Kind::Dynamic => RigidBodyBuilder::dynamic(),
            Kind::Kinematic => RigidBodyBuilder::kinematic_velocity_based(),
            Kind::Static => RigidBodyBuilder::fixed(),
        };
        let body = builder
            .pose(place(&thing.pose))
            .linvel(thing.velocity)
            .angvel(thing.spin)
            .can_sleep(false)
            .ccd_enabled(thing.kind == Kind::Dynamic);
        let (shape, at) = shared(&thing.shape)?;
        let surface = thing.surface;
        let rule = match surface.mix {
            Mix::Average => CoefficientCombineRule::Average,
            Mix::GeometricMean => CoefficientCombineRule::GeometricMean,
            Mix::Minimum => CoefficientCombineRule::Min,
            Mix::Product => CoefficientCombineRule::Multiply,
            Mix::Maximum => CoefficientCombineRule::Max,
        };
        let collider = ColliderBuilder::new(shape)
            .position(at)
            .density(0.0)
            .friction(surface.friction)
            .friction_combine_rule(rule)
            .restitution(surface.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Max);
        let body = match thing.shape.mass_properties(DENSITY) {
            Some(solid) if thing.kind == Kind::Dynamic => {
                let solid = thing.mass.map_or(solid, |mass| solid.with_mass(mass));
                let inertia = thing.moments.map_or(solid.inertia, Mat3::from_diagonal);
                let solid = rockfall::shape::MassProperties { inertia, ..solid };
                let (moments, frame) = solid.principal();
                body.additional_mass_properties(MassProperties::with_principal_inertia_frame(
                    solid.center,
                    solid.mass,
                    moments,
                    frame,
                ))
            }
            _ => body,
        };
        let (handle, _) = self.world.insert(body, collider);
        // What is pushed before the first step has its mass already.
        let Rapier { world, .. } = self;
        world.bodies[handle].recompute_mass_properties_from_colliders(&world.colliders);
        self.handles.push(handle);
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        self.world.step();
        Ok(())
    }

    fn pose(&self, body: usize) -> Result<Pose, Error> {
        let place = self.body(body).position();
        let q = place.rotation;
        Ok(Pose { position: place.translation.as_dvec3(), rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) })
    }

    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error> {
        let body = self.body(body);
        Ok((body.linvel(), body.angvel()))
    }

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        let body = &mut self.world.bodies[self.handles[body]];
        body.set_linvel(velocity, true);
        body.set_angvel(spin, true);
        Ok(())
    }

    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        self.world.bodies[self.handles[body]].apply_impulse(impulse, true);
        Ok(())
    }

    fn load(&self, _: usize) -> Option<DVec3> {
        None
    }
}

fn place(pose: &Pose) -> Place {
    Place::from_parts(pose.position.as_vec3(), pose.rotation)
}

/// The shape, and where it is in our shape's frame: its cylinders stand along y.
fn shared(shape: &Shape) -> Result<(SharedShape, Place), Error> {
    let here = Place::from_parts(Vector::ZERO, Quat::IDENTITY);
    let refused = || Error::NoShape { engine: "rapier", shape: shape.name() };
    Ok(match shape {
        Shape::Sphere { radius } => (SharedShape::ball(*radius), here),
        Shape::Box { half } => (SharedShape::cuboid(half.x, half.y, half.z), here),
        Shape::Cylinder { half_length, radius } => {
            let upright = crate::stage::turn(Vec3::X, core::f64::consts::FRAC_PI_2);
            (SharedShape::cylinder(*half_length, *radius), Place::from_parts(Vector::ZERO, upright))
        }
        Shape::HalfSpace { normal, offset } => {
            (SharedShape::halfspace(*normal), Place::from_parts(*normal * *offset, Quat::IDENTITY))
        }
        Shape::Hull(hull) => (SharedShape::convex_hull(&hull.vertices).ok_or_else(refused)?, here),
        Shape::Mesh(mesh) => {
            let mesh = SharedShape::trimesh(mesh.vertices.clone(), mesh.triangles.clone());
            (mesh.map_err(|_| refused())?, here)
        }
        Shape::Compound(compound) => {
            let part = |part: &rockfall::shape::Part| {
                let (shape, at) = shared(&part.shape)?;
                Ok((place(&part.pose) * at, shape))
            };
            let parts = compound.parts().iter().map(part).collect::<Result<Vec<_>, Error>>()?;
            (SharedShape::compound(parts), here)
        }
        _ => return Err(refused()),
    })
}
