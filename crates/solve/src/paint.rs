//! Stage 6, **paint**: colours for the manifolds, so that within a colour no body that moves stands twice.
//!
//! Reads the manifolds and the colours in their memories; writes the colours that are missing. A manifold keeps its
//! colour for as long as its pair touches. New ones are painted in rounds: a manifold whose hash is the largest at both of
//! its bodies takes the lowest colour that is free at both (Jones and Plassmann, "A Parallel Graph Coloring Heuristic",
//! SIAM J. Sci. Comput. 14(3), 1993). Which colours come out depends on the keys of the pairs alone.
//!
//! A body with more neighbours than colours leaves some of its manifolds in the colour [`OVERFLOW`], whose contacts are
//! solved one after the other, in the order of their keys. None is dropped.

use crate::manifold::{Chunk, NO_COLOR, row_of};
use rayon::prelude::*;
use rockfall_math::hash::mix;
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

/// A manifold between two bodies that move, still without a colour.
#[derive(Clone, Copy, Debug)]
struct Blank {
    a: u32,
    b: u32,
    chunk: u32,
    row: u32,
}

impl Blank {
    /// Distinct for distinct pairs.
    fn priority(&self) -> u64 {
        mix(u64::from(self.a) << 32 | u64::from(self.b))
    }
}

/// Room for [`paint`] that is kept from step to step.
#[derive(Debug, Default)]
pub struct Painter {
    /// Colours in use at each body.
    masks: Vec<AtomicU64>,
    /// Largest hash of the blank manifolds of each body.
    tops: Vec<AtomicU64>,
    /// Blank manifolds of each body.
    degrees: Vec<AtomicU32>,
}

impl Painter {
    /// Bytes held.
    pub fn memory(&self) -> usize {
        (self.masks.capacity() + self.tops.capacity()) * size_of::<AtomicU64>()
            + self.degrees.capacity() * size_of::<AtomicU32>()
    }
}

