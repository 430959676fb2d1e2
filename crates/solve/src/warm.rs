//! Stage 9, **warm**: the impulses of the last step, applied at once.
//!
//! Reads the impulses that [`crate::contacts`] took from memory; completes the blocks by what needs the bodies' inertia, which this
//! sweep has at hand; writes velocities. One sweep per step: the later
//! sub-steps start from the change of velocity that contacts made in the one before (see [`crate::push`]).

use crate::advance::Advance;
use crate::balls::warm_balls;
use crate::block::{Block, load, load3, tangents};
use crate::contacts::Contacts;
use crate::effective::complete;
use crate::line::Columns;
use crate::plan::Span;
use crate::sweep::{Beside, BodyLanes, Rows, Take, Visit, sweep};
use rockfall_math::lanes::{Lanes, Lanes3, Width};

/// Applies all accumulated impulses, after a change of every body.
pub fn warm(contacts: &mut Contacts, columns: &mut Columns<'_>, width: Width, change: &impl Advance) {
    sweep(contacts, columns, width, change, &Warm);
}

struct Warm;

impl Visit for Warm {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { cold, .. }: Beside<'_>,
        k: usize,
        span: &Span,
    ) {
        let one_sided = span.one_sided;
        let mut a = BodyLanes::gather(token, rows, &block.a, k, Take::Whole);
        let take = if one_sided { Take::Fixed } else { Take::Whole };
        let mut b = BodyLanes::gather(token, rows, &block.b, k, take);
        if P == 1 && span.is_of_plain_balls() {
            warm_balls(token, block, k, &mut a, &mut b);
            a.scatter(rows, &block.a, k);
            if !one_sided {
                b.scatter(rows, &block.b, k);
            }
            return;
        }
        complete(token, block, k, (&a, &b));
        let normal: Lanes3<L> = load3(token, &block.normal, k);
        let offset = load3(token, &block.offset, k);
        let (s, t) = tangents(token, normal);

        let friction = s.scale(load(token, &block.tangent_impulse[0], k))
            + t.scale(load(token, &block.tangent_impulse[1], k));
        let mut middle = Lanes3::splat(token, rockfall_math::Vec3::ZERO);
        for p in 0..P {
            let arm = load3(token, &block.arms[p], k);
            middle = middle + arm;
            let j = normal.scale(load(token, &block.impulses[p], k));
            a.push(-j, arm);
            b.push(j, arm - offset);
        }
        let middle = middle.scale(L::splat(token, 1.0 / P as f32));
        a.push(-friction, middle);
        b.push(friction, middle - offset);

        for twist in &block.twist_impulse {
            let j = normal.scale(load(token, twist, k));
            a.turn(-j);
            b.turn(j);
        }
        if let Some(cold) = cold {
            let j =
                load3(token, &cold.rolling_impulse, k) + normal.scale(load(token, &cold.twist_impulse, k));
            a.turn(-j);
            b.turn(j);
        }
        a.scatter(rows, &block.a, k);
        if !one_sided {
            b.scatter(rows, &block.b, k);
        }
    }
}
