//! Jolt by its C wrapper: 10 velocity and 2 position iterations, one collision step, convex radii of 50 mm, all as it
//! comes. Friction mixes by the geometric mean, which changes nothing where all materials are equal.

use super::Engine;
use crate::Error;
use crate::scene::{self, Placed, Scene};
use oxijolt_sys::*;
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Quat, Vec3};
use std::ptr::NonNull;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Of the library that the wrapper brings.
pub(super) const VERSION: &str = "5.6.0";

/// Jolt wants to know before it starts how much it will have to hold: so many for each body that moves, and a few for the
/// walls. A step that needs more ends with an error.
const PAIRS: usize = 20;
const CONTACTS: usize = 10;
const FEW: usize = 1 << 16;

/// Bytes that a step takes for each contact and each body that moves, generously.
const CONTACT_BYTES: usize = 1024;
const BODY_BYTES: usize = 512;

/// What stands still and what moves, both for objects and for the broad phase.
const STILL: u8 = 0;
const MOVING: u8 = 1;
const LAYERS: u32 = 2;

/// The wrapper's list of worlds is one for the process, and not guarded.
static WORLDS: Mutex<()> = Mutex::new(());

pub(super) struct Jolt {
    world: World,
    shapes: Vec<Cooked>,
    bodies: Vec<NonNull<JPH_Body>>,
    driven: Vec<NonNull<JPH_Body>>,
}

impl Jolt {
    pub(super) fn new(scene: &Scene, threads: usize) -> Result<Self, Error> {
        let moving = scene.driven.len() + scene.bodies.len();
        let world = World::new(scene.fixed.len(), moving, scene.gravity, threads)?;
        let cooked = scene.shapes.iter().map(|shape| cook(shape, scene.density));
        let shapes = cooked.collect::<Result<Vec<_>, _>>()?;
        let add = |shape: usize, pose: &Pose, kind: JPH_MotionType| world.add(&shapes[shape], pose, kind);
        for fixed in &scene.fixed {
            add(fixed.shape, &fixed.pose, JPH_MotionType_Static)?;
        }
        let driven = scene.driven.iter().map(|d| add(d.shape, &d.after(0), JPH_MotionType_Kinematic));
        let driven = driven.collect::<Result<_, _>>()?;
        Ok(Jolt { world, shapes, bodies: Vec::new(), driven })
    }
}

impl Engine for Jolt {
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error> {
        let first = self.bodies.is_empty();
        for b in bodies {
            let body = self.world.add(&self.shapes[b.shape], &b.pose, JPH_MotionType_Dynamic)?;
            self.bodies.push(body);
        }
        if first {
            // Advised once a world is filled, and against later.
            // SAFETY: the world lives, and no step is under way.
            unsafe { JPH_PhysicsSystem_OptimizeBroadPhase(self.world.system.as_ptr()) };
        }
        Ok(())
    }

    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error> {
        for (body, target) in self.driven.iter().zip(targets) {
            let mut position = vector(target.position.as_vec3());
            let mut rotation = quaternion(target.rotation);
            // SAFETY: world and body live, no step is under way, and the values are read during the call only.
            unsafe {
                let id = JPH_Body_GetID(body.as_ptr());
                let bodies = self.world.bodies();
                JPH_BodyInterface_MoveKinematic(bodies, id, &mut position, &mut rotation, 1.0 / scene::RATE);
            }
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        let World { system, jobs, scratch } = &self.world;
        // SAFETY: all three live, and `&mut self` keeps all others off them.
        let error = unsafe {
            JPH_PhysicsSystem_Update2(system.as_ptr(), 1.0 / scene::RATE, 1, scratch.as_ptr(), jobs.as_ptr())
        };
        if error == JPH_PhysicsUpdateError_None {
            Ok(())
        } else {
            Err(refused(format!("a buffer is full, and it drops contacts (code {error})")))
        }
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |body: &NonNull<JPH_Body>| {
            let mut p = vector(Vec3::ZERO);
            let mut q = quaternion(Quat::IDENTITY);
            // SAFETY: world and body live; reads them and writes the two values.
            unsafe {
                let id = JPH_Body_GetID(body.as_ptr());
                JPH_BodyInterface_GetPositionAndRotation(self.world.bodies(), id, &mut p, &mut q);
            }
            let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
            Pose { position, rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) }
        };
        self.bodies.iter().map(pose).collect()
    }

