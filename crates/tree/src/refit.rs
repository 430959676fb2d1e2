//! Brings the boxes of a tree up to date without sorting.

use crate::{Block, Tree, WIDTH};
use rayon::prelude::*;
use rockfall_math::Aabb;

/// Blocks that one task fills.
const GRAIN: usize = 256;

impl Tree {
    /// Takes over new boxes for the same items, in parallel. The order of the items stays, so the tree gets slower
    /// when they move far; then build it anew.
    pub fn refit(&mut self, area: impl Fn(usize) -> Aabb + Sync) {
        for level in 0..self.levels {
            let (below, here) = self.blocks.split_at_mut(self.starts[level]);
            let end = if level + 1 < self.levels { self.starts[level + 1] - self.starts[level] } else { 1 };
            let here = &mut here[..end];
            if level == 0 {
                here.par_iter_mut().zip(self.order.par_chunks(WIDTH)).with_min_len(GRAIN).for_each(
                    |(block, items)| {
                        for (lane, &item) in items.iter().enumerate() {
                            block.set(lane, &area(item as usize));
                        }
                    },
                );
            } else {
                let below = &below[self.starts[level - 1]..];
                here.par_iter_mut().zip(below.par_chunks(WIDTH)).with_min_len(GRAIN).for_each(
                    |(block, children)| {
                        for (lane, child) in children.iter().enumerate() {
                            block.set(lane, &Block::bounds(child));
                        }
                    },
                );
            }
        }
    }
}
