//! Stage 4, **pair**: which bodies are near each other.
//!
//! Reads the trees and who has a new box; writes the keys of every run of pairs. Pairs of which neither body has a new box
//! are kept; those of the others are found again by a query each. Nothing is said about pairs that ended: they are the ones
//! that were not found.

use crate::Kind;
use crate::bodies::{Bodies, State};
use crate::index::Index;
use crate::touches::{NEW, Run, Touches, rows};
use rayon::prelude::*;
use rockfall_math::room::make_room;
use rockfall_math::share::{Share, ShareSort, is_alone};
use rockfall_solve::{FIXED, row_of};

/// Rows that one thread searches at a time, at least.
const ROWS: usize = 256;

/// Pieces into which the rows of a large world are cut: enough to share, and what each finds is so much that the allocator gives its room
/// back to the system.
const PIECES: usize = 256;

/// A body so many times as large as others are on the average may have more neighbours than one thread should look for.
const LARGE: f32 = 16.0;

/// Brings the pairs up to date.
pub(crate) fn pair(touches: &mut Touches, bodies: &Bodies, index: &Index, moved: &[bool]) {
    if !moved.contains(&true) {
        return;
    }
    let size = rows_at_once(moved.len());
    let large = LARGE * mean_radius(bodies);
    let searched: Vec<Vec<u64>> = moved
        .par_chunks(size)
        .enumerate()
        .shared()
        .map(|(chunk, moved_here)| {
            let mut keys = Vec::new();
            for (i, _) in moved_here.iter().enumerate().filter(|(_, moved)| **moved) {
                let row = chunk * size + i;
                if bodies.is_mover(row) {
                    search(row, bodies, index, moved, bodies.radii[row] > large, &mut keys);
                }
            }
            keys
        })
        .collect();
    let mut found: Vec<u64> = Vec::with_capacity(searched.iter().map(Vec::len).sum());
    searched.into_iter().for_each(|keys| found.extend(keys));
    found.sort_shared();

    if touches.runs.is_empty() {
        touches.runs.push(Run::empty());
    }
    // A run takes what was found from its first key up to the first of the next.
    let first = |run: &Run| run.keys.first().copied().unwrap_or(0);
    let starts: Vec<usize> =
        touches.runs.iter().skip(1).map(|run| found.partition_point(|&key| key < first(run))).collect();
    let from = |i: usize| if i == 0 { 0 } else { starts[i - 1] };
    let to = |i: usize| starts.get(i).copied().unwrap_or(found.len());
    let runs = touches.runs.par_iter_mut().enumerate().shared();
    runs.for_each(|(i, run)| merge(run, &found[from(i)..to(i)], moved));
    drop(found);
    touches.balance();
}

/// Rows in a piece. Results don't depend on it.
fn rows_at_once(rows: usize) -> usize {
    (rows / PIECES).max(ROWS)
}

/// Mean radius of the bodies that move, infinite planes aside, metres.
fn mean_radius(bodies: &Bodies) -> f32 {
    let counts = |row: &usize| bodies.is_mover(*row) && bodies.radii[*row].is_finite();
    let movers = (0..bodies.rows()).into_par_iter().with_min_len(4096).shared().filter(counts);
    // Whole micrometres, so that the sum does not depend on the threads.
    let micrometres = |row: usize| (1e6 * bodies.radii[row]) as u64;
    let sum = |(sum, count): (u64, u64), row: usize| (sum.saturating_add(micrometres(row)), count + 1);
    let (sum, count) = movers
        .fold(|| (0, 0), sum)
        .reduce(|| (0, 0), |(sum, n), (more, m)| (sum.saturating_add(more), n + m));
    1e-6 * (sum as f64 / count.max(1) as f64) as f32
}

/// Keys of the pairs of a body that has a new box; `large` where it may have so many that all threads should look for them. Of two such bodies the one in the lower
/// row reports the pair.
fn search(row: usize, bodies: &Bodies, index: &Index, moved: &[bool], large: bool, keys: &mut Vec<u64>) {
    let dynamic = |row: usize| bodies.kinds[row] == Kind::Dynamic;
    let meets = |other: usize| {
        let ([group, mask], [others, other_mask]) = (bodies.filters[row], bodies.filters[other]);
        group & other_mask != 0 && others & mask != 0 && bodies.states[other] != State::Dead
    };
    let of_mover = |other: u32| {
        let other = other as usize;
        if other == row || (moved[other] && other < row) || !meets(other) {
            return None;
        }
        let (a, b) = match (dynamic(row), dynamic(other)) {
            (true, true) if bodies.ids[row] < bodies.ids[other] => (row, other as u32),
            (true, true) => (other, row as u32),
            (true, false) => (row, other as u32 | FIXED),
            (false, true) => (other, row as u32 | FIXED),
            (false, false) => return None,
        };
        Some((a as u64) << 32 | u64::from(b))
    };
    let of_fixed =
        |other: u32| meets(other as usize).then_some((row as u64) << 32 | u64::from(other | FIXED));
    let area = &bodies.boxes[row];
    if large && !is_alone() && index.movers.is_wide(area) {
        keys.par_extend(index.movers.par_query(area).filter_map(of_mover));
    } else {
        index.movers.query(area, |other| keys.extend(of_mover(other)));
    }
    if !dynamic(row) {
        return;
    }
    if large && !is_alone() && index.fixed.is_wide(area) {
        keys.par_extend(index.fixed.par_query(area).filter_map(of_fixed));
    } else {
        index.fixed.query(area, |other| keys.extend(of_fixed(other)));
    }
}

/// Keeps the pairs of which neither body has a new box, and takes in the ones that were found.
fn merge(run: &mut Run, found: &[u64], moved: &[bool]) {
    let stays = |key: u64| {
        let (a, b) = rows(key);
        !(moved[a as usize] || moved[row_of(b)])
    };
    if found.is_empty() && run.keys.iter().all(|&key| stays(key)) {
        return;
    }
    let room = run.keys.len() + found.len();
    let (mut keys, mut befores) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let mut found = found.iter().copied().peekable();
    for (&key, before) in run.keys.iter().zip(0..) {
        while let Some(new) = found.next_if(|&new| new < key) {
            keys.push(new);
            befores.push(NEW);
        }
        let again = found.next_if_eq(&key).is_some();
        if again || stays(key) {
            keys.push(key);
            befores.push(before);
        }
    }
    for new in found {
        keys.push(new);
        befores.push(NEW);
    }
    let len = keys.len();
    make_room(&mut keys, len);
    (run.keys, run.befores) = (keys, befores);
}
