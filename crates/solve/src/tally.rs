//! What can be said of all contacts together. Nothing here depends on the order of the blocks.

use crate::block::{Block, LANES};
use crate::contacts::Contacts;
use crate::manifold::FIXED;
use crate::shelf::{Names, Shelf};
use rayon::prelude::*;

/// Counts and depths of all contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
}

impl Tally {
    fn and(self, other: Tally) -> Tally {
        Tally {
            manifolds: self.manifolds + other.manifolds,
            touching: self.touching + other.touching,
            contacts: self.contacts + other.contacts,
            overlapping: self.overlapping + other.overlapping,
            overlap: self.overlap.saturating_add(other.overlap),
            deepest: self.deepest.max(other.deepest),
        }
    }
}

impl Contacts {
    /// Counts everything.
    pub fn tally(&self) -> Tally {
        tally(&self.ball).and(tally(&self.one)).and(tally(&self.two)).and(tally(&self.four))
    }

    /// The two rows of every contact, the second marked where contacts can't move it; in any order.
    pub fn rows(&self) -> impl ParallelIterator<Item = (u32, u32)> + '_ {
        let all = rows(&self.ball).chain(rows(&self.one)).chain(rows(&self.two)).chain(rows(&self.four));
        let body = |row: u32| self.copies.body(row & !FIXED) | row & FIXED;
        all.map(move |(a, b)| (body(a), body(b)))
    }
}

fn tally<const P: usize, const T: usize>(shelf: &Shelf<P, T>) -> Tally {
    let blocks = shelf.blocks.par_iter().zip(&shelf.names).with_min_len(16);
    blocks.fold(Tally::default, count).reduce(Tally::default, Tally::and)
}

/// 2⁵². Added to a number and taken off again, it leaves a whole number.
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// Adds a block. Lane by lane up to the end, so that a compiler can do many lanes at once; the sums of whole numbers are exact.
fn count<const P: usize, const T: usize>(
    mut tally: Tally,
    (block, names): (&Block<P, T>, &Names<P>),
) -> Tally {
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
    }
    let sum = |counts: &[u32; LANES]| counts.iter().sum::<u32>() as usize;
    tally.overlapping += sum(&overlapping);
    tally.overlap = tally.overlap.saturating_add(overlaps.iter().sum::<f64>() as u64);
    tally.contacts += sum(&names.counts);
    tally.manifolds += sum(&names.counts.map(|count| u32::from(count > 0)));
    tally.touching += sum(&least.map(|least| u32::from(least <= 0.0)));
    let deepest = least.iter().fold(f32::INFINITY, |a, &b| if b < a { b } else { a });
    tally.deepest = tally.deepest.max(-deepest);
    tally
}

fn rows<const P: usize, const T: usize>(
    shelf: &Shelf<P, T>,
) -> impl ParallelIterator<Item = (u32, u32)> + '_ {
    shelf.blocks.par_iter().zip(&shelf.keys).flat_map_iter(|(block, key)| {
        let mark = if key.is_one_sided() { FIXED } else { 0 };
        let lanes = block.a.iter().zip(&block.b).filter(|(a, _)| **a != 0);
        lanes.map(move |(&a, &b)| (a, b | mark))
    })
}
