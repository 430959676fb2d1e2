//! Three-vectors of lanes.

use super::Lanes;
use core::ops::{Add, Neg, Sub};

/// One vector per lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes3<L> {
    /// x of every lane.
    pub x: L,
    /// y of every lane.
    pub y: L,
    /// z of every lane.
    pub z: L,
}

impl<L: Lanes> Lanes3<L> {
    /// From its three components.
    #[inline(always)]
    pub fn new(x: L, y: L, z: L) -> Self {
        Lanes3 { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(token: L::Token, v: crate::Vec3) -> Self {
        Lanes3::new(L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> L {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Lanes3::new(self.y * b.z - self.z * b.y, self.z * b.x - self.x * b.z, self.x * b.y - self.y * b.x)
    }

    /// Times a number per lane.
    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        Lanes3::new(self.x * s, self.y * s, self.z * s)
    }
}

impl<L: Lanes> Add for Lanes3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Lanes3::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl<L: Lanes> Sub for Lanes3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Lanes3::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl<L: Lanes> Neg for Lanes3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes3::new(-self.x, -self.y, -self.z)
    }
}
