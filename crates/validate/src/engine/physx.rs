//! PhysX on the processor by its C wrapper: PGS, which is its default for new scenes, with 4 position and 1 velocity iterations, friction by patches, contacts from
//! 20 mm on, all as it comes, but for the length of a step, its restitution threshold, and what bodies lose and may reach by themselves: no damping, no limit of
//! spin, gyroscopic torque, sweeps of what is fast; nobody sleeps. Mass and inertia are the same numbers as ours. What is driven is told a place for each step.
//! Meshes don't move freely, hulls have 255 corners at most, and there are no cylinders, cones and ellipsoids.

mod shape;

use super::{DENSITY, Engine, Surface, Terms, Thing, within};
use crate::Error;
use physx_sys::*;
use rockfall::math::{DVec3, Mat3, Pose, Quat, Vec3, rotation};
use rockfall::{Kind, Mix, Shape};
use shape::Cooked;
use std::ptr::{self, NonNull};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The library, of which there is one for the process. Whoever makes or ends something of it holds it.
static LIBRARY: Mutex<Option<Library>> = Mutex::new(None);

/// Kept until the process ends.
struct Library(NonNull<PxPhysics>);

// SAFETY: the library may be used from any thread, by one at a time: `LIBRARY` guards it.
unsafe impl Send for Library {}

/// The library, held; it is started by whoever is first.
fn library() -> Result<(MutexGuard<'static, Option<Library>>, NonNull<PxPhysics>), Error> {
    let mut held = LIBRARY.lock().unwrap_or_else(PoisonError::into_inner);
    let physics = match &*held {
        Some(Library(physics)) => *physics,
        None => {
            let none = || refused("it did not start".to_owned());
            // SAFETY: once per process, and under the lock.
            let physics = unsafe {
                let foundation = NonNull::new(physx_create_foundation()).ok_or_else(none)?;
                NonNull::new(physx_create_physics(foundation.as_ptr())).ok_or_else(none)?
            };
            *held = Some(Library(physics));
            physics
        }
    };
    Ok((held, physics))
}

pub(super) struct Physx {
    scene: NonNull<PxScene>,
    dispatcher: NonNull<PxDefaultCpuDispatcher>,
    materials: Vec<(Surface, NonNull<PxMaterial>)>,
    bodies: Vec<Body>,
    rate: f32,
}

/// One of ours.
struct Body {
    actor: NonNull<PxRigidActor>,
    motion: Motion,
}

enum Motion {
    Fixed,
    Free,
    /// Where it was told to be, and how it goes on, m/s and rad/s.
    Driven(Pose, Vec3, Vec3),
}

impl Physx {
    pub(super) fn new(terms: &Terms) -> Result<Self, Error> {
        let (_held, physics) = library()?;
        let none = || refused("it made no scene".to_owned());
        let mode = PxDefaultCpuDispatcherWaitForWorkMode::WaitForWork;
        // SAFETY: takes numbers and no list of processors. Without threads of its own, who steps does the work.
        let dispatcher = unsafe { phys_PxDefaultCpuDispatcherCreate(0, ptr::null_mut(), mode, 0) };
        let dispatcher = NonNull::new(dispatcher).ok_or_else(none)?;
        // SAFETY: the library lives; the description is the default one with plain values, the dispatcher, which ends after the scene, and a
        // filter that is there for ever.
        let scene = unsafe {
            let mut about = PxSceneDesc_new(PxPhysics_getTolerancesScale(physics.as_ptr()));
            about.gravity = vector(terms.gravity);
            // It takes none of 0.
            about.bounceThresholdVelocity = terms.threshold.max(f32::MIN_POSITIVE);
            about.flags |= PxSceneFlags::EnableCcd;
            about.cpuDispatcher = dispatcher.as_ptr().cast();
            enable_custom_filter_shader(&mut about, sweep, 1);
            PxPhysics_createScene_mut(physics.as_ptr(), &about)
        };
        let Some(scene) = NonNull::new(scene) else {
            // SAFETY: made just now, and no scene uses it.
            unsafe { PxDefaultCpuDispatcher_release_mut(dispatcher.as_ptr()) };
            return Err(none());
        };
        Ok(Physx { scene, dispatcher, materials: Vec::new(), bodies: Vec::new(), rate: terms.rate })
    }

