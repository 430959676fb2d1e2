//! Shapes as PhysX takes them.

use super::{pose, vector};
use crate::Error;
use crate::stage::turn;
use physx_sys::*;
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Quat, Vec3};
use std::ptr::{self, NonNull};

/// Corners of a hull; of one with more the library makes another.
const CORNERS: usize = 255;

/// A geometry with a share of its mesh.
pub(super) enum Cooked {
    Sphere(PxSphereGeometry),
    Box(PxBoxGeometry),
    Capsule(PxCapsuleGeometry),
    Plane(PxPlaneGeometry, Pose),
    Hull(PxConvexMeshGeometry),
    Mesh(PxTriangleMeshGeometry),
}

impl Cooked {
    pub(super) fn new(physics: NonNull<PxPhysics>, shape: &Shape) -> Result<Self, Error> {
        let none = || Error::NoShape { engine: "physx", shape: shape.name() };
        // SAFETY: the caller holds the library; all arguments are read during the calls, and columns have as many elements of such a size as they are said
        // to have.
        unsafe {
            let parameters = PxCookingParams_new(PxPhysics_getTolerancesScale(physics.as_ptr()));
            let callback = PxPhysics_getPhysicsInsertionCallback_mut(physics.as_ptr());
            Ok(match shape {
                Shape::Sphere { radius } => Cooked::Sphere(PxSphereGeometry_new(*radius)),
                Shape::Box { half } => Cooked::Box(PxBoxGeometry_new(half.x, half.y, half.z)),
                Shape::Capsule { half_length, radius } => {
                    Cooked::Capsule(PxCapsuleGeometry_new(*radius, *half_length))
                }
                Shape::HalfSpace { normal, offset } => {
                    let plane = PxPlane { n: vector(*normal), d: -offset };
                    Cooked::Plane(PxPlaneGeometry_new(), pose(phys_PxTransformFromPlaneEquation(&plane)))
                }
                Shape::Hull(hull) if hull.vertices.len() <= CORNERS => {
                    let points: Vec<PxVec3> = hull.vertices.iter().map(|&v| vector(v)).collect();
                    let mut about = PxConvexMeshDesc_new();
                    column(&mut about.points, &points).ok_or_else(none)?;
                    about.flags = PxConvexFlags::ComputeConvex;
                    let mesh = phys_PxCreateConvexMesh(&parameters, &about, callback, ptr::null_mut());
                    let mesh = NonNull::new(mesh).ok_or_else(none)?.as_ptr();
                    let flags = PxConvexMeshGeometryFlags::TightBounds;
                    Cooked::Hull(PxConvexMeshGeometry_new(mesh, &PxMeshScale_new(), flags))
                }
                Shape::Mesh(mesh) => {
                    let vertices: Vec<PxVec3> = mesh.vertices.iter().map(|&v| vector(v)).collect();
                    let mut about = PxTriangleMeshDesc_new();
                    column(&mut about.points, &vertices).ok_or_else(none)?;
                    column(&mut about.triangles, &mesh.triangles).ok_or_else(none)?;
                    let mesh = phys_PxCreateTriangleMesh(&parameters, &about, callback, ptr::null_mut());
                    let mesh = NonNull::new(mesh).ok_or_else(none)?.as_ptr();
                    let flags = PxMeshGeometryFlags::TightBounds;
                    Cooked::Mesh(PxTriangleMeshGeometry_new(mesh, &PxMeshScale_new(), flags))
                }
                _ => return Err(none()),
            })
        }
    }

    pub(super) fn geometry(&self) -> *const PxGeometry {
        match self {
            Cooked::Sphere(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Box(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Capsule(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Plane(geometry, _) => ptr::from_ref(geometry).cast(),
            Cooked::Hull(geometry) => ptr::from_ref(geometry).cast(),
            Cooked::Mesh(geometry) => ptr::from_ref(geometry).cast(),
        }
    }

    /// Where it is in our shape's frame: its capsules lie along x, and its planes are x ≤ 0.
    pub(super) fn place(&self) -> Pose {
        let upright = || turn(Vec3::Y, core::f64::consts::FRAC_PI_2);
        match self {
            Cooked::Plane(_, place) => *place,
            Cooked::Capsule(_) => Pose { position: DVec3::ZERO, rotation: upright() },
            _ => Pose { position: DVec3::ZERO, rotation: Quat::IDENTITY },
        }
    }
}

impl Drop for Cooked {
    fn drop(&mut self) {
        // SAFETY: gives back the share that this value has; the library is still held.
        unsafe {
            match self {
                Cooked::Hull(geometry) => PxRefCounted_release_mut(geometry.convexMesh.cast()),
                Cooked::Mesh(geometry) => PxRefCounted_release_mut(geometry.triangleMesh.cast()),
                _ => {}
            }
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