    fn mass(&self) -> f64 {
        let inverse = |body: &NonNull<JPH_Body>| {
            // SAFETY: the body lives and is dynamic, so it has motion properties.
            unsafe {
                JPH_MotionProperties_GetInverseMassUnchecked(JPH_Body_GetMotionProperties(body.as_ptr()))
            }
        };
        self.bodies.iter().map(|body| 1.0 / f64::from(inverse(body))).sum()
    }
}

/// A world of the library with its threads and its memory for a step, which all end with this value.
struct World {
    system: NonNull<JPH_PhysicsSystem>,
    jobs: NonNull<JPH_JobSystem>,
    scratch: NonNull<JPH_TempAllocator>,
}

impl World {
    fn new(fixed: usize, moving: usize, gravity: f32, threads: usize) -> Result<Self, Error> {
        static READY: OnceLock<bool> = OnceLock::new();
        // SAFETY: once per process.
        if !READY.get_or_init(|| unsafe { JPH_Init() }) {
            return Err(refused("it did not start".to_owned()));
        }
        let fits = |n: usize| {
            u32::try_from(n).map_err(|_| refused(format!("no room for {moving} bodies that move")))
        };
        let contacts = CONTACTS * moving + FEW;
        let scratch = fits(CONTACT_BYTES * contacts + BODY_BYTES * moving + (64 << 20))?;
        let [bodies, pairs, contacts] = [fits(fixed + moving)?, fits(PAIRS * moving + FEW)?, fits(contacts)?];
        let none = || refused("it made no world".to_owned());

        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the tables are made here and are the system's from its making on.
        let system = unsafe {
            let pairs_of_layers = JPH_ObjectLayerPairFilterTable_Create(LAYERS);
            for layer in [STILL, MOVING] {
                JPH_ObjectLayerPairFilterTable_EnableCollision(pairs_of_layers, layer.into(), MOVING.into());
            }
            let layers = JPH_BroadPhaseLayerInterfaceTable_Create(LAYERS, LAYERS);
            for layer in [STILL, MOVING] {
                JPH_BroadPhaseLayerInterfaceTable_MapObjectToBroadPhaseLayer(layers, layer.into(), layer);
            }
            let filter =
                JPH_ObjectVsBroadPhaseLayerFilterTable_Create(layers, LAYERS, pairs_of_layers, LAYERS);
            JPH_PhysicsSystem_Create(&JPH_PhysicsSystemSettings {
                maxBodies: bodies,
                numBodyMutexes: 0,
                maxBodyPairs: pairs,
                maxContactConstraints: contacts,
                _padding: 0,
                broadPhaseLayerInterface: layers,
                objectLayerPairFilter: pairs_of_layers,
                objectVsBroadPhaseLayerFilter: filter,
            })
        };
        let system = NonNull::new(system).ok_or_else(none)?;
        // SAFETY: the system lives, and the vector is read during the call.
        unsafe { JPH_PhysicsSystem_SetGravity(system.as_ptr(), &vector(Vec3::new(0.0, 0.0, -gravity))) };
        let jobs = match i32::try_from(threads.saturating_sub(1)).unwrap_or(i32::MAX) {
            // SAFETY: room for as many jobs as the thread pool has.
            0 => unsafe { JPH_JobSystemSingleThreaded_Create(2048) },
            // The thread that steps works too.
            others => {
                let config = JobSystemThreadPoolConfig { maxJobs: 0, maxBarriers: 0, numThreads: others };
                // SAFETY: reads the configuration during the call.
                unsafe { JPH_JobSystemThreadPool_Create(&config) }
            }
        };
        // SAFETY: takes a number alone.
        let scratch = unsafe { JPH_TempAllocator_Create(scratch) };
        let (jobs, scratch) = NonNull::new(jobs).zip(NonNull::new(scratch)).ok_or_else(none)?;
        Ok(World { system, jobs, scratch })
    }

    /// For use between steps.
    fn bodies(&self) -> *mut JPH_BodyInterface {
        // SAFETY: the system lives, and the interface with it.
        unsafe { JPH_PhysicsSystem_GetBodyInterfaceNoLock(self.system.as_ptr()) }
    }