    /// What the library has for a surface.
    fn material(
        &mut self,
        physics: NonNull<PxPhysics>,
        surface: Surface,
    ) -> Result<NonNull<PxMaterial>, Error> {
        if let Some((_, known)) = self.materials.iter().find(|(known, _)| *known == surface) {
            return Ok(*known);
        }
        let rule = match surface.mix {
            Mix::Average => PxCombineMode::Average,
            Mix::Minimum => PxCombineMode::Min,
            Mix::Product => PxCombineMode::Multiply,
            Mix::Maximum => PxCombineMode::Max,
            Mix::GeometricMean => return Err(refused("it has no geometric mean of friction".to_owned())),
        };
        let Surface { friction, restitution, .. } = surface;
        // SAFETY: the library is held; takes numbers.
        let made = unsafe { PxPhysics_createMaterial_mut(physics.as_ptr(), friction, friction, restitution) };
        let made = NonNull::new(made).ok_or_else(|| refused("it made no material".to_owned()))?;
        // SAFETY: made just now.
        unsafe {
            PxMaterial_setFrictionCombineMode_mut(made.as_ptr(), rule);
            PxMaterial_setRestitutionCombineMode_mut(made.as_ptr(), PxCombineMode::Max);
        }
        self.materials.push((surface, made));
        Ok(made)
    }

    /// The actor of a body that moves freely.
    fn free(&self, body: usize) -> Result<*mut PxRigidDynamic, Error> {
        match &self.bodies[body] {
            Body { actor, motion: Motion::Free } => Ok(actor.as_ptr().cast()),
            _ => Err(refused(format!("body {body} does not move freely"))),
        }
    }
}

impl Drop for Physx {
    fn drop(&mut self) {
        let _held = LIBRARY.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: all live until here, no step is under way, and the library is held; what is used ends after what uses it.
        unsafe {
            PxScene_release_mut(self.scene.as_ptr());
            for body in &self.bodies {
                PxRigidActor_release_mut(body.actor.as_ptr());
            }
            for (_, material) in &self.materials {
                PxRefCounted_release_mut(material.as_ptr().cast());
            }
            PxDefaultCpuDispatcher_release_mut(self.dispatcher.as_ptr());
        }
    }
}

/// After the library's own filter: all pairs may be swept.
unsafe extern "C" fn sweep(pair: *mut FilterShaderCallbackInfo) -> PxFilterFlags {
    // SAFETY: called by a step with flags of its own, which the library's filter has set.
    unsafe { *(*pair).pairFlags |= PxPairFlags::DetectCcdContact };
    PxFilterFlags::empty()
}

/// Gives an actor its shapes.
fn dress(
    physics: NonNull<PxPhysics>,
    actor: NonNull<PxRigidActor>,
    material: NonNull<PxMaterial>,
    shape: &Shape,
    place: &Pose,
) -> Result<(), Error> {
    if let Shape::Compound(compound) = shape {
        let put = |part: &rockfall::shape::Part| {
            dress(physics, actor, material, &part.shape, &within(place, &part.pose))
        };
        return compound.parts().iter().try_for_each(put);
    }
    let cooked = Cooked::new(physics, shape)?;
    // What the library's own helpers give a shape.
    let flags = PxShapeFlags::Visualization | PxShapeFlags::SceneQueryShape | PxShapeFlags::SimulationShape;
    // SAFETY: library, actor and material live; geometry and pose are read during the calls; the actor takes a share of the shape, and the
    // shape one of the mesh.
    let attached = unsafe {
        let made =
            PxPhysics_createShape_mut(physics.as_ptr(), cooked.geometry(), material.as_ptr(), true, flags);
        let made = NonNull::new(made).ok_or_else(|| refused(format!("it refused a {}", shape.name())))?;
        PxShape_setLocalPose_mut(made.as_ptr(), &transform(&within(place, &cooked.place())));
        let attached = PxRigidActor_attachShape_mut(actor.as_ptr(), made.as_ptr());
        PxShape_release_mut(made.as_ptr());
        attached
    };
    if attached { Ok(()) } else { Err(refused(format!("it refused a {}", shape.name()))) }
}

/// Gives a body that was made just now its mass, and takes from it what it would lose.
fn weigh(body: *mut PxRigidDynamic, thing: &Thing) {
    let solid = thing.shape.mass_properties(DENSITY).map(|solid| {
        let solid = thing.mass.map_or(solid, |mass| solid.with_mass(mass));
        let inertia = thing.moments.map_or(solid.inertia, Mat3::from_diagonal);
        rockfall::shape::MassProperties { inertia, ..solid }
    });
    // SAFETY: the body lives and is in no scene; values are read during the calls.
    unsafe {
        PxRigidDynamic_setSleepThreshold_mut(body, 0.0);
        let body: *mut PxRigidBody = body.cast();
        PxRigidBody_setLinearDamping_mut(body, 0.0);
        PxRigidBody_setAngularDamping_mut(body, 0.0);
        PxRigidBody_setMaxAngularVelocity_mut(body, 1e6);
        PxRigidBody_setRigidBodyFlag_mut(body, PxRigidBodyFlag::EnableCcd, true);
        PxRigidBody_setRigidBodyFlag_mut(body, PxRigidBodyFlag::EnableGyroscopicForces, true);
        if let Some(solid) = solid {
            let (moments, rotation) = solid.principal();
            PxRigidBody_setMass_mut(body, solid.mass);
            PxRigidBody_setMassSpaceInertiaTensor_mut(body, &vector(moments));
            let center = Pose { position: solid.center.as_dvec3(), rotation };
            PxRigidBody_setCMassLocalPose_mut(body, &transform(&center));
        }
    }
}

