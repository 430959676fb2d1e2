//! PhysX on the processor by its C wrapper, with one solver or the other: 4 position and 1 velocity iterations, as it comes.

use super::Engine;
use crate::Error;
use crate::scene::{self, Placed, Scene};
use physx_sys::*;
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Quat, Vec3};
use std::ptr::{self, NonNull};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Of the library that the wrapper brings.
pub(super) const VERSION: &str = "5.1.3";

/// The library, of which there is one for the process. Whoever makes something of it holds it.
static LIBRARY: Mutex<Option<Library>> = Mutex::new(None);

pub(super) struct Physx {
    bodies: Vec<NonNull<PxRigidDynamic>>,
    driven: Vec<NonNull<PxRigidDynamic>>,
    world: World,
    shapes: Vec<Cooked>,
    density: f32,
}

impl Physx {
    pub(super) fn new(scene: &Scene, threads: usize, solver: PxSolverType) -> Result<Self, Error> {
        let guard = library()?;
        let library = guard.as_ref().ok_or_else(|| refused("it did not start".to_owned()))?;
        // Dropped on errors, like the shapes, while the library is still held.
        let world = World::new(library, scene.gravity, threads, solver)?;
        let shapes = scene.shapes.iter().map(|s| cook(library, s)).collect::<Result<Vec<_>, _>>()?;
        for fixed in &scene.fixed {
            world.add_static(library, &shapes[fixed.shape], &fixed.pose)?;
        }
        let add = |shape: usize, pose: &Pose| world.add(library, &shapes[shape], pose, scene.density);
        let mut driven = Vec::new();
        for d in &scene.driven {
            let body: NonNull<PxRigidDynamic> = add(d.shape, &d.after(0))?;
            // SAFETY: the body was made just now, and no step is under way.
            unsafe {
                PxRigidBody_setRigidBodyFlag_mut(body.as_ptr().cast(), PxRigidBodyFlag::Kinematic, true);
            }
            driven.push(body);
        }
        Ok(Physx { bodies: Vec::new(), driven, world, shapes, density: scene.density })
    }
}

impl Engine for Physx {
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error> {
        let guard = library()?;
        let library = guard.as_ref().ok_or_else(|| refused("it did not start".to_owned()))?;
        for b in bodies {
            self.bodies.push(self.world.add(library, &self.shapes[b.shape], &b.pose, self.density)?);
        }
        Ok(())
    }

    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error> {
        for (body, target) in self.driven.iter().zip(targets) {
            // SAFETY: the body lives and is kinematic, no step is under way, and the pose is read during the call.
            unsafe { PxRigidDynamic_setKinematicTarget_mut(body.as_ptr(), &place(target)) };
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        let (scene, mut error) = (self.world.scene.as_ptr(), 0);
        // SAFETY: the scene lives, and `&mut self` keeps all others off it; there is no task to call and no scratch memory.
        unsafe {
            PxScene_simulate_mut(scene, 1.0 / scene::RATE, ptr::null_mut(), ptr::null_mut(), 0, true);
            PxScene_fetchResults_mut(scene, true, &mut error);
        }
        if error == 0 { Ok(()) } else { Err(refused(format!("a step failed (code {error})"))) }
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |body: &NonNull<PxRigidDynamic>| {
            // SAFETY: the body lives; reading changes nothing.
            let PxTransform { p, q } = unsafe { PxRigidActor_getGlobalPose(body.as_ptr().cast()) };
            let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
            Pose { position, rotation: Quat::from_xyzw(q.x, q.y, q.z, q.w) }
        };
        self.bodies.iter().map(pose).collect()
    }

    fn mass(&self) -> f64 {
        // SAFETY: the body lives; reading changes nothing.
        let mass = |b: &NonNull<PxRigidDynamic>| unsafe { PxRigidBody_getMass(b.as_ptr().cast()) };
        self.bodies.iter().map(|body| f64::from(mass(body))).sum()
    }
}

/// Kept until the process ends.
struct Library {
    physics: NonNull<PxPhysics>,
    material: NonNull<PxMaterial>,
}

// SAFETY: the library may be used from any thread, by one at a time: `LIBRARY` guards it.
unsafe impl Send for Library {}

/// The library, held; it is started by whoever is first.
fn library() -> Result<MutexGuard<'static, Option<Library>>, Error> {
    let mut held = LIBRARY.lock().unwrap_or_else(PoisonError::into_inner);
    if held.is_none() {
        let none = || refused("it did not start".to_owned());
        // SAFETY: once per process, and under the lock.
        unsafe {
            let foundation = NonNull::new(physx_create_foundation()).ok_or_else(none)?;
            let physics = NonNull::new(physx_create_physics(foundation.as_ptr())).ok_or_else(none)?;
            let material = PxPhysics_createMaterial_mut(
                physics.as_ptr(),
                scene::FRICTION,
                scene::FRICTION,
                scene::RESTITUTION,
            );
            *held = Some(Library { physics, material: NonNull::new(material).ok_or_else(none)? });
        }
    }
    Ok(held)
}

