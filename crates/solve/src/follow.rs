//! Stage 5, **touch**: contacts follow their bodies.
//!
//! Reads the motion of the last step; writes arms, normals, signed distances, and friction impulses along the turned tangents. To
//! first order in that motion: between flat surfaces a point keeps its place on both, half-way between them. What is found anew afterwards is overwritten.
//!
//! A round body that rolls does not take the contact along: it stays opposite to the middle of the ball, or the point on the axis of the capsule, at the
//! skin's distance, and the normal is that of the flat surface. Were it to turn with the body, weight and floor would turn it over faster and faster: a ball
//! that leans by θ would feel m g r θ.
//!
//! What makes that untrue in time is the motion of one body relative to the other, and it is counted off what they may go
//! ([`crate::desk::Leash`]). What both have in common, as two stones of a heap that slides, does no harm but to second order.

use crate::block::{Block, Column3, LANES, load, load3, store, tangents};
use crate::contacts::Contacts;
use crate::line::Columns;
use crate::plan::Span;
use crate::shelf::Class;
use crate::sweep::{Beside, Rows, Visit, gather_drift, over_all};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Lanes3, Width};

/// What a step counts at least, metres, however little two bodies move: a contact that follows loses motions too small for single
/// precision, up to 3e-8 of the way between the centres in a step; so each is looked at again in time.
const CREEP: f32 = 1e-6;

/// Lets all contacts follow their bodies.
pub fn follow(contacts: &mut Contacts, columns: &mut Columns<'_>, width: Width) {
    over_all(contacts, columns, width, &Follow);
}

struct Follow;

impl Visit for Follow {
    const LINES: bool = false;

    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { slack, follows, .. }: Beside<'_>,
        k: usize,
        span: &Span,
    ) {
        let way = if span.class == Class::Ball {
            follow_balls::<L, P, T>(token, rows, block, k)
        } else {
            let skins = load::<L>(token, &slack.skins, k);
            let levers = load::<L>(token, &slack.levers, k);
            let zero = L::splat(token, 0.0);
            // What is for flat ones alone is the same, to the bit, and half of the work.
            match L::bits(skins.lt(zero)) | L::bits(zero.lt(skins)) {
                0 => follow_points::<L, P, T, false>(token, rows, block, [levers, skins], k),
                _ => follow_points::<L, P, T, true>(token, rows, block, [levers, skins], k),
            }
        };
        let left = load::<L>(token, &slack.left, k) - way - L::splat(token, CREEP);
        store(left, &mut slack.left, k);
        let these = (u16::MAX >> (LANES - L::WIDTH)) << k;
        *follows = *follows & !these | L::bits(L::splat(token, 0.0).lt(left)) << k;
    }
}

/// The contact of two balls stays between their centres, however they turn. Its distance changes by |c + Δ| − |c|, with the way c
/// between the centres, in a form that loses nothing where Δ is small. Returns how far the two have moved relative to each other.
#[inline(always)]
fn follow_balls<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    k: usize,
) -> L {
    let half = L::splat(token, 0.5);
    let (move_a, _) = gather_drift::<L>(token, rows, &block.a, k);
    let (move_b, _) = gather_drift::<L>(token, rows, &block.b, k);
    let moved = move_b - move_a;
    let before: Lanes3<L> = load3(token, &block.normal, k);
    let offset = load3(token, &block.offset, k);
    let gap = open::<L, P, T>(token, block, k);
    let centres = offset + before.scale(gap);
    let after = centres + moved;
    let (length, longer) = (centres.dot(centres).sqrt(), after.dot(after).sqrt());
    let one = L::splat(token, 1.0);
    let sum = length + longer;
    // Idle lanes, and centres that meet, have no direction: they keep theirs.
    let apart = L::splat(token, 1e-30).lt(longer);
    let grown = (centres.dot(moved) + after.dot(moved)) / L::select(apart, sum, one);
    let direction = after.scale(one / L::select(apart, longer, one));
    let normal = Lanes3::new(
        L::select(apart, direction.x, before.x),
        L::select(apart, direction.y, before.y),
        L::select(apart, direction.z, before.z),
    );
    for p in 0..P {
        let distance = load::<L>(token, &block.distances[p], k);
        let radius =
            (load3(token, &block.arms[p], k) + before.scale(half * gap)).dot(before) - half * distance;
        let distance = distance + grown;
        store(distance, &mut block.distances[p], k);
        let arm = radius + half * (distance - distance.max(L::splat(token, 0.0)));
        store3(normal.scale(arm), &mut block.arms[p], k);
    }
    let gap = open::<L, P, T>(token, block, k);
    store3(after - normal.scale(gap), &mut block.offset, k);
    turn_friction::<L, P, T>(token, block, k, (before, normal));
    moved.dot(moved).sqrt()
}

