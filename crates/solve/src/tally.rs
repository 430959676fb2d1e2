//! What can be said of all contacts together. Nothing here depends on the order of the blocks.

use crate::block::{Block, LANES};
use crate::contacts::Contacts;
use crate::manifold::FIXED;
use crate::shelf::{Names, Shelf};
use rayon::prelude::*;
use rockfall_math::share::Share;

/// Blocks whose counts and depths are added up in one go.
const RUN: usize = 64;

/// Overlaps are counted in classes, eight to each power of two, from a little below a micrometre on; what is beyond is counted in the outermost.
const CLASSES: usize = 256;

/// Mantissa bits that a class leaves out, and the number of the first class among all that there could be: that of 2⁻²¹ m.
const LEFT_OUT: u32 = 20;
const FIRST: u32 = (127 - 21) << (23 - LEFT_OUT);

/// Overlaps by depth.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Depths([u32; CLASSES]);

impl Depths {
    fn add(&mut self, overlap: f32) {
        let class = (overlap.to_bits() >> LEFT_OUT).saturating_sub(FIRST) as usize;
        self.0[class.min(CLASSES - 1)] += 1;
    }

    /// The least depth of a class, metres.
    fn least(class: usize) -> f32 {
        f32::from_bits((FIRST + class as u32) << LEFT_OUT)
    }
}

/// Counts and depths of all contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    /// Manifolds.
    pub manifolds: usize,
    /// Manifolds with a point that touches (signed distance ≤ 0).
    pub touching: usize,
    /// Contact points.
    pub contacts: usize,
    /// Contact points that overlap.
    pub overlapping: usize,
    /// Sum of their overlaps in whole nanometres, which does not know in which order they are added.
    pub overlap: u64,
    /// The largest of them, metres.
    pub deepest: f32,
    depths: Depths,
}

impl Default for Tally {
    fn default() -> Self {
        let depths = Depths([0; CLASSES]);
        Tally { manifolds: 0, touching: 0, contacts: 0, overlapping: 0, overlap: 0, deepest: 0.0, depths }
    }
}

impl Tally {
    /// The depth, metres, that 99 of 100 overlaps do not exceed; to an eighth of it, the width of the classes that they are counted in.
    pub fn percentile_99(&self) -> f32 {
        let wanted = (99 * self.overlapping as u64).div_ceil(100);
        let mut before = 0;
        for (class, &count) in self.depths.0.iter().enumerate() {
            let count = u64::from(count);
            if count > 0 && before + count >= wanted {
                let [low, high] = [class, class + 1].map(Depths::least);
                let share = (wanted - before) as f32 / count as f32;
                return (low + share * (high - low)).min(self.deepest);
            }
            before += count;
        }
        0.0
    }

    fn and(self, other: Tally) -> Tally {
        Tally {
            manifolds: self.manifolds + other.manifolds,
            touching: self.touching + other.touching,
            contacts: self.contacts + other.contacts,
            overlapping: self.overlapping + other.overlapping,
            overlap: self.overlap.saturating_add(other.overlap),
            deepest: self.deepest.max(other.deepest),
            depths: Depths(core::array::from_fn(|class| self.depths.0[class] + other.depths.0[class])),
        }
    }
}

impl Contacts {
    /// Counts everything.
    pub fn tally(&self) -> Tally {
        let mut all = Tally::default();
        tally(&mut all, &self.ball);
        tally(&mut all, &self.one);
        tally(&mut all, &self.two);
        tally(&mut all, &self.four);
        all
    }

    /// What `keep` makes of the two rows of every contact, the second marked where contacts can't move it; in any order. Shelf after shelf: a chain of parallel
    /// iterators would ask a pool even where the caller is alone.
    pub fn filter_rows<R: Send>(&self, keep: impl Fn(u32, u32) -> Option<R> + Sync) -> Vec<R> {
        let body = |row: u32| self.copies.body(row & !FIXED) | row & FIXED;
        let keep = &|(a, b): (u32, u32)| keep(body(a), body(b));
        let mut kept = Vec::new();
        kept.par_extend(rows(&self.ball).filter_map(keep));
        kept.par_extend(rows(&self.one).filter_map(keep));
        kept.par_extend(rows(&self.two).filter_map(keep));
        kept.par_extend(rows(&self.four).filter_map(keep));
        kept
    }
}

