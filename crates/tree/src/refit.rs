//! Brings the boxes of a tree up to date without sorting.

use crate::{Block, NOWHERE, Tree, WIDTH};
use rayon::prelude::*;
use rockfall_math::Aabb;
use rockfall_math::share::{Share, ShareSort, both};

/// Blocks that one task fills.
const GRAIN: usize = 256;

/// From one moved item in so many on, all blocks are filled: there the two ways take equally long when those that moved are strewn all
/// over (measured, 100,000 items).
const FEW: usize = 32;

/// Marks looked at together.
const MARKS: usize = 64;

impl Tree {
    /// Takes over new boxes for the same items, in parallel. The order of the items stays, so the tree gets slower
    /// when they move far; then build it anew.
    pub fn refit(&mut self, area: impl Fn(usize) -> Aabb + Sync) {
        for level in 0..self.levels {
            let (order, below, here) = self.level_mut(level);
            if level == 0 {
                here.par_iter_mut().zip(order.par_chunks(WIDTH)).with_min_len(GRAIN).shared().for_each(
                    |(block, items)| {
                        for (lane, &item) in items.iter().enumerate() {
                            block.set(lane, &area(item as usize));
                        }
                    },
                );
            } else {
                here.par_iter_mut().zip(below.par_chunks(WIDTH)).with_min_len(GRAIN).shared().for_each(
                    |(block, children)| {
                        for (lane, child) in children.iter().enumerate() {
                            block.set(lane, &Block::bounds(child));
                        }
                    },
                );
            }
        }
    }

    /// Takes over new boxes of the items marked in `moved`, in parallel, and leaves the same tree, bit for bit, as
    /// [`Tree::refit`] with the boxes of all others unchanged. Where few have moved it touches only what lies above
    /// those few, and its cost, but for one look at each mark, grows with their number alone.
    ///
    /// Items beyond the end of `moved` have not moved; marks of what is not an item are passed over.
    pub fn refit_moved(&mut self, moved: &[bool], area: impl Fn(usize) -> Aabb + Sync) {
        let moved = &moved[..moved.len().min(self.places.len())];
        let count = moved.par_iter().with_min_len(1 << 16).shared().filter(|&&moved| moved).count();
        if count > self.len() / FEW {
            return self.refit(area);
        }
        // Where the boxes are that change on a level, ascending. Rows of bodies lie along nearly the same curve, so this
        // sort has little to do.
        let mut stale = Vec::with_capacity(count);
        for (chunk, marks) in moved.chunks(MARKS).enumerate() {
            // A fixed length, so that the marks are compared many at a time.
            if <&[bool; MARKS]>::try_from(marks).is_ok_and(|marks| *marks == [false; MARKS]) {
                continue;
            }
            let items = marks.iter().zip(chunk * MARKS..).filter(|(moved, _)| **moved);
            stale.extend(items.map(|(_, item)| self.places[item]).filter(|&place| place != NOWHERE));
        }
        stale.sort_shared();
        for level in 0..self.levels {
            let (order, below, here) = self.level_mut(level);
            if level == 0 {
                set_some(here, 0, &stale, &|place| area(order[place] as usize));
            } else {
                set_some(here, 0, &stale, &|place| below[place].bounds());
            }
            stale.iter_mut().for_each(|place| *place /= WIDTH as u32);
            stale.dedup();
        }
    }

    /// The items, the blocks of the level below (none below level 0), and those of this level.
    fn level_mut(&mut self, level: usize) -> (&[u32], &[Block], &mut [Block]) {
        let (below, here) = self.blocks.split_at_mut(self.starts[level]);
        let end = if level + 1 < self.levels { self.starts[level + 1] - self.starts[level] } else { 1 };
        let below = if level > 0 { &below[self.starts[level - 1]..] } else { &[] };
        (&self.order, below, &mut here[..end])
    }
}

/// Puts the boxes of the places `stale`, ascending, into their lanes; `first` is the index of `blocks[0]`.
fn set_some(blocks: &mut [Block], first: usize, stale: &[u32], area: &(impl Fn(usize) -> Aabb + Sync)) {
    let block_of = |place: u32| place as usize / WIDTH;
    // Cut where a block begins, near the middle.
    let middle = stale.get(stale.len() / 2).map_or(0, |&place| block_of(place));
    let cut = stale.partition_point(|&place| block_of(place) < middle);
    if stale.len() <= GRAIN || cut == 0 {
        for &place in stale {
            blocks[block_of(place) - first].set(place as usize % WIDTH, &area(place as usize));
        }
        return;
    }
    let (left, right) = stale.split_at(cut);
    let (low, high) = blocks.split_at_mut(middle - first);
    both(|| set_some(low, first, left, area), || set_some(high, middle, right, area));
}
