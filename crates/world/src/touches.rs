//! The pairs of a world, in runs, and where their contacts are.
//!
//! All pairs, sorted by key, are cut into runs of some hundreds. A run owns everything that belongs to its pairs, so that
//! it is brought up to date in its place, by one thread, beside all others, and nothing is merged for the world as a whole. A run that has grown to twice its length is cut, neighbours that have shrunk are
//! joined. Where the cuts lie follows from what happened before; nothing that is computed may depend on it.

mod snapshot;

use crate::recall::Recall;
use rayon::prelude::*;
use rockfall_math::room::give_back;
use rockfall_math::share::{Share, ShareSort};
use rockfall_solve::{Entry, FIXED, Lane, row_of};

/// Pairs in a run that was just cut. It may grow to twice as many.
const RUN: usize = 256;

/// Runs whose pairs are appended to a long column at a time. What threads find is there twice while it is appended.
const PIECE: usize = 1024;

/// There was no such pair in the last step.
pub(crate) const NEW: u32 = u32::MAX;

/// The two rows of a key, the second with its mark.
pub(crate) fn rows(key: u64) -> (u32, u32) {
    ((key >> 32) as u32, key as u32)
}

/// Neighbouring pairs.
#[derive(Debug, Default)]
pub(crate) struct Run {
    /// Row of body a in the upper half, of body b in the lower, ascending. Of two bodies that contacts move, a has the
    /// smaller id; of others, a is the one that they move and b is marked [`FIXED`].
    pub(crate) keys: Vec<u64>,
    /// Place of each pair in the columns below, or [`NEW`]; empty where the pairs are those that the columns have.
    pub(crate) befores: Vec<u32>,
    /// First of each pair among the lanes, and the number of all.
    pub(crate) firsts: Vec<u32>,
    /// What each pair remembers.
    pub(crate) recalls: Vec<Recall>,
    /// Where the contacts of each pair are.
    pub(crate) lanes: Vec<Lane>,
}

impl Run {
    /// A run without pairs.
    pub(crate) fn empty() -> Self {
        Run { firsts: vec![0], ..Run::default() }
    }

    /// Whether the columns belong to the very pairs that the run has.
    pub(crate) fn is_current(&self) -> bool {
        self.befores.is_empty() && self.keys.len() == self.recalls.len()
    }

    /// Place in the columns of the last step of pair `i`.
    pub(crate) fn before(&self, i: usize) -> u32 {
        if self.befores.is_empty() { i as u32 } else { self.befores[i] }
    }

    /// Contacts of the pair that was at `before`, as a range of the lanes.
    pub(crate) fn contacts(&self, before: u32) -> std::ops::Range<usize> {
        self.firsts[before as usize] as usize..self.firsts[before as usize + 1] as usize
    }

    fn memory(&self) -> usize {
        self.keys.capacity() * size_of::<u64>()
            + (self.befores.capacity() + self.firsts.capacity()) * size_of::<u32>()
            + self.recalls.capacity() * size_of::<Recall>()
            + self.lanes.capacity() * size_of::<Lane>()
    }
}

/// All pairs.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    /// In the order of their keys.
    pub(crate) runs: Vec<Run>,
}

