//! What a user says of a body.

use crate::{MaterialId, ShapeId};
use rockfall_math::{Mat3, Pose, Vec3};

/// Who moves a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Forces and contacts.
    #[default]
    Dynamic,
    /// Its velocity, whatever it meets.
    Kinematic,
    /// Nobody.
    Static,
}

/// A body's stable name in the world: the user's own number, or one that [`World::spawn`](crate::World::spawn) gave.
/// All ties in the simulation are broken by it, so that the order in which bodies are added does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u64);

/// Directions in which a body can't move, in the world's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Locks {
    /// No motion along x, y, z.
    pub linear: [bool; 3],
    /// No rotation about x, y, z.
    pub angular: [bool; 3],
}

/// Mass properties that replace those of shape and density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassOverride {
    /// kg, positive.
    pub mass: f32,
    /// Centre of mass in the body's frame, metres; the shape's where `None`.
    pub center: Option<Vec3>,
    /// Inertia about the centre of mass in the body's axes, kg m²; the shape's, scaled to `mass`, where `None`.
    pub inertia: Option<Mat3>,
}

/// A body to be added with [`World::spawn`](crate::World::spawn).
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its stable id; the world picks the next free one where `None`.
    pub id: Option<BodyId>,
    /// A name for people.
    pub name: Option<String>,
    /// Who moves it.
    pub kind: Kind,
    /// What it is.
    pub shape: ShapeId,
    /// What it is made of.
    pub material: MaterialId,
    /// Where it is: the frame of its shape.
    pub pose: Pose,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// rad/s, world axes.
    pub angular_velocity: Vec3,
    /// Gravity is multiplied by this.
    pub gravity_scale: f32,
    /// Share of the velocity lost per second, 1/s: v' = v / (1 + c t).
    pub linear_damping: f32,
    /// Share of the angular velocity lost per second, 1/s.
    pub angular_damping: f32,
    /// Directions in which it can't move.
    pub locks: Locks,
    /// Groups that it belongs to, one bit each.
    pub group: u32,
    /// Groups that it collides with. Two bodies collide when each one's mask has a group of the other.
    pub mask: u32,
    /// It collides with nothing, and tells who is in it: dynamic and kinematic bodies, their groups and masks permitting, whose shapes share a point with its own; one of the two
    /// must be bounded and convex. See [`Events::entered`](crate::Events::entered). Other sensors it does not see.
    pub sensor: bool,
    /// Mass properties other than those of shape and density.
    pub mass: Option<MassOverride>,
}

impl Body {
    /// A dynamic body at `pose`, at rest.
    pub fn new(shape: ShapeId, material: MaterialId, pose: Pose) -> Self {
        Body {
            id: None,
            name: None,
            kind: Kind::Dynamic,
            shape,
            material,
            pose,
            velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            locks: Locks::default(),
            group: 1,
            mask: u32::MAX,
            sensor: false,
            mass: None,
        }
    }

    /// A body at `pose` that nobody moves.
    pub fn fixed(shape: ShapeId, material: MaterialId, pose: Pose) -> Self {
        Body { kind: Kind::Static, ..Body::new(shape, material, pose) }
    }
}
