//! The inertia of a slender body over a step.
//!
//! Reads principal moments and by how much a body may turn in a step; gives the moments that contacts meet.
//!
//! Contacts keep their arms, and bodies their inertia, through all sub-steps of a step. A rod of 1:1000 has two millionths of the moment about
//! its own axis that it has across, i of I. A blow while it tips by θ makes it turn about the axis that it had when the step began, which lies across by θ
//! meanwhile; what was next to no energy about the one is I/i θ² times as much about the other: fifty times at a hundredth of a radian. A needle that fell on a
//! floor by itself, at 60 Hz, was thrown about faster and faster by that, until it was frozen.
//!
//! A body that turns by θ is, about the axis that it starts with, as hard to turn as i cos² θ + I sin² θ at the end of the step. That is the moment it has
//! for contacts, to second order: i + (I − i) θ². What rests or slides slowly keeps its own, and shorter steps take less.
//!
//! The angular velocity that contacts see is that of axes that tip with the body (`rockfall_solve::slender`); this is for the arms, that don't. Without it rods of two
//! heaps of twenty spun at up to 4,400 rad/s, with it at 420.

use rockfall_math::Vec3;
use rockfall_solve::slender::long_axis;

/// Whether a body with these inverse moments is slender.
pub(crate) fn is_slender(inverse_moments: Vec3) -> bool {
    long_axis(inverse_moments).is_some()
}

/// The inverse moments for contacts in a step in which a body turns by up to `turn`, rad, about its principal axes.
pub(crate) fn over_turn(inverse_moments: Vec3, turn: Vec3) -> Vec3 {
    let moments = 1.0 / inverse_moments;
    let squared = (turn * turn).min(Vec3::ONE);
    let of = |i: usize| {
        let mixed = |other: usize, about: usize| (moments[other] - moments[i]).max(0.0) * squared[about];
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        inverse_moments[i] / (1.0 + inverse_moments[i] * (mixed(j, k) + mixed(k, j)))
    };
    Vec3::new(of(0), of(1), of(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::{Mat3, trig};

    const ROD: Vec3 = Vec3::new(1e6, 2.0, 2.5);

    #[test]
    fn what_rests_or_rolls_keeps_its_moments() {
        assert_eq!(over_turn(ROD, Vec3::ZERO), ROD);
        // About its own axis nothing but the two moments across is mixed.
        let rolled = over_turn(ROD, Vec3::X * 0.01);
        assert!(rolled.x == ROD.x && rolled.y == ROD.y && (rolled.z - 1.0 / (0.4 + 0.1 * 1e-4)).abs() < 1e-6);
        assert!(is_slender(ROD) && !is_slender(Vec3::new(12.0, 12.0, 6.0)) && !is_slender(Vec3::ZERO));
    }

    /// The moment about the axis that the step began with, of the body as it is turned at its end.
    #[test]
    fn what_tips_is_as_hard_to_turn_as_at_the_end_of_its_turn() {
        for angle in [1e-3_f32, 1e-2, 0.1] {
            let (sin, cos) = trig::sin_cos(angle);
            let turned = Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z);
            let inertia = turned * Mat3::from_diagonal(1.0 / ROD) * turned.transpose();
            let ours = 1.0 / over_turn(ROD, Vec3::Z * angle).x;
            assert!((ours / inertia.x_axis.x - 1.0).abs() < angle * angle + 1e-5, "{ours} {inertia}");
        }
    }
}