/// Gives a colour below [`COLORS`], or [`OVERFLOW`], to every manifold between two bodies that move. `rows` is the number
/// of bodies.
pub fn paint(chunks: &mut [Chunk], rows: usize, painter: &mut Painter) {
    let Painter { masks, tops, degrees } = painter;
    degrees.clear();
    degrees.resize_with(rows, AtomicU32::default);
    masks.clear();
    masks.resize_with(rows, AtomicU64::default);
    tops.resize_with(rows, AtomicU64::default);
    let masks = &masks[..];
    let tops = &tops[..];
    let degrees = &degrees[..];

    let mut blanks: Vec<Blank> = chunks
        .par_iter()
        .enumerate()
        .flat_map_iter(|(chunk, content)| {
            let Chunk { manifolds, memories } = content;
            manifolds.iter().zip(memories).enumerate().filter_map(move |(row, (m, memory))| {
                if m.is_one_sided() {
                    return None;
                }
                if memory.color < COLORS {
                    let bit = 1 << memory.color;
                    masks[row_of(m.a)].fetch_or(bit, Relaxed);
                    masks[row_of(m.b)].fetch_or(bit, Relaxed);
                    return None;
                }
                degrees[row_of(m.a)].fetch_add(1, Relaxed);
                degrees[row_of(m.b)].fetch_add(1, Relaxed);
                Some(Blank { a: m.a, b: m.b, chunk: chunk as u32, row: row as u32 })
            })
        })
        .collect();

    let degree = |row: u32| degrees[row as usize].load(Relaxed);
    blanks.retain(|blank| {
        let crowded = [blank.a, blank.b].into_iter().any(|row| stands_back(blank.priority(), degree(row)));
        if crowded {
            chunks[blank.chunk as usize].memories[blank.row as usize].color = OVERFLOW;
        }
        !crowded
    });

    let mut painted: Vec<(Blank, u32)> = Vec::with_capacity(blanks.len());
    while !blanks.is_empty() {
        blanks.par_iter().for_each(|blank| {
            tops[blank.a as usize].store(0, Relaxed);
            tops[blank.b as usize].store(0, Relaxed);
        });
        blanks.par_iter().for_each(|blank| {
            tops[blank.a as usize].fetch_max(blank.priority(), Relaxed);
            tops[blank.b as usize].fetch_max(blank.priority(), Relaxed);
        });
        let winners: Vec<Option<u32>> = blanks
            .par_iter()
            .map(|blank| {
                let (a, b) = (blank.a as usize, blank.b as usize);
                let priority = blank.priority();
                if tops[a].load(Relaxed) != priority || tops[b].load(Relaxed) != priority {
                    return None;
                }
                // The only winner at both bodies: nobody else touches these two masks in this round.
                let color = (masks[a].load(Relaxed) | masks[b].load(Relaxed)).trailing_ones();
                if color < COLORS {
                    masks[a].fetch_or(1 << color, Relaxed);
                    masks[b].fetch_or(1 << color, Relaxed);
                }
                Some(color.min(OVERFLOW))
            })
            .collect();
        painted.extend(blanks.iter().zip(&winners).filter_map(|(&blank, color)| Some((blank, (*color)?))));
        // A body without a free colour can't lose its blanks one a round.
        let mut rest = Vec::with_capacity(blanks.len());
        for (blank, winner) in blanks.into_iter().zip(winners) {
            if winner.is_some() {
                continue;
            }
            let full = masks[blank.a as usize].load(Relaxed) | masks[blank.b as usize].load(Relaxed);
            if full == u64::MAX {
                painted.push((blank, OVERFLOW));
            } else {
                rest.push(blank);
            }
        }
        blanks = rest;
    }
    for (blank, color) in painted {
        chunks[blank.chunk as usize].memories[blank.row as usize].color = color;
    }
    debug_assert!(
        chunks
            .iter()
            .flat_map(|c| c.manifolds.iter().zip(&c.memories))
            .all(|(m, memory)| m.is_one_sided() || memory.color != NO_COLOR)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifold::{Manifold, Memory};
    use std::collections::HashSet;

    fn chunk(pairs: &[(u32, u32)]) -> Chunk {
        Chunk {
            manifolds: pairs.iter().map(|&(a, b)| Manifold { a, b, ..Manifold::default() }).collect(),
            memories: vec![Memory::default(); pairs.len()],
        }
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

    fn colors(chunks: &[Chunk]) -> Vec<u32> {
        chunks.iter().flat_map(|c| c.memories.iter().map(|m| m.color)).collect()
    }

    #[test]
    fn no_body_stands_twice_in_a_colour() {
        let pairs = random_pairs(20_000, 2_000);
        let mut chunks = vec![chunk(&pairs)];
        paint(&mut chunks, 2_001, &mut Painter::default());
        let mut seen = HashSet::new();
        for (&(a, b), color) in pairs.iter().zip(colors(&chunks)) {
            assert!(color < COLORS);
            assert!(seen.insert((a, color)) && seen.insert((b, color)));
        }
    }

    #[test]
    fn colours_depend_on_neither_threads_nor_chunks() {
        let pairs = random_pairs(20_000, 2_000);
        let run = |threads: usize, size: usize| {
            let mut chunks: Vec<Chunk> = pairs.chunks(size).map(chunk).collect();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| paint(&mut chunks, 2_001, &mut Painter::default()));
            colors(&chunks)
        };
        assert_eq!(run(1, 100_000), run(3, 100));
    }

    #[test]
    fn a_hub_overflows_and_loses_nothing() {
        let pairs: Vec<(u32, u32)> = (2..5_002).map(|b| (1, b)).collect();
        let mut chunks = vec![chunk(&pairs)];
        paint(&mut chunks, 5_002, &mut Painter::default());
        let colors = colors(&chunks);
        assert_eq!(colors.iter().filter(|&&c| c == OVERFLOW).count(), 5_000 - COLORS as usize);
        assert_eq!(colors.iter().filter(|&&c| c < COLORS).collect::<HashSet<_>>().len(), COLORS as usize);
    }

    #[test]
    fn colours_are_kept_and_freed_ones_used_again() {
        let mut chunks = vec![chunk(&[(1, 2), (1, 3), (1, 4)])];
        let mut painter = Painter::default();
        paint(&mut chunks, 5, &mut painter);
        let before = colors(&chunks);
        chunks[0].memories[1].color = NO_COLOR;
        paint(&mut chunks, 5, &mut painter);
        assert_eq!(before, colors(&chunks));
    }
}
