//! Cells in which a function is interpolated between its values at the eight corners, fine where it has to be.
//!
//! A grid of large cells covers the box around the body and a rim; each is cut into eight, and these again, as often as it takes. Corner `k` of a
//! cell is the one with bit 0, 1, 2 of `k` set where x, y, z is high; children are numbered in the same way.

use rockfall_math::Vec3;

/// Marks a link to a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// How often a large cell may be cut.
pub(super) const MOST_CUTS: u32 = 12;

/// A function of the place, in single precision, in the frame of the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Octree {
    /// Lowest corner, metres.
    pub(super) origin: Vec3,
    /// Edge length of a large cell, metres.
    pub(super) cell: f32,
    /// Large cells along x, y, z.
    pub(super) size: [u32; 3],
    /// Links of the large cells, x running fastest: to a leaf (see [`LEAF`]) or to `nodes`.
    pub(super) roots: Vec<u32>,
    /// Links of each cell that is cut, by number of the child.
    pub(super) nodes: Vec<[u32; 8]>,
    /// Values at the corners, metres.
    pub(super) leaves: Vec<[f32; 8]>,
}

/// A place within a leaf.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub(super) leaf: usize,
    /// From 0 to 1 along each edge.
    pub(super) at: Vec3,
    /// Edge length of the leaf, metres.
    pub(super) edge: f32,
}

impl Octree {
    /// Highest corner, metres.
    pub(super) fn end(&self) -> Vec3 {
        self.origin + self.cell * self.extent()
    }

    /// Large cells along x, y, z.
    #[inline]
    pub(super) fn extent(&self) -> Vec3 {
        // Not by a loop over the three, which is a call for each place that is looked up.
        Vec3::new(self.size[0] as f32, self.size[1] as f32, self.size[2] as f32)
    }

    pub(super) fn scaled(&self, by: f32) -> Self {
        let mut scaled = self.clone();
        scaled.origin *= by;
        scaled.cell *= by;
        scaled.leaves.as_flattened_mut().iter_mut().for_each(|distance| *distance *= by);
        scaled
    }

    /// Bytes.
    pub(super) fn memory(&self) -> usize {
        4 * self.roots.capacity() + 32 * self.nodes.capacity() + 32 * self.leaves.capacity()
    }

    /// The leaf that holds a point of the covered box; one outside is taken to its nearest.
    #[inline]
    pub(super) fn spot(&self, p: Vec3) -> Spot {
        let size = self.extent();
        let scaled = ((p - self.origin) / self.cell).clamp(Vec3::ZERO, size);
        let finest = (1 << MOST_CUTS) as f32;
        let fine = (finest * scaled).min(finest * size - 1.0);
        // To cut the fractions off exactly: behind 2²³ there is no room for one. A cast would have to look for what is out of its range.
        let near = fine + WHOLE;
        let cell = Vec3::select((near - WHOLE).cmpgt(fine), near - 1.0, near).to_array().map(whole_bits);
        let (leaf, below) = self.leaf(cell);
        let cells = (1_u32 << (MOST_CUTS - below)) as f32;
        let low = Vec3::from(cell.map(|n| (n >> below) as f32));
        Spot { leaf, at: cells * scaled - low, edge: self.cell / cells }
    }

    /// The leaf that holds one of the smallest cells that there may be, and how often it could be cut more: the bits of that cell tell the way down.
    #[inline(always)]
    pub(super) fn leaf(&self, [x, y, z]: [u32; 3]) -> (usize, u32) {
        let large = |n: u32| (n >> MOST_CUTS) as usize;
        let [nx, ny] = [self.size[0] as usize, self.size[1] as usize];
        let mut link = self.roots[large(x) + nx * (large(y) + ny * large(z))];
        let mut below = MOST_CUTS;
        while link & LEAF == 0 {
            below -= 1;
            let high = (x >> below & 1) | (y >> below & 1) << 1 | (z >> below & 1) << 2;
            link = self.nodes[link as usize][high as usize];
        }
        ((link & !LEAF) as usize, below)
    }

    #[inline]
    pub(super) fn value_at(&self, spot: &Spot) -> f32 {
        interpolate(&self.leaves[spot.leaf], spot.at)
    }

