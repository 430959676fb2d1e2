//! What happens to each body between two sweeps: [`crate::push`] or [`crate::drift`].
//!
//! Rows that a sweep is about to read are advanced by it, tile by tile, while they are on their way into the cache: eight passes over all
//! bodies in a step of four sub-steps would cost a third of the solver's memory traffic.

use crate::line::{Columns, Drift, Line, Role};
use rayon::prelude::*;
use rockfall_math::lanes::Row;
use rockfall_math::share::Share;
use rockfall_math::{Quat, Vec3};

/// Rows that one thread takes at a time.
const ROWS: usize = 512;

/// A body, as far as it is its own business; see [`Columns`] for what the fields are.
#[derive(Debug)]
#[allow(missing_docs)]
pub struct Body<'a> {
    pub line: &'a mut Line,
    pub drift: &'a mut Drift,
    pub reference: &'a mut Row,
    pub rotation: &'a mut Quat,
    pub start: &'a Quat,
    pub frame: &'a Quat,
    pub inverse_moments: &'a Vec3,
    pub damping: &'a [f32; 2],
    pub role: Role,
    pub locks: u8,
}

/// A change of every body by itself.
pub trait Advance: Sync {
    /// Whether nothing changes.
    const IDLE: bool = false;

    /// Changes a body.
    fn advance(&self, body: Body<'_>);
}

/// No change.
#[derive(Clone, Copy, Debug)]
pub struct Stay;

impl Advance for Stay {
    const IDLE: bool = true;

    fn advance(&self, _: Body<'_>) {}
}

/// Changes all bodies.
pub(crate) fn advance<A: Advance>(columns: &mut Columns<'_>, change: &A) {
    if A::IDLE {
        return;
    }
    let Columns { lines, drifts, references, rotations, starts, frames, inverse_moments, .. } = columns;
    (
        &mut **lines,
        &mut **drifts,
        &mut **references,
        &mut **rotations,
        (*starts, *frames, *inverse_moments),
        columns.dampings,
        columns.roles,
        columns.locks,
    )
        .into_par_iter()
        .with_min_len(ROWS)
        .shared()
        .for_each(
            |(line, drift, reference, rotation, (start, frame, inverse_moments), damping, &role, &locks)| {
                change.advance(Body {
                    line,
                    drift,
                    reference,
                    rotation,
                    start,
                    frame,
                    inverse_moments,
                    damping,
                    role,
                    locks,
                })
            },
        );
}
