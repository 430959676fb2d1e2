//! Immutable geometry: what a body is made of, cooked once and shared by any number of bodies.
//!
//! Lengths are metres, the frame of a shape is the user's own, z is up where a shape has a natural axis.

#![forbid(unsafe_code)]

mod bounds;
mod compound;
mod extent;
mod field;
mod frustum;
mod height_field;
mod hull;
mod kind;
mod mass;
mod mesh;
mod polyhedron;
mod principal;

pub use bounds::UNBOUNDED;
pub use compound::{Compound, CompoundError, Part};
pub use field::{
    Balls, CacheUse, Feature, FeatureEdge, Features, Field, FieldError, FieldMemory, FieldPoint,
    FieldSettings, Normals, SAMPLES_IN_A_BALL, Sample, Samples,
};
pub use frustum::Frustum;
pub use height_field::{HeightField, HeightFieldError, MOST_SAMPLES};
pub use hull::{
    CornerBlock, EdgeBlock, FaceBlock, HULL_LANES, Hull, HullBlocks, HullDefect, HullEdge, HullError,
    MAX_CORNERS,
};
pub use kind::ShapeError;
pub use mass::MassProperties;
pub use mesh::{EdgeKind, Mesh, MeshError, MeshReport, NearestOnMesh, TrianglePart, nearest_on_triangle};

use rockfall_math::Vec3;
use std::sync::Arc;

/// The smallest size of a shape, metres. The inertia of anything smaller drowns in single precision.
pub const SMALLEST: f32 = 1e-6;

/// The largest size of a shape and the largest coordinate in its frame, metres.
pub const LARGEST: f32 = 1e6;

/// A shape in its own frame. Cloning is cheap: large geometry is shared.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A ball around the origin.
    Sphere {
        /// Metres, positive.
        radius: f32,
    },
    /// A box around the origin, edges along the axes.
    Box {
        /// Half of the edge lengths, metres, positive.
        half: Vec3,
    },
    /// A cylinder with hemispheres at its ends, around the z axis.
    Capsule {
        /// Half of the distance between the centres of the hemispheres, metres, not negative.
        half_length: f32,
        /// Metres, positive.
        radius: f32,
    },
    /// A cylinder around the z axis, flat at both ends.
    Cylinder {
        /// Half of the height, metres, positive.
        half_length: f32,
        /// Metres, positive.
        radius: f32,
    },
    /// A cone around the z axis with its tip up, or a truncated one either way up. The origin is half-way up, which is not
    /// the centre of mass.
    Cone {
        /// Half of the height, metres, positive.
        half_length: f32,
        /// Radius of the lower end, metres, not negative.
        lower: f32,
        /// Radius of the upper end, metres, not negative: 0 is a tip. One of the two is positive.
        upper: f32,
    },
    /// An ellipsoid around the origin.
    Ellipsoid {
        /// Half axes along x, y and z, metres, positive.
        half: Vec3,
    },
    /// A box around the origin that has grown to all sides, so that its edges and corners are round.
    RoundedBox {
        /// Half of the edge lengths of the box before it has grown, metres, positive.
        half: Vec3,
        /// By how much it has grown, metres, positive.
        radius: f32,
    },
    /// A convex polyhedron.
    Hull(Arc<Hull>),
    /// A convex polyhedron that has grown to all sides, so that its edges and corners are round.
    RoundedHull {
        /// The polyhedron before it has grown.
        hull: Arc<Hull>,
        /// By how much it has grown, metres, positive.
        radius: f32,
    },
    /// All points p with `normal · p ≤ offset`. Immovable bodies only.
    HalfSpace {
        /// Unit length, points out of the solid.
        normal: Vec3,
        /// Signed distance of the surface from the origin along `normal`, metres.
        offset: f32,
    },
    /// A triangle surface, seen from the side of its normals. A closed one is a solid; of an open one static and kinematic bodies can be.
    Mesh(Arc<Mesh>),
    /// The inside of a closed triangle surface, concave or with holes, as its signed distance.
    Field(Arc<Field>),
    /// A surface z = h(x, y) over a regular grid. Immovable bodies only.
    HeightField(Arc<HeightField>),
    /// Several shapes at fixed places. Immovable bodies only where a part is for those only.
    Compound(Arc<Compound>),
}
