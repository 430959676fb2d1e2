//! Stage 8, **link**: islands of bodies that touch.
//!
//! Reads contacts; writes the root of each body's island. Used for sleep alone: a pile that is one huge island is still
//! solved by all threads.

use crate::bodies::Bodies;
use rockfall_solve::line::Role;
use rockfall_solve::{Contacts, FIXED, row_of};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Disjoint sets of rows. The root of a set is its smallest row, whatever the order in which sets were joined.
#[derive(Debug, Default)]
pub(crate) struct Islands {
    parents: Vec<AtomicU32>,
}

impl Islands {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.parents.capacity() * size_of::<AtomicU32>()
    }

    /// The smallest row of the island of `row`.
    pub(crate) fn root(&self, mut row: u32) -> u32 {
        loop {
            let parent = self.parents[row as usize].load(Relaxed);
            if parent == row {
                return row;
            }
            // Halve the path on the way; any ancestor is a valid parent.
            let above = self.parents[parent as usize].load(Relaxed);
            self.parents[row as usize].store(above, Relaxed);
            row = above;
        }
    }

    fn join(&self, a: u32, b: u32) {
        let (mut a, mut b) = (self.root(a), self.root(b));
        while a != b {
            let (low, high) = (a.min(b), a.max(b));
            // Only a root may get a parent; another thread may have given it one meanwhile.
            match self.parents[high as usize].compare_exchange(high, low, Relaxed, Relaxed) {
                Ok(_) => return,
                Err(_) => (a, b) = (self.root(low), self.root(high)),
            }
        }
    }
}

/// Joins bodies that touch. A body on which a moving kinematic body acts is not at rest.
pub(crate) fn link(islands: &mut Islands, bodies: &mut Bodies, contacts: &Contacts) {
    islands.parents.clear();
    islands.parents.extend((0..bodies.rows() as u32).map(AtomicU32::new));
    let sets = &*islands;
    let driven = |row: usize| {
        bodies.roles[row] == Role::Driven && bodies.lines[row].motion[..6].iter().any(|&x| x != 0.0)
    };
    let pushed = contacts.filter_rows(|a, b| {
        if b & FIXED != 0 {
            return driven(row_of(b)).then_some(a as usize);
        }
        sets.join(a, b);
        None
    });
    for row in pushed {
        bodies.rests[row] = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_the_smallest_row_in_any_order() {
        let joins = [(5, 9), (9, 3), (7, 8), (2, 7), (3, 4)];
        for rotation in 0..joins.len() {
            let islands = Islands { parents: (0..10).map(AtomicU32::new).collect() };
            for i in 0..joins.len() {
                let (a, b) = joins[(i + rotation) % joins.len()];
                islands.join(a, b);
            }
            let roots: Vec<u32> = (0..10).map(|row| islands.root(row)).collect();
            assert_eq!(roots, [0, 1, 2, 3, 3, 3, 6, 2, 2, 3]);
        }
    }
}
