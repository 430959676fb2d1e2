//! A body's pose in twelve bytes.

use rockfall_math::{Quat, Vec3};
use std::f32::consts::FRAC_1_SQRT_2;

/// A pose; [`wire`](super) tells its bits.
pub type Record = [u32; 3];

/// A body that is not there.
pub const ABSENT: Record = [PLACE, 0, 0];

/// The most that a rotation is off, rad. Each of three numbers is off by half of √2 / 2047; the fourth, which follows from them, by at most three times that since it is at least as large as each; the
/// angle is twice the length of all four.
pub const ROTATION_ERROR: f32 = 0.0025;

const PLACE_BITS: u32 = 20;
const PLACE: u32 = (1 << PLACE_BITS) - 1;
const MIDDLE: i64 = 1 << (PLACE_BITS - 1);
const TURN: u32 = (1 << 11) - 1;

/// Even steps in which positions are told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Metres, a power of two.
    pub step: f32,
}

impl Grid {
    /// The finest one that reaches so far from the origin, metres.
    pub fn reaching(distance: f32) -> Grid {
        let mut grid = Grid { step: f32::exp2(-24.0) };
        while grid.reach() < distance && grid.step < 1e6 {
            grid.step *= 2.0;
        }
        grid
    }

    /// How far from the origin it reaches on each axis, metres.
    pub fn reach(self) -> f32 {
        self.step * (MIDDLE - 2) as f32
    }

    /// A pose, `position` in metres from the origin of the grid. What is beyond the reach is [`ABSENT`].
    pub fn record(self, position: Vec3, rotation: Quat, asleep: bool) -> Record {
        let place = position.to_array().map(|x| (f64::from(x) / f64::from(self.step)).round());
        if !place.iter().all(|x| x.abs() < (MIDDLE - 1) as f64) || !rotation.is_finite() {
            return ABSENT;
        }
        let all = rotation.to_array();
        let largest = (0..4).fold(0, |best, k| if all[k].abs() > all[best].abs() { k } else { best });
        let sign = if all[largest] < 0.0 { -1.0 } else { 1.0 };
        let mut others = (0..4).filter(|&k| k != largest).map(|k| {
            let share = (sign * all[k] / FRAC_1_SQRT_2).clamp(-1.0, 1.0);
            ((0.5 + 0.5 * share) * TURN as f32).round() as u32
        });
        let top = [largest as u32 & 1, largest as u32 >> 1, u32::from(asleep)];
        std::array::from_fn(|axis| {
            let place = (place[axis] as i64 + MIDDLE) as u32;
            place | others.next().unwrap_or_default() << PLACE_BITS | top[axis] << 31
        })
    }

    /// The pose of a record and whether the body sleeps, as the page reads it; `None` of one that is not there.
    pub fn pose(self, record: Record) -> Option<(Vec3, Quat, bool)> {
        if record[0] & PLACE == PLACE {
            return None;
        }
        let place =
            record.map(|word| ((i64::from(word & PLACE) - MIDDLE) as f64 * f64::from(self.step)) as f32);
        let three = record.map(|word| {
            let share = (word >> PLACE_BITS & TURN) as f32 / TURN as f32;
            (2.0 * share - 1.0) * FRAC_1_SQRT_2
        });
        let largest = (record[0] >> 31 | record[1] >> 31 << 1) as usize;
        let mut all = [0.0; 4];
        (0..4).filter(|&k| k != largest).zip(three).for_each(|(k, x)| all[k] = x);
        all[largest] = (1.0 - three.iter().map(|x| x * x).sum::<f32>()).max(0.0).sqrt();
        Some((Vec3::from_array(place), Quat::from_array(all), record[2] >> 31 == 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    fn share(k: u64) -> f32 {
        (mix(k) >> 40) as f32 / (1_u64 << 24) as f32
    }

    #[test]
    fn poses_come_back_within_the_bounds() {
        let grid = Grid::reaching(300.0);
        assert_eq!(grid.step, 1.0 / 1024.0);
        let mut worst = 0.0_f32;
        for k in 0..200_000 {
            let number = |i: u64| 2.0 * share(8 * k + i) - 1.0;
            let position = Vec3::new(number(0), number(1), number(2)) * 300.0;
            // Also where several are equally large.
            let raw = if k % 4 == 0 {
                Quat::from_xyzw(1.0, number(3).signum(), -1.0, 1.0 + 1e-4 * number(4))
            } else {
                Quat::from_xyzw(number(3), number(4), number(5), number(6))
            };
            let rotation = raw.normalize();
            let (p, q, asleep) = grid.pose(grid.record(position, rotation, k % 3 == 0)).unwrap();
            assert!((p - position).abs().max_element() <= 0.5 * grid.step * 1.001, "{p} {position}");
            assert_eq!(asleep, k % 3 == 0);
            let angle = 2.0 * (1.0 - f64::from(q.dot(rotation)).powi(2)).max(0.0).sqrt();
            worst = worst.max(angle as f32);
        }
        assert!(worst < ROTATION_ERROR, "{worst}");
        assert!(worst > 0.2 * ROTATION_ERROR, "{worst}: the bound says nothing");
    }

    #[test]
    fn what_is_too_far_or_no_number_is_not_there() {
        let grid = Grid::reaching(10.0);
        for bad in [Vec3::X * 1e3, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(grid.record(bad, Quat::IDENTITY, false), ABSENT);
        }
        assert_eq!(grid.record(Vec3::ZERO, Quat::NAN, false), ABSENT);
        assert!(grid.pose(ABSENT).is_none());
        assert!(grid.pose(grid.record(Vec3::splat(grid.reach()), Quat::IDENTITY, false)).is_some());
    }
}
