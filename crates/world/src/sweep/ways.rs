//! How bodies go in a step, block by block of the movers' tree: most of those around a fast body go its way, and are passed over together.

use super::Scene;
use super::flight::way;
use rockfall_math::{Aabb, Vec3};
use rockfall_tree::Fold;

/// The motion of one body in the step, or bounds on those of several.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Least and largest translation along each axis, metres.
    low: Vec3,
    high: Vec3,
    /// How far turning takes a point of one of them at most, metres.
    spin: f32,
    /// The smallest inner radius, metres.
    inner: f32,
}

impl Ways {
    const NONE: Ways =
        Ways { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, spin: 0.0, inner: f32::INFINITY };

    /// Those of all bodies that can move.
    pub(super) fn of_all(scene: &Scene<'_>) -> Fold<Ways> {
        scene.trees.movers.fold(Ways::NONE, |row| Ways::of(scene, row), Ways::join)
    }

    pub(super) fn of(scene: &Scene<'_>, row: u32) -> Self {
        let (way, turn) = way(scene.bodies, row);
        let row = row as usize;
        let arm = if scene.bodies.balls[row] { 0.0 } else { scene.bodies.radii[row] };
        Ways { low: way, high: way, spin: turn.length() * arm, inner: scene.bodies.inners[row] }
    }

    fn join(self, other: Ways) -> Ways {
        Ways {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            spin: self.spin.max(other.spin),
            inner: self.inner.min(other.inner),
        }
    }

    /// Whether a body goes so much the same way as all of some others that it can't get through any in this step: a point of one goes by less than
    /// the smaller inner radius, seen from the other. Contacts push that out again.
    pub(super) fn is_calm(&self, others: &Ways) -> bool {
        let most = (self.low - others.high).abs().max((self.high - others.low).abs());
        most.length() + self.spin + others.spin < self.inner.min(others.inner)
    }

    /// Where bodies must be at the start of the step to come into `area` in it.
    pub(super) fn reached_from(&self, area: &Aabb) -> Aabb {
        let (low, high) = (self.low.min(Vec3::ZERO).as_dvec3(), self.high.max(Vec3::ZERO).as_dvec3());
        Aabb::around(area.min.as_dvec3() - high, area.max.as_dvec3() - low).grown(self.spin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn going(x: f32) -> Ways {
        Ways { low: Vec3::X * x, high: Vec3::X * x, spin: 0.0, inner: 0.1 }
    }

    #[test]
    fn what_is_calm_with_all_is_calm_with_each() {
        let (slow, fast) = (going(1.0), going(1.15));
        let both = slow.join(fast).join(Ways::NONE);
        for (x, calm) in [(1.0, [true, false]), (1.07, [true, true]), (1.2, [false, true])] {
            let own = going(x);
            assert_eq!([own.is_calm(&slow), own.is_calm(&fast)], calm);
            assert_eq!(own.is_calm(&both), calm == [true, true]);
        }
        let spins = Ways { spin: 0.05, ..fast };
        assert!(going(1.11).is_calm(&spins) && !going(1.09).is_calm(&spins));
        let thin = Ways { inner: 0.01, ..fast };
        assert!(going(1.155).is_calm(&thin) && !going(1.17).is_calm(&thin));
    }

    #[test]
    fn bodies_come_from_where_they_were() {
        let area = Aabb::new(Vec3::ZERO, Vec3::ONE);
        let from = going(-2.0).join(going(0.5)).reached_from(&area);
        assert_eq!(from, Aabb::new(Vec3::new(-0.5, 0.0, 0.0), Vec3::new(3.0, 1.0, 1.0)));
        // What turns only may reach out.
        let turns = Ways { spin: 0.25, ..going(0.0) };
        assert_eq!(turns.reached_from(&area), area.grown(0.25));
    }
}
