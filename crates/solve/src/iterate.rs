//! Stage 9, **solve** and **relax**: one sweep of sequential impulses.
//!
//! Reads contacts and drift; writes impulses and velocities. For each manifold in turn: friction at the middle of its
//! points as a true cone, twist about the normal, rolling; and each point's normal impulse. With position correction the
//! sweep is *solve*, without it *relax*; contacts that have not closed yet (speculative ones) keep their gap in both.
//!
//! *Solve* begins with friction, whose bound is then the impulse that the last sub-step ended with; soft correction leaks
//! some of it. *Relax* brings that back and ends with friction, so that the velocities that are kept obey Coulomb's law with
//! equality: also in the sub-step of an impact, whose whole impulse comes in one sweep.
//!
//! The signed distance follows the drift to first order: s = s₀ + n · (Δp_b − Δp_a + Δθ_b × r_b − Δθ_a × r_a). For a ball
//! that rolls this is exact; an edge that turns by Δθ errs by r Δθ² / 2, on the side of more room.

use crate::advance::Advance;
use crate::balls::iterate_balls;
use crate::block::{Block, Cold, load, load3, store, tangents};
use crate::contacts::Contacts;
use crate::line::Columns;
use crate::plan::Span;
use crate::soft::{Softness, SubStep};
use crate::sweep::{Beside, BodyLanes, Rows, Symmetric, Take, Visit, gather_drift, sweep};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Lanes3, Width};

/// One sweep over all contacts, with position correction, after a change of every body.
pub fn solve(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    change: &impl Advance,
    step: &SubStep,
) {
    sweep(contacts, columns, width, change, &Iterate::<false> { step: *step });
}

/// One sweep over all contacts, without position correction, after a change of every body.
pub fn relax(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    change: &impl Advance,
    step: &SubStep,
) {
    sweep(contacts, columns, width, change, &Iterate::<true> { step: *step });
}

/// Two kernels, so that each has only what it needs.
struct Iterate<const RELAX: bool> {
    step: SubStep,
}

impl<const RELAX: bool> Visit for Iterate<RELAX> {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { mut cold, .. }: Beside<'_>,
        k: usize,
        span: &Span,
    ) {
        let (step, one_sided) = (&self.step, span.one_sided);
        let plain_balls = P == 1 && span.is_of_plain_balls();
        let take = if plain_balls { Take::Motion } else { Take::Whole };
        let mut a = BodyLanes::gather(token, rows, &block.a, k, take);
        let mut b = BodyLanes::gather(token, rows, &block.b, k, if one_sided { Take::Fixed } else { take });
        let bodies = (&mut a, &mut b);
        if plain_balls {
            iterate_balls::<L, P, T, RELAX>(token, step, rows, block, k, one_sided, bodies);
        } else {
            let place = Place::new(token, rows, block, k, one_sided);
            if !RELAX {
                let soon = if one_sided { place.after(token, step.h, &a, &b) } else { place };
                hold(token, block, cold.as_deref_mut(), k, &soon, (&mut a, &mut b));
            }
            let bodies = (&mut a, &mut b);
            press::<L, P, T, RELAX>(token, step, block, cold.as_deref_mut(), k, one_sided, &place, bodies);
            if RELAX {
                hold(token, block, cold, k, &place, (&mut a, &mut b));
            }
        }
        a.scatter(rows, &block.a, k);
        if !one_sided {
            b.scatter(rows, &block.b, k);
        }
    }
}

/// Where two bodies are.
#[derive(Clone, Copy)]
pub(crate) struct Place<L> {
    /// From a to b.
    pub(crate) normal: Lanes3<L>,
    /// Centre of mass of b seen from that of a, metres.
    pub(crate) offset: Lanes3<L>,
    /// By how much they have parted along the normal since the step began, their turns aside, metres.
    pub(crate) gap: L,
    /// How far a and b have turned since then, rad.
    pub(crate) turns: [Lanes3<L>; 2],
}

impl<L: Lanes> Place<L> {
    /// Of a contact now. It goes with the first of its bodies; so where that one is carried by a body that turns, the arm from the other's
    /// centre is the one that has moved. Between two bodies that contacts move either may be the smaller one, and both arms stay what they were.
    #[inline(always)]
    pub(crate) fn new<const P: usize, const T: usize>(
        token: L::Token,
        rows: &Rows<'_>,
        block: &Block<P, T>,
        k: usize,
        one_sided: bool,
    ) -> Self {
        let normal: Lanes3<L> = load3(token, &block.normal, k);
        let offset: Lanes3<L> = load3(token, &block.offset, k);
        let (way_a, turn_a) = gather_drift(token, rows, &block.a, k);
        let (way_b, turn_b) = gather_drift(token, rows, &block.b, k);
        let apart = way_b - way_a;
        let offset = if one_sided { offset + apart } else { offset };
        Place { normal, offset, gap: normal.dot(apart), turns: [turn_a, turn_b] }
    }

