//! Stage 10, **retrace**: what bounced elastically moves by the mean of its velocities before and after.
//!
//! Reads velocities at both ends of the step, and which contacts pressed; writes drift and rotations. Contacts stop what would go through them,
//! and bodies drift by what stopped them; restitution turns velocities when that is done. So in the step of a bounce places follow from
//! velocities that nobody keeps. Of one ball that is made up for where it bounces ([`crate::bounce`]), of many at once it is not: a column that
//! meets the ground sinks by other ways than its velocities tell, and its weight does work.
//!
//! Over a step of T impulses λ change the velocities v⁰ to v⁺, m (v⁺ − v⁰) = m g T + Σ λ, and the energy by
//!
//!   m (v⁺ − v⁰) · ½ (v⁺ + v⁰) − m g · Δx = Σ λ · ½ (v⁺ + v⁰) where Δx = ½ (v⁰ + v⁺) T.
//!
//! That is zero whoever touches whom, as each contact parts at the speed at which it closed: the way of the second-order integrator in free
//! flight, ½ (v⁰ + v⁺) T, through a bounce. Two surfaces keep the gap that they had, and go apart in the next step.
//!
//! It is for perfectly elastic contacts, with the second-order integrator, more than one sweep of restitution, and no sub-steps. With e < 1 surfaces
//! would go on into each other, and no energy has to be kept; what is pressed by such a contact, or by one that is too slow to bounce,
//! stays where the contacts brought it. What a body does not touch it may run into, by as much as it was held back before: the speed times T. So
//! it is not for the long steps that sub-steps are for.

use crate::block::{Block, LANES};
use crate::contacts::Contacts;
use crate::drift::Integrator;
use crate::line::{Columns, Role};
use crate::plan::Span;
use crate::respond::Plan;
use crate::sweep::{Beside, Rows, Visit, over_all};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Row, Width};
use rockfall_math::rotation::{compose, from_rotation_vector, normalize};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Velocities before a step, where any contact is perfectly elastic.
pub(crate) struct Starts(Vec<Row>);

impl Starts {
    /// Before contacts and gravity change them.
    pub(crate) fn new(contacts: &Contacts, columns: &Columns<'_>, plan: &Plan) -> Option<Self> {
        let asked = plan.integrator == Integrator::SecondOrder && plan.bounces > 1 && plan.substeps == 1;
        let elastic = || contacts.colds.iter().any(|cold| cold.restitution.iter().any(|&e| e >= 1.0));
        (asked && elastic()).then(|| Starts(columns.lines.iter().map(|line| line.motion).collect()))
    }

    /// Moves those that no others than elastic contacts have pressed by the mean of their velocities.
    pub(crate) fn retrace(
        self,
        contacts: &mut Contacts,
        columns: &mut Columns<'_>,
        width: Width,
        plan: &Plan,
    ) {
        let rows = contacts.copies.rows().max(columns.lines.len());
        let marks =
            Marks { slow: plan.restitution_threshold, rows: (0..rows).map(|_| AtomicU8::new(0)).collect() };
        over_all(contacts, columns, width, &marks);
        let mut marks: Vec<u8> = marks.rows.into_iter().map(AtomicU8::into_inner).collect();
        for copy in columns.lines.len()..rows {
            let mark = marks[copy];
            marks[contacts.copies.body(copy as u32) as usize] |= mark;
        }
        for (row, start) in self.0.iter().enumerate() {
            let (now, reference) = (columns.lines[row].motion, &columns.references[row]);
            // What an old impulse pushed and let go again has lost its last bit, and with it the way of free flight.
            let let_go = marks[row] == 0 && now[..3] != reference[..3];
            if columns.roles[row] != Role::Free || !(let_go || marks[row] == ELASTIC) {
                continue;
            }
            let mean = |i: usize| 0.5 * plan.dt * (start[i] + now[i]);
            let (way, turn) = (Vec3::new(mean(0), mean(1), mean(2)), Vec3::new(mean(3), mean(4), mean(5)));
            let drift = &mut columns.drifts[row];
            if let_go {
                drift.set(way, drift.rotation());
                continue;
            }
            let more = turn - drift.rotation();
            drift.set(way, turn);
            let rotation = &mut columns.rotations[row];
            *rotation = normalize(compose(from_rotation_vector(more), *rotation));
        }
    }
}

/// A contact pressed that parts as it closed.
const ELASTIC: u8 = 1;
/// One that does not.
const OTHER: u8 = 2;

/// What pressed each body.
struct Marks {
    /// Contacts that close more slowly don't bounce, m/s.
    slow: f32,
    rows: Vec<AtomicU8>,
}

impl Visit for Marks {
    const LINES: bool = false;

    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        _: L::Token,
        _: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { cold, .. }: Beside<'_>,
        k: usize,
        &Span { one_sided, .. }: &Span,
    ) {
        for lane in (k..(k + L::WIDTH).min(LANES)).filter(|&lane| block.a[lane] != 0) {
            let mut mark = 0;
            for p in 0..P {
                let (peak, e, approach) = match cold.as_deref() {
                    Some(cold) => (cold.peak[p][lane], cold.restitution[lane], cold.approach[p][lane]),
                    None => (block.impulses[p][lane], 0.0, 0.0),
                };
                let elastic = e >= 1.0 && (approach < -self.slow || approach >= 0.0);
                if peak > 0.0 || block.impulses[p][lane] > 0.0 {
                    mark |= if elastic { ELASTIC } else { OTHER };
                }
            }
            if mark != 0 {
                self.rows[block.a[lane] as usize].fetch_or(mark, Relaxed);
                if !one_sided {
                    self.rows[block.b[lane] as usize].fetch_or(mark, Relaxed);
                }
            }
        }
    }
}
