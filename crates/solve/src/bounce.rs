//! Stage 10, **bounce**: restitution, once, after all sub-steps.
//!
//! Reads the approach velocities that [`crate::batch`] measured before the step and the largest impulses of the step; writes
//! impulses and velocities. A point bounces if it approached faster than a threshold and was pressed at any time.

use crate::batch::Batches;
use crate::block::{Block, Cold, load, load3, store};
use crate::line::Columns;
use crate::sweep::{BodyLanes, Rows, Visit, sweep};
use rockfall_math::disjoint::DisjointRows;
use rockfall_math::lanes::{Lanes, Lanes3, Width};

/// Gives every point that hit its share of the approach velocity back. `threshold` in m/s.
pub fn bounce(batches: &mut Batches, columns: &mut Columns<'_>, width: Width, threshold: f32) {
    if batches.colds.is_empty() {
        return;
    }
    let rows = Rows { lines: DisjointRows::new(columns.lines), drifts: DisjointRows::new(columns.drifts) };
    sweep(batches, &rows, width, &Bounce { threshold });
}

struct Bounce {
    threshold: f32,
}

impl Visit for Bounce {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        cold: Option<&mut Cold>,
        k: usize,
        one_sided: bool,
    ) {
        let Some(cold) = cold else { return };
        let mut a = BodyLanes::gather(token, rows, &block.a, k, true);
        let mut b = BodyLanes::gather(token, rows, &block.b, k, !one_sided);
        let normal: Lanes3<L> = load3(token, &block.normal, k);
        let offset: Lanes3<L> = load3(token, &block.offset, k);
        let zero = L::splat(token, 0.0);
        let restitution: L = load(token, &cold.restitution, k);
        for p in 0..P {
            let arm_a = load3(token, &block.arms[p], k);
            let arm_b = arm_a - offset;
            let approach: L = load(token, &cold.approach[p], k);
            let peak: L = load(token, &cold.peak[p], k);
            let speed = normal.dot(b.at(arm_b) - a.at(arm_a));
            let mass: L = load(token, &block.masses[p], k);
            let old: L = load(token, &block.impulses[p], k);
            let rebound = (old - mass * (speed + restitution * approach)).max(zero);
            let hit = approach.lt(L::splat(token, -self.threshold));
            let new = L::select(hit, L::select(zero.lt(peak), rebound, old), old);
            let new = L::select(zero.lt(restitution), new, old);
            store(new, &mut block.impulses[p], k);
            let j = normal.scale(new - old);
            a.push(-j, arm_a);
            b.push(j, arm_b);
        }
        a.scatter(rows, &block.a, k);
        if !one_sided {
            b.scatter(rows, &block.b, k);
        }
    }
}
