//! Stage 10, **bounce**: restitution, once a step, after all sub-steps.
//!
//! Reads the approach velocities that [`crate::contacts`] measured before the step and the largest impulses of the step; writes
//! impulses and velocities. A point bounces if it approached faster than a threshold and was pressed at any time. Its share
//! of normal impulse allows friction its share too: over fall and rebound together Coulomb's bound is μ (1 + e) m v.
//!
//! Where one that bounces touches others, what one contact gives another one takes away, so the sweep is repeated, where
//! [`Plan::bounces`] allows it, until little changes. Newton's law for all contacts at once, v⁺ ≥ −e v⁻ where none pulls and each
//! that presses has equality, keeps the energy
//! for e = 1 whoever touches whom: it changes by ½ Σ λ (v⁺ + v⁻) = 0. So from the second sweep on points take part that were pressed and
//! did not hit: what parted at v⁻ > 0 may close at e v⁻, to bounce in the next step.
//!
//! Under a constant acceleration a, ½ w² − a s is conserved exactly, with the speed w and the gap s. A point that approaches at w₀ with a
//! gap of s₀ hits at −√(w₀² − 2 a s₀), rebounds with e times that, and has √(w² + 2 a s) left where the step leaves it, s from the
//! surface. So a perfectly elastic ball neither gains nor loses height, whatever the step and wherever in it the ball hits.
//! Semi-implicit Euler steps of h are the leapfrog scheme whose velocities run half a sub-step ahead: with it, w = v + ½ a h, and the
//! velocity is taken ahead again in the end.

use crate::advance::Stay;
use crate::block::{Block, load, load3, store};
use crate::contacts::Contacts;
use crate::drift::Integrator;
use crate::iterate::{Place, rub};
use crate::line::Columns;
use crate::plan::Span;
use crate::respond::Plan;
use crate::sweep::{Beside, BodyLanes, Rows, Take, Visit, sweep};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Lanes3, Width};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Rounds over the points of a manifold.
const ROUNDS: usize = 4;

/// Velocities that change by less in a sweep are done: a share of the threshold, and no less than this, m/s.
const CALM: (f32, f32) = (0.05, 1e-3);

/// The latter where nothing but these velocities decides what becomes of the energy.
const CALM_RETRACED: f32 = 1e-4;

/// Gives every point that hit its share of the approach velocity back. Where it is `retraced`, what is perfectly elastic stays where it is
/// while it bounces (`retrace.rs`), and has its own speed back.
pub fn bounce(contacts: &mut Contacts, columns: &mut Columns<'_>, width: Width, plan: &Plan, retraced: bool) {
    if contacts.colds.is_empty() {
        return;
    }
    let ahead = match plan.integrator {
        Integrator::SemiImplicit => 0.5 * plan.h(),
        Integrator::SecondOrder => 0.0,
    };
    let threshold = plan.restitution_threshold;
    let calm = if retraced { CALM_RETRACED } else { CALM.1 };
    let calm = calm.max(CALM.0 * threshold);
    let mut visit = Bounce {
        threshold,
        gravity: plan.gravity,
        ahead,
        calm,
        retraced,
        all: false,
        stirred: AtomicBool::new(false),
    };
    for _ in 0..plan.bounces {
        sweep(contacts, columns, width, &Stay, &visit);
        if !std::mem::take(visit.stirred.get_mut()) {
            break;
        }
        visit.all = true;
    }
}

struct Bounce {
    /// m/s.
    threshold: f32,
    /// m/s².
    gravity: Vec3,
    /// Time by which velocities are ahead of places, s.
    ahead: f32,
    /// Changes up to this don't count, m/s.
    calm: f32,
    /// Whether what is perfectly elastic stays where it is.
    retraced: bool,
    /// Whether points take part that did not hit.
    all: bool,
    /// Whether a change counted.
    stirred: AtomicBool,
}

impl Visit for Bounce {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { cold, .. }: Beside<'_>,
        k: usize,
        &Span { one_sided, .. }: &Span,
    ) {
        let Some(cold) = cold else { return };
        let mut a = BodyLanes::gather(token, rows, &block.a, k, Take::Whole);
        let take = if one_sided { Take::Fixed } else { Take::Whole };
        let mut b = BodyLanes::gather(token, rows, &block.b, k, take);
        let zero = L::splat(token, 0.0);
        let place = Place::new(token, rows, block, k, one_sided);
        let Place { normal, offset, gap, turns: [ta, tb] } = place;
        let restitution: L = load(token, &cold.restitution, k);
        // Relative acceleration along the normal of two bodies in free flight.
        let pull = normal.dot(Lanes3::splat(token, self.gravity)) * (b.gravity_scale - a.gravity_scale);
        let pull =
            if self.retraced { L::select(restitution.lt(L::splat(token, 1.0)), pull, zero) } else { pull };
        let ahead = pull * L::splat(token, self.ahead);
        let mut middle = Lanes3::splat(token, Vec3::ZERO);
        let mut pressed = zero;
        // One point after the other turns a body that falls flat; a few rounds level it.
        for p in (0..if P > 1 { ROUNDS } else { 1 }).flat_map(|_| 0..P) {
            let arm_a = load3(token, &block.arms[p], k);
            let arm_b = arm_a - offset;
            let approach: L = load(token, &cold.approach[p], k);
            let peak: L = load(token, &cold.peak[p], k);
            let speed = normal.dot(b.at(arm_b) - a.at(arm_a));
            let mass: L = load(token, &block.masses[p], k);
            let old: L = load(token, &block.impulses[p], k);
            let start = approach + ahead;
            let distance: L = load(token, &block.distances[p], k);
            let hit_squared = (start * start - (pull + pull) * distance).max(zero);
            let (lever_a, lever_b) = (arm_a.cross(normal), arm_b.cross(normal));
            let distance = distance + (gap + (lever_b.dot(tb) - lever_a.dot(ta)));
            let leave_squared = restitution * restitution * hit_squared + (pull + pull) * distance;
            let rebound = leave_squared.max(zero).sqrt() - ahead;
            let rebound = (old - mass * (speed - rebound)).max(zero);
            let still = if self.all {
                let closing = (restitution * approach).max(zero);
                (old - mass * (speed + closing)).max(zero)
            } else {
                old
            };
            let hit = approach.lt(L::splat(token, -self.threshold));
            let new = L::select(zero.lt(peak), L::select(hit, rebound, still), old);
            let new = L::select(zero.lt(restitution), new, old);
            let change = (new - old).max(old - new);
            if L::bits((mass * L::splat(token, self.calm)).lt(change)) != 0 {
                self.stirred.store(true, Relaxed);
            }
            store(new, &mut block.impulses[p], k);
            let j = normal.scale(new - old);
            a.push(-j, arm_a);
            b.push(j, arm_b);
        }
        for p in 0..P {
            middle = middle + load3(token, &block.arms[p], k);
            pressed = pressed + load(token, &block.impulses[p], k);
        }
        let middle = middle.scale(L::splat(token, 1.0 / P as f32));
        rub(token, block, k, &mut a, &mut b, &place, middle, pressed);
        a.scatter(rows, &block.a, k);
        if !one_sided {
            b.scatter(rows, &block.b, k);
        }
    }
}
