//! What collision detection hands to the solver, and what it gets back.

use rockfall_math::Vec3;

/// Set in a row number: the body can't be moved by contacts.
pub const FIXED: u32 = 1 << 31;

/// The colour of a manifold that has none yet.
pub const NO_COLOR: u32 = u32::MAX;

/// The row without its [`FIXED`] mark.
#[inline]
pub fn row_of(marked: u32) -> usize {
    (marked & !FIXED) as usize
}

/// Up to four contact points of a pair of bodies, in world axes. Body `a` is always one that contacts can move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifold {
    /// Row of the body with the normal's tail.
    pub a: u32,
    /// Row of the other body, marked [`FIXED`] where contacts can't move it.
    pub b: u32,
    /// The first so many points are set, 1 to 4.
    pub count: u32,
    /// Unit vector from a to b.
    pub normal: Vec3,
    /// From the centre of mass of `a` to each point, metres.
    pub arms: [Vec3; 4],
    /// Signed distances, metres.
    pub distances: [f32; 4],
}

impl Manifold {
    /// Whether contacts move only one of the two bodies.
    pub fn is_one_sided(&self) -> bool {
        self.b & FIXED != 0
    }

    /// The smallest signed distance.
    pub fn deepest(&self) -> f32 {
        self.distances[..self.count as usize].iter().fold(f32::INFINITY, |d, &x| d.min(x))
    }
}

/// What a manifold remembers from one step to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// Names of the points.
    pub features: [u32; 4],
    /// Normal impulse of each point in the last sub-step, N s.
    pub normals: [f32; 4],
    /// Friction impulse on b in world axes, N s.
    pub friction: Vec3,
    /// Angular impulse about the normal on b, N m s.
    pub twist: f32,
    /// Angular impulse against rolling on b, N m s.
    pub rolling: Vec3,
    /// See [`crate::paint`].
    pub color: u32,
}

impl Default for Memory {
    fn default() -> Self {
        Memory {
            features: [0; 4],
            normals: [0.0; 4],
            friction: Vec3::ZERO,
            twist: 0.0,
            rolling: Vec3::ZERO,
            color: NO_COLOR,
        }
    }
}
