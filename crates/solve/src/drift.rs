//! Stage 9, **drift**: transformation over time.
//!
//! Reads velocities; writes positions (as motion since the step began), rotations, and the angular velocities that a freely
//! turning body has after the sub-step.
//!
//! Velocities are pushed before positions move: semi-implicit Euler, whose parabola is ½ g T h below the true one after T. With
//! [`Integrator::SecondOrder`] a body in free flight moves by the mean of its velocities before and after the push, ½ g h² less, which
//! is exact. One that a contact pushed does not: its velocity over the sub-step is the one that the contact chose.
//!
//! A body whose principal moments differ turns without torque as a top: its angular momentum stays, its angular
//! velocity does not. The turn is split into turns about the three principal axes, each exact (Dullweber, Leimkuhler and
//! McLachlan, "Symplectic splitting methods for rigid body molecular dynamics", J. Chem. Phys. 107, 1997): second
//! order, stable at any speed, the energy does not drift, and the angular momentum is kept to rounding. Each turn by the
//! angle α is a Cayley turn by 2 atan(α/2): it needs no trigonometry and keeps lengths exactly. Slender bodies turn by other turns: see [`crate::slender`].

use crate::advance::{Advance, Body};
use crate::line::Role;
use crate::push::unlocked;
use crate::slender::{attitude, carried, long_axis, spin_slender, uncarried};
use rockfall_math::rotation::{compose, from_rotation_vector, inverse, normalize};
use rockfall_math::{DQuat, DVec3, Quat, Vec3};

/// A body that turns by less than this in a sub-step (rad, squared) has a gyroscopic term below rounding of its contacts'.
const SLOW: f32 = 1e-6;

/// How positions follow from velocities in free flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// By the velocity after the push: first order, symplectic.
    #[default]
    SemiImplicit,
    /// By the mean of the velocities before and after the push: exact under gravity. What rocks on its contacts loses less by it, too: a bowl of hulls with
    /// balls in it went on at 50 mm/s.
    SecondOrder,
}

/// Advances positions and rotations over a sub-step: transformation over time.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// Length of the sub-step, s.
    pub h: f32,
    /// By how much the way of a body in free flight differs from its new velocity times `h`, m.
    pub lag: Vec3,
}

impl Transform {
    /// Over `h` seconds under a gravity in m/s².
    pub fn new(h: f32, gravity: Vec3, integrator: Integrator) -> Self {
        let lag = match integrator {
            Integrator::SemiImplicit => Vec3::ZERO,
            Integrator::SecondOrder => gravity * (-0.5 * h * h),
        };
        Transform { h, lag }
    }
}

impl Advance for Transform {
    #[inline]
    fn advance(&self, body: Body<'_>) {
        let Body { line, drift, reference, rotation, start, frame, inverse_moments, role, locks, .. } = body;
        let (h, moments) = (self.h, *inverse_moments);
        if role == Role::Still {
            return;
        }
        let (mut v, mut w) = (line.velocity(), line.angular_velocity());
        if role == Role::Free && locks != 0 {
            (v, w) = (unlocked(v, locks), unlocked(w, locks >> 3));
        }
        if !v.is_finite() || !w.is_finite() {
            // The pose stays what it was; the world freezes the body when it settles.
            return;
        }
        let mut way = v * h;
        // No contact pushed it.
        if role == Role::Free && reference[..3] == line.motion[..3] {
            way += unlocked(self.lag * line.gravity_scale(), locks);
        }
        drift.set(drift.translation() + way, drift.rotation() + w * h);
        if role == Role::Driven {
            *rotation = normalize(compose(from_rotation_vector(w * h), *rotation));
            return;
        }
        let turned = w.length_squared() * h * h;
        let round = moments.x == moments.y && moments.y == moments.z;
        let long = if round || locks >> 3 != 0 { None } else { long_axis(moments) };
        let after = if let Some(axis) = long {
            let (from, now) = (attitude(*start, *frame), attitude(*rotation, *frame));
            let (q, after) = spin_slender(now, uncarried(w, axis, from, now), moments, axis, h);
            *rotation = normalize(compose(q, inverse(*frame)));
            carried(after, axis, from, attitude(*rotation, *frame))
        } else if round || locks >> 3 != 0 || turned < SLOW || moments.min_element() <= 0.0 {
            let half = w * (0.5 * h);
            *rotation = normalize(compose(Quat::from_xyzw(half.x, half.y, half.z, 1.0), *rotation));
            w
        } else {
            let (q, after) = spin(compose(*rotation, *frame), w, moments, h);
            *rotation = normalize(compose(q, inverse(*frame)));
            after
        };
        // What contacts gave stays measurable as velocity − reference, the free turn aside.
        for (r, (old, new)) in reference[..6]
            .iter_mut()
            .zip(line.motion[..6].iter().zip(v.to_array().into_iter().chain(after.to_array())))
        {
            *r += new - old;
        }
        line.set_velocities(v, after);
    }
}

