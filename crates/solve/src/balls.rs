//! Stage 9, **warm**, **solve** and **relax**, for two balls that neither bounce nor resist rolling.
//!
//! Their arms lie along the normal, r_a n and −r_b n, and their inertia is the same about all axes, so most of what
//! [`crate::iterate`] and [`crate::effective`] do falls away: a normal impulse turns nobody, and the matrix of the tangents is a number,
//!
//!   1 / m = 1/M_a + 1/M_b + r_a²/I_a + r_b²/I_b.
//!
//! With W = r_a ω_a + r_b ω_b and the right-handed frame (s, t, n) the slip is (s · Δv − t · W, t · Δv + s · W), and an impulse
//! (j_s, j_t) turns a by −r_a/I_a (j_s t − j_t s) and b by −r_b/I_b (j_s t − j_t s).
//!
//! The two free places of the tangents' matrix hold 1/I_a and 1/I_b, so that sweeps need not fetch the bodies' inertia.

use crate::block::{Block, load, load3, store, tangents};
use crate::effective::invert;
use crate::iterate::{pressed, shorten};
use crate::soft::SubStep;
use crate::sweep::{BodyLanes, Rows, gather_drift};
use rockfall_math::lanes::{Lanes, Lanes3};

/// What a contact of two balls is, lane by lane.
struct Pair<L> {
    normal: Lanes3<L>,
    s: Lanes3<L>,
    t: Lanes3<L>,
    /// From the centres to the contact.
    radii: [L; 2],
    /// 1/I_a and 1/I_b.
    inverse_inertia: [L; 2],
}

impl<L: Lanes> Pair<L> {
    #[inline(always)]
    fn load<const P: usize, const T: usize>(token: L::Token, block: &Block<P, T>, k: usize) -> Self {
        let normal: Lanes3<L> = load3(token, &block.normal, k);
        let (s, t) = tangents(token, normal);
        let radius_a = load3(token, &block.arms[0], k).dot(normal);
        let radius_b = load3(token, &block.offset, k).dot(normal) - radius_a;
        let [_, inertia_a, inertia_b] = [0, 1, 2].map(|i| load(token, &block.tangent_mass[i], k));
        Pair { normal, s, t, radii: [radius_a, radius_b], inverse_inertia: [inertia_a, inertia_b] }
    }

    /// Applies a friction impulse.
    #[inline(always)]
    fn rub(&self, a: &mut BodyLanes<L>, b: &mut BodyLanes<L>, [js, jt]: [L; 2]) {
        let j = self.s.scale(js) + self.t.scale(jt);
        a.v = a.v - j.scale(a.inverse_mass);
        b.v = b.v + j.scale(b.inverse_mass);
        let turn = self.t.scale(js) - self.s.scale(jt);
        a.w = a.w - turn.scale(self.inverse_inertia[0] * self.radii[0]);
        b.w = b.w - turn.scale(self.inverse_inertia[1] * self.radii[1]);
    }

    /// Applies a normal impulse.
    #[inline(always)]
    fn press(&self, a: &mut BodyLanes<L>, b: &mut BodyLanes<L>, j: L) {
        let along = self.normal.scale(j);
        a.v = a.v - along.scale(a.inverse_mass);
        b.v = b.v + along.scale(b.inverse_mass);
    }
}

/// Completes effective masses and applies the impulses of the last step.
#[inline(always)]
pub(crate) fn warm_balls<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    k: usize,
    a: &mut BodyLanes<L>,
    b: &mut BodyLanes<L>,
) {
    let (inertia_a, inertia_b) = (a.inverse_inertia.0[0], b.inverse_inertia.0[0]);
    store(inertia_a, &mut block.tangent_mass[1], k);
    store(inertia_b, &mut block.tangent_mass[2], k);
    let pair = Pair::load(token, block, k);
    let [radius_a, radius_b] = pair.radii;
    let inverse_mass = a.inverse_mass + b.inverse_mass;
    let compliance = inverse_mass + radius_a * radius_a * inertia_a + radius_b * radius_b * inertia_b;
    let zero = L::splat(token, 0.0);
    let in_use = zero.lt(load(token, &block.masses[0], k));
    store(L::select(in_use, invert(token, inverse_mass), zero), &mut block.masses[0], k);
    store(invert(token, compliance), &mut block.tangent_mass[0], k);

    pair.press(a, b, load(token, &block.impulses[0], k));
    pair.rub(a, b, [0, 1].map(|i| load(token, &block.tangent_impulse[i], k)));
}