    /// The value, and how it changes along x, y and z.
    #[inline]
    pub(super) fn slope_at(&self, spot: &Spot) -> (f32, Vec3) {
        let (c, at) = (&self.leaves[spot.leaf], spot.at);
        let between = |a: f32, b: f32, t: f32| a + t * (b - a);
        // Along x at the four edges, then of the two faces, and so on.
        let along_x = [0, 2, 4, 6].map(|k| c[k + 1] - c[k]);
        let x = [0, 1, 2, 3].map(|k| c[2 * k] + at.x * along_x[k]);
        let along_y = [x[1] - x[0], x[3] - x[2]];
        let y = [x[0] + at.y * along_y[0], x[2] + at.y * along_y[1]];
        let along_z = y[1] - y[0];
        let along_x =
            between(between(along_x[0], along_x[1], at.y), between(along_x[2], along_x[3], at.y), at.z);
        let slope = Vec3::new(along_x, between(along_y[0], along_y[1], at.z), along_z);
        (y[0] + at.z * along_z, slope / spot.edge)
    }

    #[inline]
    pub(super) fn value(&self, p: Vec3) -> f32 {
        self.value_at(&self.spot(p))
    }
}

/// 2²³: from there on single precision has no fractions.
pub(super) const WHOLE: f32 = (1 << 23) as f32;

/// How much a number from 2²³ to 2²⁴ is above 2²³.
#[inline(always)]
pub(super) fn whole_bits(x: f32) -> u32 {
    x.to_bits() & ((1 << 23) - 1)
}

/// Trilinear interpolation.
#[inline]
pub(super) fn interpolate(corners: &[f32; 8], at: Vec3) -> f32 {
    let c = corners;
    let between = |a: f32, b: f32, t: f32| a + t * (b - a);
    let x = [0, 2, 4, 6].map(|k| between(c[k], c[k + 1], at.x));
    between(between(x[0], x[1], at.y), between(x[2], x[3], at.y), at.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_interpolated_exactly_at_every_depth() {
        let f = |p: Vec3| p.x + 2.0 * p.y - 4.0 * p.z;
        let corner = |low: Vec3, edge: f32| {
            std::array::from_fn(|k| f(low + edge * Vec3::from([k & 1, k >> 1 & 1, k >> 2].map(|b| b as f32))))
        };
        let mut octree = Octree {
            origin: Vec3::splat(-1.0),
            cell: 2.0,
            size: [1, 2, 1],
            roots: vec![LEAF, 0],
            nodes: vec![std::array::from_fn(|k| LEAF | (k + 1) as u32)],
            leaves: vec![corner(Vec3::splat(-1.0), 2.0)],
        };
        for k in 0..8 {
            let low = Vec3::from([k & 1, k >> 1 & 1, k >> 2].map(|b| b as f32)) + Vec3::new(-1.0, 1.0, -1.0);
            octree.leaves.push(corner(low, 1.0));
        }
        for i in 0..1000_u32 {
            let p = Vec3::new(
                (i % 10) as f32 / 5.0 - 1.0,
                (i / 10 % 10) as f32 / 2.5 - 1.0,
                (i / 100) as f32 / 5.0 - 1.0,
            );
            assert!((octree.value(p) - f(p)).abs() < 1e-5, "{p}");
        }
        assert_eq!(octree.end(), Vec3::new(1.0, 3.0, 1.0));
    }

    #[test]
    fn the_slope_is_that_of_differences() {
        let wave = |k: usize| (rockfall_math::hash::mix(k as u64) >> 40) as f32 / (1 << 24) as f32;
        let leaves = vec![std::array::from_fn(wave)];
        let octree = Octree { cell: 0.5, size: [1; 3], roots: vec![LEAF], leaves, ..Octree::default() };
        for i in 0..100 {
            let p = 0.5 * Vec3::new(wave(3 * i + 8), wave(3 * i + 9), wave(3 * i + 10));
            let (value, slope) = octree.slope_at(&octree.spot(p));
            assert_eq!(value, octree.value(p));
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                // Along one axis the function is linear.
                let (low, high) = (p - axis * p.dot(axis), p + axis * (0.5 - p.dot(axis)));
                let difference = (octree.value(high) - octree.value(low)) / 0.5;
                assert!((slope.dot(axis) - difference).abs() < 1e-5, "{p} {slope} {difference}");
            }
        }
    }
}
