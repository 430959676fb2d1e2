//! Slender bodies: rods, needles, blades.
//!
//! A rod of 1:1000 has two millionths of the moment about its own axis that it has across, i of I, and two things of a step that do others no harm
//! drive it faster and faster.
//!
//! **Arms and inertia that stay behind.** Contacts keep their arms, and bodies their inertia, through all sub-steps. When the rod has tipped by θ, the axis that it
//! had when the step began lies across by θ. A blow makes it turn about that old axis as if it had i there: what was next to no energy is I/i θ² times as much about the new one, fifty times at a
//! hundredth of a radian. So contacts see the angular velocity of a slender body in axes that tip with it, T⁻¹ ω, where T is the shortest turn from the direction that
//! its axis had to the one that it has. There its inertia is what it was, and so ½ ω · I ω is the energy that contacts deal with: each takes from it as much as its impulse times the
//! speed that it sees, and what brakes can't drive. The axes don't roll with the rod: what rolls by radians in a sub-step would be seen to tip another way in each.
//! [`carried`] takes velocities there, and [`uncarried`] back when the step is over. What it leaves out is the turn of the arm, θ, as for all bodies.
//!
//! **Free flight.** Turns about the three principal axes (see [`crate::drift`]) give and take I ω² h of momentum about the long axis, that cancel to third order; what is left
//! is little beside I, not beside i: a rod that tumbled at 20 rad/s had 13 times its energy now and then. The turns of [`spin_slender`] are those of a ball and what a slender top differs by.

use rockfall_math::rotation::{between, compose, rotate, rotate_back};
use rockfall_math::{DQuat, DVec3, Quat, Vec3};

/// Bodies are slender whose largest principal moment is so many times the smallest: rods from 1:14 on. Others are as they are: what a step may add to their
/// energy is less than what the blow takes.
const SLENDER: f32 = 100.0;

/// Which of its principal axes a body is slender along, if it is, by its inverse moments.
#[inline]
pub fn long_axis(inverse_moments: Vec3) -> Option<usize> {
    let (least, most) = (inverse_moments.min_element(), inverse_moments.max_element());
    let slender = least > 0.0 && most > SLENDER * least;
    slender.then(|| (0..3).find(|&i| inverse_moments[i] == most).unwrap_or(0))
}

/// The shortest turn from where principal axis `axis` points in one attitude (principal axes to world) to where it points in another.
fn tip(axis: usize, from: Quat, to: Quat) -> Quat {
    between(rotate(from, Vec3::AXES[axis]), rotate(to, Vec3::AXES[axis]))
}

/// An angular velocity as contacts see it in a step that began with attitude `from`, when it is `now`.
#[inline]
pub fn carried(w: Vec3, axis: usize, from: Quat, now: Quat) -> Vec3 {
    rotate_back(tip(axis, from, now), w)
}

/// The other way round.
#[inline]
pub fn uncarried(w: Vec3, axis: usize, from: Quat, now: Quat) -> Vec3 {
    rotate(tip(axis, from, now), w)
}

/// The attitude of a body from its principal axes to the world.
#[inline]
pub fn attitude(rotation: Quat, frame: Quat) -> Quat {
    compose(rotation, frame)
}

