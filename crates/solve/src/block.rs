//! Contacts side by side: sixteen manifolds whose numbers lie lane by lane.
//!
//! A block always has sixteen lanes, so that its layout depends on nothing; a kernel takes it in pieces as wide as the
//! machine's registers. Kernels that write to blocks and bodies fetch from memory what is in [`Block`] (hot) and, only for
//! contacts that bounce or resist rolling, what is in [`Cold`].

use bytemuck::{Pod, Zeroable};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Lanes3};

/// Lanes of a block.
pub const LANES: usize = 16;

/// One number per lane.
pub type Column = [f32; LANES];

/// One vector per lane.
pub type Column3 = [Column; 3];

/// Sixteen manifolds of up to P points; T is 1 where a torque about the normal resists twisting, and 0 where a single
/// point leaves the twist free. 164 bytes a manifold with four points, 116 with two, 80 with one.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Block<const P: usize, const T: usize> {
    /// Row of the first body; 0 in lanes that are not in use.
    pub a: [u32; LANES],
    /// Row of the second body, without its mark.
    pub b: [u32; LANES],
    /// From a to b.
    pub normal: Column3,
    /// Centre of mass of b seen from that of a, metres; without the gap between bodies that don't touch yet.
    pub offset: Column3,
    /// From the centre of mass of a to each point, metres. Points that are not in use lie in the middle of the others.
    pub arms: [Column3; P],
    /// Signed distances at the start of the step, metres.
    pub distances: [Column; P],
    /// Effective masses along the normal, kg; 0 for points that are not in use, any other number for one whose mass is not known yet.
    pub masses: [Column; P],
    /// Accumulated normal impulses, N s.
    pub impulses: [Column; P],
    /// Inverse of the 2 × 2 matrix of the tangents at the middle of the points: 11, 12, 22, kg. Something else for two balls: see
    /// `balls.rs`.
    pub tangent_mass: [Column; 3],
    /// Accumulated friction impulse along the two tangents, N s.
    pub tangent_impulse: [Column; 2],
    /// Coefficient of friction.
    pub friction: Column,
    /// Effective moment of inertia about the normal, kg m².
    pub twist_mass: [Column; T],
    /// Accumulated angular impulse about the normal, N m s.
    pub twist_impulse: [Column; T],
    /// Largest twist impulse per normal impulse, m.
    pub twist_limit: [Column; T],
}

/// What only contacts that bounce, resist rolling, or resist twisting at a single point need.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Cold {
    /// Coefficient of restitution.
    pub restitution: Column,
    /// Normal velocity of each point before the step, m/s; negative where the bodies approach.
    pub approach: [Column; 4],
    /// Largest normal impulse of each point in the step, N s.
    pub peak: [Column; 4],
    /// Largest rolling impulse per normal impulse, m.
    pub rolling_limit: Column,
    /// Inverse of the sum of the inverse inertias: xx, xy, xz, yy, yz, zz, kg m².
    pub rolling_mass: [Column; 6],
    /// Accumulated angular impulse against rolling, N m s.
    pub rolling_impulse: Column3,
    /// Effective moment of inertia about the normal, kg m²; 0 where the block resists twisting itself.
    pub twist_mass: Column,
    /// Accumulated angular impulse about the normal, N m s.
    pub twist_impulse: Column,
    /// Largest twist impulse per normal impulse, m.
    pub twist_limit: Column,
}

impl<const P: usize, const T: usize> Block<P, T> {
    /// Sixteen lanes that do nothing.
    pub const IDLE: Self = Block {
        a: [0; LANES],
        b: [0; LANES],
        normal: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
        offset: [[0.0; LANES]; 3],
        arms: [[[0.0; LANES]; 3]; P],
        distances: [[0.0; LANES]; P],
        masses: [[0.0; LANES]; P],
        impulses: [[0.0; LANES]; P],
        tangent_mass: [[0.0; LANES]; 3],
        tangent_impulse: [[0.0; LANES]; 2],
        friction: [0.0; LANES],
        twist_mass: [[0.0; LANES]; T],
        twist_impulse: [[0.0; LANES]; T],
        twist_limit: [[0.0; LANES]; T],
    };
}

impl Cold {
    /// Sixteen lanes that do nothing.
    pub const IDLE: Self = Cold {
        restitution: [0.0; LANES],
        approach: [[0.0; LANES]; 4],
        peak: [[0.0; LANES]; 4],
        rolling_limit: [0.0; LANES],
        rolling_mass: [[0.0; LANES]; 6],
        rolling_impulse: [[0.0; LANES]; 3],
        twist_mass: [0.0; LANES],
        twist_impulse: [0.0; LANES],
        twist_limit: [0.0; LANES],
    };
}

/// Reads `WIDTH` lanes of a column from lane `k` on.
#[inline(always)]
pub(crate) fn load<L: Lanes>(token: L::Token, column: &Column, k: usize) -> L {
    L::load(token, &column[k..k + L::WIDTH])
}

/// Writes `WIDTH` lanes of a column from lane `k` on.
#[inline(always)]
pub(crate) fn store<L: Lanes>(x: L, column: &mut Column, k: usize) {
    x.store(&mut column[k..k + L::WIDTH]);
}

/// Reads `WIDTH` vectors from lane `k` on.
#[inline(always)]
pub(crate) fn load3<L: Lanes>(token: L::Token, columns: &Column3, k: usize) -> Lanes3<L> {
    Lanes3::new(load(token, &columns[0], k), load(token, &columns[1], k), load(token, &columns[2], k))
}

/// Reads one vector from a lane.
pub(crate) fn get3(columns: &Column3, lane: usize) -> Vec3 {
    Vec3::new(columns[0][lane], columns[1][lane], columns[2][lane])
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
///
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017: continuous but for n.z = 0.
#[inline(always)]
pub(crate) fn tangents<L: Lanes>(token: L::Token, n: Lanes3<L>) -> (Lanes3<L>, Lanes3<L>) {
    let one = L::splat(token, 1.0);
    let sign = L::select(n.z.lt(L::splat(token, 0.0)), -one, one);
    let a = -(one / (sign + n.z));
    let b = n.x * n.y * a;
    (
        Lanes3::new(one + sign * n.x * n.x * a, sign * b, -(sign * n.x)),
        Lanes3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// [`tangents`] of one vector.
pub(crate) fn tangents_of(n: Vec3) -> (Vec3, Vec3) {
    let (s, t) = tangents::<f32>((), Lanes3::new(n.x, n.y, n.z));
    (Vec3::new(s.x, s.y, s.z), Vec3::new(t.x, t.y, t.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hot_bytes_per_contact() {
        assert_eq!(size_of::<Block<4, 1>>() / LANES, 164);
        assert_eq!(size_of::<Block<2, 1>>() / LANES, 116);
        assert_eq!(size_of::<Block<1, 0>>() / LANES, 80);
    }

    #[test]
    fn tangents_are_a_right_handed_frame() {
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.36, -0.48, 0.8)] {
            let (s, t) = tangents_of(n);
            assert!((s.cross(t) - n).length() < 1e-6);
            assert!(s.dot(t).abs() < 1e-6 && s.dot(n).abs() < 1e-6);
        }
    }
}
