//! Stage 3, **index**: boxes to trees.
//!
//! Reads the boxes and who has a new one; writes two trees, one over the bodies that move, one over those that never do.

use crate::bodies::Bodies;
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_tree::Tree;

/// The broad phase of a world. Items of both trees are rows.
#[derive(Debug, Default)]
pub(crate) struct Index {
    /// Dynamic and kinematic bodies.
    pub(crate) movers: Tree,
    /// Static bodies.
    pub(crate) fixed: Tree,
    /// Boxes renewed since the movers' tree was built.
    worn: usize,
}

impl Index {
    /// Trees over the first so many rows, whose boxes are up to date.
    pub(crate) fn new(bodies: &Bodies, rows: usize) -> Self {
        Index { movers: tree(bodies, rows, true), fixed: tree(bodies, rows, false), worn: 0 }
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.movers.memory() + self.fixed.memory()
    }
}

/// What became of the rows since the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Turnover {
    /// Rows at the end are new.
    pub(crate) fresh: usize,
    /// Any row may be another one's now, or a body that never moves has come or was put somewhere else: all boxes and both trees are made anew.
    pub(crate) all: bool,
}

/// Brings the trees up to date.
pub(crate) fn index(index: &mut Index, bodies: &Bodies, moved: &[bool], turnover: Turnover) {
    let renewed = moved.par_iter().with_min_len(4096).shared().filter(|&&m| m).count();
    index.worn += renewed;
    if turnover.all {
        index.fixed = tree(bodies, bodies.rows(), false);
    }
    // A refit tree answers the same queries, more slowly the further its items have gone.
    if turnover.all || turnover.fresh > 0 || index.worn > index.movers.len() {
        index.movers = tree(bodies, bodies.rows(), true);
        index.worn = 0;
    } else if renewed > 0 {
        index.movers.refit_moved(moved, |row| bodies.boxes[row]);
    }
}

/// A tree over those of the first so many rows that can move, or over the others.
fn tree(bodies: &Bodies, rows: usize, movers: bool) -> Tree {
    let rows = (1..rows as u32).into_par_iter().shared();
    let items: Vec<u32> = rows.filter(|&row| bodies.is_mover(row as usize) == movers).collect();
    Tree::build_some(&items, |row| bodies.boxes[row])
}