impl Engine for Physx {
    fn put(&mut self, thing: &Thing) -> Result<(), Error> {
        if thing.kind == Kind::Dynamic && matches!(thing.shape, Shape::Mesh(_)) {
            return Err(Error::NoShape { engine: "physx", shape: "mesh that moves freely" });
        }
        let (_held, physics) = library()?;
        let material = self.material(physics, thing.surface)?;
        let at = transform(&thing.pose);
        // SAFETY: the library is held, and reads the pose during the call.
        let actor: *mut PxRigidActor = unsafe {
            match thing.kind {
                Kind::Static => PxPhysics_createRigidStatic_mut(physics.as_ptr(), &at).cast(),
                _ => PxPhysics_createRigidDynamic_mut(physics.as_ptr(), &at).cast(),
            }
        };
        let actor = NonNull::new(actor).ok_or_else(|| refused("it made no body".to_owned()))?;
        let motion = match thing.kind {
            Kind::Static => Motion::Fixed,
            Kind::Dynamic => Motion::Free,
            Kind::Kinematic => Motion::Driven(thing.pose, thing.velocity, thing.spin),
        };
        // From here on it ends with the scene, whatever is refused.
        self.bodies.push(Body { actor, motion });
        match thing.kind {
            Kind::Static => {}
            Kind::Dynamic => weigh(actor.as_ptr().cast(), thing),
            // Before it gets its shapes, of which meshes are for what is driven alone.
            // SAFETY: the body was made just now.
            Kind::Kinematic => unsafe {
                let body = actor.as_ptr().cast();
                PxRigidBody_setRigidBodyFlag_mut(body, PxRigidBodyFlag::Kinematic, true);
            },
        }
        dress(physics, actor, material, &thing.shape, &Pose::default())?;
        // SAFETY: scene and actor live, and no step is under way.
        if !unsafe { PxScene_addActor_mut(self.scene.as_ptr(), actor.as_ptr().cast(), ptr::null()) } {
            return Err(refused("it refused a body".to_owned()));
        }
        match thing.kind {
            Kind::Dynamic => self.set_velocity(self.bodies.len() - 1, thing.velocity, thing.spin),
            _ => Ok(()),
        }
    }

    fn step(&mut self) -> Result<(), Error> {
        let dt = 1.0 / self.rate;
        for body in &mut self.bodies {
            if let Motion::Driven(at, velocity, spin) = &mut body.motion {
                at.position += velocity.as_dvec3() * f64::from(dt);
                let turned = rotation::compose(rotation::from_rotation_vector(*spin * dt), at.rotation);
                at.rotation = rotation::normalize(turned);
                // SAFETY: the body lives and is kinematic, no step is under way, and the pose is read during the call.
                unsafe { PxRigidDynamic_setKinematicTarget_mut(body.actor.as_ptr().cast(), &transform(at)) };
            }
        }
        let (scene, mut error) = (self.scene.as_ptr(), 0);
        // SAFETY: the scene lives, and `&mut self` keeps all others off it; there is no task to call and no scratch memory.
        unsafe {
            PxScene_simulate_mut(scene, dt, ptr::null_mut(), ptr::null_mut(), 0, true);
            PxScene_fetchResults_mut(scene, true, &mut error);
        }
        if error == 0 { Ok(()) } else { Err(refused(format!("a step failed (code {error})"))) }
    }

