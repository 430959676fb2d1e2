//! Morton codes: one number that keeps neighbours in space near each other.

use rockfall_math::{Aabb, Vec3};

/// Bits per axis.
const BITS: u32 = 21;

/// Place of `point` along a Z-shaped curve through `bounds`, 63 bits, x in the lowest. The cells of the curve are cubes
/// that divide the longest side of `bounds` by 2²¹, so that a flat world is not cut into slices. Points outside
/// count as the nearest ones inside; a coordinate that is not a number counts as the smallest.
#[inline]
pub fn morton(point: Vec3, bounds: &Aabb) -> u64 {
    Grid::new(bounds).morton(point)
}

/// The cells of the curve, for many points in the same bounds. Double precision, so that bounds as wide as single
/// precision goes do not overflow.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    min: Vec3,
    scale: f64,
}

impl Grid {
    /// The cells in `bounds`; a single one where `bounds` has no extent or is not finite.
    pub fn new(bounds: &Aabb) -> Self {
        let sides = bounds.max.as_dvec3() - bounds.min.as_dvec3();
        let longest = sides.max_element();
        let scale = f64::from(1_u32 << BITS) / longest;
        let usable = sides.is_finite() && longest > 0.0 && scale.is_finite();
        Grid { min: bounds.min, scale: if usable { scale } else { 0.0 } }
    }

    /// See [`morton`].
    #[inline]
    pub fn morton(&self, point: Vec3) -> u64 {
        let cell = (point.as_dvec3() - self.min.as_dvec3()) * self.scale;
        // A cast saturates, and takes NaN to 0.
        let part = |x: f64| spread((x as u32).min((1 << BITS) - 1));
        part(cell.x) | part(cell.y) << 1 | part(cell.z) << 2
    }
}

/// Moves bit i to bit 3 i.
#[inline]
fn spread(x: u32) -> u64 {
    let x = u64::from(x);
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb::new(Vec3::ZERO, Vec3::ONE);

    #[test]
    fn spread_moves_every_bit() {
        for bit in 0..BITS {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread((1 << BITS) - 1), 0x1249_2492_4924_9249);
    }

    #[test]
    fn octants_come_in_z_order() {
        let codes: Vec<u64> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.5 + 0.25)
            .map(|p| morton(p, &UNIT) >> 60)
            .collect();
        assert_eq!(codes, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn cells_of_a_flat_world_are_cubes() {
        let flat = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 1.0, 1.0 / 1024.0));
        let cell = 1.0 / 2_097_152.0;
        assert_eq!(morton(Vec3::new(cell, 0.0, 0.0), &flat), 1);
        assert_eq!(morton(Vec3::new(0.0, cell, 0.0), &flat), 2);
        assert_eq!(morton(Vec3::new(0.0, 0.0, cell), &flat), 4);
    }

    #[test]
    fn any_input_has_a_code() {
        let wide = Aabb::new(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX));
        assert!(morton(Vec3::ZERO, &wide) > 0);
        for bounds in [Aabb::EMPTY, Aabb::new(Vec3::ONE, Vec3::ONE), wide, Aabb::new(Vec3::NAN, Vec3::NAN)] {
            for point in [Vec3::NAN, Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ONE] {
                assert!(morton(point, &bounds) < 1 << 63);
            }
        }
        assert_eq!(morton(Vec3::splat(9.0), &UNIT), (1 << 63) - 1);
        assert_eq!(morton(Vec3::splat(-9.0), &UNIT), 0);
    }
}