impl Touches {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.runs.iter().map(Run::memory).sum::<usize>() + self.runs.capacity() * size_of::<Run>()
    }

    /// Number of pairs.
    pub(crate) fn pairs(&self) -> usize {
        self.runs.iter().map(|run| run.keys.len()).sum()
    }

    /// Keys of all pairs, ascending.
    pub(crate) fn keys(&self) -> impl Iterator<Item = u64> + '_ {
        self.runs.iter().flat_map(|run| run.keys.iter().copied())
    }

    /// Each contact's key and lane, in the order of the keys. Not between [`crate::pair`] and [`crate::touch`].
    pub(crate) fn contacts(&self) -> impl Iterator<Item = (u64, Lane)> + '_ {
        self.runs.iter().flat_map(Run::entries)
    }

    /// Cuts runs that have become long and joins those that have become short.
    pub(crate) fn balance(&mut self) {
        let long = |run: &Run| run.keys.len() > 2 * RUN;
        let short =
            |a: &Run, b: &Run| a.keys.is_empty() || b.keys.is_empty() || a.keys.len() + b.keys.len() < RUN;
        let as_they_are =
            |(i, run): (usize, &Run)| !long(run) && self.runs.get(i + 1).is_none_or(|next| !short(run, next));
        if self.runs.par_iter().enumerate().with_min_len(64).shared().all(as_they_are) {
            return;
        }
        for run in std::mem::take(&mut self.runs) {
            match self.runs.last_mut() {
                Some(last) if !long(&run) && short(last, &run) => join(last, run),
                _ if long(&run) => self.runs.extend(cut(&run)),
                _ => self.runs.push(run),
            }
        }
    }

    /// Follows the bodies to their new rows, `u32::MAX` for those that are gone. Returns every contact with its new rows.
    ///
    /// On the way everything is in a few long columns. Runs are many small vectors: with the new ones beside the old the allocator would hold
    /// twice their room from then on. Where `all` rows have other places it gives back what it holds before there are new ones.
    pub(crate) fn rename(&mut self, new_rows: &[u32], all: bool) -> Vec<Entry> {
        let mut places: Vec<Place> = Vec::with_capacity(self.pairs());
        for (piece, runs) in self.runs.chunks_mut(PIECE).enumerate() {
            places.par_extend(runs.par_iter_mut().enumerate().shared().flat_map_iter(|(i, run)| {
                let keys = std::mem::take(&mut run.keys);
                keys.into_iter().zip(0..).filter_map(move |(key, pair)| {
                    let key = renamed(key, new_rows)?;
                    Some(Place { key, run: (piece * PIECE + i) as u32, pair })
                })
            }));
        }
        places.sort_shared_by_key(|place| place.key);

        let run_of = |place: &Place| &self.runs[place.run as usize];
        let recalls: Vec<Recall> =
            places.par_iter().shared().map(|place| run_of(place).recalls[place.pair as usize]).collect();
        let mut entries: Vec<Entry> = Vec::with_capacity(self.runs.iter().map(|run| run.lanes.len()).sum());
        for places in places.chunks(PIECE * RUN) {
            entries.par_extend(places.par_iter().shared().flat_map_iter(|place| {
                let (a, b) = rows(place.key);
                let run = run_of(place);
                run.lanes[run.contacts(place.pair)].iter().map(move |&lane| Entry { lane, a, b })
            }));
        }
        self.runs = Vec::new();
        if all {
            give_back();
        }
        self.runs = (places.par_chunks(RUN), recalls.par_chunks(RUN))
            .into_par_iter()
            .shared()
            .map(|(places, recalls)| {
                Run::of(places.iter().map(|place| place.key).collect(), recalls, &entries)
            })
            .collect();
        entries
    }

    /// Every contact with its rows, in the order of the keys. Not between [`crate::pair`] and [`crate::touch`].
    pub(crate) fn entries(&self) -> Vec<Entry> {
        let entry = |(key, lane)| Entry { lane, a: rows(key).0, b: rows(key).1 };
        self.runs.par_iter().shared().flat_map_iter(|run| run.entries().map(entry)).collect()
    }

    /// Moves every contact to the lane that it has now, in the order of [`Touches::rename`].
    pub(crate) fn relocate(&mut self, lanes: &[Lane]) {
        let mut rest = lanes;
        for run in &mut self.runs {
            let here;
            (here, rest) = rest.split_at(run.lanes.len());
            run.lanes.copy_from_slice(here);
        }
    }
}

impl Run {
    /// A run of pairs with these keys, whose contacts are somewhere among `entries`, which are in the order of the keys.
    fn of(keys: Vec<u64>, recalls: &[Recall], entries: &[Entry]) -> Self {
        let key_of = |entry: &Entry| u64::from(entry.a) << 32 | u64::from(entry.b);
        let start = keys.first().map_or(0, |&first| entries.partition_point(|entry| key_of(entry) < first));
        let mut next = start;
        let mut firsts = Vec::with_capacity(keys.len() + 1);
        firsts.push(0);
        for &key in &keys {
            next += entries[next..].iter().take_while(|entry| key_of(entry) == key).count();
            firsts.push((next - start) as u32);
        }
        let lanes = entries[start..next].iter().map(|entry| entry.lane).collect();
        Run { keys, befores: Vec::new(), firsts, recalls: recalls.to_vec(), lanes }
    }

