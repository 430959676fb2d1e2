//! Box3D by its C interface: four sub-steps, as its samples and benchmarks have them, and its own threads. Friction
//! mixes by the geometric mean, which changes nothing where all materials are equal.

use super::Engine;
use crate::Error;
use crate::scene::{self, Placed, Scene};
use boxddd_sys::ffi::*;
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Quat, Vec3};
use std::ptr::{self, NonNull};
use std::sync::{Mutex, PoisonError};

/// Sub-steps of a step.
const SUB_STEPS: i32 = 4;

/// The library's list of worlds is one for the process, and not guarded.
static WORLDS: Mutex<()> = Mutex::new(());

pub(super) struct Box3d {
    bodies: Vec<b3BodyId>,
    driven: Vec<b3BodyId>,
    /// Dropped before the meshes that it refers to.
    world: World,
    shapes: Vec<Cooked>,
    density: f32,
}

impl Box3d {
    pub(super) fn new(scene: &Scene, threads: usize) -> Result<Self, Error> {
        let shapes = scene.shapes.iter().map(cook).collect::<Result<Vec<_>, _>>()?;
        let world = World::new(scene.gravity, threads)?;
        let add = |shape: usize, pose: &Pose, kind: b3BodyType| {
            world.add(&shapes[shape], pose, kind, scene.density)
        };
        for fixed in &scene.fixed {
            add(fixed.shape, &fixed.pose, b3BodyType_b3_staticBody)?;
        }
        let driven = scene.driven.iter().map(|d| add(d.shape, &d.after(0), b3BodyType_b3_kinematicBody));
        let driven = driven.collect::<Result<_, _>>()?;
        Ok(Box3d { bodies: Vec::new(), driven, world, shapes, density: scene.density })
    }
}

impl Engine for Box3d {
    fn spawn(&mut self, bodies: &[Placed]) -> Result<(), Error> {
        for b in bodies {
            let kind = b3BodyType_b3_dynamicBody;
            self.bodies.push(self.world.add(&self.shapes[b.shape], &b.pose, kind, self.density)?);
        }
        Ok(())
    }

    fn drive(&mut self, targets: &[Pose]) -> Result<(), Error> {
        for (&body, target) in self.driven.iter().zip(targets) {
            let target = b3Transform { p: vector(target.position.as_vec3()), q: quaternion(target.rotation) };
            // SAFETY: the body is one of this world's, which lives, and no step is under way.
            unsafe { b3Body_SetTargetTransform(body, target, 1.0 / scene::RATE, true) };
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        // SAFETY: the world lives, and `&mut self` keeps all others off it.
        unsafe { b3World_Step(self.world.0, 1.0 / scene::RATE, SUB_STEPS) };
        Ok(())
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |&body: &b3BodyId| {
            // SAFETY: the body is one of this world's, which lives; reading changes nothing.
            let b3Transform { p, q } = unsafe { b3Body_GetTransform(body) };
            let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
            Pose { position, rotation: Quat::from_xyzw(q.v.x, q.v.y, q.v.z, q.s) }
        };
        self.bodies.iter().map(pose).collect()
    }

    fn mass(&self) -> f64 {
        // SAFETY: the bodies are this world's, which lives; reading changes nothing.
        self.bodies.iter().map(|&body| f64::from(unsafe { b3Body_GetMass(body) })).sum()
    }
}

/// The version of the library, as 1.2.3.
pub(super) fn version() -> String {
    // SAFETY: returns three constants.
    let b3Version { major, minor, revision } = unsafe { b3GetVersion() };
    format!("{major}.{minor}.{revision}")
}

/// A world of the library, which ends with this value.
struct World(b3WorldId);

impl World {
    fn new(gravity: f32, threads: usize) -> Result<Self, Error> {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: returns a plain value.
        let mut def = unsafe { b3DefaultWorldDef() };
        def.gravity = vector(Vec3::new(0.0, 0.0, -gravity));
        def.enableSleep = false;
        def.workerCount = u32::try_from(threads).unwrap_or(u32::MAX);
        // SAFETY: `def` is the default one with plain numbers changed, and `WORLDS` is held.
        let world = unsafe { b3CreateWorld(&def) };
        // SAFETY: takes any id.
        if unsafe { b3World_IsValid(world) } {
            Ok(World(world))
        } else {
            Err(refused("it made no world".to_owned()))
        }
    }