    /// `h` seconds later. *Solve* comes before bodies drift and *relax* after it: were each to rub where bodies are, one would take back in every
    /// sub-step what the other gave, and what relaxes last tips a box that a turntable carries.
    #[inline(always)]
    fn after(self, token: L::Token, h: f32, a: &BodyLanes<L>, b: &BodyLanes<L>) -> Self {
        Place { offset: self.offset + (b.v - a.v).scale(L::splat(token, h)), ..self }
    }
}

/// Friction at the middle of the points as a true cone, twist about the normal, rolling: as much of each as the normal
/// impulses allow.
#[inline(always)]
fn hold<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    cold: Option<&mut Cold>,
    k: usize,
    place: &Place<L>,
    (a, b): (&mut BodyLanes<L>, &mut BodyLanes<L>),
) {
    let zero = L::splat(token, 0.0);
    let normal = place.normal;
    let mut middle = Lanes3::splat(token, Vec3::ZERO);
    let mut pressed = zero;
    for p in 0..P {
        middle = middle + load3(token, &block.arms[p], k);
        pressed = pressed + load(token, &block.impulses[p], k);
    }
    let middle = middle.scale(L::splat(token, 1.0 / P as f32));

    rub(token, block, k, a, b, place, middle, pressed);
    for twist in 0..T {
        let mass = load(token, &block.twist_mass[twist], k);
        let limit = load::<L>(token, &block.twist_limit[twist], k) * pressed;
        let impulse = &mut block.twist_impulse[twist];
        let spin = Spin { mass, limit, normal };
        spin.resist(token, impulse, k, a, b);
    }
    if let Some(cold) = cold {
        roll(token, cold, k, a, b, normal, pressed);
        if T == 0 {
            let mass = load(token, &cold.twist_mass, k);
            let limit = load::<L>(token, &cold.twist_limit, k) * pressed;
            Spin { mass, limit, normal }.resist(token, &mut cold.twist_impulse, k, a, b);
        }
    }
}

/// Normal impulses, point by point.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn press<L: Lanes, const P: usize, const T: usize, const RELAX: bool>(
    token: L::Token,
    step: &SubStep,
    block: &mut Block<P, T>,
    mut cold: Option<&mut Cold>,
    k: usize,
    one_sided: bool,
    &Place { normal, offset, gap, turns: [ta, tb] }: &Place<L>,
    (a, b): (&mut BodyLanes<L>, &mut BodyLanes<L>),
) {
    for p in 0..P {
        let arm_a = load3(token, &block.arms[p], k);
        let arm_b = arm_a - offset;
        let lever_a = arm_a.cross(normal);
        let lever_b = arm_b.cross(normal);
        let distance = load::<L>(token, &block.distances[p], k) + (gap + (lever_b.dot(tb) - lever_a.dot(ta)));
        let speed = normal.dot(b.v - a.v) + (lever_b.dot(b.w) - lever_a.dot(a.w));
        let mass: L = load(token, &block.masses[p], k);
        let old: L = load(token, &block.impulses[p], k);
        let new = pressed::<L, RELAX>(token, step, one_sided, distance, speed, mass, old);
        store(new, &mut block.impulses[p], k);
        if let Some(cold) = cold.as_deref_mut() {
            let peak: L = load(token, &cold.peak[p], k);
            store(new.max(peak), &mut cold.peak[p], k);
        }

        let j = new - old;
        let along = normal.scale(j);
        a.v = a.v - along.scale(a.inverse_mass);
        a.w = a.w - a.inverse_inertia.times(lever_a).scale(j);
        if !one_sided {
            b.v = b.v + along.scale(b.inverse_mass);
            b.w = b.w + b.inverse_inertia.times(lever_b).scale(j);
        }
    }
}

/// The normal impulse of a point that had `old`, for its signed distance and the speed at which the bodies part there.
#[inline(always)]
pub(crate) fn pressed<L: Lanes, const RELAX: bool>(
    token: L::Token,
    step: &SubStep,
    one_sided: bool,
    distance: L,
    speed: L,
    mass: L,
    old: L,
) -> L {
    let zero = L::splat(token, 0.0);
    let new = if RELAX {
        let gap = distance.max(zero) * L::splat(token, 1.0 / step.h);
        old - mass * (speed + gap)
    } else {
        let soft = if one_sided { &step.one_sided } else { &step.two_sided };
        let (bias, mass_scale, leak) = correction(token, step, soft, distance);
        old - mass * mass_scale * (speed + bias) - leak * old
    };
    new.max(zero)
}