    /// Each contact's key and lane.
    fn entries(&self) -> impl Iterator<Item = (u64, Lane)> + '_ {
        (0_u32..)
            .zip(&self.keys)
            .flat_map(|(i, &key)| self.lanes[self.contacts(i)].iter().map(move |&lane| (key, lane)))
    }
}

/// A key under new rows; nothing where one of them is gone.
fn renamed(key: u64, new_rows: &[u32]) -> Option<u64> {
    let (a, b) = rows(key);
    let (new_a, new_b) = (new_rows[a as usize], new_rows[row_of(b)]);
    (new_a != u32::MAX && new_b != u32::MAX).then(|| u64::from(new_a) << 32 | u64::from(new_b | (b & FIXED)))
}

/// Where a pair comes from, and its new key.
struct Place {
    key: u64,
    run: u32,
    pair: u32,
}

/// Appends a run to the one before it.
fn join(last: &mut Run, mut run: Run) {
    let (pairs, contacts) = (last.recalls.len() as u32, last.lanes.len() as u32);
    for run in [&mut *last, &mut run] {
        if run.befores.is_empty() {
            run.befores = (0..run.keys.len() as u32).collect();
        }
    }
    let moved = |before: u32| if before == NEW { NEW } else { before + pairs };
    last.keys.append(&mut run.keys);
    last.befores.extend(run.befores.into_iter().map(moved));
    last.firsts.pop();
    last.firsts.extend(run.firsts.into_iter().map(|first| first + contacts));
    last.recalls.append(&mut run.recalls);
    last.lanes.append(&mut run.lanes);
}

