//! Stage 1, **apply**: bodies that were added or removed since the last step take their places.
//!
//! Reads states and ids; writes all columns, the keys of all pairs, and the order of contacts. Rows are in a canonical order, so that nothing
//! depends on the order of the user's calls: new rows stand behind the old ones by id, and every [`SORT_EVERY`] steps, if they are disordered,
//! all rows are sorted along the Hilbert curve, the immobile ones last: neighbours in space are neighbours in memory.

use crate::bodies::{Bodies, State};
use crate::index::Turnover;
use crate::touches::{Touches, rows};
use rayon::prelude::*;
use rockfall_math::Aabb;
use rockfall_math::room::give_back;
use rockfall_math::share::{Share, ShareSort};
use rockfall_solve::{Contacts, Desk, row_of};
use rockfall_tree::{hilbert, morton::Grid};
use std::collections::BTreeSet;

/// Steps between two sorts of all rows. 64 keeps a flowing pile sorted at under 1 % of the time.
const SORT_EVERY: u64 = 64;

/// Rows are sorted when more than one in so many lies before the one in front of it: in a pile that has come to rest a few neighbours trade
/// places, and are near each other still. Other numbers were not tried.
const DISORDER: usize = 32;

/// Brings the rows into order. `fresh` is the number of rows at the end that are new since the last step, `stirred` are the
/// rows that were put somewhere else; rows are cut into tiles from `tiles_from` movers on.
pub(crate) fn apply(
    bodies: &mut Bodies,
    touches: &mut Touches,
    contacts: &mut Contacts,
    fresh: usize,
    stirred: &BTreeSet<u32>,
    step: u64,
    tiles_from: usize,
) -> Turnover {
    let rows = bodies.rows();
    if !stirred.is_empty() {
        forget(bodies, touches, &contacts.desk(rows - fresh), stirred);
    }
    let dead = bodies.states.contains(&State::Dead);
    if dead || !stirred.is_empty() {
        wake_partners(bodies, touches, stirred);
    }
    let due = step.is_multiple_of(SORT_EVERY) || fresh > rows / 4;
    let keys = if due { curve(bodies) } else { Vec::new() };
    // Bodies that came stand by id until all rows are sorted: that must not depend on the order in which they were added.
    let sort = due && (fresh > 0 || dead || is_disordered(&keys));
    // What never moves is looked for by others, not the other way round.
    let fixed =
        (rows - fresh..rows).chain(stirred.iter().map(|&row| row as usize)).any(|row| !bodies.is_mover(row));
    // With bodies that came, whether a sort moves rows depends on the order in which they were added; nothing else may.
    let turnover = |all: bool| Turnover { fresh, all: all || fixed || dead || (sort && fresh > 0) };
    let sparse = due && contacts.is_sparse();
    if !sort && !sparse && !dead && fresh == 0 {
        return turnover(false);
    }
    let alive = |row: &u32| bodies.states[*row as usize] != State::Dead;
    let mut order: Vec<u32> = (0..rows as u32).into_par_iter().shared().filter(alive).collect();
    if sort {
        order[1..].sort_shared_by_key(|&row| (keys[row as usize], bodies.ids[row as usize]));
    } else {
        let old = order.partition_point(|&row| (row as usize) < rows - fresh);
        order[old..].sort_unstable_by_key(|&row| bodies.ids[row as usize]);
    }
    // Decided when all rows are sorted, whether or not a row moves: it must not depend on the order in which bodies were added.
    let movers = order.par_iter().shared().filter(|row| bodies.is_mover(**row as usize)).count();
    let tiled = if sort { movers >= tiles_from } else { contacts.is_tiled() };
    let sorted =
        order.len() == rows && order.par_iter().enumerate().shared().all(|(i, &row)| i == row as usize);
    if sorted {
        let split = fresh > 0 && contacts.split_bodies() > 0;
        if tiled != contacts.is_tiled() || split || sparse {
            let lanes = contacts.sort(touches.entries(), tiled, rows, &order);
            touches.relocate(&lanes);
        }
        return turnover(false);
    }
    bodies.reorder(&order);
    let mut new_rows = vec![u32::MAX; rows];
    for (new, &old) in order.iter().enumerate() {
        new_rows[old as usize] = new as u32;
    }
    let entries = touches.rename(&new_rows, sort);
    let lanes = contacts.sort(entries, tiled, bodies.rows(), &new_rows);
    touches.relocate(&lanes);
    if sort {
        give_back();
    }
    // Otherwise only rows that are new have changed places.
    turnover(sort)
}

/// Place of every row along the curve; immobile bodies behind all others.
fn curve(bodies: &Bodies) -> Vec<(bool, u64)> {
    let bounds = (1..bodies.rows())
        .into_par_iter()
        .with_min_len(4096)
        .shared()
        .filter(|&row| bodies.is_mover(row))
        .map(|row| Aabb::around(bodies.positions[row], bodies.positions[row]))
        .reduce(|| Aabb::EMPTY, |a, b| a.union(&b));
    let grid = Grid::new(&bounds);
    (0..bodies.rows())
        .into_par_iter()
        .shared()
        .map(|row| (!bodies.is_mover(row), hilbert(grid.morton(bodies.positions[row].as_vec3()))))
        .collect()
}

/// Whether many rows do not stand in order. `keys` are their places along the curve, that of the world first.
fn is_disordered(keys: &[(bool, u64)]) -> bool {
    let before = |pair: &&[(bool, u64)]| pair[1] < pair[0];
    keys[1..].par_windows(2).with_min_len(4096).shared().filter(before).count() > keys.len() / DISORDER
}

/// What pairs know of a body that was put somewhere else is true no more.
fn forget(bodies: &Bodies, touches: &mut Touches, desk: &Desk<'_>, stirred: &BTreeSet<u32>) {
    touches.runs.par_iter_mut().shared().for_each(|run| {
        for (i, &key) in run.keys.iter().enumerate() {
            let (a, b) = (rows(key).0, row_of(rows(key).1) as u32);
            if stirred.contains(&a) || stirred.contains(&b) {
                let count = bodies.ways[a as usize].wrapping_add(bodies.ways[b as usize]);
                run.recalls[i].set(count, 0.0);
                run.lanes[run.contacts(i as u32)].iter().for_each(|&lane| desk.unleash(lane));
            }
        }
    });
}

/// What rested on a body that is gone, or somewhere else now, rests no more.
fn wake_partners(bodies: &mut Bodies, touches: &Touches, stirred: &BTreeSet<u32>) {
    let mut left: Vec<bool> = bodies.states.iter().map(|&state| state == State::Dead).collect();
    for &row in stirred {
        left[row as usize] = true;
    }
    for key in touches.keys() {
        let (a, b) = rows(key);
        let (a, b) = (a as usize, row_of(b));
        for (row, other) in [(a, b), (b, a)] {
            if left[other] && bodies.states[row] == State::Asleep {
                bodies.states[row] = State::Awake;
                bodies.rests[row] = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_neighbours_that_trade_places_are_no_disorder() {
        let mut keys: Vec<(bool, u64)> = (0..1000).map(|i| (i >= 900, i)).collect();
        // The world's place says nothing.
        keys[0] = (true, u64::MAX);
        assert!(!is_disordered(&keys));
        (1..20).for_each(|i| keys.swap(40 * i, 40 * i + 1));
        assert!(!is_disordered(&keys));
        (1..20).for_each(|i| keys.swap(40 * i + 20, 40 * i + 21));
        assert!(is_disordered(&keys));
    }
}