/// Points between flat surfaces keep their places on both, those of a round one their places opposite to its middle; `ROUND` says whether there are such.
/// Returns how far those have moved relative to each other, at most.
#[inline(always)]
fn follow_points<L: Lanes, const P: usize, const T: usize, const ROUND: bool>(
    token: L::Token,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    [lever, skin]: [L; 2],
    k: usize,
) -> L {
    let zero = L::splat(token, 0.0);
    let half = L::splat(token, 0.5);
    let (move_a, turn_a) = gather_drift::<L>(token, rows, &block.a, k);
    let (move_b, turn_b) = gather_drift::<L>(token, rows, &block.b, k);
    let moved = move_b - move_a;
    let before: Lanes3<L> = load3(token, &block.normal, k);
    let offset = load3(token, &block.offset, k);
    let gap = open::<L, P, T>(token, block, k);
    let (from_b, back) = (offset + before.scale(gap), before.scale(half * gap));

    let (a_is_round, b_is_round) = (zero.lt(skin), skin.lt(zero));
    // Of a round a, of a round b, of two flat ones.
    let which = |[a, b, flat]: [Lanes3<L>; 3]| {
        let pick = |a: L, b: L, flat: L| L::select(a_is_round, a, L::select(b_is_round, b, flat));
        Lanes3::new(pick(a.x, b.x, flat.x), pick(a.y, b.y, flat.y), pick(a.z, b.z, flat.z))
    };
    // From a middle to its contact, along the normal from a to b.
    let reach = |distance: L| {
        let open = half * distance;
        L::select(a_is_round, skin + open, L::select(b_is_round, skin - open, zero))
    };

    let between = (turn_a + turn_b).scale(half);
    let turned = if ROUND { which([turn_b, turn_a, between]) } else { between }.cross(before);
    let normal = before + turned;
    let normal = normal.scale(L::splat(token, 1.0) / normal.dot(normal).sqrt());
    // A point of either surface near the contact has gone relative to the other body what the contact's first point has, and what
    // the turn of one against the other adds; of a turn of both, first order leaves out ½ θ² r.
    let first = load3(token, &block.arms[0], k) + back;
    // The middle of a round body, and what of the other one is opposite to it.
    let ends = |at: Lanes3<L>, distance: L| {
        if ROUND {
            let reach = reach(distance);
            (at - before.scale(reach.max(zero)), at - before.scale(reach.min(zero)))
        } else {
            (at, at)
        }
    };
    let (on_a, on_b) = ends(first, load(token, &block.distances[0], k));
    let slid = moved + turn_b.cross(on_b - from_b) - turn_a.cross(on_a);
    let turn = turn_b - turn_a;
    let length = |v: Lanes3<L>| v.dot(v).sqrt();
    let bent = half * (turn_a.dot(turn_a) * length(on_a) + turn_b.dot(turn_b) * length(on_b - from_b));
    let way = length(slid) + lever * length(turn) + bent;
    let mut arms = [Lanes3::splat(token, Vec3::ZERO); P];
    for (p, to) in arms.iter_mut().enumerate() {
        let arm = load3(token, &block.arms[p], k) + back;
        let distance = load::<L>(token, &block.distances[p], k);
        let (on_a, on_b) = ends(arm, distance);
        let of_a = turn_a.cross(on_a);
        let of_b = moved + turn_b.cross(on_b - from_b);
        let used = zero.lt(load(token, &block.masses[p], k));
        let followed = distance + before.dot(of_b - of_a);
        store(L::select(used, followed, distance), &mut block.distances[p], k);
        *to = arm + (of_a + of_b).scale(half);
        if ROUND {
            let out = normal.scale(reach(followed));
            *to = which([on_a + of_a + out, on_b + of_b + out, *to]);
        }
    }
    let gap = open::<L, P, T>(token, block, k);
    for (p, arm) in arms.into_iter().enumerate() {
        store3(arm - normal.scale(half * gap), &mut block.arms[p], k);
    }
    store3(from_b + moved - normal.scale(gap), &mut block.offset, k);
    turn_friction::<L, P, T>(token, block, k, (before, normal));
    way
}

