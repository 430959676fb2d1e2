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

    /// Where the ray `origin + t / inverse` enters each box, t ≥ 0; infinite where it misses or enters later than
    /// `max`. `inverse` is infinite on the axes that the ray does not follow. No hit is lost to rounding: the far ends are stretched by three roundings (Ize, "Robust BVH ray
    /// traversal", JCGT 2013).
    #[inline]
    pub(crate) fn enters(&self, origin: Vec3, inverse: Vec3, max: f32) -> [f32; WIDTH] {
        const STRETCH: f32 = 1.0 + 4.0 * f32::EPSILON;
        let mut entry = [0.0_f32; WIDTH];
        let mut exit = [max; WIDTH];
        for axis in 0..3 {
            if inverse[axis].is_infinite() {
                for (lane, exit) in exit.iter_mut().enumerate() {
                    let between =
                        (self.min[axis][lane] <= origin[axis]) & (origin[axis] <= self.max[axis][lane]);
                    *exit = if between { *exit } else { -1.0 };
                }
                continue;
            }
            for lane in 0..WIDTH {
                let a = (self.min[axis][lane] - origin[axis]) * inverse[axis];
                let b = (self.max[axis][lane] - origin[axis]) * inverse[axis];
                let (near, far) = if a < b { (a, b) } else { (b, a) };
                entry[lane] = if near > entry[lane] { near } else { entry[lane] };
                exit[lane] = exit[lane].min(far * STRETCH);
            }
        }
        for lane in 0..WIDTH {
            let hit = (entry[lane] <= exit[lane]) & (self.min[0][lane] <= self.max[0][lane]);
            entry[lane] = if hit { entry[lane] } else { f32::INFINITY };
        }
        entry
    }
}
