//! What a file of another program holds, in the terms of a scene: metres, kilograms, seconds, radians, z up.

use crate::mesh_file::TriangleSoup;
use rockfall_math::{DVec3, Mat3, Pose, Vec3};
use std::fmt;

/// A scene of another program.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// In the order of the file; instances one after the other in the place of what makes them.
    pub bodies: Vec<Body>,
    /// Shapes of bodies, each once: its parts, at least one. A shape of one part has that part's frame.
    pub shapes: Vec<Vec<Part>>,
    /// Geometries of parts, each once.
    pub geometries: Vec<Geometry>,
    /// Materials of bodies, each once.
    pub materials: Vec<Material>,
    /// kg/m³ of what has none, where the format says so.
    pub density: Option<f32>,
    /// m/s², where the file says something of it.
    pub gravity: Option<DVec3>,
    /// XXH3 of the bytes of the file, those that it refers to not included.
    pub checksum: u64,
    /// What is there and can't be had, and what was taken for something else.
    pub notes: Vec<Note>,
}

/// Who moves a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Forces and contacts.
    Dynamic,
    /// Its velocity.
    Kinematic,
    /// Nobody.
    #[default]
    Static,
}

/// One body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Where it is in the file.
    pub name: String,
    /// Who moves it.
    pub kind: Kind,
    /// Whether it collides with nothing, and tells who is in it.
    pub sensor: bool,
    /// Index into [`Content::shapes`].
    pub shape: u32,
    /// Index into [`Content::materials`]; the scene's choice where `None`.
    pub material: Option<u32>,
    /// The frame of its shape.
    pub pose: Pose,
    /// Of the centre of mass, m/s.
    pub velocity: DVec3,
    /// rad/s, world axes.
    pub angular_velocity: DVec3,
    /// Gravity is multiplied by this.
    pub gravity_scale: f32,
    /// 1/s.
    pub linear_damping: f32,
    /// 1/s.
    pub angular_damping: f32,
    /// Groups that it belongs to, one bit each.
    pub group: u32,
    /// Groups that it meets.
    pub mask: u32,
    /// What replaces the mass of shape and material.
    pub mass: Mass,
}

/// Mass properties that the file gives for a body as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mass {
    /// kg.
    pub mass: Option<f32>,
    /// Centre of mass in the shape's frame, m.
    pub center: Option<Vec3>,
    /// About the centre of mass along the shape's axes, kg m².
    pub inertia: Option<Mat3>,
}

impl Mass {
    /// Whether the file says nothing.
    pub fn is_default(&self) -> bool {
        *self == Mass::default()
    }
}

/// One part of a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Index into [`Content::geometries`].
    pub geometry: u32,
    /// Where it is in the shape's frame; there, where it is the only one.
    pub pose: Pose,
    /// How heavy it is, where the body's material does not say.
    pub weight: Option<Weight>,
}

/// How heavy a part is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// kg.
    Mass(f32),
    /// kg/m³.
    Density(f32),
}

/// Geometry around an origin; round ones have their axis along z.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A ball.
    Sphere {
        /// m.
        radius: f32,
    },
    /// A box.
    Box {
        /// Half the edges along x, y, z, m.
        half: Vec3,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Half the diameters along x, y, z, m.
        half: Vec3,
    },
    /// A cylinder with half balls at its ends.
    Capsule {
        /// Of the cylinder, m.
        half_length: f32,
        /// m.
        radius: f32,
    },
    /// A cylinder, a cone, or a truncated cone.
    Cone {
        /// m.
        half_length: f32,
        /// Radius at the lower end, m.
        lower: f32,
        /// Radius at the upper end, m.
        upper: f32,
    },
    /// Everything below the plane z = 0.
    HalfSpace,
    /// The convex hull of points.
    Hull(Vec<Vec3>),
    /// A surface, for bodies that forces don't move.
    Mesh(TriangleSoup),
    /// The inside of a closed surface, as hulls.
    Decomposition {
        /// The surface.
        soup: TriangleSoup,
        /// The most hulls there may be, where the file says so.
        max_hulls: Option<u32>,
    },
    /// The inside of a closed surface, as a distance field.
    Field {
        /// The surface.
        soup: TriangleSoup,
        /// Samples along its longest side.
        resolution: u32,
    },
}

/// What a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Where it is in the file.
    pub name: String,
    /// Coulomb's coefficient.
    pub friction: f32,
    /// From 0 to 1.
    pub restitution: f32,
    /// kg/m³; [`Content::density`] where `None`.
    pub density: Option<f32>,
    /// How friction of two materials becomes one.
    pub friction_mix: Mix,
    /// How restitution of two materials becomes one.
    pub restitution_mix: Mix,
}

/// The rule that makes one coefficient of two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mix {
    /// (a + b) / 2.
    #[default]
    Average,
    /// The smaller one.
    Minimum,
    /// a · b.
    Product,
    /// The larger one.
    Maximum,
}

/// Something that a user has to know of what was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// What it is.
    pub what: String,
    /// Where it was found first; empty where it holds for the whole file.
    pub first: String,
    /// How often.
    pub count: usize,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        match (self.first.is_empty(), self.count) {
            (true, _) => Ok(()),
            (false, 1) => write!(f, " ({})", self.first),
            (false, n) => write!(f, " ({} and {} more)", self.first, n - 1),
        }
    }
}
