//! Broad phase: which boxes overlap which.
//!
//! A [`Tree`] sorts the boxes along the Hilbert curve and groups eight neighbours on that curve into a block, eight
//! blocks into a block of the next level, and so on up to one root. Nothing in it is a pointer: the children of
//! lane `i` of block `b` are block `8 b + i` of the level below. That makes the build one sort and one linear pass,
//! a refit the linear pass alone, or the ways up from the few boxes that have moved, and a query eight box tests at a time on
//! plain arrays.
//!
//! A binary tree split where the bits of the codes change (LBVH) fits space a little better, but takes a random access
//! per level instead of one per three levels, and twice the memory.
//!
//! A grid of several levels, its cells sorted by their codes, was measured against the tree (`examples/broad_phase`). It is built in
//! two thirds of the time and finds the pairs of equal boxes in 0.85 of it, but has to be sorted anew where a refit will do, so
//! that a step of equal boxes comes out even at best; with sizes of 1 to 100 its queries take 1.4 times as long, over
//! levels that are nearly empty. So there is no grid.

#![forbid(unsafe_code)]

mod block;
mod build;
mod cast;
mod fold;
pub mod hilbert;
pub mod morton;
mod order;
mod query;
mod radix;
mod refit;

pub use fold::Fold;
pub use hilbert::hilbert;
pub use morton::morton;

use block::{Block, WIDTH};
use rockfall_math::Aabb;

/// The place of what is not an item.
const NOWHERE: u32 = u32::MAX;

/// Levels that a tree over `u32` items can have: 8¹¹ > 2³².
const MAX_LEVELS: usize = 11;

/// A bounding-volume hierarchy over boxes. Items are the indices of the boxes that it was built from, or of some of them.
///
/// A box that contains nothing (`min > max` on some axis, as [`Aabb::EMPTY`], or a coordinate that is not a number)
/// holds its place but is never reported. Infinite sides are allowed: such a box is reported wherever it reaches.
///
/// The tree depends on the boxes alone, not on the number of threads.
///
/// ```
/// use rockfall_math::{Aabb, Vec3};
/// use rockfall_tree::Tree;
///
/// let unit = |x: f32| Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 1.0, 1.0));
/// let tree = Tree::build(&[unit(0.0), unit(5.0), unit(0.5)]);
/// let mut found = Vec::new();
/// tree.query(&unit(0.75), |item| found.push(item));
/// found.sort();
/// assert_eq!(found, [0, 2]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Items along the curve.
    order: Vec<u32>,
    /// Where each item lies in `order`, or [`NOWHERE`], up to the last one.
    places: Vec<u32>,
    /// All levels, the items' own boxes first, the root last.
    blocks: Vec<Block>,
    /// Where each level starts in `blocks`; level 0 holds the items' own boxes.
    starts: [usize; MAX_LEVELS],
    /// Levels in use; 0 without items.
    levels: usize,
}

impl Tree {
    /// Number of items, those with an empty box included.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are no items at all.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The smallest box around all items; [`Aabb::EMPTY`] without any.
    pub fn bounds(&self) -> Aabb {
        self.blocks.last().map_or(Aabb::EMPTY, Block::bounds)
    }

    /// Heap memory, bytes.
    pub fn memory(&self) -> usize {
        (self.order.capacity() + self.places.capacity()) * size_of::<u32>()
            + self.blocks.capacity() * size_of::<Block>()
    }

    /// Items along the curve: neighbours in this order are neighbours in space.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    fn block(&self, level: usize, index: usize) -> &Block {
        &self.blocks[self.starts[level] + index]
    }
}