/// Turns the normal, and expresses the friction impulse in its new tangents.
#[inline(always)]
fn turn_friction<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    k: usize,
    (before, after): (Lanes3<L>, Lanes3<L>),
) {
    let (s, t) = tangents(token, before);
    let friction = s.scale(load(token, &block.tangent_impulse[0], k))
        + t.scale(load(token, &block.tangent_impulse[1], k));
    let (s, t) = tangents(token, after);
    store(s.dot(friction), &mut block.tangent_impulse[0], k);
    store(t.dot(friction), &mut block.tangent_impulse[1], k);
    store3(after, &mut block.normal, k);
}

/// The mean gap of the points in use, 0 where bodies touch; see [`crate::single`].
#[inline(always)]
fn open<L: Lanes, const P: usize, const T: usize>(token: L::Token, block: &Block<P, T>, k: usize) -> L {
    let zero = L::splat(token, 0.0);
    let one = L::splat(token, 1.0);
    let (mut sum, mut count) = (zero, zero);
    for p in 0..P {
        let used = L::select(zero.lt(load(token, &block.masses[p], k)), one, zero);
        sum = sum + used * load(token, &block.distances[p], k);
        count = count + used;
    }
    (sum / count.max(one)).max(zero)
}

/// Writes `WIDTH` vectors from lane `k` on.
#[inline(always)]
fn store3<L: Lanes>(v: Lanes3<L>, columns: &mut Column3, k: usize) {
    for (column, x) in columns.iter_mut().zip([v.x, v.y, v.z]) {
        store(x, column, k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::desk::{Found, Leash};
    use crate::line::{Bodies, Drift};
    use crate::manifold::{Manifold, Memory};
    use rockfall_math::{Mat3, Quat, rotation};

    fn drift(translation: Vec3, rotation: Vec3) -> Drift {
        let mut drift = Drift::default();
        drift.set(translation, rotation);
        drift
    }

    /// A contact after both bodies have moved, and how far they may still go.
    fn followed(
        manifold: Manifold,
        friction: Vec3,
        offset: Vec3,
        [a, b]: [Drift; 2],
        balls: bool,
        skin: f32,
        width: Width,
    ) -> (Manifold, Memory, f32) {
        let mut contacts = Contacts::default();
        let memory = Memory { color: 0, friction, ..Memory::default() };
        let found = Found {
            manifold,
            memory,
            offset,
            active: true,
            balls,
            leash: Leash { skin, ..LEASH },
            ..Found::default()
        };
        let mut arrivals = vec![vec![found]];
        contacts.place(&mut arrivals);
        let mut bodies = Bodies::new(3);
        contacts.prepare(&bodies.lines);
        bodies.drifts[1..].copy_from_slice(&[a, b]);
        follow(&mut contacts, &mut bodies.columns(), width);
        let (manifold, memory) = contacts.read(arrivals[0][0].lane);
        let (slack, follows) = if balls {
            (&contacts.ball.slacks[0], contacts.ball.follows[0])
        } else if manifold.count == 1 {
            (&contacts.one.slacks[0], contacts.one.follows[0])
        } else {
            (&contacts.two.slacks[0], contacts.two.follows[0])
        };
        assert_eq!(follows & 1 == 1, slack.left[0] > 0.0);
        (manifold, memory, slack.left[0])
    }

    const LEASH: Leash = Leash { length: 0.1, lever: 0.4, skin: 0.0 };

    /// Two balls, in contact and apart, whatever the size of their motion.
    #[test]
    fn the_contact_of_two_balls_follows_exactly_at_every_width() {
        let (radius_a, radius_b) = (0.3, 0.5);
        let direction = Vec3::new(0.6, 0.0, 0.8);
        for (start, size) in [(-0.01, 1e-6), (-0.01, 0.1), (0.02, 1e-4), (0.02, 0.1)] {
            let offset = direction * (radius_a + radius_b + start);
            let arms = [direction * (radius_a + 0.5 * start), Vec3::ZERO, Vec3::ZERO, Vec3::ZERO];
            let distances = [start, 0.0, 0.0, 0.0];
            let manifold = Manifold { a: 1, b: 2, count: 1, normal: direction, arms, distances };
            let a = drift(size * Vec3::new(0.3, -0.2, 0.7), Vec3::splat(0.3));
            let b = drift(size * Vec3::new(-0.1, 0.6, 0.2), Vec3::splat(-0.2));
            let centres = offset + b.translation() - a.translation();
            let normal = centres.normalize();
            let distance = centres.as_dvec3().length() - f64::from(radius_a) - f64::from(radius_b);
            for width in Width::all() {
                let (m, ..) = followed(manifold, Vec3::ZERO, offset, [a, b], true, 0.0, width);
                assert!((f64::from(m.distances[0]) - distance).abs() < 1e-7, "{distance} {m:?}");
                assert!((m.normal - normal).length() < 2e-7);
                assert!((m.arms[0] - normal * (radius_a + 0.5 * distance as f32)).length() < 2e-7, "{m:?}");
            }
        }
    }

    /// Against the motion itself: a plane of b over points of a, both moved and turned a little; one pair that touches and one with a
    /// gap.
    #[test]
    fn a_contact_follows_to_first_order_at_every_width() {
        let offset = Vec3::new(0.2, -0.1, 1.0);
        let arms = [Vec3::new(0.5, 0.5, 0.5), Vec3::new(-0.5, 0.4, 0.5), Vec3::ZERO, Vec3::ZERO];
        let small = 1e-3;
        let a = drift(small * Vec3::new(0.3, -0.2, 0.7), small * Vec3::new(0.5, 0.4, -0.6));
        let b = drift(small * Vec3::new(-0.1, 0.6, 0.2), small * Vec3::new(-0.3, 0.7, 0.2));
        let friction = Vec3::new(0.3, -0.4, 0.0);
        for (width, start) in Width::all().flat_map(|width| [(width, 0.0), (width, 0.01)]) {
            let manifold =
                Manifold { a: 1, b: 2, count: 2, normal: Vec3::Z, arms, distances: [start, start, 0.0, 0.0] };
            let (manifold, memory, _) = followed(manifold, friction, offset, [a, b], false, 0.0, width);
            let turned = |d: &Drift| {
                Mat3::from_quat(rotation::normalize(rotation::from_rotation_vector(d.rotation())))
            };
            for (p, &arm) in arms.iter().enumerate().take(2) {
                let on_a = a.translation() + turned(&a) * arm;
                let on_b = offset + b.translation() + turned(&b) * (arm - offset);
                let gap = start + (on_b - on_a).dot(Vec3::Z);
                assert!((manifold.distances[p] - gap).abs() < 5.0 * small * small, "{gap} {manifold:?}");
                let middle = 0.5 * (on_a + on_b) - a.translation();
                assert!((manifold.arms[p] - middle).length() < 5.0 * small * small);
            }
            let half = Quat::from_scaled_axis(0.5 * (a.rotation() + b.rotation()));
            assert!((manifold.normal - half * Vec3::Z).length() < small * small);
            assert!((memory.friction - half * friction).length() < 2.0 * small * friction.length());
        }
    }

    /// Against the motion itself: a capsule, and a ball about its end, that rolls on a plane which moves and turns as well; each of them as the first of the two and
    /// as the second, touching and with a gap.
    #[test]
    fn a_round_body_rolls_through_its_contact_at_every_width() {
        let (radius, small) = (0.3, 1e-3);
        let round = drift(small * Vec3::new(4.0, -2.0, 0.7), small * Vec3::new(5.0, 9.0, -6.0));
        let flat = drift(small * Vec3::new(-0.1, 0.6, 0.2), small * Vec3::new(-0.3, 0.7, 0.2));
        let turned =
            |d: &Drift| Mat3::from_quat(rotation::normalize(rotation::from_rotation_vector(d.rotation())));
        for (width, start, count, first) in Width::all().flat_map(|width| {
            [(0.0, 1, true), (0.01, 1, false), (-0.002, 2, true), (0.0, 2, false)]
                .map(|(start, count, first)| (width, start, count, first))
        }) {
            // From the round body's centre: the middles of its ends, and down to the plane; the plane's body is further down.
            let middles =
                [Vec3::new(if count == 1 { 0.0 } else { 0.4 }, 0.0, 0.0), Vec3::new(-0.4, 0.0, 0.0)];
            let down = if first { Vec3::Z } else { -Vec3::Z };
            let to_flat = Vec3::new(0.3, -0.2, 0.0) + 1.5 * down;
            let feet = middles.map(|middle| middle + (radius + start) * down);
            // From the centre of a, and half-way between the surfaces.
            let from_a = |p: Vec3| if first { p } else { p - to_flat };
            let arm = |i: usize| from_a(feet[i] - 0.5 * start * down);
            let arms = [arm(0), arm(1), Vec3::ZERO, Vec3::ZERO];
            let distances = [start, start, 0.0, 0.0];
            let manifold = Manifold { a: 1, b: 2, count, normal: Vec3::Z, arms, distances };
            let (offset, motions, skin) = match first {
                true => (to_flat, [round, flat], radius),
                false => (-to_flat, [flat, round], -radius),
            };
            let (m, ..) = followed(manifold, Vec3::ZERO, offset, motions, false, skin, width);
            let normal = turned(&flat) * Vec3::Z;
            assert!((m.normal - normal).length() < small * small, "{normal} {m:?}");
            for i in 0..count as usize {
                let middle = round.translation() + turned(&round) * middles[i];
                let foot = to_flat + flat.translation() + turned(&flat) * (feet[i] - to_flat);
                let out = if first { normal } else { -normal };
                let gap = (foot - middle).dot(out) - radius;
                assert!((m.distances[i] - gap).abs() < 30.0 * small * small, "{gap} {m:?}");
                let origin = if first { round.translation() } else { to_flat + flat.translation() };
                let at = middle + (radius + 0.5 * gap) * out - origin;
                assert!((m.arms[i] - at).length() < 30.0 * small * small, "{at} {m:?}");
            }
        }
    }

    /// What both bodies have in common costs nothing but to second order; sliding costs its way, turning its angle times the lever.
    #[test]
    fn only_motion_relative_to_each_other_uses_up_the_leash() {
        let offset = Vec3::new(0.2, -0.1, 1.0);
        let arms = [Vec3::new(0.5, 0.5, 0.5), Vec3::new(-0.5, 0.4, 0.5), Vec3::ZERO, Vec3::ZERO];
        let manifold = Manifold { a: 1, b: 2, count: 2, normal: Vec3::Z, arms, distances: [0.0; 4] };
        let used = |a, b, balls| {
            let manifold = Manifold { count: if balls { 1 } else { 2 }, ..manifold };
            LEASH.length - followed(manifold, Vec3::ZERO, offset, [a, b], balls, 0.0, Width::native()).2
        };
        let close = |x: f32, y: f32| assert!((x - y - CREEP).abs() < 2e-7, "{x} {y}");
        let (way, turn) = (Vec3::new(0.01, -0.02, 0.03), Vec3::new(0.003, 0.001, -0.002));
        // b goes along on a body that turns.
        let (a, b) = (drift(way, turn), drift(way + turn.cross(offset), turn));
        let (arm_a, arm_b) = (arms[0], arms[0] - offset);
        close(used(a, b, false), 0.5 * turn.length_squared() * (arm_a.length() + arm_b.length()));
        let slide = Vec3::new(0.006, 0.0, 0.008);
        close(used(drift(way, Vec3::ZERO), drift(way + slide, Vec3::ZERO), false), 0.01);
        let about_first = drift(turn.cross(-arm_b), turn);
        let bent = 0.5 * turn.length_squared() * arm_b.length();
        close(used(Drift::default(), about_first, false), 0.4 * turn.length() + bent);
        close(used(drift(way, turn), drift(way + slide, -turn), true), 0.01);
        // Farther than the leash reaches.
        close(used(drift(way, turn), drift(way + 20.0 * slide, -turn), true), 0.2);
    }
}
