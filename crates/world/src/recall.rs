//! What a pair knows from one step to the next, and for how long that serves.
//!
//! Each body counts the way that it has gone; a pair that was looked at sets a mark on the sum of both counts. Until the sum has come to
//! the mark, bodies that were apart still are, and the manifold of those that touch has only to follow them: points keep
//! their places on both surfaces, signed distances change with them. In a pile at rest this spares almost all collision
//! detection. The bound is conservative: it counts all motion, also that which the two have in common.

use crate::Shape;
use rockfall_collide::Cache;
use rockfall_solve::Drift;

/// Share of the smaller inner radius by which two bodies may move while their manifold only follows them.
const LOOSE: f32 = 5e-3;

/// The same for two balls, whose contact follows exactly but for rounding. While it is not looked at it stays, also where the balls have
/// parted: up to a gap of as much.
const LOOSE_BALLS: f32 = 0.2;

/// Counts of a metre: way is counted in nanometres, modulo 2³². No step adds more than [`LEAP`] to a count and no mark is
/// further ahead than [`AHEAD`], so that a difference of counts is never mistaken.
const METRE: f32 = 1e9;
const LEAP: f32 = 0.7e9;
const AHEAD: f32 = 0.5e9;

/// What a step adds to the count of a body that moves at all freely, 1 µm, however little it moves. A contact that follows loses motions too
/// small for single precision, up to 3e-8 of the way between the centres in a step; so each is looked at again in time.
pub(crate) const CREEP: u32 = 1000;

/// The count of a body that was put somewhere else is moved on by so much: past every mark.
pub(crate) const ELSEWHERE: u32 = LEAP as u32;

/// What a pair remembers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Recall {
    /// Of the pair function.
    pub(crate) cache: Cache,
    /// The sum of both bodies' counts at which the pair has to be looked at again.
    pub(crate) mark: u32,
}

impl Recall {
    /// Way that is left until the pair has to be looked at, metres.
    pub(crate) fn left(&self, count: u32) -> f32 {
        self.mark.wrapping_sub(count) as i32 as f32 / METRE
    }

    /// Sets the mark for `way` metres more.
    pub(crate) fn set(&mut self, count: u32, way: f32) {
        self.mark = count.wrapping_add(count_below(way));
    }
}

/// A length in counts, rounded down a little more than single precision errs by, and not beyond [`AHEAD`].
pub(crate) fn count_below(length: f32) -> u32 {
    (length * (METRE * (1.0 - 1e-6))).min(AHEAD) as u32
}

/// A length in counts, rounded up, so that whatever moves gets on; [`LEAP`] at most.
pub(crate) fn count_of(length: f32) -> u32 {
    (length * (METRE * (1.0 + 1e-6))).min(LEAP).ceil() as u32
}

/// What a body's motion in a step adds to its count, `radius` being the distance of its farthest point from its centre.
pub(crate) fn way(drift: &Drift, radius: f32) -> u32 {
    count_of(drift.translation().length() + drift.rotation().length() * radius)
}

/// How far two bodies may move while their manifold only follows them, metres. Nothing where a shape is round and the other is not: a ball
/// that rolls does not take its contact along.
pub(crate) fn looseness(a: &Shape, b: &Shape, balls: bool) -> f32 {
    if balls {
        return LOOSE_BALLS * a.inner_radius().min(b.inner_radius());
    }
    let of = |shape: &Shape| match shape {
        Shape::Sphere { .. } | Shape::Capsule { .. } => 0.0,
        Shape::Box { .. } | Shape::Hull(_) => LOOSE * shape.inner_radius(),
        Shape::HalfSpace { .. } | Shape::Mesh(_) | Shape::HeightField(_) => f32::INFINITY,
    };
    of(a).min(of(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::Vec3;

    fn drift(translation: Vec3, rotation: Vec3) -> Drift {
        let mut drift = Drift::default();
        drift.set(translation, rotation);
        drift
    }

    #[test]
    fn marks_are_passed_in_time_also_when_counts_wrap() {
        for start in [0, u32::MAX - 5, 1 << 31] {
            let mut recall = Recall::default();
            recall.set(start, 1e-3);
            assert!((recall.left(start) - 1e-3).abs() < 1e-8);
            let step = drift(Vec3::new(3e-4, 0.0, 0.0), Vec3::new(0.0, 1e-4, 0.0));
            let count = start.wrapping_add(2 * way(&step, 1.0));
            assert!((recall.left(count) - 2e-4).abs() < 1e-7);
            assert!(recall.left(count.wrapping_add(way(&step, 1.0))) < 0.0);
            // The largest leaps of both bodies from the furthest mark.
            recall.set(start, 1e9);
            let far = way(&drift(Vec3::splat(1e5), Vec3::ZERO), 1.0);
            assert!(recall.left(start.wrapping_add(2 * far)) < 0.0);
        }
        assert_eq!(way(&Drift::default(), 1.0), 0);
        assert!(way(&drift(Vec3::splat(1e-12), Vec3::ZERO), 1.0) > 0);
    }
}
