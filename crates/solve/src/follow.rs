//! Stage 5, **touch**: contacts follow their bodies.
//!
//! Reads the motion of the last step; writes arms, normals, signed distances, and friction impulses along the turned tangents. To
//! first order in that motion: a point keeps its place on both surfaces, half-way between them. What is found anew afterwards is overwritten.

use crate::block::{Block, Cold, Column3, load, load3, store, tangents};
use crate::contacts::Contacts;
use crate::line::Columns;
use crate::plan::Span;
use crate::shelf::Class;
use crate::sweep::{Rows, Visit, gather_drift, over_all};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Lanes, Lanes3, Width};

/// Lets all contacts follow their bodies.
pub fn follow(contacts: &mut Contacts, columns: &mut Columns<'_>, width: Width) {
    over_all(contacts, columns, width, &Follow);
}

struct Follow;

impl Visit for Follow {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        _: Option<&mut Cold>,
        k: usize,
        span: &Span,
    ) {
        if span.class == Class::Ball {
            follow_balls::<L, P, T>(token, rows, block, k);
        } else {
            follow_points::<L, P, T>(token, rows, block, k);
        }
    }
}

/// The contact of two balls stays between their centres, however they turn. Its distance changes by |c + Δ| − |c|, with the way c
/// between the centres, in a form that loses nothing where Δ is small.
#[inline(always)]
fn follow_balls<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    k: usize,
) {
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
}

/// Points between flat surfaces keep their places on both.
#[inline(always)]
fn follow_points<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    k: usize,
) {
    let zero = L::splat(token, 0.0);
    let half = L::splat(token, 0.5);
    let (move_a, turn_a) = gather_drift::<L>(token, rows, &block.a, k);
    let (move_b, turn_b) = gather_drift::<L>(token, rows, &block.b, k);
    let moved = move_b - move_a;
    let before: Lanes3<L> = load3(token, &block.normal, k);
    let offset = load3(token, &block.offset, k);
    let gap = open::<L, P, T>(token, block, k);
    let (from_b, back) = (offset + before.scale(gap), before.scale(half * gap));

    let turned = (turn_a + turn_b).scale(half).cross(before);
    let normal = before + turned;
    let normal = normal.scale(L::splat(token, 1.0) / normal.dot(normal).sqrt());
    let mut arms = [Lanes3::splat(token, Vec3::ZERO); P];
    for (p, to) in arms.iter_mut().enumerate() {
        let arm = load3(token, &block.arms[p], k) + back;
        let of_a = turn_a.cross(arm);
        let of_b = moved + turn_b.cross(arm - from_b);
        let used = zero.lt(load(token, &block.masses[p], k));
        let distance = load::<L>(token, &block.distances[p], k);
        let followed = distance + before.dot(of_b - of_a);
        store(L::select(used, followed, distance), &mut block.distances[p], k);
        *to = arm + (of_a + of_b).scale(half);
    }
    let gap = open::<L, P, T>(token, block, k);
    for (p, arm) in arms.into_iter().enumerate() {
        store3(arm - normal.scale(half * gap), &mut block.arms[p], k);
    }
    store3(from_b + moved - normal.scale(gap), &mut block.offset, k);
    turn_friction::<L, P, T>(token, block, k, (before, normal));
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
    use crate::desk::Found;
    use crate::line::{Drift, Line, Role};
    use crate::manifold::{Manifold, Memory};
    use crate::shelf::Lane;
    use crate::single::Surface;
    use rockfall_math::{Mat3, Quat, rotation};

    fn drift(translation: Vec3, rotation: Vec3) -> Drift {
        let mut drift = Drift::default();
        drift.set(translation, rotation);
        drift
    }

    /// A contact after both bodies have moved.
    fn followed(
        manifold: Manifold,
        friction: Vec3,
        offset: Vec3,
        [a, b]: [Drift; 2],
        balls: bool,
        width: Width,
    ) -> (Manifold, Memory) {
        let mut contacts = Contacts::default();
        let memory = Memory { color: 0, friction, ..Memory::default() };
        let (surface, lane) = (Surface::default(), Lane::NONE);
        let arrival = Found { manifold, memory, surface, offset, active: true, ordinal: 0, balls, lane };
        let mut arrivals = vec![vec![arrival]];
        contacts.place(&mut arrivals);
        let mut lines = vec![Line::default(); 3];
        contacts.prepare(&lines);
        let mut drifts = vec![Drift::default(), a, b];
        let mut columns = Columns {
            lines: &mut lines,
            drifts: &mut drifts,
            references: &mut [[0.0; 8]; 3],
            rotations: &mut [Quat::IDENTITY; 3],
            frames: &[Quat::IDENTITY; 3],
            inverse_moments: &[Vec3::ONE; 3],
            dampings: &[[0.0; 2]; 3],
            roles: &[Role::Free; 3],
            locks: &[0; 3],
        };
        follow(&mut contacts, &mut columns, width);
        contacts.read(arrivals[0][0].lane)
    }

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
                let (m, _) = followed(manifold, Vec3::ZERO, offset, [a, b], true, width);
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
        for (width, start) in Width::all().into_iter().flat_map(|width| [(width, 0.0), (width, 0.01)]) {
            let manifold =
                Manifold { a: 1, b: 2, count: 2, normal: Vec3::Z, arms, distances: [start, start, 0.0, 0.0] };
            let (manifold, memory) = followed(manifold, friction, offset, [a, b], false, width);
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
}
