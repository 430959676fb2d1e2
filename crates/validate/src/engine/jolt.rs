//! Jolt by its C wrapper: 10 velocity and 2 position iterations, one collision step, 20 mm of slop, all as it comes, but for the length of a step, its restitution
//! threshold, and what bodies lose and may reach by themselves: no damping, no limit of spin, gyroscopic torque, casts of what is fast; nobody sleeps. Convex radii are 50 mm, or the
//! smallest half width of a shape that is thinner. Mass and inertia are the same numbers as ours. Meshes don't move freely, and there are no ellipsoids.

use super::{DENSITY, Engine, Terms, Thing};
use crate::Error;
use crate::stage::turn;
use oxijolt_sys::*;
use rockfall::math::{DVec3, Mat3, Pose, Quat, Vec3};
use rockfall::{Kind, Mix, Shape};
use std::ffi::c_void;
use std::ptr::{self, NonNull};
use std::sync::{Mutex, OnceLock, PoisonError};

/// What a world has room for; a body more, or a step that needs more, is an error.
const BODIES: u32 = 8192;
const PAIRS: u32 = 1 << 16;
const CONTACTS: u32 = 1 << 15;
const SCRATCH: u32 = 96 << 20;

/// Half the extent of a plane, m.
const WIDE: f32 = 1000.0;

/// What stands still and what moves, both for objects and for the broad phase.
const STILL: u8 = 0;
const MOVING: u8 = 1;
const LAYERS: u32 = 2;

/// How friction mixes, by the user data of bodies.
const MIXES: [Mix; 5] = [Mix::Average, Mix::GeometricMean, Mix::Minimum, Mix::Product, Mix::Maximum];

/// The wrapper's list of worlds is one for the process, and not guarded.
static WORLDS: Mutex<()> = Mutex::new(());

/// What a contact calls, whichever world it is in.
static CALLS: JPH_ContactListener_Procs = JPH_ContactListener_Procs {
    OnContactValidate: None,
    OnContactAdded: Some(rub),
    OnContactPersisted: Some(rub),
    OnContactRemoved: None,
};

pub(super) struct Jolt {
    system: NonNull<JPH_PhysicsSystem>,
    jobs: NonNull<JPH_JobSystem>,
    scratch: NonNull<JPH_TempAllocator>,
    listener: NonNull<JPH_ContactListener>,
    bodies: Vec<JPH_BodyID>,
    rate: f32,
}

impl Jolt {
    pub(super) fn new(terms: &Terms) -> Result<Self, Error> {
        static READY: OnceLock<bool> = OnceLock::new();
        // SAFETY: once per process.
        if !READY.get_or_init(|| unsafe { JPH_Init() }) {
            return Err(refused("it did not start".to_owned()));
        }
        let none = || refused("it made no world".to_owned());
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the tables are made here and are the system's from its making on; the calls are for ever.
        let (system, listener) = unsafe {
            let pairs = JPH_ObjectLayerPairFilterTable_Create(LAYERS);
            let layers = JPH_BroadPhaseLayerInterfaceTable_Create(LAYERS, LAYERS);
            for layer in [STILL, MOVING] {
                JPH_ObjectLayerPairFilterTable_EnableCollision(pairs, layer.into(), MOVING.into());
                JPH_BroadPhaseLayerInterfaceTable_MapObjectToBroadPhaseLayer(layers, layer.into(), layer);
            }
            let filter = JPH_ObjectVsBroadPhaseLayerFilterTable_Create(layers, LAYERS, pairs, LAYERS);
            JPH_ContactListener_SetProcs(&CALLS);
            let system = JPH_PhysicsSystem_Create(&JPH_PhysicsSystemSettings {
                maxBodies: BODIES,
                numBodyMutexes: 0,
                maxBodyPairs: PAIRS,
                maxContactConstraints: CONTACTS,
                _padding: 0,
                broadPhaseLayerInterface: layers,
                objectLayerPairFilter: pairs,
                objectVsBroadPhaseLayerFilter: filter,
            });
            (NonNull::new(system).ok_or_else(none)?, JPH_ContactListener_Create(ptr::null_mut()))
        };
        // SAFETY: takes numbers alone.
        let (jobs, scratch) =
            unsafe { (JPH_JobSystemSingleThreaded_Create(2048), JPH_TempAllocator_Create(SCRATCH)) };
        let (jobs, scratch) = NonNull::new(jobs).zip(NonNull::new(scratch)).ok_or_else(none)?;
        let listener = NonNull::new(listener).ok_or_else(none)?;
        // SAFETY: all live; the settings are a plain value that is filled in before it is read.
        unsafe {
            let mut settings = std::mem::zeroed();
            JPH_PhysicsSystem_GetPhysicsSettings(system.as_ptr(), &mut settings);
            settings.minVelocityForRestitution = terms.threshold;
            JPH_PhysicsSystem_SetPhysicsSettings(system.as_ptr(), &mut settings);
            JPH_PhysicsSystem_SetGravity(system.as_ptr(), &vector(terms.gravity));
            JPH_PhysicsSystem_SetContactListener(system.as_ptr(), listener.as_ptr());
        }
        Ok(Jolt { system, jobs, scratch, listener, bodies: Vec::new(), rate: terms.rate })
    }

