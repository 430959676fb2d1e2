//! Eight boxes side by side, tested at once.

use glam::Vec4;
use rockfall_math::{Aabb, Vec3};

/// Boxes per block.
pub(crate) const WIDTH: usize = 8;

/// Eight boxes, coordinate by coordinate: three cache lines. A lane without a box holds NaN, which no comparison
/// lets through, whatever the query.
#[repr(align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
}

/// Bit for bit, so that lanes without a box are equal.
impl PartialEq for Block {
    fn eq(&self, other: &Self) -> bool {
        let bits = |sides: &[[f32; WIDTH]; 3]| sides.map(|axis| axis.map(f32::to_bits));
        bits(&self.min) == bits(&other.min) && bits(&self.max) == bits(&other.max)
    }
}

impl Block {
    pub(crate) const EMPTY: Block = Block { min: [[f32::NAN; WIDTH]; 3], max: [[f32::NAN; WIDTH]; 3] };

    /// Puts a box into a lane; one that contains nothing, or has a coordinate that is no number, clears it.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, area: &Aabb) {
        let Aabb { min, max } =
            if area.min.cmple(area.max).all() { *area } else { Aabb { min: Vec3::NAN, max: Vec3::NAN } };
        for axis in 0..3 {
            self.min[axis][lane] = min[axis];
            self.max[axis][lane] = max[axis];
        }
    }

    /// The box in a lane.
    #[inline]
    pub(crate) fn area(&self, lane: usize) -> Aabb {
        let corner = |sides: &[[f32; WIDTH]; 3]| Vec3::from_array(sides.map(|axis| axis[lane]));
        Aabb { min: corner(&self.min), max: corner(&self.max) }
    }

    /// The smallest box around all lanes. `f32::min` and `max` pass over NaN.
    #[inline]
    pub(crate) fn bounds(&self) -> Aabb {
        let low = |lanes: &[f32; WIDTH]| lanes.iter().fold(f32::INFINITY, |a, &b| a.min(b));
        let high = |lanes: &[f32; WIDTH]| lanes.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
        Aabb {
            min: Vec3::new(low(&self.min[0]), low(&self.min[1]), low(&self.min[2])),
            max: Vec3::new(high(&self.max[0]), high(&self.max[1]), high(&self.max[2])),
        }
    }

    /// Bit i is set where the box in lane i shares a point with `area`.
    #[inline]
    pub(crate) fn overlaps(&self, area: &Aabb) -> u32 {
        let (low, high) = (area.min.to_array(), area.max.to_array());
        // Four lanes at a time as `Vec4`: the same loop over plain floats compiles to scalar comparisons.
        let half = |first: usize| {
            let lanes = |side: &[f32; WIDTH]| Vec4::from_slice(&side[first..first + 4]);
            let begins = |axis: usize| lanes(&self.min[axis]).cmple(Vec4::splat(high[axis]));
            let ends = |axis: usize| lanes(&self.max[axis]).cmpge(Vec4::splat(low[axis]));
            (begins(0) & ends(0) & begins(1) & ends(1) & begins(2) & ends(2)).bitmask()
        };
        half(0) | half(4) << 4
    }

    /// Where the beam enters each box, t ≥ 0, and bit i set where it does so no later than `max`. No hit is lost to rounding: each end errs by four roundings, that of the
    /// direction among them, and the far ones are stretched by more than both (Ize, "Robust BVH ray traversal", JCGT 2013).
    #[inline]
    pub(crate) fn enters(&self, beam: &Beam, max: f32) -> ([f32; WIDTH], u32) {
        let mut entries = [0.0; WIDTH];
        let mut hits = 0;
        for first in [0, WIDTH / 2] {
            let lanes = |side: &[f32; WIDTH]| Vec4::from_slice(&side[first..first + 4]);
            let mut entry = Vec4::ZERO;
            let mut exit = Vec4::splat(max);
            // A lane without a box holds no number, which passes no comparison.
            let mut met = lanes(&self.min[0]).cmple(lanes(&self.max[0]));
            for axis in 0..3 {
                let (low, high) = (Vec4::splat(beam.area.min[axis]), Vec4::splat(beam.area.max[axis]));
                let (min, max) = (lanes(&self.min[axis]), lanes(&self.max[axis]));
                if beam.stays[axis] {
                    met &= min.cmple(high) & max.cmpge(low);
                    continue;
                }
                let inverse = Vec4::splat(beam.inverse[axis]);
                let (near, far) = if beam.inverse[axis] > 0.0 {
                    ((min - high) * inverse, (max - low) * inverse)
                } else {
                    ((max - low) * inverse, (min - high) * inverse)
                };
                entry = near.max(entry);
                exit = (far * STRETCH).min(exit);
            }
            met &= entry.cmple(exit);
            hits |= met.bitmask() << first;
            entries[first..first + 4].copy_from_slice(&entry.to_array());
        }
        (entries, hits)
    }

    /// Squared distance of each box from `area`, and bit i set where it is at most `most`. Rounded down by more than what it errs by, so that nothing near is lost.
    #[inline]
    pub(crate) fn squared_distances(&self, area: &Aabb, most: f32) -> ([f32; WIDTH], u32) {
        let mut distances = [0.0; WIDTH];
        let mut near = 0;
        for first in [0, WIDTH / 2] {
            let lanes = |side: &[f32; WIDTH]| Vec4::from_slice(&side[first..first + 4]);
            let mut squared = Vec4::ZERO;
            for axis in 0..3 {
                let below = lanes(&self.min[axis]) - area.max[axis];
                let above = Vec4::splat(area.min[axis]) - lanes(&self.max[axis]);
                let gap = below.max(above).max(Vec4::ZERO);
                squared += gap * gap;
            }
            squared *= 1.0 - 4.0 * f32::EPSILON;
            let holds = lanes(&self.min[0]).cmple(lanes(&self.max[0]));
            near |= (holds & squared.cmple(Vec4::splat(most))).bitmask() << first;
            distances[first..first + 4].copy_from_slice(&squared.to_array());
        }
        (distances, near)
    }
}

/// By how much a far end is stretched.
pub(crate) const STRETCH: f32 = 1.0 + 5.0 * f32::EPSILON;

/// A box on its way along a straight line, or, where it is a point, a ray.
pub(crate) struct Beam {
    area: Aabb,
    inverse: Vec3,
    /// Axes that it does not move along.
    stays: [bool; 3],
}

impl Beam {
    pub(crate) fn new(area: &Aabb, direction: Vec3) -> Self {
        let inverse = direction.recip();
        Beam { area: *area, inverse, stays: inverse.to_array().map(f32::is_infinite) }
    }
}
