//! Stage 7, **prepare**: what bouncing, rolling and twisting contacts need to know of their bodies before a step.
//!
//! Reads velocities and inertia; writes approach velocities, effective moments, and empty peaks into the cold halves.

use crate::block::{Block, Cold, LANES, get3};
use crate::contacts::Contacts;
use crate::line::Line;
use crate::plan::cold_of;
use crate::shelf::Shelf;
use rayon::prelude::*;
use rockfall_math::Mat3;
use rockfall_math::disjoint::DisjointRows;
use rockfall_math::share::Share;

impl Contacts {
    /// Fills in what follows from the bodies' state in all cold halves.
    pub(crate) fn refresh(&mut self, lines: &[Line]) {
        if self.colds.is_empty() {
            return;
        }
        let colds = DisjointRows::new(&mut self.colds);
        let line = |row: u32| self.copies.line(row, lines);
        shelf(&self.ball, &colds, &line);
        shelf(&self.one, &colds, &line);
        shelf(&self.two, &colds, &line);
        shelf(&self.four, &colds, &line);
    }
}

fn shelf<const P: usize, const T: usize>(
    shelf: &Shelf<P, T>,
    colds: &DisjointRows<'_, Cold>,
    line: &(impl Fn(u32) -> Line + Sync),
) {
    shelf.blocks.par_iter().enumerate().with_min_len(16).shared().for_each(|(i, block)| {
        if let Some(cold) = cold_of(&shelf.colds, i).filter(|_| !shelf.keys[i].is_parked()) {
            // SAFETY: every cold half belongs to one block.
            let cold = unsafe { colds.row(cold) };
            (0..LANES).filter(|&lane| block.a[lane] != 0).for_each(|lane| refresh(block, cold, lane, line));
        }
    });
}

fn refresh<const P: usize, const T: usize>(
    block: &Block<P, T>,
    cold: &mut Cold,
    lane: usize,
    line: &impl Fn(u32) -> Line,
) {
    let [a, b] = [block.a[lane], block.b[lane]].map(line);
    let (n, offset) = (get3(&block.normal, lane), get3(&block.offset, lane));
    for p in 0..P {
        let arm = get3(&block.arms[p], lane);
        let v_a = a.velocity() + a.angular_velocity().cross(arm);
        let v_b = b.velocity() + b.angular_velocity().cross(arm - offset);
        cold.approach[p][lane] = n.dot(v_b - v_a);
        cold.peak[p][lane] = 0.0;
    }
    let compliance = a.inverse_inertia() + b.inverse_inertia();
    if cold.rolling_limit[lane] > 0.0 {
        let mass = if compliance.determinant() > 0.0 { compliance.inverse() } else { Mat3::ZERO };
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = mass;
        for (column, value) in cold.rolling_mass.iter_mut().zip([x.x, x.y, x.z, y.y, y.z, z.z]) {
            column[lane] = value;
        }
    }
    if T == 0 && cold.twist_limit[lane] > 0.0 {
        let compliance = n.dot(compliance * n);
        cold.twist_mass[lane] = if compliance > 0.0 { 1.0 / compliance } else { 0.0 };
    }
}