    /// For use between steps.
    fn interface(&self) -> *mut JPH_BodyInterface {
        // SAFETY: the system lives, and the interface with it.
        unsafe { JPH_PhysicsSystem_GetBodyInterfaceNoLock(self.system.as_ptr()) }
    }
}

impl Drop for Jolt {
    fn drop(&mut self) {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: all four live until here, no step is under way, and `WORLDS` is held.
        unsafe {
            JPH_PhysicsSystem_Destroy(self.system.as_ptr());
            JPH_JobSystem_Destroy(self.jobs.as_ptr());
            JPH_TempAllocator_Destroy(self.scratch.as_ptr());
            JPH_ContactListener_Destroy(self.listener.as_ptr());
        }
    }
}

/// Mixes friction by the later of the rules of two bodies.
unsafe extern "C" fn rub(
    _: *mut c_void,
    a: *const JPH_Body,
    b: *const JPH_Body,
    _: *const JPH_ContactManifold,
    settings: *mut JPH_ContactSettings,
) {
    // SAFETY: called by a step with bodies and settings of its own; the former are read only.
    unsafe {
        let rule =
            |body: *const JPH_Body| MIXES[JPH_Body_GetUserData(body.cast_mut()) as usize % MIXES.len()];
        (*settings).combinedFriction = rule(a).mix(rule(b), JPH_Body_GetFriction(a), JPH_Body_GetFriction(b));
    }
}

