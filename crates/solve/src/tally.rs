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

fn count<const P: usize, const T: usize>(
    mut tally: Tally,
    (block, names): (&Block<P, T>, &Names<P>),
) -> Tally {
    let mut least = [f32::INFINITY; LANES];
    for (p, distances) in block.distances.iter().enumerate() {
        let used = names.counts.map(|count| count as usize > p);
        for ((least, &distance), used) in least.iter_mut().zip(distances).zip(used) {
            *least = if used && distance < *least { distance } else { *least };
            let overlap = if used && distance < 0.0 { -distance } else { 0.0 };
            tally.overlapping += usize::from(overlap > 0.0);
            tally.overlap = tally.overlap.saturating_add((1e9 * f64::from(overlap)) as u64);
        }
    }
    for (&least, &count) in least.iter().zip(&names.counts) {
        tally.contacts += count as usize;
        tally.manifolds += usize::from(count > 0);
        tally.touching += usize::from(least <= 0.0);
        tally.deepest = if -least > tally.deepest { -least } else { tally.deepest };
    }
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
