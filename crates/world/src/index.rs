//! Stage 3, **index**: boxes to trees.
//!
//! Reads the boxes and who has a new one; writes two trees, one over the bodies that move, one over those that never do.

use crate::bodies::Bodies;
use rayon::prelude::*;
use rockfall_math::Aabb;
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
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.movers.memory() + self.fixed.memory()
    }
}

/// Brings the trees up to date; `rebuild` after rows have moved or come.
pub(crate) fn index(index: &mut Index, bodies: &Bodies, moved: &[bool], rebuild: bool) {
    let area = |row: usize, mover: bool| {
        if bodies.is_mover(row) == mover { bodies.boxes[row] } else { Aabb::EMPTY }
    };
    let boxes = |mover: bool| -> Vec<Aabb> {
        (0..bodies.rows()).into_par_iter().with_min_len(1024).map(|row| area(row, mover)).collect()
    };
    let renewed = moved.par_iter().with_min_len(4096).filter(|&&m| m).count();
    index.worn += renewed;
    if rebuild {
        index.fixed = Tree::build(&boxes(false));
    }
    // A refit tree answers the same queries, more slowly the further its items have gone.
    if rebuild || index.worn > bodies.rows() {
        index.movers = Tree::build(&boxes(true));
        index.worn = 0;
    } else if renewed > 0 {
        index.movers.refit_moved(moved, |row| area(row, true));
    }
}
