//! Stage 4, **pair**: which bodies are near each other.
//!
//! Reads the trees and who has a new box; writes the pairs, sorted by key. Pairs of which neither body has a new box are
//! kept; those of the others are found again by a query each. Nothing is said about pairs that ended: they are the ones
//! that were not found.

use crate::Kind;
use crate::bodies::{Bodies, State};
use crate::index::Index;
use rayon::prelude::*;
use rockfall_math::room::make_room;
use rockfall_solve::{FIXED, row_of};

/// There was no such pair in the last step.
pub(crate) const NEW: u32 = u32::MAX;

/// Pairs of bodies whose boxes overlap, sorted by key.
#[derive(Debug, Default)]
pub(crate) struct Pairs {
    /// Row of body a in the upper half, of body b in the lower. Of two bodies that contacts move, a has the smaller id;
    /// of others, a is the one that they move and b is marked [`FIXED`].
    pub(crate) keys: Vec<u64>,
    /// Number of each pair in the last step, which names its manifolds there, or [`NEW`].
    pub(crate) befores: Vec<u32>,
}

/// The two rows of a key, the second with its mark.
pub(crate) fn rows(key: u64) -> (u32, u32) {
    ((key >> 32) as u32, key as u32)
}

impl Pairs {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.keys.capacity() * size_of::<u64>() + self.befores.capacity() * size_of::<u32>()
    }

    /// Number of the pair with a key.
    pub(crate) fn number(&self, key: u64) -> Option<usize> {
        self.keys.binary_search(&key).ok()
    }

    /// Follows the bodies to their new rows, `u32::MAX` for those that are gone.
    pub(crate) fn rename(&mut self, new_rows: &[u32]) {
        let mut renamed: Vec<(u64, u32)> = self
            .keys
            .par_iter()
            .zip(&self.befores)
            .filter_map(|(&key, &before)| {
                let (a, b) = rows(key);
                let (new_a, new_b) = (new_rows[a as usize], new_rows[row_of(b)]);
                let gone = new_a == u32::MAX || new_b == u32::MAX;
                (!gone).then(|| (u64::from(new_a) << 32 | u64::from(new_b | (b & FIXED)), before))
            })
            .collect();
        renamed.par_sort_unstable();
        (self.keys, self.befores) = renamed.into_iter().unzip();
    }
}

/// Rows that one thread searches or merges at a time.
const ROWS: usize = 256;

/// Brings the pairs up to date.
pub(crate) fn pair(pairs: &mut Pairs, bodies: &Bodies, index: &Index, moved: &[bool]) {
    let mut found: Vec<u64> = (0..moved.len())
        .into_par_iter()
        .with_min_len(ROWS)
        .filter(|&row| moved[row] && bodies.is_mover(row))
        .fold(Vec::new, |mut keys, row| {
            search(row, bodies, index, moved, &mut keys);
            keys
        })
        .reduce(Vec::new, |mut all, mut some| {
            if all.len() < some.len() {
                std::mem::swap(&mut all, &mut some);
            }
            all.append(&mut some);
            all
        });
    let static_moved = (0..moved.len()).any(|row| moved[row] && !bodies.is_mover(row));
    if found.is_empty() && !moved.contains(&true) && !static_moved {
        return;
    }
    found.par_sort_unstable();

    // Old and new pairs are merged independently for each run of rows of body a.
    let merged: Vec<(Vec<u64>, Vec<u32>)> = (0..moved.len().div_ceil(ROWS))
        .into_par_iter()
        .map(|run| {
            let range = |keys: &[u64]| {
                let start = (run * ROWS) as u64;
                let at = |row: u64| keys.partition_point(|&key| key >> 32 < row);
                at(start)..at(start + ROWS as u64)
            };
            let (old, new) = (range(&pairs.keys), range(&found));
            merge(&pairs.keys[old.clone()], &pairs.befores[old], &found[new], moved)
        })
        .collect();
    let total = merged.iter().map(|(keys, _)| keys.len()).sum();
    pairs.keys.clear();
    pairs.befores.clear();
    make_room(&mut pairs.keys, total);
    make_room(&mut pairs.befores, total);
    for (keys, befores) in merged {
        pairs.keys.extend(keys);
        pairs.befores.extend(befores);
    }
}

/// Keys of the pairs of a body that has a new box. Of two such bodies the one in the lower row reports the pair.
fn search(row: usize, bodies: &Bodies, index: &Index, moved: &[bool], keys: &mut Vec<u64>) {
    let dynamic = |row: usize| bodies.kinds[row] == Kind::Dynamic;
    let meets = |other: usize| {
        let ([group, mask], [others, other_mask]) = (bodies.filters[row], bodies.filters[other]);
        group & other_mask != 0 && others & mask != 0 && bodies.states[other] != State::Dead
    };
    index.movers.query(&bodies.boxes[row], |other| {
        let other = other as usize;
        if other == row || (moved[other] && other < row) || !meets(other) {
            return;
        }
        let (a, b) = match (dynamic(row), dynamic(other)) {
            (true, true) if bodies.ids[row] < bodies.ids[other] => (row, other as u32),
            (true, true) => (other, row as u32),
            (true, false) => (row, other as u32 | FIXED),
            (false, true) => (other, row as u32 | FIXED),
            (false, false) => return,
        };
        keys.push((a as u64) << 32 | u64::from(b));
    });
    if dynamic(row) {
        index.fixed.query(&bodies.boxes[row], |other| {
            if meets(other as usize) {
                keys.push((row as u64) << 32 | u64::from(other | FIXED));
            }
        });
    }
}

/// The old pairs of which neither body has a new box, and the ones that were found.
fn merge(old: &[u64], befores: &[u32], found: &[u64], moved: &[bool]) -> (Vec<u64>, Vec<u32>) {
    let room = old.len() + found.len();
    let (mut keys, mut numbers) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let mut found = found.iter().copied().peekable();
    for (&key, &before) in old.iter().zip(befores) {
        while let Some(new) = found.next_if(|&new| new < key) {
            keys.push(new);
            numbers.push(NEW);
        }
        let (a, b) = rows(key);
        let again = found.next_if_eq(&key).is_some();
        if again || !(moved[a as usize] || moved[row_of(b)]) {
            keys.push(key);
            numbers.push(before);
        }
    }
    for new in found {
        keys.push(new);
        numbers.push(NEW);
    }
    (keys, numbers)
}