/// Turns a free body by `h` seconds. `q` maps principal axes to the world, `w` is the angular velocity in the world, and
/// `inverse_moments` belong to the principal axes. Returns the new rotation and angular velocity.
///
/// In double precision: a quaternion's length is only known to 6e-8 in single precision, always on the same side, and over ten
/// thousand steps that bias would show in the angular momentum.
pub fn spin(q: Quat, w: Vec3, inverse_moments: Vec3, h: f32) -> (Quat, Vec3) {
    let m = inverse_moments.as_dvec3();
    let mut q = q.as_dquat().normalize();
    let mut momentum = (q.inverse() * w.as_dvec3()) / m;
    for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let t = 0.5 * share * f64::from(h) * momentum[axis] * m[axis];
        let mut turn = DVec3::ZERO;
        turn[axis] = t;
        q *= DQuat::from_vec4(turn.extend(1.0));
        // The momentum stays in the world, so in the body it turns the other way.
        let scale = 1.0 / (1.0 + t * t);
        let (cos, sin) = ((1.0 - t * t) * scale, 2.0 * t * scale);
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let (x, y) = (momentum[i], momentum[j]);
        momentum[i] = cos * x + sin * y;
        momentum[j] = cos * y - sin * x;
    }
    let q = q.normalize();
    (q.as_quat(), (q * (momentum * m)).as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::rotation::{rotate, rotate_back};

    /// Section 2.4 of the collected known answers: the box of the Gazebo benchmark, ten seconds at 1 ms.
    #[test]
    fn a_free_top_keeps_energy_and_angular_momentum() {
        let moments = Vec3::new(0.808_333, 0.683_333, 0.141_667);
        let (mut q, mut w) = (Quat::IDENTITY, Vec3::new(0.1, 5.0, 0.1));
        let world_momentum = |q: Quat, w: Vec3| rotate(q, rotate_back(q, w) * moments);
        let energy = |q: Quat, w: Vec3| 0.5 * w.dot(world_momentum(q, w));
        let (l0, e0) = (world_momentum(q, w), energy(q, w));
        let (mut worst_l, mut worst_e, mut flips) = (0.0_f32, 0.0_f32, Vec::new());
        let mut before = rotate_back(q, w).y;
        for step in 0..10_000 {
            (q, w) = spin(q, w, 1.0 / moments, 1e-3);
            worst_l = worst_l.max((world_momentum(q, w) - l0).length() / l0.length());
            worst_e = worst_e.max((energy(q, w) - e0).abs() / e0);
            let now = rotate_back(q, w).y;
            if now * before < 0.0 {
                flips.push(step as f32 * 1e-3);
            }
            before = now;
        }
        assert!(worst_l < 5e-5, "angular momentum drifts by {worst_l}");
        assert!(worst_e < 1e-4, "energy drifts by {worst_e}");
        // The sign changes of ω_y, from a reference integration; single precision shifts them a little, since the
        // motion starts next to the unstable axis.
        for (flip, exact) in flips.iter().zip([1.165_96, 4.194_382, 7.222_804]) {
            assert!((flip - exact).abs() < 0.02, "{flips:?}");
        }
        assert_eq!(flips.len(), 3);
    }

    #[test]
    fn a_symmetric_top_precesses_at_its_rate() {
        // Body-cone rate (I₃ − I₁) ω₃ / I₁ about the axis of symmetry.
        let moments = Vec3::new(0.04, 0.04, 0.02);
        let (mut q, mut w) = (Quat::IDENTITY, Vec3::new(1.0, 0.0, 10.0));
        let rate = (0.02_f32 - 0.04) * 10.0 / 0.04;
        for _ in 0..1000 {
            (q, w) = spin(q, w, 1.0 / moments, 1e-3);
        }
        let body = rotate_back(q, w);
        let expected = Vec3::new(rockfall_math::trig::cos(rate), rockfall_math::trig::sin(rate), 10.0);
        assert!((body - expected).length() < 1e-3, "{body} {expected}");
    }

    #[test]
    fn second_order() {
        let moments = Vec3::new(0.8, 0.6, 0.2);
        let run = |n: u32| {
            let (mut q, mut w) = (Quat::IDENTITY, Vec3::new(1.0, 2.0, 3.0));
            for _ in 0..n {
                (q, w) = spin(q, w, 1.0 / moments, 1.0 / n as f32);
            }
            w
        };
        let exact = run(2048);
        let (coarse, fine) = ((run(32) - exact).length(), (run(64) - exact).length());
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.2, "{order}");
    }
}