/// A scene of the library with its threads, which end with this value.
struct World {
    scene: NonNull<PxScene>,
    dispatcher: NonNull<PxDefaultCpuDispatcher>,
}

impl World {
    fn new(library: &Library, gravity: f32, threads: usize, solver: PxSolverType) -> Result<Self, Error> {
        let none = || refused("it made no scene".to_owned());
        let threads = u32::try_from(threads).unwrap_or(u32::MAX);
        let mode = PxDefaultCpuDispatcherWaitForWorkMode::WaitForWork;
        // SAFETY: takes numbers and no list of processors. The thread that steps sleeps meanwhile.
        let dispatcher = unsafe { phys_PxDefaultCpuDispatcherCreate(threads, ptr::null_mut(), mode, 0) };
        let dispatcher = NonNull::new(dispatcher).ok_or_else(none)?;
        // SAFETY: the library lives; the description is the default one with plain values, the dispatcher, which ends after
        // the scene, and the library's own filter.
        let scene = unsafe {
            let mut about = PxSceneDesc_new(PxPhysics_getTolerancesScale(library.physics.as_ptr()));
            about.gravity = vector(Vec3::new(0.0, 0.0, -gravity));
            about.solverType = solver;
            about.cpuDispatcher = dispatcher.as_ptr().cast();
            about.filterShader = get_default_simulation_filter_shader();
            PxPhysics_createScene_mut(library.physics.as_ptr(), &about)
        };
        match NonNull::new(scene) {
            Some(scene) => Ok(World { scene, dispatcher }),
            None => {
                // SAFETY: made just now, and no scene uses it.
                unsafe { PxDefaultCpuDispatcher_release_mut(dispatcher.as_ptr()) };
                Err(none())
            }
        }
    }

    fn add_static(&self, library: &Library, shape: &Cooked, pose: &Pose) -> Result<(), Error> {
        let Library { physics, material } = library;
        // SAFETY: library, scene and shape live; the poses are read during the calls.
        let added = unsafe {
            let (at, within) = (place(pose), shape.turn());
            let geometry = shape.geometry();
            let body = phys_PxCreateStatic(physics.as_ptr(), &at, geometry, material.as_ptr(), &within);
            !body.is_null() && PxScene_addActor_mut(self.scene.as_ptr(), body.cast(), ptr::null())
        };
        if added { Ok(()) } else { Err(refused("it refused a body".to_owned())) }
    }

    fn add(
        &self,
        library: &Library,
        shape: &Cooked,
        pose: &Pose,
        density: f32,
    ) -> Result<NonNull<PxRigidDynamic>, Error> {
        let Library { physics, material } = library;
        let none = || refused("it refused a body".to_owned());
        // SAFETY: library, scene and shape live; the poses are read during the calls.
        unsafe {
            let (at, within) = (place(pose), shape.turn());
            let geometry = shape.geometry();
            let body =
                phys_PxCreateDynamic(physics.as_ptr(), &at, geometry, material.as_ptr(), density, &within);
            let body = NonNull::new(body).ok_or_else(none)?;
            // Nothing is slow enough to sleep.
            PxRigidDynamic_setSleepThreshold_mut(body.as_ptr(), 0.0);
            let added = PxScene_addActor_mut(self.scene.as_ptr(), body.as_ptr().cast(), ptr::null());
            added.then_some(body).ok_or_else(none)
        }
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: both live until here, no step is under way, and the scene ends first; the library's list of scenes has a lock
        // of its own. Its bodies stay until the process
        // ends: a scene does not own them, and a process has one scene, but for tests.
        unsafe {
            PxScene_release_mut(self.scene.as_ptr());
            PxDefaultCpuDispatcher_release_mut(self.dispatcher.as_ptr());
        }
    }
}