/// One visit of *solve* or *relax*; see [`crate::iterate`].
#[inline(always)]
pub(crate) fn iterate_balls<L: Lanes, const P: usize, const T: usize, const RELAX: bool>(
    token: L::Token,
    step: &SubStep,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    k: usize,
    one_sided: bool,
    (a, b): (&mut BodyLanes<L>, &mut BodyLanes<L>),
) {
    let pair = Pair::load(token, block, k);
    let (moved_a, _) = gather_drift(token, rows, &block.a, k);
    let (moved_b, _) = gather_drift(token, rows, &block.b, k);
    let apart = moved_b - moved_a;
    if RELAX {
        press_balls::<L, P, T, RELAX>(token, step, block, k, one_sided, &pair, apart, (a, b));
        hold_balls(token, block, k, one_sided, &pair, apart, (a, b));
    } else {
        let soon = if one_sided { apart + (b.v - a.v).scale(L::splat(token, step.h)) } else { apart };
        hold_balls(token, block, k, one_sided, &pair, soon, (a, b));
        press_balls::<L, P, T, RELAX>(token, step, block, k, one_sided, &pair, apart, (a, b));
    }
}

/// The velocity of b seen from a, turns about their centres aside. A ball that is carried by one that turns goes with it; see [`crate::iterate::Place`].
#[inline(always)]
fn parting<L: Lanes>(one_sided: bool, apart: Lanes3<L>, a: &BodyLanes<L>, b: &BodyLanes<L>) -> Lanes3<L> {
    let parting = b.v - a.v;
    if one_sided { parting - b.w.cross(apart) } else { parting }
}

/// Coulomb friction.
#[inline(always)]
fn hold_balls<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    k: usize,
    one_sided: bool,
    pair: &Pair<L>,
    apart: Lanes3<L>,
    (a, b): (&mut BodyLanes<L>, &mut BodyLanes<L>),
) {
    let around = a.w.scale(pair.radii[0]) + b.w.scale(pair.radii[1]);
    let slip = parting(one_sided, apart, a, b);
    let slip_s = pair.s.dot(slip) - pair.t.dot(around);
    let slip_t = pair.t.dot(slip) + pair.s.dot(around);
    let mass: L = load(token, &block.tangent_mass[0], k);
    let [old_s, old_t] = [0, 1].map(|i| load::<L>(token, &block.tangent_impulse[i], k));
    let (new_s, new_t) = (old_s - mass * slip_s, old_t - mass * slip_t);
    let limit = load::<L>(token, &block.friction, k) * load(token, &block.impulses[0], k);
    let scale = shorten(token, limit, new_s * new_s + new_t * new_t);
    let (new_s, new_t) = (new_s * scale, new_t * scale);
    store(new_s, &mut block.tangent_impulse[0], k);
    store(new_t, &mut block.tangent_impulse[1], k);
    pair.rub(a, b, [new_s - old_s, new_t - old_t]);
}

