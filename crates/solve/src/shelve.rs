//! Stage 8, **prepare**, first half: which contact goes into which lane.
//!
//! A counting sort of all manifolds into buckets by side, colour, class and temperature. Each run of chunks counts
//! for itself; sums over the runs give every run its places, so that all of them can write at once and the order within a
//! bucket is that of the pairs' keys.

use crate::batch::{Batches, CLASSES, Class, Layer, Span, Surface};
use crate::block::{Cold, LANES};
use crate::manifold::{Chunk, Manifold, row_of};
use crate::paint::{COLORS, OVERFLOW};
use rayon::prelude::*;
use rockfall_math::room::make_room;

/// Blocks in a span. Results don't depend on it.
const SPAN: usize = 8;

/// Chunks that one thread counts at a time.
pub(crate) const RUN: usize = 32;

/// Contacts that are left out.
pub(crate) const NOWHERE: u16 = u16::MAX;

/// Side, colour, class, cold: the order in which contacts are solved.
fn bucket(side: usize, color: u32, class: Class, cold: bool) -> usize {
    ((side * (OVERFLOW as usize + 1) + color as usize) * CLASSES.len() + class as usize) * 2
        + usize::from(cold)
}

const BUCKETS: usize = 2 * (OVERFLOW as usize + 1) * CLASSES.len() * 2;

/// The class of a bucket, and whether it is a cold one.
pub(crate) fn kind_of(bucket: usize) -> (Class, bool) {
    (CLASSES[bucket / 2 % CLASSES.len()], bucket % 2 == 1)
}

/// Where contacts go.
pub(crate) struct Places {
    /// For each run and bucket, the first lane.
    pub(crate) lanes: Vec<Vec<u32>>,
    /// For each bucket that is cold, what to add to a block's number to get that of its cold half.
    pub(crate) colds: Vec<isize>,
}

impl Batches {
    /// Cuts the contacts into blocks and spans.
    pub(crate) fn shelve(
        &mut self,
        chunks: &[Chunk],
        active: &(impl Fn(usize) -> bool + Sync),
        surface: &(impl Fn(usize, usize) -> Surface + Sync),
    ) -> Places {
        let runs = chunks.len().div_ceil(RUN);
        self.codes.resize_with(runs, Vec::new);
        let mut counts: Vec<Vec<u32>> = self
            .codes
            .par_iter_mut()
            .enumerate()
            .map(|(run, codes)| {
                let mut counts = vec![0; BUCKETS];
                let mut ordinal = Ordinal::before(chunks, run * RUN);
                codes.clear();
                let run = &chunks[run * RUN..chunks.len().min((run + 1) * RUN)];
                for (m, memory) in run.iter().flat_map(|c| c.manifolds.iter().zip(&c.memories)) {
                    let (a, b) = (row_of(m.a), row_of(m.b));
                    let one_sided = m.is_one_sided();
                    let color = if one_sided { ordinal.next(m) } else { memory.color };
                    if !active(a) && (one_sided || !active(b)) {
                        codes.push(NOWHERE);
                        continue;
                    }
                    let cold = surface(a, b).is_cold(m.count);
                    let code = bucket(usize::from(one_sided), color, Class::of(m.count), cold);
                    counts[code] += 1;
                    codes.push(code as u16);
                }
                counts
            })
            .collect();
        let colds = self.cut(&mut counts);
        Places { lanes: counts, colds }
    }

    /// Turns the number of contacts of each run in each bucket into the first lane of that run, and lays out the blocks.
    /// Returns how far the cold halves of each bucket are from its blocks.
    fn cut(&mut self, counts: &mut [Vec<u32>]) -> Vec<isize> {
        self.spans.clear();
        self.layers.clear();
        let mut next = [0_usize; CLASSES.len()];
        let mut colds = 0;
        let mut shifts = vec![0; BUCKETS];
        for side in 0..2 {
            for color in 0..=OVERFLOW {
                let first = self.spans.len();
                let mut total = 0;
                for (class, cold) in CLASSES.into_iter().flat_map(|class| [(class, false), (class, true)]) {
                    let bucket = bucket(side, color, class, cold);
                    let from = next[class as usize];
                    shifts[bucket] = colds as isize - from as isize;
                    let mut lane = (from * LANES) as u32;
                    for run in counts.iter_mut() {
                        lane += std::mem::replace(&mut run[bucket], lane);
                    }
                    let to = (lane as usize).div_ceil(LANES);
                    next[class as usize] = to;
                    total += to - from;
                    for start in (from..to).step_by(SPAN) {
                        let end = (start + SPAN).min(to);
                        let cold_from = cold.then_some(colds);
                        self.spans.push(Span {
                            class,
                            one_sided: side == 1,
                            from: start,
                            to: end,
                            cold: cold_from,
                        });
                        colds += if cold { end - start } else { 0 };
                    }
                }
                if self.spans.len() > first {
                    let spans = first..self.spans.len();
                    self.layers.push(Layer { spans, serial: color == COLORS, blocks: total });
                }
            }
        }
        self.one.resize(next[Class::One as usize]);
        self.two.resize(next[Class::Two as usize]);
        self.four.resize(next[Class::Four as usize]);
        self.colds.truncate(colds);
        make_room(&mut self.colds, colds);
        self.colds.resize(colds, Cold::IDLE);
        shifts
    }
}

/// Numbers the one-sided manifolds of each body from 0: their colours, since they stand together in the order of keys.
#[derive(Default)]
struct Ordinal {
    body: u32,
    next: u32,
}

impl Ordinal {
    /// The state that counting from the very first chunk would have before chunk `chunk`.
    fn before(chunks: &[Chunk], chunk: usize) -> Self {
        let mut earlier = chunks[..chunk].iter().rev().flat_map(|c| c.manifolds.iter().rev());
        let Some(last) = earlier.next().filter(|m| m.is_one_sided()) else { return Ordinal::default() };
        let more = earlier.take_while(|m| m.is_one_sided() && m.a == last.a).count();
        Ordinal { body: last.a, next: more as u32 + 1 }
    }

    fn next(&mut self, m: &Manifold) -> u32 {
        if self.body != m.a {
            *self = Ordinal { body: m.a, next: 0 };
        }
        self.next += 1;
        (self.next - 1).min(OVERFLOW)
    }
}