    fn add(&self, shape: &Cooked, pose: &Pose, kind: JPH_MotionType) -> Result<NonNull<JPH_Body>, Error> {
        let layer = if kind == JPH_MotionType_Static { STILL } else { MOVING };
        let (position, rotation) = (vector(pose.position.as_vec3()), quaternion(pose.rotation));
        // SAFETY: world and shape live; the settings are made and ended here; the body takes a share of the shape.
        unsafe {
            let settings = JPH_BodyCreationSettings_Create3(
                shape.0.as_ptr(),
                &position,
                &rotation,
                kind,
                JPH_ObjectLayer::from(layer),
            );
            JPH_BodyCreationSettings_SetFriction(settings, scene::FRICTION);
            JPH_BodyCreationSettings_SetRestitution(settings, scene::RESTITUTION);
            JPH_BodyCreationSettings_SetAllowSleeping(settings, false);
            let body = JPH_BodyInterface_CreateBody(self.bodies(), settings);
            JPH_BodyCreationSettings_Destroy(settings);
            let body = NonNull::new(body).ok_or_else(|| refused("it refused a body".to_owned()))?;
            JPH_BodyInterface_AddBody(self.bodies(), JPH_Body_GetID(body.as_ptr()), JPH_Activation_Activate);
            Ok(body)
        }
    }
}

impl Drop for World {
    fn drop(&mut self) {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: all three live until here, no step is under way, and `WORLDS` is held.
        unsafe {
            JPH_PhysicsSystem_Destroy(self.system.as_ptr());
            JPH_JobSystem_Destroy(self.jobs.as_ptr());
            JPH_TempAllocator_Destroy(self.scratch.as_ptr());
        }
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

fn cook(shape: &Shape, density: f32) -> Result<Cooked, Error> {
    let none = || refused(format!("no such shape: a {}", shape.name()));
    let count = |n: usize| u32::try_from(n).map_err(|_| none());
    let radius_of_edges = JPH_DEFAULT_CONVEX_RADIUS as f32;
    // SAFETY: all arguments are read during the calls, and columns have as many elements as they are said to; settings are made
    // and ended here; the shape that is returned has one share, ours.
    let made: *mut JPH_Shape = unsafe {
        match shape {
            Shape::Sphere { radius } => JPH_SphereShape_Create(*radius).cast(),
            Shape::Box { half } => JPH_BoxShape_Create(&vector(*half), radius_of_edges).cast(),
            Shape::Capsule { half_length, radius } => JPH_CapsuleShape_Create(*half_length, *radius).cast(),
            Shape::Hull(hull) => {
                let points: Vec<JPH_Vec3> = hull.vertices.iter().map(|&v| vector(v)).collect();
                let settings = JPH_ConvexHullShapeSettings_Create(
                    points.as_ptr(),
                    count(points.len())?,
                    radius_of_edges,
                );
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
            // None of the scenes has these.
            Shape::HalfSpace { .. }
            | Shape::Field(_)
            | Shape::HeightField(_)
            | Shape::Cylinder { .. }
            | Shape::Cone { .. }
            | Shape::Ellipsoid { .. }
            | Shape::RoundedBox { .. }
            | Shape::RoundedHull { .. }
            | Shape::Compound(_) => return Err(none()),
        }
    };
    let made = Cooked(NonNull::new(made).ok_or_else(none)?);
    if !matches!(shape, Shape::Mesh(_)) {
        // SAFETY: the shape was made just now, and is one of the convex ones.
        unsafe { JPH_ConvexShape_SetDensity(made.0.as_ptr().cast(), density) };
    }
    match shape {
        Shape::Capsule { .. } => upright(&made).ok_or_else(none),
        _ => Ok(made),
    }
}

/// A shape along y turned to z.
fn upright(shape: &Cooked) -> Option<Cooked> {
    let turn = quaternion(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    // SAFETY: reads its arguments during the call; the result takes a share of the shape, and has one of its own.
    let made = unsafe { JPH_RotatedTranslatedShape_Create(&vector(Vec3::ZERO), &turn, shape.0.as_ptr()) };
    NonNull::new(made.cast()).map(Cooked)
}

fn refused(reason: String) -> Error {
    Error::Engine { engine: "jolt", reason }
}

fn vector(v: Vec3) -> JPH_Vec3 {
    JPH_Vec3 { x: v.x, y: v.y, z: v.z }
}

fn quaternion(q: Quat) -> JPH_Quat {
    JPH_Quat { x: q.x, y: q.y, z: q.z, w: q.w }
}
