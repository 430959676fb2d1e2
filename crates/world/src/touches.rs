//! The pairs of a world and their manifolds, in runs.
//!
//! All pairs, sorted by key, are cut into runs of some hundreds. A run owns everything that belongs to its pairs, so that
//! it is brought up to date in its place, by one thread, beside all others: no second set of manifolds is held, and nothing
//! is merged for the world as a whole. A run that has grown to twice its length is cut, neighbours that have shrunk are
//! joined. Where the cuts lie follows from what happened before; nothing that is computed may depend on it.

use crate::recall::Recall;
use rayon::prelude::*;
use rockfall_math::room::make_room;
use rockfall_solve::{Chunk, FIXED, Manifold, Memory, row_of};

/// Pairs in a run that was just cut. It may grow to twice as many.
const RUN: usize = 256;

/// There was no such pair in the last step.
pub(crate) const NEW: u32 = u32::MAX;

/// The two rows of a key, the second with its mark.
pub(crate) fn rows(key: u64) -> (u32, u32) {
    ((key >> 32) as u32, key as u32)
}

/// Neighbouring pairs; their manifolds are in the chunk of the same number.
#[derive(Debug, Default)]
pub(crate) struct Run {
    /// Row of body a in the upper half, of body b in the lower, ascending. Of two bodies that contacts move, a has the
    /// smaller id; of others, a is the one that they move and b is marked [`FIXED`].
    pub(crate) keys: Vec<u64>,
    /// Place of each pair in the columns below, or [`NEW`]; empty where the pairs are those that the columns have.
    pub(crate) befores: Vec<u32>,
    /// First manifold of each pair in the chunk, and the number of all.
    pub(crate) firsts: Vec<u32>,
    /// What each pair remembers.
    pub(crate) recalls: Vec<Recall>,
}

impl Run {
    /// Place in the columns of the last step of pair `i`.
    pub(crate) fn before(&self, i: usize) -> u32 {
        if self.befores.is_empty() { i as u32 } else { self.befores[i] }
    }

    /// Manifolds of the pair that was at `before`, as a range in the chunk.
    pub(crate) fn manifolds(&self, before: u32) -> std::ops::Range<usize> {
        self.firsts[before as usize] as usize..self.firsts[before as usize + 1] as usize
    }

    fn memory(&self) -> usize {
        self.keys.capacity() * size_of::<u64>()
            + (self.befores.capacity() + self.firsts.capacity()) * size_of::<u32>()
            + self.recalls.capacity() * size_of::<Recall>()
    }
}

/// All pairs and manifolds.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    /// Pairs.
    pub(crate) runs: Vec<Run>,
    /// Manifolds, run by run.
    pub(crate) chunks: Vec<Chunk>,
}

