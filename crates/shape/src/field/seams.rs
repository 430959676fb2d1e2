//! Closes the seams between cells of different sizes.
//!
//! A corner of a small cell that lies on the face or edge of a larger one takes the value that the larger one has there; otherwise the distance would jump at the
//! face between the two, and contacts with it. Large cells first: then what they have on their faces is final, and a small
//! cell's face, bilinear between four points of a bilinear function, is that function.

use super::build::{Place, corner};
use super::octree::{LEAF, MOST_CUTS, Octree, interpolate};
use rayon::prelude::*;
use rockfall_math::Vec3;

/// Makes the function continuous, to rounding. `places` are those of the leaves.
pub(super) fn close(octree: &mut Octree, places: &[Place]) {
    for cuts in 1..=MOST_CUTS {
        let cells: Vec<usize> = (0..places.len()).filter(|&leaf| places[leaf].cuts == cuts).collect();
        let closed: Vec<[f32; 8]> = cells.par_iter().map(|&leaf| closed(octree, places, leaf)).collect();
        for (leaf, corners) in cells.into_iter().zip(closed) {
            octree.leaves[leaf] = corners;
        }
    }
}

/// The corners of a leaf, after all larger leaves are done.
fn closed(octree: &Octree, places: &[Place], leaf: usize) -> [f32; 8] {
    let place = &places[leaf];
    let step = 1 << (MOST_CUTS - place.cuts);
    std::array::from_fn(|k| {
        let bits = corner(k);
        let at: [u32; 3] = std::array::from_fn(|i| place.low[i] + bits[i] * step);
        let around = (0..8).filter_map(|side| holder(octree, at, corner(side)));
        let largest = around.min_by_key(|&other| (places[other].cuts, other));
        match largest.filter(|&other| places[other].cuts < place.cuts) {
            Some(other) => {
                let (low, edge) = (places[other].low, 1 << (MOST_CUTS - places[other].cuts));
                let within = [0, 1, 2].map(|i| (at[i] - low[i]) as f32 / edge as f32);
                interpolate(&octree.leaves[other], Vec3::from(within))
            }
            None => octree.leaves[leaf][k],
        }
    })
}

/// The leaf that has one of the eight smallest cells around a point, `below` it in x, y, z where that is 1; none outside.
fn holder(octree: &Octree, at: [u32; 3], below: [u32; 3]) -> Option<usize> {
    let mut cell = [0; 3];
    for i in 0..3 {
        cell[i] = at[i].checked_sub(below[i]).filter(|c| c >> MOST_CUTS < octree.size[i])?;
    }
    let [x, y, z] = cell.map(|c| c >> MOST_CUTS);
    let mut link = octree.roots[(x + octree.size[0] * (y + octree.size[1] * z)) as usize];
    let mut bit = MOST_CUTS;
    while link & LEAF == 0 {
        bit -= 1;
        let child = (0..3).fold(0, |k, i| k | (cell[i] >> bit & 1) << i);
        link = octree.nodes[link as usize][child as usize];
    }
    Some((link & !LEAF) as usize)
}