/// Cuts a run into runs of equal length.
fn cut(run: &Run) -> Vec<Run> {
    let pieces = run.keys.len().div_ceil(RUN);
    let start = |piece: usize| piece * run.keys.len() / pieces;
    // Where the last step's pairs are cut: at the first that goes on in a piece; those that have ended go with the piece before.
    let mut old_start = vec![run.recalls.len() as u32; pieces + 1];
    for piece in (1..pieces).rev() {
        let first = (start(piece)..start(piece + 1)).map(|i| run.before(i)).find(|&before| before != NEW);
        old_start[piece] = first.unwrap_or(old_start[piece + 1]);
    }
    old_start[0] = 0;
    (0..pieces)
        .map(|piece| {
            let (pairs, old) = (start(piece)..start(piece + 1), old_start[piece]..old_start[piece + 1]);
            let first = |i: u32| run.firsts[i as usize];
            let shifted = |before: u32| if before == NEW { NEW } else { before - old.start };
            Run {
                keys: run.keys[pairs.clone()].to_vec(),
                befores: pairs.map(|i| shifted(run.before(i))).collect(),
                firsts: (old.start..=old.end).map(|i| first(i) - first(old.start)).collect(),
                recalls: run.recalls[old.start as usize..old.end as usize].to_vec(),
                lanes: run.lanes[first(old.start) as usize..first(old.end) as usize].to_vec(),
            }
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use rockfall_solve::Contacts;

    /// Lanes that can be told apart.
    pub(crate) fn lanes(count: usize) -> Vec<Lane> {
        let mut contacts = Contacts::default();
        let manifold = rockfall_solve::Manifold { a: 1, b: 2, count: 1, ..Default::default() };
        let arrival = rockfall_solve::Found {
            manifold,
            memory: rockfall_solve::Memory { color: 0, ..Default::default() },
            active: true,
            ..Default::default()
        };
        let mut arrivals = vec![vec![arrival; count]];
        contacts.place(&mut arrivals);
        arrivals[0].iter().map(|arrival| arrival.lane).collect()
    }

    /// A run of pairs with these keys, each with `count(key)` contacts, whose lanes are the next ones.
    pub(crate) fn run_of(
        keys: &[u64],
        lanes: &mut impl Iterator<Item = Lane>,
        count: impl Fn(u64) -> usize,
    ) -> Run {
        let mut run = Run { keys: keys.to_vec(), ..Run::empty() };
        for &key in keys {
            run.recalls.push(Recall { mark: key as u32, ..Recall::default() });
            run.lanes.extend(lanes.take(count(key)));
            run.firsts.push(run.lanes.len() as u32);
        }
        run
    }

    /// A key, and what its pair finds of itself: mark and lanes.
    type Found = (u64, Option<(u32, Vec<Lane>)>);

    fn found(touches: &Touches) -> Vec<Found> {
        let of = |run: &Run, i: usize| {
            let before = run.before(i);
            let lanes = |before| run.lanes[run.contacts(before)].to_vec();
            (before != NEW).then(|| (run.recalls[before as usize].mark, lanes(before)))
        };
        touches.runs.iter().flat_map(|r| (0..r.keys.len()).map(move |i| (r.keys[i], of(r, i)))).collect()
    }

    #[test]
    fn cutting_and_joining_lose_nothing() {
        let all = lanes(3000);
        // Every third pair is new, every fifth of the old ones has ended; contacts come in threes, none to two.
        let old: Vec<u64> = (0..2000).filter(|k| k % 3 != 0).collect();
        let mut run = run_of(&old, &mut all.iter().copied(), |key| key as usize % 3);
        let now: Vec<u64> = (0..2000).filter(|k| k % 3 == 0 || k % 5 != 0).collect();
        run.befores = now.iter().map(|k| old.binary_search(k).map_or(NEW, |i| i as u32)).collect();
        run.keys = now;
        let before = run.lanes.clone();
        let mut touches = Touches { runs: vec![run] };
        let whole = found(&touches);
        touches.balance();
        assert!(touches.runs.len() > 4 && touches.runs.iter().all(|run| run.keys.len() <= RUN));
        assert_eq!(found(&touches), whole);
        // Contacts of pairs that have ended are still there, to be given back.
        assert_eq!(touches.runs.iter().flat_map(|run| run.lanes.clone()).collect::<Vec<_>>(), before);

        let mut all = all.into_iter();
        let parts = whole.chunks(50).map(|c| c.iter().map(|(k, _)| *k).collect::<Vec<_>>());
        let runs: Vec<Run> = parts.map(|keys| run_of(&keys, &mut all, |key| key as usize % 3)).collect();
        let mut touches = Touches { runs };
        let (whole, parts) = (found(&touches), touches.runs.len());
        touches.balance();
        assert!(touches.runs.len() < parts / 3);
        assert_eq!(found(&touches), whole);
        assert!(touches.keys().is_sorted() && touches.pairs() == whole.len());
    }

    #[test]
    fn pairs_follow_their_rows() {
        let key = |a: u64, b: u64| a << 32 | b;
        let keys = [key(1, 2), key(1, 3), key(2, 3), key(3, u64::from(4 | FIXED))];
        let all = lanes(6);
        let mut next = all.iter().copied();
        let runs = vec![run_of(&keys[..2], &mut next, |_| 1), run_of(&keys[2..], &mut next, |_| 1)];
        let mut touches = Touches { runs };
        let entries = touches.rename(&[0, 3, u32::MAX, 1, 2], true);
        let keys: Vec<u64> = touches.keys().collect();
        assert_eq!(keys, [key(1, u64::from(2 | FIXED)), key(3, 1)]);
        let words: Vec<u32> = touches.runs[0].recalls.iter().map(|recall| recall.mark).collect();
        assert_eq!(words, [4 | FIXED, 3]);
        let entries: Vec<_> = entries.iter().map(|e| (e.a, e.b, e.lane)).collect();
        assert_eq!(entries, [(1, 2 | FIXED, all[3]), (3, 1, all[1])]);
        touches.relocate(&[all[4], all[5]]);
        assert_eq!(touches.contacts().map(|(_, lane)| lane).collect::<Vec<_>>(), [all[4], all[5]]);
    }
}