/// Adds the blocks of a shelf: one after the other where they are few, since a tally is a kilobyte to be made and added.
fn tally<const P: usize, const T: usize>(all: &mut Tally, shelf: &Shelf<P, T>) {
    let add = |tally: &mut Tally, blocks: &[Block<P, T>], names: &[Names<P>]| {
        blocks.iter().zip(names).for_each(|(block, names)| count(tally, block, names));
    };
    if shelf.blocks.len() <= RUN {
        return add(all, &shelf.blocks, &shelf.names);
    }
    let runs = shelf.blocks.par_chunks(RUN).zip(shelf.names.par_chunks(RUN)).shared();
    let tally = |(blocks, names): (&[Block<P, T>], &[Names<P>])| {
        let mut tally = Tally::default();
        add(&mut tally, blocks, names);
        tally
    };
    *all = all.and(runs.map(tally).reduce(Tally::default, Tally::and));
}

/// 2⁵². Added to a number and taken off again, it leaves a whole number.
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// Adds a block. Lane by lane up to the end, so that a compiler can do many lanes at once; the sums of whole numbers are exact.
fn count<const P: usize, const T: usize>(tally: &mut Tally, block: &Block<P, T>, names: &Names<P>) {
    let mut least = [f32::INFINITY; LANES];
    let mut overlaps = [0.0_f64; LANES];
    let mut overlapping = [0_u32; LANES];
    for (distances, point) in block.distances.iter().zip(0..) {
        let used = |lane: usize| if names.counts[lane] > point { distances[lane] } else { f32::INFINITY };
        let here: [f32; LANES] = core::array::from_fn(used);
        least = core::array::from_fn(|lane| least[lane].min(here[lane]));
        overlapping = core::array::from_fn(|lane| overlapping[lane] + u32::from(here[lane] < 0.0));
        let whole = |overlap: f32| 1e9 * f64::from(overlap) + WHOLE - WHOLE;
        overlaps = core::array::from_fn(|lane| overlaps[lane] + whole((-here[lane]).max(0.0)));
        here.iter().filter(|distance| **distance < 0.0).for_each(|distance| tally.depths.add(-distance));
    }
    let sum = |counts: &[u32; LANES]| counts.iter().sum::<u32>() as usize;
    tally.overlapping += sum(&overlapping);
    tally.overlap = tally.overlap.saturating_add(overlaps.iter().sum::<f64>() as u64);
    tally.contacts += sum(&names.counts);
    tally.manifolds += sum(&names.counts.map(|count| u32::from(count > 0)));
    tally.touching += sum(&least.map(|least| u32::from(least <= 0.0)));
    let deepest = least.iter().fold(f32::INFINITY, |a, &b| if b < a { b } else { a });
    tally.deepest = tally.deepest.max(-deepest);
}

fn rows<const P: usize, const T: usize>(
    shelf: &Shelf<P, T>,
) -> impl ParallelIterator<Item = (u32, u32)> + '_ {
    shelf.blocks.par_iter().zip(&shelf.keys).shared().flat_map_iter(|(block, key)| {
        let mark = if key.is_one_sided() { FIXED } else { 0 };
        let lanes = block.a.iter().zip(&block.b).filter(|(a, _)| **a != 0);
        lanes.map(move |(&a, &b)| (a, b | mark))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    /// Promise: the depth that 99 of 100 do not exceed is that of the sorted list, to a twelfth, from micrometres to metres.
    #[test]
    fn ninety_nine_of_a_hundred_are_less_deep() {
        for scale in [3e-6_f32, 1e-3, 0.4] {
            for number in [1_u64, 50, 1000, 30_000] {
                let mut depths: Vec<f32> = (0..number)
                    .map(|i| scale * (1 + mix(i) % 1000) as f32 * 1e-3)
                    .map(|x| x * x / scale)
                    .collect();
                let mut tally = Tally { overlapping: number as usize, ..Tally::default() };
                for &depth in &depths {
                    tally.depths.add(depth);
                    tally.deepest = tally.deepest.max(depth);
                }
                depths.sort_by(f32::total_cmp);
                let exact = depths[(99 * depths.len()).div_ceil(100) - 1];
                let found = tally.percentile_99();
                assert!(
                    (found / exact - 1.0).abs() < 1.0 / 12.0 || exact < 1e-6,
                    "{found} for {exact} of {number}"
                );
            }
        }
        assert_eq!(Tally::default().percentile_99(), 0.0);
    }
}