    fn pose(&self, body: usize) -> Result<Pose, Error> {
        // SAFETY: the actor lives; reading changes nothing.
        Ok(pose(unsafe { PxRigidActor_getGlobalPose(self.bodies[body].actor.as_ptr()) }))
    }

    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error> {
        let Body { actor, motion } = &self.bodies[body];
        Ok(match motion {
            Motion::Fixed => (Vec3::ZERO, Vec3::ZERO),
            Motion::Driven(_, velocity, spin) => (*velocity, *spin),
            Motion::Free => {
                let body = actor.as_ptr().cast();
                // SAFETY: the body lives; reading changes nothing.
                let [v, w] =
                    unsafe { [PxRigidBody_getLinearVelocity(body), PxRigidBody_getAngularVelocity(body)] };
                (Vec3::new(v.x, v.y, v.z), Vec3::new(w.x, w.y, w.z))
            }
        })
    }

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        if let Motion::Driven(_, v, w) = &mut self.bodies[body].motion {
            (*v, *w) = (velocity, spin);
            return Ok(());
        }
        let body = self.free(body)?;
        // SAFETY: the body lives, no step is under way, and the values are read during the calls.
        unsafe {
            PxRigidDynamic_setLinearVelocity_mut(body, &vector(velocity), true);
            PxRigidDynamic_setAngularVelocity_mut(body, &vector(spin), true);
        }
        Ok(())
    }

    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        let body = self.free(body)?.cast();
        // SAFETY: the body lives, no step is under way, and the value is read during the call.
        unsafe { PxRigidBody_addForce_mut(body, &vector(impulse), PxForceMode::Impulse, true) };
        Ok(())
    }

    fn load(&self, _: usize) -> Option<DVec3> {
        None
    }
}

fn refused(reason: String) -> Error {
    Error::Peer { engine: "physx", reason }
}

fn vector(v: Vec3) -> PxVec3 {
    PxVec3 { x: v.x, y: v.y, z: v.z }
}

fn transform(pose: &Pose) -> PxTransform {
    let q = pose.rotation;
    PxTransform { q: PxQuat { x: q.x, y: q.y, z: q.z, w: q.w }, p: vector(pose.position.as_vec3()) }
}

fn pose(PxTransform { p, q }: PxTransform) -> Pose {
    let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
    Pose { position, rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::cuboid;
    use rockfall::shape::{Hull, Mesh};
    use std::sync::Arc;

    /// Promise: what PhysX lacks is named, and the scene ends all the same.
    #[test]
    fn what_it_lacks_is_named() {
        let spiral = |i: u16| {
            let (sin, cos) = libm::sincos(2.4 * f64::from(i));
            let z = (f64::from(i) - 150.0) / 151.0;
            (DVec3::new(cos, sin, 0.0) * libm::sqrt(1.0 - z * z) + DVec3::Z * z).as_vec3()
        };
        let hull = Hull::from_points(&(0..=300).map(spiral).collect::<Vec<_>>()).expect("a round hull");
        assert!(hull.vertices.len() > 255);
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let mesh =
            Mesh::from_triangles(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).expect("closed");
        for (shape, name) in [
            (Shape::Cylinder { half_length: 0.5, radius: 0.5 }, "cylinder"),
            (Shape::Ellipsoid { half: Vec3::new(0.5, 0.6, 0.7) }, "ellipsoid"),
            (Shape::Hull(Arc::new(hull)), "hull"),
            (Shape::Mesh(Arc::new(mesh)), "mesh that moves freely"),
        ] {
            let mut physx = Physx::new(&Terms::FINE).expect("a scene");
            let thing = Thing::new(shape, Surface::new(0.5, 0.0), DVec3::ZERO);
            let error = physx.put(&thing).expect_err(name);
            assert!(matches!(error, Error::NoShape { engine: "physx", shape } if shape == name), "{error}");
        }
        let mix = Surface { mix: Mix::GeometricMean, ..Surface::new(0.5, 0.0) };
        let mut physx = Physx::new(&Terms::FINE).expect("a scene");
        let error =
            physx.put(&Thing::new(cuboid(1.0, 1.0, 1.0), mix, DVec3::ZERO)).expect_err("no such rule");
        assert!(error.to_string().contains("geometric mean"), "{error}");
    }

    /// Promise: a cube that would pass a thin wall within a step is stopped.
    #[test]
    fn what_is_fast_is_stopped_by_a_thin_wall() {
        let terms = Terms { gravity: Vec3::ZERO, ..Terms::FRAMES };
        let mut physx = Physx::new(&terms).expect("a scene");
        let surface = Surface::new(0.0, 0.0);
        physx.put(&Thing::new(cuboid(0.02, 2.0, 2.0), surface, DVec3::X).fixed()).expect("a wall");
        let cube = Thing::new(cuboid(0.1, 0.1, 0.1), surface, DVec3::ZERO);
        physx.put(&cube.moving(Vec3::X * 200.0, Vec3::ZERO)).expect("a cube");
        (0..10).try_for_each(|_| physx.step()).expect("steps");
        let place = physx.pose(1).expect("there").position;
        assert!((0.9..0.96).contains(&place.x), "{place}");
    }
}
