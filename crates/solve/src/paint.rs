//! Stage 6, **paint**: colours for contacts, so that within a colour no body that moves stands twice.
//!
//! Reads the contacts that are new; writes their colours. A contact keeps its colour for as long as its pair touches, and each body
//! knows which colours are taken at it: one set for contacts with bodies that move, one for those with others, which are swept
//! separately. New ones are painted in rounds: a contact whose hash is the largest at both of
//! its bodies takes the lowest colour that is free at both (Jones and Plassmann, "A Parallel Graph Coloring Heuristic",
//! SIAM J. Sci. Comput. 14(3), 1993). Which colours come out depends on the keys of the pairs alone.
//!
//! A body with more neighbours than colours leaves some of its contacts in the colour [`OVERFLOW`]. That is the sign for splitting it
//! (`copies.rs`), after which they find colours. What is left even then is solved one after the other, in the order of the
//! rows. None is dropped.

use crate::manifold::{FIXED, NO_COLOR};
use rayon::prelude::*;
use rockfall_math::hash::{combine, mix};
use rockfall_math::share::Share;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// Colours of manifolds that are solved in parallel.
pub const COLORS: u32 = 64;

/// The colour of the manifolds that found no other.
pub const OVERFLOW: u32 = COLORS;

/// A body with more blank manifolds than this is crowded: it can't give all of them a colour anyway, and looking at each in
/// every round would take longer than solving them one by one.
const CROWD: u32 = 4 * COLORS;

/// Whether a manifold of that hash stands back at a body with `degree` blanks. About twice as many as there are colours don't.
fn stands_back(priority: u64, degree: u32) -> bool {
    degree > CROWD && priority < u64::MAX - u64::MAX / u64::from(degree) * u64::from(2 * COLORS)
}

/// A contact that has no colour yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blank {
    a: u32,
    /// Where contacts move it.
    b: Option<u32>,
    /// Distinct for distinct contacts.
    priority: u64,
}

impl Blank {
    /// Of two rows, the second marked where contacts can't move it; `ordinal` is distinct for contacts of the same rows.
    pub(crate) fn new(a: u32, b: u32, ordinal: u32) -> Self {
        let key = u64::from(a) << 32 | u64::from(b);
        let priority = if ordinal == 0 { mix(key) } else { combine(mix(key), ordinal.into()) };
        Blank { a, b: (b & FIXED == 0).then_some(b), priority }
    }

    /// The bodies that contacts move.
    fn rows(&self) -> impl Iterator<Item = usize> {
        [Some(self.a), self.b].into_iter().flatten().map(|row| row as usize)
    }
}

/// Which colours are taken at each body, and room for [`Painter::paint`].
#[derive(Debug, Default)]
pub(crate) struct Painter {
    /// By contacts between two bodies that move.
    pairs: Vec<AtomicU64>,
    /// By contacts with bodies that contacts can't move.
    grounds: Vec<AtomicU64>,
    /// Largest hash of the blank contacts of each body.
    tops: Vec<AtomicU64>,
    /// Blank contacts of each body.
    degrees: Vec<AtomicU32>,
}