impl Engine for Jolt {
    fn put(&mut self, thing: &Thing) -> Result<(), Error> {
        let (layer, kind) = match thing.kind {
            Kind::Dynamic => (MOVING, JPH_MotionType_Dynamic),
            Kind::Kinematic => (MOVING, JPH_MotionType_Kinematic),
            Kind::Static => (STILL, JPH_MotionType_Static),
        };
        if thing.kind == Kind::Dynamic && matches!(thing.shape, Shape::Mesh(_)) {
            return Err(Error::NoShape { engine: "jolt", shape: "mesh that moves freely" });
        }
        let shape = cook(&thing.shape)?;
        let (position, rotation) = (vector(thing.pose.position.as_vec3()), quaternion(thing.pose.rotation));
        let rule = MIXES.iter().position(|mix| *mix == thing.surface.mix).unwrap_or(0);
        // SAFETY: world and shape live; the settings are made and ended here; the body takes a share of the shape.
        unsafe {
            let settings = JPH_BodyCreationSettings_Create3(
                shape.0.as_ptr(),
                &position,
                &rotation,
                kind,
                JPH_ObjectLayer::from(layer),
            );
            JPH_BodyCreationSettings_SetFriction(settings, thing.surface.friction);
            JPH_BodyCreationSettings_SetRestitution(settings, thing.surface.restitution);
            JPH_BodyCreationSettings_SetUserData(settings, rule as u64);
            JPH_BodyCreationSettings_SetAllowSleeping(settings, false);
            JPH_BodyCreationSettings_SetLinearDamping(settings, 0.0);
            JPH_BodyCreationSettings_SetAngularDamping(settings, 0.0);
            JPH_BodyCreationSettings_SetMaxAngularVelocity(settings, 1e6);
            JPH_BodyCreationSettings_SetApplyGyroscopicForce(settings, true);
            JPH_BodyCreationSettings_SetLinearVelocity(settings, &vector(thing.velocity));
            JPH_BodyCreationSettings_SetAngularVelocity(settings, &vector(thing.spin));
            if let (Some(solid), Kind::Dynamic) = (thing.shape.mass_properties(DENSITY), thing.kind) {
                let solid = thing.mass.map_or(solid, |mass| solid.with_mass(mass));
                let inertia = thing.moments.map_or(solid.inertia, Mat3::from_diagonal);
                let [x, y, z] = inertia.to_cols_array_2d().map(|[x, y, z]| JPH_Vec4 { x, y, z, w: 0.0 });
                let inertia = JPH_Mat4 { column: [x, y, z, JPH_Vec4 { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }] };
                let mass = JPH_MassProperties { mass: solid.mass, inertia };
                let given = JPH_OverrideMassProperties_MassAndInertiaProvided;
                JPH_BodyCreationSettings_SetOverrideMassProperties(settings, given);
                JPH_BodyCreationSettings_SetMassPropertiesOverride(settings, &mass);
                JPH_BodyCreationSettings_SetMotionQuality(settings, JPH_MotionQuality_LinearCast);
            }
            let body = JPH_BodyInterface_CreateBody(self.interface(), settings);
            JPH_BodyCreationSettings_Destroy(settings);
            let body = NonNull::new(body).ok_or_else(|| refused(format!("no room for {BODIES} bodies")))?;
            let id = JPH_Body_GetID(body.as_ptr());
            JPH_BodyInterface_AddBody(self.interface(), id, JPH_Activation_Activate);
            self.bodies.push(id);
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        // SAFETY: all three live, and `&mut self` keeps all others off them.
        let error = unsafe {
            let (system, scratch, jobs) = (self.system.as_ptr(), self.scratch.as_ptr(), self.jobs.as_ptr());
            JPH_PhysicsSystem_Update2(system, 1.0 / self.rate, 1, scratch, jobs)
        };
        if error == JPH_PhysicsUpdateError_None {
            Ok(())
        } else {
            Err(refused(format!("a buffer is full, and it drops contacts (code {error})")))
        }
    }

    fn pose(&self, body: usize) -> Result<Pose, Error> {
        let mut p = vector(Vec3::ZERO);
        let mut q = quaternion(Quat::IDENTITY);
        // SAFETY: world and body live; reads them and writes the two values.
        unsafe {
            JPH_BodyInterface_GetPositionAndRotation(self.interface(), self.bodies[body], &mut p, &mut q);
        }
        let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
        Ok(Pose { position, rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) })
    }

    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error> {
        let [mut v, mut w] = [vector(Vec3::ZERO); 2];
        // SAFETY: world and body live; reads them and writes the two values.
        unsafe {
            let (all, id) = (self.interface(), self.bodies[body]);
            JPH_BodyInterface_GetLinearAndAngularVelocity(all, id, &mut v, &mut w);
        }
        Ok((Vec3::new(v.x, v.y, v.z), Vec3::new(w.x, w.y, w.z)))
    }

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        let [mut v, mut w] = [vector(velocity), vector(spin)];
        // SAFETY: world and body live, and the values are read during the call.
        unsafe {
            let (all, id) = (self.interface(), self.bodies[body]);
            JPH_BodyInterface_SetLinearAndAngularVelocity(all, id, &mut v, &mut w);
        }
        Ok(())
    }

    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        let mut impulse = vector(impulse);
        // SAFETY: world and body live, and the value is read during the call.
        unsafe { JPH_BodyInterface_AddImpulse(self.interface(), self.bodies[body], &mut impulse) };
        Ok(())
    }

    fn load(&self, _: usize) -> Option<DVec3> {
        None
    }
}

/// A share of a shape of the library.
struct Cooked(NonNull<JPH_Shape>);

impl Drop for Cooked {
    fn drop(&mut self) {
        // SAFETY: gives back the share that this value has.
        unsafe { JPH_Shape_Destroy(self.0.as_ptr()) };
    }
}

