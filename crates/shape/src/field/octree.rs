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
    fn extent(&self) -> Vec3 {
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
        // None is negative; to cut the fraction off is faster than `floor`, which is a call where a processor may lack it.
        let whole = scaled.map(|x| x as u32 as f32).min(size - 1.0);
        let mut at = scaled - whole;
        let [x, y, z] = [whole.x as usize, whole.y as usize, whole.z as usize];
        let [nx, ny] = [self.size[0] as usize, self.size[1] as usize];
        let mut link = self.roots[x + nx * (y + ny * z)];
        let mut edge = self.cell;
        while link & LEAF == 0 {
            let high = at.cmpge(Vec3::splat(0.5));
            link = self.nodes[link as usize][high.bitmask() as usize];
            at = 2.0 * at - Vec3::select(high, Vec3::ONE, Vec3::ZERO);
            edge *= 0.5;
        }
        Spot { leaf: (link & !LEAF) as usize, at, edge }
    }

    #[inline]
    pub(super) fn value_at(&self, spot: &Spot) -> f32 {
        interpolate(&self.leaves[spot.leaf], spot.at)
    }

    #[inline]
    pub(super) fn value(&self, p: Vec3) -> f32 {
        self.value_at(&self.spot(p))
    }
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
}