impl Painter {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        (self.pairs.capacity() + self.grounds.capacity() + self.tops.capacity()) * size_of::<AtomicU64>()
            + self.degrees.capacity() * size_of::<AtomicU32>()
    }

    /// Has place for so many bodies.
    pub(crate) fn resize(&mut self, rows: usize) {
        if self.pairs.len() == rows {
            return;
        }
        self.pairs.resize_with(rows, AtomicU64::default);
        self.grounds.resize_with(rows, AtomicU64::default);
        self.tops.resize_with(rows, AtomicU64::default);
        self.degrees.resize_with(rows, AtomicU32::default);
    }

    /// Knows of no contact, and has place for so many bodies.
    pub(crate) fn clear(&mut self, rows: usize) {
        self.resize(rows);
        let all = self.pairs.par_iter_mut().chain(&mut self.grounds);
        all.with_min_len(4096).shared().for_each(|mask| *mask = AtomicU64::new(0));
    }

    fn masks(&self, a: u32, b: Option<u32>) -> impl Iterator<Item = &AtomicU64> {
        let of_a = if b.is_some() { &self.pairs } else { &self.grounds };
        [Some(&of_a[a as usize]), b.map(|b| &self.pairs[b as usize])].into_iter().flatten()
    }

    /// A colour is taken at a contact's bodies; b where contacts move it.
    pub(crate) fn take(&self, color: u32, a: u32, b: Option<u32>) {
        if color < COLORS {
            self.masks(a, b).for_each(|mask| {
                mask.fetch_or(1 << color, Relaxed);
            });
        }
    }

    /// Takes a colour at a contact's bodies where it is free at both, and tells whether it was. Not for several threads at once.
    pub(crate) fn take_if_free(&self, color: u32, a: u32, b: Option<u32>) -> bool {
        let free = color >= COLORS || self.masks(a, b).all(|mask| mask.load(Relaxed) >> color & 1 == 0);
        self.take(color, a, b);
        free && Some(a) != b
    }

    /// A colour is free again.
    pub(crate) fn free(&self, color: u32, a: u32, b: Option<u32>) {
        if color < COLORS {
            self.masks(a, b).for_each(|mask| {
                mask.fetch_and(!(1 << color), Relaxed);
            });
        }
    }

    /// A colour below [`COLORS`], or [`OVERFLOW`], for each of some contacts that have none; it is taken at their bodies.
    pub(crate) fn paint(&self, blanks: &[Blank]) -> Vec<u32> {
        let Painter { tops, degrees, .. } = self;
        let colors: Vec<AtomicU32> = blanks.par_iter().shared().map(|_| AtomicU32::new(NO_COLOR)).collect();
        let rows = || blanks.par_iter().shared().flat_map_iter(Blank::rows);
        rows().for_each(|row| degrees[row].store(0, Relaxed));
        rows().for_each(|row| {
            degrees[row].fetch_add(1, Relaxed);
        });
        let mut left: Vec<(&Blank, &AtomicU32)> = blanks.par_iter().zip(&colors).shared().collect();
        left.par_iter().shared().for_each(|(blank, color)| {
            if blank.rows().any(|row| stands_back(blank.priority, degrees[row].load(Relaxed))) {
                color.store(OVERFLOW, Relaxed);
            }
        });
        let is_blank = |(_, color): &(&Blank, &AtomicU32)| color.load(Relaxed) == NO_COLOR;
        loop {
            left = left.into_par_iter().shared().filter(is_blank).collect();
            if left.is_empty() {
                break;
            }
            let rows = || left.par_iter().shared().flat_map_iter(|(blank, _)| blank.rows());
            rows().for_each(|row| tops[row].store(0, Relaxed));
            left.par_iter().shared().for_each(|(blank, _)| {
                blank.rows().for_each(|row| {
                    tops[row].fetch_max(blank.priority, Relaxed);
                });
            });
            let taken =
                |blank: &Blank| self.masks(blank.a, blank.b).fold(0, |all, mask| all | mask.load(Relaxed));
            left.par_iter().shared().for_each(|(blank, color)| {
                if blank.rows().all(|row| tops[row].load(Relaxed) == blank.priority) {
                    // The only winner at its bodies: nobody else touches these masks in this round.
                    let found = taken(blank).trailing_ones().min(OVERFLOW);
                    self.take(found, blank.a, blank.b);
                    color.store(found, Relaxed);
                }
            });
            // A body without a free colour can't lose its blanks one a round.
            left.par_iter().shared().filter(|blank| is_blank(blank) && taken(blank.0) == u64::MAX).for_each(
                |(_, color)| {
                    color.store(OVERFLOW, Relaxed);
                },
            );
        }
        colors.into_par_iter().shared().map(AtomicU32::into_inner).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn blanks(pairs: &[(u32, u32)]) -> Vec<Blank> {
        pairs.iter().map(|&(a, b)| Blank::new(a, b, 0)).collect()
    }

    fn painter(rows: usize) -> Painter {
        let mut painter = Painter::default();
        painter.resize(rows);
        painter
    }

    fn random_pairs(n: u32, bodies: u64) -> Vec<(u32, u32)> {
        let mut pairs: Vec<(u32, u32)> = (0..u64::from(n))
            .map(|i| ((mix(2 * i) % bodies) as u32 + 1, (mix(2 * i + 1) % bodies) as u32 + 1))
            .filter(|(a, b)| a < b)
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    #[test]
    fn no_body_stands_twice_in_a_colour() {
        let pairs = random_pairs(20_000, 2_000);
        let mut seen = HashSet::new();
        for (&(a, b), color) in pairs.iter().zip(painter(2_001).paint(&blanks(&pairs))) {
            assert!(color < COLORS);
            assert!(seen.insert((a, color)) && seen.insert((b, color)));
        }
    }

    #[test]
    fn colours_do_not_depend_on_threads() {
        let blanks = blanks(&random_pairs(20_000, 2_000));
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| painter(2_001).paint(&blanks))
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_hub_overflows_and_loses_nothing() {
        let pairs: Vec<(u32, u32)> = (2..5_002).map(|b| (1, b)).collect();
        let colors = painter(5_002).paint(&blanks(&pairs));
        assert_eq!(colors.iter().filter(|&&c| c == OVERFLOW).count(), 5_000 - COLORS as usize);
        assert_eq!(colors.iter().filter(|&&c| c < COLORS).collect::<HashSet<_>>().len(), COLORS as usize);
    }

    #[test]
    fn freed_colours_are_used_again() {
        let painter = painter(5);
        let before = painter.paint(&blanks(&[(1, 2), (1, 3), (1, 4)]));
        painter.free(before[1], 1, Some(3));
        assert_eq!(painter.paint(&blanks(&[(1, 3)])), [before[1]]);
    }

    #[test]
    fn contacts_with_immovable_bodies_have_colours_of_their_own() {
        let mut blanks = blanks(&[(1, 2), (1, 3 | FIXED), (1, 4 | FIXED), (2, 4 | FIXED)]);
        blanks.push(Blank::new(1, 4 | FIXED, 1));
        let colors = painter(5).paint(&blanks);
        let of_one = HashSet::from([colors[1], colors[2], colors[4]]);
        assert_eq!(of_one, HashSet::from([0, 1, 2]));
        assert_eq!((colors[0], colors[3]), (0, 0));
    }
}