fn cook(shape: &Shape) -> Result<Cooked, Error> {
    let none = || Error::NoShape { engine: "jolt", shape: shape.name() };
    let count = |n: usize| u32::try_from(n).map_err(|_| none());
    let edge = |thinnest: f32| thinnest.min(JPH_DEFAULT_CONVEX_RADIUS as f32);
    // SAFETY: all arguments are read during the calls, and columns have as many elements as they are said to; settings are made and ended here; a
    // shape that contains another takes a share of it; the shape that is returned has one share, ours.
    let made: *mut JPH_Shape = unsafe {
        match shape {
            Shape::Sphere { radius } => JPH_SphereShape_Create(*radius).cast(),
            Shape::Box { half } => JPH_BoxShape_Create(&vector(*half), edge(half.min_element())).cast(),
            Shape::HalfSpace { normal, offset } => {
                let plane = JPH_Plane { normal: vector(*normal), distance: -offset };
                JPH_PlaneShape_Create(&plane, ptr::null(), WIDE).cast()
            }
            Shape::Capsule { half_length, radius } => {
                upright(Cooked::of(JPH_CapsuleShape_Create(*half_length, *radius).cast(), none)?)
            }
            Shape::Cylinder { half_length, radius } => {
                let settings =
                    JPH_CylinderShapeSettings_Create(*half_length, *radius, edge(half_length.min(*radius)));
                let made = JPH_CylinderShapeSettings_CreateShape(settings);
                JPH_ShapeSettings_Destroy(settings.cast());
                upright(Cooked::of(made.cast(), none)?)
            }
            Shape::Hull(hull) => {
                let points: Vec<JPH_Vec3> = hull.vertices.iter().map(|&v| vector(v)).collect();
                let (first, points) = (points.as_ptr(), count(points.len())?);
                let settings =
                    JPH_ConvexHullShapeSettings_Create(first, points, JPH_DEFAULT_CONVEX_RADIUS as f32);
                let made = JPH_ConvexHullShapeSettings_CreateShape(settings);
                JPH_ShapeSettings_Destroy(settings.cast());
                made.cast()
            }
            Shape::Mesh(mesh) => {
                let vertices: Vec<JPH_Vec3> = mesh.vertices.iter().map(|&v| vector(v)).collect();
                let triangle = |&[i1, i2, i3]: &[u32; 3]| JPH_IndexedTriangle {
                    i1,
                    i2,
                    i3,
                    materialIndex: 0,
                    userData: 0,
                };
                let triangles: Vec<JPH_IndexedTriangle> = mesh.triangles.iter().map(triangle).collect();
                let (corners, faces) = (count(vertices.len())?, count(triangles.len())?);
                let settings =
                    JPH_MeshShapeSettings_Create2(vertices.as_ptr(), corners, triangles.as_ptr(), faces);
                let made = JPH_MeshShapeSettings_CreateShape(settings);
                JPH_ShapeSettings_Destroy(settings.cast());
                made.cast()
            }
            Shape::Compound(compound) => {
                let parts = compound.parts().iter().map(|part| Ok((cook(&part.shape)?, part.pose)));
                let parts = parts.collect::<Result<Vec<_>, Error>>()?;
                let settings = JPH_StaticCompoundShapeSettings_Create();
                for (part, pose) in &parts {
                    let (p, q) = (vector(pose.position.as_vec3()), quaternion(pose.rotation));
                    JPH_CompoundShapeSettings_AddShape2(settings.cast(), &p, &q, part.0.as_ptr(), 0);
                }
                let made = JPH_StaticCompoundShape_Create(settings);
                JPH_ShapeSettings_Destroy(settings.cast());
                made.cast()
            }
            _ => return Err(none()),
        }
    };
    Cooked::of(made, none)
}

impl Cooked {
    fn of(made: *mut JPH_Shape, none: impl Fn() -> Error) -> Result<Self, Error> {
        NonNull::new(made).map(Cooked).ok_or_else(none)
    }
}

/// A shape along y turned to z, or null.
fn upright(shape: Cooked) -> *mut JPH_Shape {
    let turned = quaternion(turn(Vec3::X, core::f64::consts::FRAC_PI_2));
    // SAFETY: reads its arguments during the call; the result takes a share of the shape, and has one of its own.
    unsafe { JPH_RotatedTranslatedShape_Create(&vector(Vec3::ZERO), &turned, shape.0.as_ptr()).cast() }
}

fn refused(reason: String) -> Error {
    Error::Peer { engine: "jolt", reason }
}

fn vector(v: Vec3) -> JPH_Vec3 {
    JPH_Vec3 { x: v.x, y: v.y, z: v.z }
}

fn quaternion(q: Quat) -> JPH_Quat {
    JPH_Quat { x: q.x, y: q.y, z: q.z, w: q.w }
}