/// Velocity to add to the approach, factor on the mass, and leak of the impulse, for a signed distance.
///
/// A spring whose pull is cut off at the push speed would give way to any load beyond that: the leak of the impulse would
/// outweigh the correction, and a pile would sink into itself. So beyond the cut the leak shrinks as the overlap grows, and the
/// load that the contact carries at rest goes on growing with it.
#[inline(always)]
fn correction<L: Lanes>(token: L::Token, step: &SubStep, soft: &Softness, distance: L) -> (L, L, L) {
    let zero = L::splat(token, 0.0);
    let one = L::splat(token, 1.0);
    let open = zero.lt(distance);
    let fastest = L::splat(token, -step.push_speed);
    let push = distance * L::splat(token, soft.rate);
    let cut = push.lt(fastest);
    let kept = fastest / L::select(cut, push, fastest);
    let leak = L::splat(token, soft.impulse_scale) * kept;
    (
        L::select(open, distance * L::splat(token, 1.0 / step.h), push * kept),
        L::select(open, one, one - leak),
        L::select(open, zero, leak),
    )
}

/// Coulomb friction: the impulse that stops the middle of the points, shortened to the cone's radius.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn rub<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    k: usize,
    a: &mut BodyLanes<L>,
    b: &mut BodyLanes<L>,
    &Place { normal, offset, .. }: &Place<L>,
    middle: Lanes3<L>,
    pressed: L,
) {
    let arm_b = middle - offset;
    let (s, t) = tangents(token, normal);
    let slip = b.at(arm_b) - a.at(middle);
    let (slip_s, slip_t) = (s.dot(slip), t.dot(slip));
    let [m11, m12, m22] = [0, 1, 2].map(|i| load::<L>(token, &block.tangent_mass[i], k));
    let old_s: L = load(token, &block.tangent_impulse[0], k);
    let old_t: L = load(token, &block.tangent_impulse[1], k);
    let new_s = old_s - (m11 * slip_s + m12 * slip_t);
    let new_t = old_t - (m12 * slip_s + m22 * slip_t);
    let limit = load::<L>(token, &block.friction, k) * pressed;
    let scale = shorten(token, limit, new_s * new_s + new_t * new_t);
    let (new_s, new_t) = (new_s * scale, new_t * scale);
    store(new_s, &mut block.tangent_impulse[0], k);
    store(new_t, &mut block.tangent_impulse[1], k);
    let j = s.scale(new_s - old_s) + t.scale(new_t - old_t);
    a.push(-j, middle);
    b.push(j, arm_b);
}

/// The factor that brings a vector of squared length `squared` down to `limit`; 1 where it is shorter.
#[inline(always)]
pub(crate) fn shorten<L: Lanes>(token: L::Token, limit: L, squared: L) -> L {
    let long = (limit * limit).lt(squared);
    let length = L::select(long, squared, L::splat(token, 1.0)).sqrt();
    L::select(long, limit / length, L::splat(token, 1.0))
}

/// Torque about the normal against twisting.
struct Spin<L> {
    mass: L,
    limit: L,
    normal: Lanes3<L>,
}

impl<L: Lanes> Spin<L> {
    #[inline(always)]
    fn resist(
        &self,
        token: L::Token,
        impulse: &mut crate::block::Column,
        k: usize,
        a: &mut BodyLanes<L>,
        b: &mut BodyLanes<L>,
    ) {
        let old: L = load(token, impulse, k);
        let rate = self.normal.dot(b.w - a.w);
        let new = (old - self.mass * rate).max(-self.limit).min(self.limit);
        store(new, impulse, k);
        let j = self.normal.scale(new - old);
        a.turn(-j);
        b.turn(j);
    }
}

/// Torque against rolling, across the normal.
#[inline(always)]
fn roll<L: Lanes>(
    token: L::Token,
    cold: &mut Cold,
    k: usize,
    a: &mut BodyLanes<L>,
    b: &mut BodyLanes<L>,
    normal: Lanes3<L>,
    pressed: L,
) {
    let mass = Symmetric([0, 1, 2, 3, 4, 5].map(|i| load(token, &cold.rolling_mass[i], k)));
    let limit = load::<L>(token, &cold.rolling_limit, k) * pressed;
    let old: Lanes3<L> = load3(token, &cold.rolling_impulse, k);
    let new = old - mass.times(b.w - a.w);
    let new = new - normal.scale(normal.dot(new));
    let new = new.scale(shorten(token, limit, new.dot(new)));
    for (column, x) in cold.rolling_impulse.iter_mut().zip([new.x, new.y, new.z]) {
        store(x, column, k);
    }
    let j = new - old;
    a.turn(-j);
    b.turn(j);
}
