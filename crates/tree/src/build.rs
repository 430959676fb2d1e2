//! Sorts the items along the curve and lays out the levels.

use crate::morton::Grid;
use crate::order::order;
use crate::{Block, MAX_LEVELS, NOWHERE, Tree, WIDTH, hilbert};
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_math::{Aabb, Vec3};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Boxes that one task keys: less than this is not worth a thread.
const GRAIN: usize = 2048;

impl Tree {
    /// Builds a tree over `boxes`, in parallel. Equal places keep the order of the indices.
    ///
    /// At most 2³² − 1 boxes have an index.
    pub fn build(boxes: &[Aabb]) -> Tree {
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        Tree::build_some(&all, |item| boxes[item])
    }

    /// Builds a tree over some items, whose boxes are `area`, in parallel. Equal places keep the order of `items`, none of which comes twice.
    pub fn build_some(items: &[u32], area: impl Fn(usize) -> Aabb + Sync) -> Tree {
        let area_of = |&item: &u32| area(item as usize);
        let grid = Grid::new(&populated(items, &area_of));
        let codes: Vec<u64> = items
            .par_iter()
            .with_min_len(GRAIN)
            .shared()
            .map(|item| {
                let area = area_of(item);
                let holds = area.min.cmple(area.max).all();
                if holds { hilbert(grid.morton(area.center())) } else { u64::MAX }
            })
            .collect();
        let mut order = order(&codes);
        drop(codes);
        order.par_iter_mut().with_min_len(GRAIN).shared().for_each(|place| *place = items[*place as usize]);
        // Atomic, so that all threads can write: each place is written once.
        let end = order.par_iter().shared().max().map_or(0, |&last| last as usize + 1);
        let places: Vec<AtomicU32> = (0..end).map(|_| AtomicU32::new(NOWHERE)).collect();
        order.par_iter().zip(0..order.len() as u32).with_min_len(GRAIN).shared().for_each(
            |(&item, place)| {
                places[item as usize].store(place, Relaxed);
            },
        );
        let places = places.into_iter().map(AtomicU32::into_inner).collect();

        let mut tree = Tree { order, places, ..Tree::default() };
        let mut below = items.len();
        let mut total = 0;
        while tree.levels < MAX_LEVELS && below > 0 {
            let count = below.div_ceil(WIDTH);
            tree.starts[tree.levels] = total;
            tree.levels += 1;
            total += count;
            below = if count > 1 { count } else { 0 };
        }
        tree.blocks = vec![Block::EMPTY; total];
        tree.refit(area);
        tree
    }
}

/// The part of space where nearly all boxes are. A few that flew off to infinity must not squeeze the rest into one
/// cell of the curve, so take the middle of a sample and widen it; what lies outside sorts to the border.
fn populated(items: &[u32], area_of: &(impl Fn(&u32) -> Aabb + Sync)) -> Aabb {
    const SAMPLE: usize = 1024;
    const WIDER: f32 = 8.0;
    let step = items.len().div_ceil(SAMPLE).max(1);
    let sample = items.iter().step_by(step).map(|item| area_of(item).center());
    let centres: Vec<Vec3> = sample.filter(|c| c.is_finite()).collect();
    if centres.is_empty() {
        return Aabb::EMPTY;
    }
    let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
    for axis in 0..3 {
        let mut sorted: Vec<f32> = centres.iter().map(|c| c[axis]).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let cut = sorted.len() / 64;
        let (low, high) = (sorted[cut], sorted[sorted.len() - 1 - cut]);
        let reach = (high - low) * WIDER;
        (min[axis], max[axis]) = (low - reach, high + reach);
    }
    let all = items
        .par_iter()
        .with_min_len(GRAIN)
        .shared()
        .map(|item| area_of(item).center())
        .filter(|centre| centre.is_finite())
        .map(|centre| Aabb::new(centre, centre))
        .reduce(|| Aabb::EMPTY, |a, b| a.union(&b));
    // Adding zero makes -0 and 0 one, so that the bits don't depend on the order of the reduction.
    Aabb { min: min.max(all.min) + Vec3::ZERO, max: max.min(all.max) + Vec3::ZERO }
}
