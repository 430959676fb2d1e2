//! Stage 9, **push**: gravity, damping, and the warm start of every sub-step but the first.
//!
//! Reads velocities and references; writes both. A contact's impulse in a sub-step is what it had accumulated in the one
//! before, plus corrections. Applying the former again contact by contact would be one more sweep over all of them; their
//! sum is known per body: it is the velocity that the body gained beyond gravity in the last sub-step. Normals, arms and
//! masses stay the same within a step, so the two are equal but for rounding.
//!
//! `references` holds the velocity from which that gain is measured.

use crate::advance::{Advance, Body};
use crate::line::Role;
use rockfall_math::Vec3;

/// Advances velocities by gravity over a sub-step.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// m/s².
    pub gravity: Vec3,
    /// Length of the sub-step, s.
    pub h: f32,
    /// Whether it is the first of a step.
    pub first: bool,
}

impl Advance for Push {
    #[inline]
    fn advance(&self, body: Body<'_>) {
        let Body { line, drift, reference, damping, role, locks, .. } = body;
        let &Push { gravity, h, first } = self;
        if first {
            drift.0 = [0.0; 8];
        }
        if role != Role::Free {
            return;
        }
        let (v, w) = (line.velocity(), line.angular_velocity());
        let from = |i: usize| Vec3::new(reference[i], reference[i + 1], reference[i + 2]);
        let (warm_v, warm_w) = if first { (Vec3::ZERO, Vec3::ZERO) } else { (v - from(0), w - from(3)) };
        let v = (v + gravity * (h * line.gravity_scale())) * (1.0 / (1.0 + damping[0] * h));
        let w = w * (1.0 / (1.0 + damping[1] * h));
        reference[..3].copy_from_slice(&v.to_array());
        reference[3..6].copy_from_slice(&w.to_array());
        line.set_velocities(unlocked(v + warm_v, locks), unlocked(w + warm_w, locks >> 3));
    }
}

/// `v` without its components along the axes whose bits are set.
#[inline]
pub(crate) fn unlocked(v: Vec3, bits: u8) -> Vec3 {
    let keep = |i: u8, x: f32| if bits >> i & 1 == 1 { 0.0 } else { x };
    if bits & 7 == 0 { v } else { Vec3::new(keep(0, v.x), keep(1, v.y), keep(2, v.z)) }
}
