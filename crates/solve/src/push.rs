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
    /// How many came before it; any number to begin with.
    pub count: u32,
    /// Whether velocities gather no rounding however long a body falls.
    pub exact: bool,
}

impl Advance for Push {
    #[inline]
    fn advance(&self, body: Body<'_>) {
        let Body { line, drift, reference, damping, role, locks, .. } = body;
        let &Push { h, first, .. } = self;
        if first {
            drift.0 = [0.0; 8];
        }
        if role != Role::Free {
            return;
        }
        let (v, w) = (line.velocity(), line.angular_velocity());
        let from = |i: usize| Vec3::new(reference[i], reference[i + 1], reference[i + 2]);
        let (warm_v, warm_w) = if first { (Vec3::ZERO, Vec3::ZERO) } else { (v - from(0), w - from(3)) };
        let v = self.fallen(v, line.gravity_scale()) * (1.0 / (1.0 + damping[0] * h));
        let w = w * (1.0 / (1.0 + damping[1] * h));
        reference[..3].copy_from_slice(&v.to_array());
        reference[3..6].copy_from_slice(&w.to_array());
        line.set_velocities(unlocked(v + warm_v, locks), unlocked(w + warm_w, locks >> 3));
    }
}

impl Push {
    /// A velocity after gravity's push, which a body takes `scale` times.
    #[inline]
    fn fallen(&self, v: Vec3, scale: f32) -> Vec3 {
        let gain = self.gravity * (self.h * scale);
        let fast = Vec3::splat(LATER) * gain.abs();
        if !self.exact || v.abs().cmplt(fast).all() || scale == 0.0 {
            return v + gain;
        }
        let exact = f64::from(self.h) * f64::from(scale);
        let along = |i: usize| match self.gravity[i] {
            0.0 => v[i],
            g => gather_up(v[i], f64::from(g) * exact, self.count),
        };
        Vec3::new(along(0), along(1), along(2))
    }
}

/// So many pushes may round as they like, and what rests is pushed by the same each time.
const LATER: f32 = 8.0;

/// `v` after push number `count` of `gain` each. A velocity in single precision rounds one and the same increment to the same side
/// again and again: of a fall of ten seconds in steps of 1 ms that takes 10 mm. So a push gives what the sum of all of them,
/// rounded to units of the last place of `v`, grows by; that is added without rounding.
#[inline]
fn gather_up(v: f32, gain: f64, count: u32) -> f32 {
    // 2⁻²³ of the power of two below |v|, the unit of its last place; to this, 1.5 · 2⁵² units round any sum that is added and taken away.
    let unit = f64::from(f32::from_bits(v.to_bits() & 0x7f80_0000)) * f64::from(f32::EPSILON);
    let round = 1.5 * 2_f64.powi(52) * unit;
    let sum = |count: u32| (f64::from(count) * gain + round) - round;
    v + (sum(count + 1) - sum(count)) as f32
}

/// `v` without its components along the axes whose bits are set.
#[inline]
pub(crate) fn unlocked(v: Vec3, bits: u8) -> Vec3 {
    let keep = |i: u8, x: f32| if bits >> i & 1 == 1 { 0.0 } else { x };
    if bits & 7 == 0 { v } else { Vec3::new(keep(0, v.x), keep(1, v.y), keep(2, v.z)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hundred thousand pushes of 1/10 ms, from rest and from a throw upwards.
    #[test]
    fn a_long_fall_gathers_no_rounding() {
        let h = 1e-4_f32;
        for start in [0.0_f32, 30.0, -1e-3] {
            let mut v = Vec3::new(3.0, 0.0, start);
            for count in 0..100_000 {
                let push = Push { gravity: Vec3::new(0.0, 0.0, -9.81), h, first: false, count, exact: true };
                v = push.fallen(v, 1.0);
            }
            let exact = f64::from(start) - f64::from(9.81_f32) * f64::from(h) * 1e5;
            // Units of the last place at 64 m/s and more are 8e-6; one is lost in every power of two, and where the sum begins.
            assert!((f64::from(v.z) - exact).abs() < 4e-5, "{} {exact}", v.z);
            assert_eq!([v.x, v.y], [3.0, 0.0]);
        }
    }

    #[test]
    fn what_rests_is_pushed_by_the_same_each_time() {
        let push =
            |count| Push { gravity: Vec3::new(0.0, 0.0, -9.81), h: 1e-3, first: false, count, exact: true };
        let gains: Vec<Vec3> = (0..100).map(|count| push(count).fallen(Vec3::ZERO, 1.0)).collect();
        assert!(gains.iter().all(|gain| *gain == gains[0]));
    }
}
