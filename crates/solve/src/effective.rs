//! Effective masses: the inverse of what a unit impulse does to a contact.
//!
//! d · K e with the report's K = K_a + K_b, for the normal at each point, for the two tangents at the middle of the points,
//! and for the torque about the normal.

use crate::block::{Block, load, load3, store, tangents};
use crate::sweep::BodyLanes;
use rockfall_math::lanes::{Lanes, Lanes3};

/// Effective masses of lanes, along the normal where a point is in use: where the mass is not 0 yet.
#[inline(always)]
pub(crate) fn complete<L: Lanes, const P: usize, const T: usize>(
    token: L::Token,
    block: &mut Block<P, T>,
    k: usize,
    (a, b): (&BodyLanes<L>, &BodyLanes<L>),
) {
    let zero = L::splat(token, 0.0);
    let (inertia_a, inertia_b) = (&a.inverse_inertia, &b.inverse_inertia);
    let inverse_mass: L = a.inverse_mass + b.inverse_mass;
    let offset: Lanes3<L> = load3(token, &block.offset, k);
    let n: Lanes3<L> = load3(token, &block.normal, k);
    let (s, t) = tangents(token, n);

    let mut middle = Lanes3::new(zero, zero, zero);
    for p in 0..P {
        let arm: Lanes3<L> = load3(token, &block.arms[p], k);
        middle = middle + arm;
        let (ca, cb) = (arm.cross(n), (arm - offset).cross(n));
        let compliance = inverse_mass + ca.dot(inertia_a.times(ca)) + cb.dot(inertia_b.times(cb));
        let in_use = zero.lt(load(token, &block.masses[p], k));
        store(L::select(in_use, invert(token, compliance), zero), &mut block.masses[p], k);
    }
    let middle = middle.scale(L::splat(token, 1.0 / P as f32));

    let [sa, ta] = [s, t].map(|d| middle.cross(d));
    let [sb, tb] = [s, t].map(|d| (middle - offset).cross(d));
    let (isa, isb) = (inertia_a.times(sa), inertia_b.times(sb));
    let k11 = inverse_mass + sa.dot(isa) + sb.dot(isb);
    let k12 = ta.dot(isa) + tb.dot(isb);
    let k22 = inverse_mass + ta.dot(inertia_a.times(ta)) + tb.dot(inertia_b.times(tb));
    let inverse = invert(token, k11 * k22 - k12 * k12);
    store(k22 * inverse, &mut block.tangent_mass[0], k);
    store(-(k12 * inverse), &mut block.tangent_mass[1], k);
    store(k11 * inverse, &mut block.tangent_mass[2], k);

    for twist in 0..T {
        let compliance = n.dot(inertia_a.times(n)) + n.dot(inertia_b.times(n));
        store(invert(token, compliance), &mut block.twist_mass[twist], k);
    }
}

/// 1 / x, or 0 where nothing can give way.
#[inline(always)]
pub(crate) fn invert<L: Lanes>(token: L::Token, x: L) -> L {
    let zero = L::splat(token, 0.0);
    let one = L::splat(token, 1.0);
    let positive = zero.lt(x);
    L::select(positive, one / L::select(positive, x, one), zero)
}