impl Touches {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        let chunk = |c: &Chunk| {
            c.manifolds.capacity() * size_of::<Manifold>() + c.memories.capacity() * size_of::<Memory>()
        };
        self.chunks.iter().map(chunk).sum::<usize>()
            + self.runs.iter().map(Run::memory).sum::<usize>()
            + self.runs.capacity() * (size_of::<Run>() + size_of::<Chunk>())
    }

    /// Number of pairs.
    pub(crate) fn pairs(&self) -> usize {
        self.runs.iter().map(|run| run.keys.len()).sum()
    }

    /// Keys of all pairs, ascending.
    pub(crate) fn keys(&self) -> impl Iterator<Item = u64> + '_ {
        self.runs.iter().flat_map(|run| run.keys.iter().copied())
    }

    /// Whether the pair of a key is in contact, or about to be.
    pub(crate) fn has_manifold(&self, key: u64) -> bool {
        let run = self.runs.partition_point(|run| run.keys.first().is_some_and(|&first| first <= key));
        let Some(run) = run.checked_sub(1).map(|i| &self.runs[i]) else { return false };
        run.keys.binary_search(&key).is_ok_and(|i| !run.manifolds(i as u32).is_empty())
    }

    /// Cuts runs that have become long and joins those that have become short.
    pub(crate) fn balance(&mut self) {
        let long = |run: &Run| run.keys.len() > 2 * RUN;
        let short =
            |a: &Run, b: &Run| a.keys.is_empty() || b.keys.is_empty() || a.keys.len() + b.keys.len() < RUN;
        if !self.runs.iter().any(long) && !self.runs.windows(2).any(|pair| short(&pair[0], &pair[1])) {
            return;
        }
        let old = std::mem::take(&mut self.runs).into_iter().zip(std::mem::take(&mut self.chunks));
        for (run, chunk) in old {
            match (self.runs.last_mut(), self.chunks.last_mut()) {
                (Some(last), Some(of_last)) if !long(&run) && short(last, &run) => {
                    join(last, of_last, run, chunk);
                }
                _ if long(&run) => {
                    for (run, chunk) in cut(&run, &chunk) {
                        self.runs.push(run);
                        self.chunks.push(chunk);
                    }
                }
                _ => {
                    self.runs.push(run);
                    self.chunks.push(chunk);
                }
            }
        }
    }

    /// Follows the bodies to their new rows, `u32::MAX` for those that are gone. Column by column, so that only one of them
    /// is there twice.
    pub(crate) fn rename(&mut self, new_rows: &[u32]) {
        let mut places: Vec<Place> = Vec::with_capacity(self.pairs());
        for (number, run) in self.runs.iter_mut().enumerate() {
            for (i, key) in std::mem::take(&mut run.keys).into_iter().enumerate() {
                let (a, b) = rows(key);
                let (new_a, new_b) = (new_rows[a as usize], new_rows[row_of(b)]);
                if new_a != u32::MAX && new_b != u32::MAX {
                    let key = u64::from(new_a) << 32 | u64::from(new_b | (b & FIXED));
                    places.push(Place { key, run: number as u32, pair: i as u32 });
                }
            }
        }
        places.par_sort_unstable_by_key(|place| place.key);

        let Touches { runs, chunks } = self;
        let keys = gather(&places, |place| [place.key]);
        let recalls = gather(&places, |place| [runs[place.run as usize].recalls[place.pair as usize]]);
        let manifolds = gather(&places, |place| {
            let (a, b) = rows(place.key);
            let range = runs[place.run as usize].manifolds(place.pair);
            chunks[place.run as usize].manifolds[range].iter().map(move |&m| Manifold { a, b, ..m })
        });
        chunks.iter_mut().for_each(|chunk| chunk.manifolds = Vec::new());
        let memories = gather(&places, |place| {
            let range = runs[place.run as usize].manifolds(place.pair);
            chunks[place.run as usize].memories[range].iter().copied()
        });
        let counts = gather(&places, |place| [runs[place.run as usize].manifolds(place.pair).len() as u32]);
        let firsts = counts.into_iter().map(|counts| {
            let mut first = 0;
            let ends = counts.into_iter().map(|count| {
                first += count;
                first
            });
            std::iter::once(0).chain(ends).collect()
        });
        *runs = keys
            .into_iter()
            .zip(recalls)
            .zip(firsts)
            .map(|((keys, recalls), firsts)| Run { keys, befores: Vec::new(), firsts, recalls })
            .collect();
        *chunks = manifolds
            .into_iter()
            .zip(memories)
            .map(|(manifolds, memories)| Chunk { manifolds, memories })
            .collect();
    }
}

/// Where a pair comes from, and its new key.
struct Place {
    key: u64,
    run: u32,
    pair: u32,
}

/// A column of new runs: what each of their pairs brings.
fn gather<T: Send, I: IntoIterator<Item = T>>(
    places: &[Place],
    of: impl Fn(&Place) -> I + Sync,
) -> Vec<Vec<T>> {
    let column = |places: &[Place]| {
        let mut column: Vec<T> = places.iter().flat_map(&of).collect();
        let len = column.len();
        make_room(&mut column, len);
        column
    };
    places.par_chunks(RUN).map(column).collect()
}

/// Appends a run and its chunk to those before it.
fn join(last: &mut Run, of_last: &mut Chunk, mut run: Run, mut chunk: Chunk) {
    let (pairs, manifolds) = (last.recalls.len() as u32, of_last.manifolds.len() as u32);
    for run in [&mut *last, &mut run] {
        if run.befores.is_empty() {
            run.befores = (0..run.keys.len() as u32).collect();
        }
    }
    let moved = |before: u32| if before == NEW { NEW } else { before + pairs };
    last.keys.append(&mut run.keys);
    last.befores.extend(run.befores.into_iter().map(moved));
    last.firsts.pop();
    last.firsts.extend(run.firsts.into_iter().map(|first| first + manifolds));
    last.recalls.append(&mut run.recalls);
    of_last.manifolds.append(&mut chunk.manifolds);
    of_last.memories.append(&mut chunk.memories);
}