    fn add(&self, shape: &Cooked, pose: &Pose, kind: b3BodyType, density: f32) -> Result<b3BodyId, Error> {
        // SAFETY: return plain values.
        let (mut body_def, mut shape_def) = unsafe { (b3DefaultBodyDef(), b3DefaultShapeDef()) };
        body_def.type_ = kind;
        body_def.position = vector(pose.position.as_vec3());
        body_def.rotation = quaternion(pose.rotation);
        body_def.enableSleep = false;
        shape_def.density = density;
        shape_def.baseMaterial.friction = scene::FRICTION;
        shape_def.baseMaterial.restitution = scene::RESTITUTION;
        // SAFETY: the world lives, and the definition is the default one with plain values changed.
        let body = unsafe { b3CreateBody(self.0, &body_def) };
        // SAFETY: the body was made just now. Spheres, capsules and hulls are copied; a mesh lives longer than the world.
        let made = unsafe {
            match shape {
                Cooked::Sphere(sphere) => b3CreateSphereShape(body, &shape_def, sphere),
                Cooked::Capsule(capsule) => b3CreateCapsuleShape(body, &shape_def, capsule),
                Cooked::Box(hull) => b3CreateHullShape(body, &shape_def, &hull.base),
                Cooked::Hull(hull) => b3CreateHullShape(body, &shape_def, hull.as_ptr()),
                Cooked::Mesh(mesh) => b3CreateMeshShape(body, &shape_def, mesh.as_ptr(), vector(Vec3::ONE)),
            }
        };
        // SAFETY: takes any id.
        if unsafe { b3Shape_IsValid(made) } {
            Ok(body)
        } else {
            Err(refused("it refused a shape".to_owned()))
        }
    }
}

impl Drop for World {
    fn drop(&mut self) {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the world lives until here, and `WORLDS` is held.
        unsafe { b3DestroyWorld(self.0) };
    }
}

/// A shape as the library takes it.
enum Cooked {
    Sphere(b3Sphere),
    Capsule(b3Capsule),
    Box(Box<b3BoxHull>),
    Hull(NonNull<b3HullData>),
    Mesh(NonNull<b3MeshData>),
}

impl Drop for Cooked {
    fn drop(&mut self) {
        match self {
            // SAFETY: made by `b3CreateHull`, freed once; worlds have copies.
            Cooked::Hull(hull) => unsafe { b3DestroyHull(hull.as_ptr()) },
            // SAFETY: made by `b3CreateMesh`, freed once, after the world that refers to it.
            Cooked::Mesh(mesh) => unsafe { b3DestroyMesh(mesh.as_ptr()) },
            Cooked::Sphere(_) | Cooked::Capsule(_) | Cooked::Box(_) => {}
        }
    }
}

fn cook(shape: &Shape) -> Result<Cooked, Error> {
    let none = || refused(format!("no such shape: a {}", shape.name()));
    let count = |n: usize| i32::try_from(n).map_err(|_| none());
    match shape {
        Shape::Sphere { radius } => {
            Ok(Cooked::Sphere(b3Sphere { center: vector(Vec3::ZERO), radius: *radius }))
        }
        Shape::Capsule { half_length, radius } => {
            let [center1, center2] = [-*half_length, *half_length].map(|z| vector(Vec3::Z * z));
            Ok(Cooked::Capsule(b3Capsule { center1, center2, radius: *radius }))
        }
        // SAFETY: returns a plain value.
        Shape::Box { half } => Ok(Cooked::Box(Box::new(unsafe { b3MakeBoxHull(half.x, half.y, half.z) }))),
        Shape::Hull(hull) => {
            let points: Vec<b3Vec3> = hull.vertices.iter().map(|&v| vector(v)).collect();
            let count = count(points.len())?;
            // SAFETY: `points` has so many points.
            NonNull::new(unsafe { b3CreateHull(points.as_ptr(), count, count) })
                .map(Cooked::Hull)
                .ok_or_else(none)
        }
        Shape::Mesh(mesh) => {
            let mut vertices: Vec<b3Vec3> = mesh.vertices.iter().map(|&v| vector(v)).collect();
            let corners = mesh.triangles.iter().flatten();
            let mut indices =
                corners.map(|&i| i32::try_from(i).map_err(|_| none())).collect::<Result<Vec<_>, _>>()?;
            let def = b3MeshDef {
                vertices: vertices.as_mut_ptr(),
                indices: indices.as_mut_ptr(),
                materialIndices: ptr::null_mut(),
                weldTolerance: 0.0,
                vertexCount: count(vertices.len())?,
                triangleCount: count(mesh.triangles.len())?,
                weldVertices: false,
                useMedianSplit: false,
                identifyEdges: true,
            };
            // SAFETY: the counts are those of the columns, which live until the call is over, and it copies them; no
            // degenerate triangles are asked for.
            NonNull::new(unsafe { b3CreateMesh(&def, ptr::null_mut(), 0) }).map(Cooked::Mesh).ok_or_else(none)
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

fn refused(reason: String) -> Error {
    Error::Engine { engine: "box3d", reason }
}

fn vector(v: Vec3) -> b3Vec3 {
    b3Vec3 { x: v.x, y: v.y, z: v.z }
}

fn quaternion(q: Quat) -> b3Quat {
    b3Quat { v: b3Vec3 { x: q.x, y: q.y, z: q.z }, s: q.w }
}
