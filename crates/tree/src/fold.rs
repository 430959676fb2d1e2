//! What the items below each block have in common, and queries that pass over blocks by it.

use crate::{Tree, WIDTH};
use rayon::prelude::*;
use rockfall_math::Aabb;
use rockfall_math::share::Share;

/// Blocks that one task fills.
const GRAIN: usize = 256;

/// A value for every item of a tree and for everything below each of its blocks; see [`Tree::fold`].
#[derive(Clone, Debug, PartialEq)]
pub struct Fold<T> {
    /// For each lane of each block, in the order of the tree's blocks.
    lanes: Vec<T>,
    /// That of all items.
    pub all: T,
}

impl Tree {
    /// Joins the values of all items below each block, in parallel. `none` is that of no item: joined with another it changes nothing.
    pub fn fold<T: Copy + Send + Sync>(
        &self,
        none: T,
        item: impl Fn(u32) -> T + Sync,
        join: impl Fn(T, T) -> T + Sync,
    ) -> Fold<T> {
        let mut lanes = vec![none; self.blocks.len() * WIDTH];
        for level in 0..self.levels {
            let (below, here) = lanes.split_at_mut(self.starts[level] * WIDTH);
            if level == 0 {
                let here = here.par_iter_mut().zip(&self.order);
                here.with_min_len(GRAIN * WIDTH).shared().for_each(|(lane, &of)| *lane = item(of));
            } else {
                let children = below[self.starts[level - 1] * WIDTH..].par_chunks(WIDTH);
                let here = here.par_iter_mut().zip(children);
                here.with_min_len(GRAIN).shared().for_each(|(lane, children)| {
                    *lane = children.iter().fold(none, |all, &child| join(all, child));
                });
            }
        }
        let all = lanes.iter().rev().take(WIDTH).fold(none, |all, &lane| join(all, lane));
        Fold { lanes, all }
    }

    /// [`Tree::query`] that passes over what is not `wanted`: items, and blocks of whose items none can be, by the value of all of them and the
    /// box around them. `fold` is one of this tree as it is.
    #[inline]
    pub fn query_where<T>(
        &self,
        area: &Aabb,
        fold: &Fold<T>,
        wanted: impl Fn(&T, &Aabb) -> bool,
        f: impl FnMut(u32),
    ) {
        let Some(root) = self.levels.checked_sub(1) else { return };
        let keep = |level: usize, index: usize, hits: u32| {
            let lanes = &fold.lanes[(self.starts[level] + index) * WIDTH..][..WIDTH];
            let block = self.block(level, index);
            let (mut open, mut kept) = (hits, 0);
            while open != 0 {
                let lane = open.trailing_zeros() as usize;
                kept |= u32::from(wanted(&lanes[lane], &block.area(lane))) << lane;
                open &= open - 1;
            }
            kept
        };
        self.query_below(root, 0, area, keep, f);
    }
}