/// Cuts a run and its chunk into runs of equal length.
fn cut(run: &Run, chunk: &Chunk) -> Vec<(Run, Chunk)> {
    let pieces = run.keys.len().div_ceil(RUN);
    let start = |piece: usize| piece * run.keys.len() / pieces;
    // Where the last step's pairs are cut: at the first that goes on in a piece or behind it.
    let mut old_start = vec![run.recalls.len() as u32; pieces + 1];
    for piece in (0..pieces).rev() {
        let first = (start(piece)..start(piece + 1)).map(|i| run.before(i)).find(|&before| before != NEW);
        old_start[piece] = first.unwrap_or(old_start[piece + 1]);
    }
    (0..pieces)
        .into_par_iter()
        .map(|piece| {
            let (pairs, old) = (start(piece)..start(piece + 1), old_start[piece]..old_start[piece + 1]);
            let first = |i: u32| run.firsts.get(i as usize).copied().unwrap_or_default();
            let manifolds = first(old.start) as usize..first(old.end) as usize;
            let shifted = |before: u32| if before == NEW { NEW } else { before - old.start };
            let piece = Run {
                keys: run.keys[pairs.clone()].to_vec(),
                befores: pairs.map(|i| shifted(run.before(i))).collect(),
                firsts: (old.start..=old.end).map(|i| first(i) - first(old.start)).collect(),
                recalls: run.recalls[old.start as usize..old.end as usize].to_vec(),
            };
            let content = Chunk {
                manifolds: chunk.manifolds[manifolds.clone()].to_vec(),
                memories: chunk.memories[manifolds].to_vec(),
            };
            (piece, content)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of pairs with these keys, each with `count(key)` manifolds whose body a is the key.
    fn run_of(keys: &[u64], count: impl Fn(u64) -> usize) -> (Run, Chunk) {
        let (mut run, mut chunk) = (Run { keys: keys.to_vec(), ..Run::default() }, Chunk::default());
        for &key in keys {
            run.firsts.push(chunk.manifolds.len() as u32);
            run.recalls.push(Recall { mark: key as u32, ..Recall::default() });
            for _ in 0..count(key) {
                chunk.manifolds.push(Manifold { a: key as u32, ..Manifold::default() });
                chunk.memories.push(Memory { color: key as u32, ..Memory::default() });
            }
        }
        run.firsts.push(chunk.manifolds.len() as u32);
        (run, chunk)
    }

    fn touches_of(runs: Vec<(Run, Chunk)>) -> Touches {
        let (runs, chunks) = runs.into_iter().unzip();
        Touches { runs, chunks }
    }

    /// A key, and what its pair finds of itself: mark and manifolds.
    type Found = (u64, Option<(u32, Vec<u32>)>);

    fn found(touches: &Touches) -> Vec<Found> {
        let of = |run: &Run, chunk: &Chunk, i: usize| {
            let before = run.before(i);
            (before != NEW).then(|| {
                let names = chunk.manifolds[run.manifolds(before)].iter().map(|m| m.a).collect();
                (run.recalls[before as usize].mark, names)
            })
        };
        let pairs = touches.runs.iter().zip(&touches.chunks);
        pairs.flat_map(|(r, c)| (0..r.keys.len()).map(move |i| (r.keys[i], of(r, c, i)))).collect()
    }

    #[test]
    fn cutting_and_joining_lose_nothing() {
        // Every third pair is new, every fifth of the old ones has ended; manifolds come in threes, none to two.
        let old: Vec<u64> = (0..2000).filter(|k| k % 3 != 0).collect();
        let (mut run, chunk) = run_of(&old, |key| key as usize % 3);
        let now: Vec<u64> = (0..2000).filter(|k| k % 3 == 0 || k % 5 != 0).collect();
        run.befores = now.iter().map(|k| old.binary_search(k).map_or(NEW, |i| i as u32)).collect();
        run.keys = now;
        let mut touches = touches_of(vec![(run, chunk)]);
        let whole = found(&touches);
        touches.balance();
        assert!(touches.runs.len() > 4 && touches.runs.iter().all(|run| run.keys.len() <= RUN));
        assert_eq!(touches.runs.len(), touches.chunks.len());
        assert_eq!(found(&touches), whole);

        let parts: Vec<_> = whole.chunks(50).map(|c| c.iter().map(|(k, _)| *k).collect::<Vec<_>>()).collect();
        let mut touches = touches_of(parts.iter().map(|keys| run_of(keys, |key| key as usize % 3)).collect());
        let whole = found(&touches);
        touches.balance();
        assert!(touches.runs.len() < parts.len() / 3);
        assert_eq!(found(&touches), whole);
        assert!(touches.keys().is_sorted() && touches.pairs() == whole.len());
        assert!(touches.has_manifold(4) && !touches.has_manifold(6) && !touches.has_manifold(10_000));
    }

    #[test]
    fn pairs_follow_their_rows() {
        let key = |a: u64, b: u64| a << 32 | b;
        let keys = [key(1, 2), key(1, 3), key(2, 3), key(3, u64::from(4 | FIXED))];
        let mut touches = touches_of(vec![run_of(&keys[..2], |_| 1), run_of(&keys[2..], |_| 1)]);
        touches.rename(&[0, 3, u32::MAX, 1, 2]);
        let keys: Vec<u64> = touches.keys().collect();
        assert_eq!(keys, [key(1, u64::from(2 | FIXED)), key(3, 1)]);
        let words: Vec<u32> = touches.runs[0].recalls.iter().map(|recall| recall.mark).collect();
        assert_eq!(words, [4 | FIXED, 3]);
        let rows: Vec<_> = touches.chunks[0].manifolds.iter().map(|m| (m.a, m.b)).collect();
        assert_eq!(rows, [(1, 2 | FIXED), (3, 1)]);
    }
}
