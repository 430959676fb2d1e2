//! Stage 6, **paint**: colours for contacts, so that within a colour no body that moves stands twice.
//!
//! Reads the contacts that are new; writes their colours. A contact keeps its colour for as long as its pair touches, and each body
//! knows which colours are taken at it: one set for contacts with bodies that move, one for those with others, which are swept
//! separately. New ones are painted in rounds: a contact whose hash is the largest at both of
//! its bodies takes the lowest colour that is free at both (Jones and Plassmann, "A Parallel Graph Coloring Heuristic",
//! SIAM J. Sci. Comput. 14(3), 1993). Which colours come out depends on the keys of the pairs alone.
//!
//! A body with more neighbours than colours leaves some of its contacts in the colour [`OVERFLOW`], which are
//! solved one after the other, in the order of their rows. None is dropped.

use crate::desk::Found;
use crate::manifold::NO_COLOR;
use rayon::prelude::*;
use rockfall_math::hash::{combine, mix};
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
struct Blank {
    a: u32,
    /// Where contacts move it.
    b: Option<u32>,
    /// Distinct for distinct contacts.
    priority: u64,
    group: u32,
    index: u32,
}

impl Blank {
    fn new(arrival: &Found, group: usize, index: usize) -> Self {
        let m = &arrival.manifold;
        let key = u64::from(m.a) << 32 | u64::from(m.b);
        let priority =
            if arrival.ordinal == 0 { mix(key) } else { combine(mix(key), arrival.ordinal.into()) };
        let b = (!m.is_one_sided()).then_some(m.b);
        Blank { a: m.a, b, priority, group: group as u32, index: index as u32 }
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
        all.with_min_len(4096).for_each(|mask| *mask = AtomicU64::new(0));
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

    /// A colour is free again.
    pub(crate) fn free(&self, color: u32, a: u32, b: Option<u32>) {
        if color < COLORS {
            self.masks(a, b).for_each(|mask| {
                mask.fetch_and(!(1 << color), Relaxed);
            });
        }
    }

    /// Gives a colour below [`COLORS`], or [`OVERFLOW`], to every contact that has none.
    pub(crate) fn paint(&self, arrivals: &mut [Vec<Found>]) {
        let blanks: Vec<Blank> = arrivals
            .par_iter()
            .enumerate()
            .flat_map_iter(|(group, arrivals)| {
                let blank = |arrival: &Found| arrival.memory.color == NO_COLOR;
                let numbered = (0..).zip(arrivals).filter(move |(_, arrival)| blank(arrival));
                numbered.map(move |(index, arrival)| Blank::new(arrival, group, index))
            })
            .collect();
        let Painter { tops, degrees, .. } = self;
        blanks.par_iter().flat_map_iter(Blank::rows).for_each(|row| degrees[row].store(0, Relaxed));
        blanks.par_iter().flat_map_iter(Blank::rows).for_each(|row| {
            degrees[row].fetch_add(1, Relaxed);
        });
        let (crowded, mut blanks): (Vec<Blank>, Vec<Blank>) = blanks.into_par_iter().partition(|blank| {
            blank.rows().any(|row| stands_back(blank.priority, degrees[row].load(Relaxed)))
        });
        let mut color = |blank: &Blank, color: u32| {
            arrivals[blank.group as usize][blank.index as usize].memory.color = color;
        };
        crowded.iter().for_each(|blank| color(blank, OVERFLOW));

        while !blanks.is_empty() {
            blanks.par_iter().flat_map_iter(Blank::rows).for_each(|row| tops[row].store(0, Relaxed));
            blanks.par_iter().for_each(|blank| {
                blank.rows().for_each(|row| {
                    tops[row].fetch_max(blank.priority, Relaxed);
                });
            });
            let winners: Vec<Option<u32>> = blanks
                .par_iter()
                .map(|blank| {
                    if blank.rows().any(|row| tops[row].load(Relaxed) != blank.priority) {
                        return None;
                    }
                    // The only winner at its bodies: nobody else touches these masks in this round.
                    let taken = self.masks(blank.a, blank.b).fold(0, |all, mask| all | mask.load(Relaxed));
                    let color = taken.trailing_ones().min(OVERFLOW);
                    self.take(color, blank.a, blank.b);
                    Some(color)
                })
                .collect();
            // A body without a free colour can't lose its blanks one a round.
            let full = |blank: &Blank| {
                self.masks(blank.a, blank.b).fold(0, |all, mask| all | mask.load(Relaxed)) == u64::MAX
            };
            let mut rest = Vec::with_capacity(blanks.len());
            for (blank, winner) in blanks.into_iter().zip(winners) {
                match winner {
                    Some(found) => color(&blank, found),
                    None if full(&blank) => color(&blank, OVERFLOW),
                    None => rest.push(blank),
                }
            }
            blanks = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::{FIXED, Manifold, Memory};
    use crate::shelf::Lane;
    use crate::single::Surface;
    use rockfall_math::Vec3;
    use std::collections::HashSet;

    fn arrivals(pairs: &[(u32, u32)]) -> Vec<Found> {
        let one = |&(a, b): &(u32, u32)| Found {
            manifold: Manifold { a, b, count: 1, ..Manifold::default() },
            memory: Memory::default(),
            surface: Surface::default(),
            offset: Vec3::ZERO,
            active: true,
            ordinal: 0,
            balls: false,
            lane: Lane::NONE,
        };
        pairs.iter().map(one).collect()
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

    fn colors(groups: &[Vec<Found>]) -> Vec<u32> {
        groups.iter().flatten().map(|arrival| arrival.memory.color).collect()
    }

    #[test]
    fn no_body_stands_twice_in_a_colour() {
        let pairs = random_pairs(20_000, 2_000);
        let mut groups = vec![arrivals(&pairs)];
        painter(2_001).paint(&mut groups);
        let mut seen = HashSet::new();
        for (&(a, b), color) in pairs.iter().zip(colors(&groups)) {
            assert!(color < COLORS);
            assert!(seen.insert((a, color)) && seen.insert((b, color)));
        }
    }

    #[test]
    fn colours_depend_on_neither_threads_nor_groups() {
        let pairs = random_pairs(20_000, 2_000);
        let run = |threads: usize, size: usize| {
            let mut groups: Vec<Vec<Found>> = pairs.chunks(size).map(arrivals).collect();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| painter(2_001).paint(&mut groups));
            colors(&groups)
        };
        assert_eq!(run(1, 100_000), run(3, 100));
    }

    #[test]
    fn a_hub_overflows_and_loses_nothing() {
        let pairs: Vec<(u32, u32)> = (2..5_002).map(|b| (1, b)).collect();
        let mut groups = vec![arrivals(&pairs)];
        painter(5_002).paint(&mut groups);
        let colors = colors(&groups);
        assert_eq!(colors.iter().filter(|&&c| c == OVERFLOW).count(), 5_000 - COLORS as usize);
        assert_eq!(colors.iter().filter(|&&c| c < COLORS).collect::<HashSet<_>>().len(), COLORS as usize);
    }

    #[test]
    fn colours_are_kept_and_freed_ones_used_again() {
        let mut groups = vec![arrivals(&[(1, 2), (1, 3), (1, 4)])];
        let painter = painter(5);
        painter.paint(&mut groups);
        let before = colors(&groups);
        painter.free(before[1], 1, Some(3));
        groups[0][1].memory.color = NO_COLOR;
        painter.paint(&mut groups);
        assert_eq!(before, colors(&groups));
    }

    #[test]
    fn contacts_with_immovable_bodies_have_colours_of_their_own() {
        let mut groups =
            vec![arrivals(&[(1, 2), (1, 3 | FIXED), (1, 4 | FIXED), (1, 4 | FIXED), (2, 4 | FIXED)])];
        groups[0][3].ordinal = 1;
        painter(5).paint(&mut groups);
        let colors = colors(&groups);
        let of_one: HashSet<u32> = colors[1..4].iter().copied().collect();
        assert_eq!(of_one, HashSet::from([0, 1, 2]));
        assert_eq!((colors[0], colors[4]), (0, 0));
    }
}