/// A shape as the library takes it.
enum Cooked {
    Sphere(PxSphereGeometry),
    Box(PxBoxGeometry),
    Capsule(PxCapsuleGeometry),
    Hull(PxConvexMeshGeometry),
    Mesh(PxTriangleMeshGeometry),
}

impl Cooked {
    fn geometry(&self) -> *const PxGeometry {
        match self {
            Cooked::Sphere(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Box(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Capsule(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Hull(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Mesh(geometry) => ptr::from_ref(geometry).cast(),
        }
    }

    /// From the library's axes of the shape to ours: its capsules lie along x.
    fn turn(&self) -> PxTransform {
        let rotation = match self {
            Cooked::Capsule(_) => Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
            _ => Quat::IDENTITY,
        };
        place(&Pose { position: DVec3::ZERO, rotation })
    }
}

fn cook(library: &Library, shape: &Shape) -> Result<Cooked, Error> {
    let none = || refused(format!("no such shape: a {}", shape.name()));
    let physics = library.physics.as_ptr();
    // SAFETY: all arguments are read during the calls, and columns have as many elements of such a size as they are said to have.
    // Meshes stay until the process ends, because bodies do.
    unsafe {
        let parameters = PxCookingParams_new(PxPhysics_getTolerancesScale(physics));
        let callback = PxPhysics_getPhysicsInsertionCallback_mut(physics);
        match shape {
            Shape::Sphere { radius } => Ok(Cooked::Sphere(PxSphereGeometry_new(*radius))),
            Shape::Box { half } => Ok(Cooked::Box(PxBoxGeometry_new(half.x, half.y, half.z))),
            Shape::Capsule { half_length, radius } => {
                Ok(Cooked::Capsule(PxCapsuleGeometry_new(*radius, *half_length)))
            }
            Shape::Hull(hull) => {
                let points: Vec<PxVec3> = hull.vertices.iter().map(|&v| vector(v)).collect();
                let mut about = PxConvexMeshDesc_new();
                column(&mut about.points, &points).ok_or_else(none)?;
                about.flags = PxConvexFlags::ComputeConvex;
                let mesh = phys_PxCreateConvexMesh(&parameters, &about, callback, ptr::null_mut());
                let mesh = NonNull::new(mesh).ok_or_else(none)?.as_ptr();
                let flags = PxConvexMeshGeometryFlags::TightBounds;
                Ok(Cooked::Hull(PxConvexMeshGeometry_new(mesh, &PxMeshScale_new(), flags)))
            }
            Shape::Mesh(mesh) => {
                let vertices: Vec<PxVec3> = mesh.vertices.iter().map(|&v| vector(v)).collect();
                let mut about = PxTriangleMeshDesc_new();
                column(&mut about.points, &vertices).ok_or_else(none)?;
                column(&mut about.triangles, &mesh.triangles).ok_or_else(none)?;
                let mesh = phys_PxCreateTriangleMesh(&parameters, &about, callback, ptr::null_mut());
                let mesh = NonNull::new(mesh).ok_or_else(none)?.as_ptr();
                let flags = PxMeshGeometryFlags::TightBounds;
                Ok(Cooked::Mesh(PxTriangleMeshGeometry_new(mesh, &PxMeshScale_new(), flags)))
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
            | Shape::Compound(_) => Err(none()),
        }
    }
}

/// Points a description at a column; nothing where it is too long.
fn column<T>(data: &mut PxBoundedData, values: &[T]) -> Option<()> {
    data.count = u32::try_from(values.len()).ok()?;
    data.stride = u32::try_from(size_of::<T>()).ok()?;
    data.data = values.as_ptr().cast();
    Some(())
}

fn refused(reason: String) -> Error {
    Error::Engine { engine: "physx", reason }
}

fn vector(v: Vec3) -> PxVec3 {
    PxVec3 { x: v.x, y: v.y, z: v.z }
}

fn place(pose: &Pose) -> PxTransform {
    let q = pose.rotation;
    PxTransform { q: PxQuat { x: q.x, y: q.y, z: q.z, w: q.w }, p: vector(pose.position.as_vec3()) }
}