/// The normal impulse.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn press_balls<L: Lanes, const P: usize, const T: usize, const RELAX: bool>(
    token: L::Token,
    step: &SubStep,
    block: &mut Block<P, T>,
    k: usize,
    one_sided: bool,
    pair: &Pair<L>,
    apart: Lanes3<L>,
    (a, b): (&mut BodyLanes<L>, &mut BodyLanes<L>),
) {
    let distance = load::<L>(token, &block.distances[0], k) + pair.normal.dot(apart);
    let speed = pair.normal.dot(parting(one_sided, apart, a, b));
    let old: L = load(token, &block.impulses[0], k);
    let mass: L = load(token, &block.masses[0], k);
    let new = pressed::<L, RELAX>(token, step, one_sided, distance, speed, mass, old);
    store(new, &mut block.impulses[0], k);
    pair.press(a, b, new - old);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Contacts;
    use crate::advance::Stay;
    use crate::desk::Found;
    use crate::iterate::{relax, solve};
    use crate::line::{Bodies, Line};
    use crate::manifold::{FIXED, Manifold, Memory};
    use crate::single::Surface;
    use crate::soft::Softness;
    use crate::warm::warm;
    use rockfall_math::lanes::Width;
    use rockfall_math::{Mat3, Vec3};

    /// Velocities and impulses after a warm start and two sweeps over one contact, as a contact of balls or as any other.
    fn swept(balls: bool, fixed: bool, distance: f32, width: Width) -> (Vec<Line>, Memory) {
        let normal = Vec3::new(0.36, -0.48, 0.8);
        let (radius_a, radius_b) = (0.3, 0.5);
        let arms = [normal * (radius_a + 0.5 * distance), Vec3::ZERO, Vec3::ZERO, Vec3::ZERO];
        let b = if fixed { 2 | FIXED } else { 2 };
        let manifold = Manifold { a: 1, b, count: 1, normal, arms, distances: [distance, 0.0, 0.0, 0.0] };
        let friction = Vec3::new(0.2, 0.1, -0.03);
        let memory = Memory { color: 0, normals: [0.7, 0.0, 0.0, 0.0], friction, ..Memory::default() };
        let surface = Surface { friction: 0.5, ..Surface::default() };
        let offset = normal * (radius_a + radius_b + distance);
        let found = Found { manifold, memory, surface, offset, active: true, balls, ..Found::default() };
        let mut contacts = Contacts::default();
        contacts.desk(3);
        let mut arrivals = vec![vec![found]];
        contacts.place(&mut arrivals);
        let mut bodies = Bodies::new(3);
        for (line, mass) in bodies.lines[1..].iter_mut().zip([2.0_f32, 5.0]) {
            line.set_velocities(Vec3::new(0.3, mass, -0.7), Vec3::new(mass, -1.0, 0.5));
            line.motion[6] = 1.0 / mass;
            line.set_inverse_inertia(&Mat3::from_diagonal(Vec3::splat(7.0 / mass)));
        }
        bodies.drifts[1].set(Vec3::new(1e-3, -2e-3, 3e-3), Vec3::new(0.01, 0.02, 0.03));
        contacts.prepare(&bodies.lines);
        let mut columns = bodies.columns();
        let h = 1.0 / 240.0;
        let soft = Softness::new(60.0, 0.5, h);
        let step = SubStep { h, push_speed: 3.0, two_sided: soft, one_sided: soft };
        warm(&mut contacts, &mut columns, width, &Stay);
        solve(&mut contacts, &mut columns, width, &Stay, &step);
        relax(&mut contacts, &mut columns, width, &Stay, &step);
        let memory = contacts.read(arrivals[0][0].lane).1;
        (bodies.lines, memory)
    }

    /// The same impulses and velocities as by the equations of any contact, where bodies overlap and where they don't touch yet.
    #[test]
    fn balls_are_solved_as_any_other_contact() {
        for (fixed, distance) in [(false, -0.01), (false, 0.002), (true, -0.01), (true, 0.002)] {
            for width in Width::all() {
                let ((balls, memory), (any, expected)) =
                    (swept(true, fixed, distance, width), swept(false, fixed, distance, width));
                assert!(expected.normals[0] > 0.0 && expected.friction.length() > 0.0);
                assert!((memory.normals[0] - expected.normals[0]).abs() < 1e-5, "{memory:?} {expected:?}");
                assert!((memory.friction - expected.friction).length() < 1e-5, "{memory:?} {expected:?}");
                for (ball, other) in balls.iter().zip(&any) {
                    assert!((ball.velocity() - other.velocity()).length() < 1e-5, "{ball:?} {other:?}");
                    let turn = (ball.angular_velocity() - other.angular_velocity()).length();
                    assert!(turn < 2e-5, "{ball:?} {other:?}");
                }
            }
        }
    }
}