/// [`crate::drift::spin`] of a body that is slender along principal axis `axis`.
///
/// ½ L · m L is ½ m₁ L², of a ball, ½ (m₀ − m₁) L₀², of a turn about the long axis, and ½ (m₂ − m₁) L₂², where m₂ − m₁ is i/I of m₁ at most, since no moment is more than
/// the sum of the others. Each is a turn about a line that stays, the first two don't know each other, and the last one is small; so with half of it before and half after them the
/// energy is off by as little as for others.
pub fn spin_slender(q: Quat, w: Vec3, inverse_moments: Vec3, axis: usize, h: f32) -> (Quat, Vec3) {
    let m = inverse_moments.as_dvec3();
    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut q = q.as_dquat().normalize();
    let mut momentum = (q.inverse() * w.as_dvec3()) / m;
    let half = 0.5 * f64::from(h);
    // By half of the time, about a principal axis; returns the momentum then.
    let mut turn = |about: usize, rate: f64, q: &mut DQuat| {
        let t = half * rate * momentum[about];
        let mut line = DVec3::ZERO;
        line[about] = t;
        *q *= DQuat::from_vec4(line.extend(1.0));
        let scale = 1.0 / (1.0 + t * t);
        let (cos, sin) = ((1.0 - t * t) * scale, 2.0 * t * scale);
        let (i, j) = ((about + 1) % 3, (about + 2) % 3);
        let (x, y) = (momentum[i], momentum[j]);
        momentum[i] = cos * x + sin * y;
        momentum[j] = cos * y - sin * x;
        momentum
    };
    turn(third, 0.5 * (m[third] - m[second]), &mut q);
    let seen = turn(axis, m[axis] - m[second], &mut q);
    q *= DQuat::from_vec4((seen * (half * m[second])).extend(1.0));
    let momentum = turn(third, 0.5 * (m[third] - m[second]), &mut q);
    let q = q.normalize();
    (q.as_quat(), (q * (momentum * m)).as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drift::spin;
    use rockfall_math::rotation::from_rotation_vector;

    /// The moments of a rod of 1 m, 1 mm and 1 kg, along each axis.
    fn rods() -> [(usize, Vec3); 3] {
        let (own, across) = (6e6, 12.0);
        [0, 1, 2].map(|axis| {
            let mut m = Vec3::splat(across);
            m[axis] = own;
            (axis, m)
        })
    }

    fn energy(q: Quat, w: Vec3, m: Vec3) -> f64 {
        let w = rotate_back(q, w).as_dvec3();
        0.5 * w.dot(w / m.as_dvec3())
    }

    /// A second of sub-steps at 60 Hz and at 1 kHz. Turns about the three axes would give it up to 13 times its energy.
    #[test]
    fn a_rod_that_tumbles_keeps_its_energy_and_its_momentum() {
        for (axis, m) in rods() {
            for (steps, rate) in [(240, 240.0_f32), (4000, 4000.0)] {
                let mut q = from_rotation_vector(Vec3::new(0.3, -0.5, 0.2));
                let mut w = Vec3::splat(14.0);
                w[axis] = 3.0;
                w = rotate(q, w);
                let momentum = |q: Quat, w: Vec3| rotate(q, rotate_back(q, w) / m);
                let (before, l) = (energy(q, w, m), momentum(q, w));
                let mut others = (q, w);
                let mut most = 0.0_f64;
                for _ in 0..steps {
                    (q, w) = spin_slender(q, w, m, axis, 1.0 / rate);
                    others = spin(others.0, others.1, m, 1.0 / rate);
                    most = most.max(energy(others.0, others.1, m) / before);
                    assert!((energy(q, w, m) / before - 1.0).abs() < 1e-3, "{axis} {rate}");
                    assert!((momentum(q, w) - l).length() < 1e-3 * l.length(), "{axis} {rate}");
                }
                assert!(axis != 1 || most > 1.05, "{most}");
            }
        }
    }

    /// As the general one where both are good: a body of 1:12 in small steps.
    #[test]
    fn it_turns_as_others_do() {
        let m = Vec3::new(1.0, 100.0, 1.01);
        let (mut a, mut b) =
            ((Quat::IDENTITY, Vec3::new(2.0, 5.0, 1.0)), (Quat::IDENTITY, Vec3::new(2.0, 5.0, 1.0)));
        for _ in 0..2000 {
            a = spin_slender(a.0, a.1, m, 1, 5e-4);
            b = spin(b.0, b.1, m, 5e-4);
        }
        assert!((a.1 - b.1).length() < 1e-2, "{a:?} {b:?}");
    }

    /// The energy that contacts see, with the inertia that the step began with, is that of the body.
    #[test]
    fn carried_velocities_have_the_energy_of_the_body() {
        for (axis, m) in rods() {
            let from = from_rotation_vector(Vec3::new(0.1, 0.7, -0.4));
            let now = compose(from_rotation_vector(Vec3::new(0.3, -0.2, 0.4)), from);
            let w = Vec3::new(3.0, -8.0, 5.0);
            let seen = carried(w, axis, from, now);
            let share = energy(from, seen, m) / energy(now, w, m);
            assert!((share - 1.0).abs() < 1e-3, "{share}");
            assert!((uncarried(seen, axis, from, now) - w).length() < 1e-5);
            assert_eq!(
                (long_axis(m), long_axis(Vec3::new(12.0, 12.0, 6.0)), long_axis(Vec3::ZERO)),
                (Some(axis), None, None)
            );
        }
    }
}
