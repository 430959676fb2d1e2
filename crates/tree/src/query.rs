//! Finds the items whose boxes overlap a box.

use crate::{MAX_LEVELS, Tree, WIDTH};
use rayon::iter::plumbing::{Folder, UnindexedConsumer, UnindexedProducer, bridge_unindexed};
use rayon::prelude::*;
use rockfall_math::Aabb;

/// Level whose blocks [`Tree::is_wide`] counts: each holds 8³ items.
const WIDE_LEVEL: usize = 2;

/// Blocks of that level from which on a query is worth more than one thread.
const WIDE_BLOCKS: usize = 64;

impl Tree {
    /// Calls `f` with every item whose box shares a point with `area`, touching included, along the curve.
    /// Allocates nothing.
    #[inline]
    pub fn query(&self, area: &Aabb, f: impl FnMut(u32)) {
        if let Some(root) = self.levels.checked_sub(1) {
            self.query_below(root, 0, area, all, f);
        }
    }

    /// [`Tree::query`] by several threads, for a box that meets tens of thousands of items; collected, they come in the same
    /// order. A query that finds fewer is faster without; see [`Tree::is_wide`].
    pub fn par_query(&self, area: &Aabb) -> impl ParallelIterator<Item = u32> + use<'_> {
        let root = self.levels.saturating_sub(1);
        Part { tree: self, area: *area, level: root, first: 0, last: usize::from(self.levels > 0) }
    }

    /// Whether `area` meets so much of the tree, blocks of some 32,000 items in all, that [`Tree::par_query`] may pay. Looks at the upper
    /// levels only and stops when it has seen enough: a tenth of what a query costs that finds a handful. Ask for boxes
    /// alone that are much larger than usual.
    pub fn is_wide(&self, area: &Aabb) -> bool {
        if self.levels <= WIDE_LEVEL + 1 {
            return false;
        }
        self.met(self.levels - 1, 0, area, 0) >= WIDE_BLOCKS
    }

    /// `so_far` and the number of blocks on `WIDE_LEVEL` below this block that `area` meets; stops when there are enough.
    fn met(&self, level: usize, index: usize, area: &Aabb, so_far: usize) -> usize {
        let mut hits = self.block(level, index).overlaps(area);
        if level == WIDE_LEVEL + 1 {
            return so_far + hits.count_ones() as usize;
        }
        let mut count = so_far;
        while hits != 0 && count < WIDE_BLOCKS {
            count = self.met(level - 1, index * WIDTH + hits.trailing_zeros() as usize, area, count);
            hits &= hits - 1;
        }
        count
    }

    /// Calls `f` with the items below one block whose boxes share a point with `area`. Of the lanes of a block (its level, its index) that
    /// do, `keep` returns those to go on with.
    #[inline]
    pub(crate) fn query_below(
        &self,
        top: usize,
        index: usize,
        area: &Aabb,
        keep: impl Fn(usize, usize, u32) -> u32,
        mut f: impl FnMut(u32),
    ) {
        // Lanes still to visit in the block on each level of the path from the top; the path itself is the index.
        let mut open = [0_u32; MAX_LEVELS];
        let mut level = top;
        let mut index = index;
        open[top] = keep(top, index, self.block(top, index).overlaps(area));
        loop {
            if level == 0 {
                let mut hits = open[0];
                while hits != 0 {
                    f(self.order[index * WIDTH + hits.trailing_zeros() as usize]);
                    hits &= hits - 1;
                }
                open[0] = 0;
            }
            while open[level] == 0 {
                if level == top {
                    return;
                }
                level += 1;
                index /= WIDTH;
            }
            let lane = open[level].trailing_zeros() as usize;
            open[level] &= open[level] - 1;
            level -= 1;
            index = index * WIDTH + lane;
            open[level] = keep(level, index, self.block(level, index).overlaps(area));
        }
    }
}

/// Keeps all lanes of a block.
fn all(_level: usize, _index: usize, hits: u32) -> u32 {
    hits
}

/// What is left of a query: the blocks `first..last` of a level.
struct Part<'a> {
    tree: &'a Tree,
    area: Aabb,
    level: usize,
    first: usize,
    last: usize,
}

impl ParallelIterator for Part<'_> {
    type Item = u32;

    fn drive_unindexed<C: UnindexedConsumer<u32>>(self, consumer: C) -> C::Result {
        bridge_unindexed(self, consumer)
    }
}

impl UnindexedProducer for Part<'_> {
    type Item = u32;

    /// Halves the blocks that the query meets. Blocks of fewer than 8² items are not worth a task.
    fn split(mut self) -> (Self, Option<Self>) {
        loop {
            if self.last - self.first > 1 {
                let middle = self.first.midpoint(self.last);
                let right = Part { first: middle, ..self };
                return (Part { last: middle, ..self }, Some(right));
            }
            if self.level <= 1 || self.first == self.last {
                return (self, None);
            }
            // Down to the children that are met, from the first of them to the last.
            let hits = self.tree.block(self.level, self.first).overlaps(&self.area);
            let children = self.first * WIDTH;
            self.level -= 1;
            self.first = children + (hits.trailing_zeros() as usize).min(WIDTH);
            self.last = (children + (u32::BITS - hits.leading_zeros()) as usize).max(self.first);
        }
    }

    fn fold_with<F: Folder<u32>>(self, mut folder: F) -> F {
        let mut found = Vec::new();
        for index in self.first..self.last {
            if folder.full() {
                break;
            }
            self.tree.query_below(self.level, index, &self.area, all, |item| found.push(item));
            folder = folder.consume_iter(found.drain(..));
        }
        folder
    }
}
