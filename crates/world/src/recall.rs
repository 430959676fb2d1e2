//! What a pair knows from one step to the next, and for how long that serves.
//!
//! Each body counts the way that it has gone, and by how much it reaches further; a pair that was looked at and is apart sets a mark on the
//! sum of both counts: until the sum has come to the mark, the bodies are out of reach still. The bound is conservative: it counts all motion, also that which the two have in common.
//! The contacts of those that touch have only to follow them, until the two have gone so far relative to each other as [`leash`]
//! says: points keep their places on both surfaces, signed distances change with them. In a pile at rest this spares almost
//! all collision detection, and much of it in a heap that slides.

use crate::Shape;
use rockfall_collide::Cache;
use rockfall_solve::{Drift, Leash};

/// Share of the smaller inner radius by which two bodies may move relative to each other while their manifold only follows them.
const LOOSE: f32 = 5e-3;

/// Of a field, in place of the inner radius, its contact scale; and more where the user allows more: so much of its error, up to that share. Found anew at every tremor, contacts of curved bodies of many triangles are other ones at each.
const ERRING: f32 = 0.25;
const LOOSEST: f32 = 0.02;

/// The same for two balls, whose contact follows exactly but for rounding. While it is not looked at it stays, also where the balls have
/// parted: up to a gap of as much.
const LOOSE_BALLS: f32 = 0.2;

/// Counts of a metre: way is counted in nanometres, modulo 2³². No step adds more than [`LEAP`] to a count and no mark is
/// further ahead than [`AHEAD`], so that a difference of counts is never mistaken.
const METRE: f32 = 1e9;
pub(crate) const LEAP: u32 = 700_000_000;
const AHEAD: f32 = 0.5e9;

/// What a pair remembers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Recall {
    /// Of the pair function.
    pub(crate) cache: Cache,
    /// The sum of both bodies' counts at which the pair has to be looked at again, if it has no contact.
    pub(crate) mark: u32,
}

impl Recall {
    /// Whether the pair need not be looked at yet.
    pub(crate) fn serves(&self, count: u32) -> bool {
        self.mark.wrapping_sub(count) as i32 > 0
    }

    /// Sets the mark for `way` metres more, if that is any.
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
    (length * (METRE * (1.0 + 1e-6))).min(LEAP as f32).ceil() as u32
}

/// What a body's motion in a step adds to its count, `radius` being the distance of its farthest point from its centre.
pub(crate) fn way(drift: &Drift, radius: f32) -> u32 {
    count_of(drift.translation().length() + drift.rotation().length() * radius)
}

/// How far two bodies may move relative to each other while their contacts only follow them. Nothing where both are round, but for balls: their normals turn with neither
/// of them. `radii` are the distances of their farthest points from their centres.
pub(crate) fn leash(a: &Shape, b: &Shape, radii: [f32; 2], balls: bool) -> Leash {
    if balls {
        let length = LOOSE_BALLS * a.inner_radius().min(b.inner_radius());
        return Leash { length, ..Leash::default() };
    }
    let (length, skin) = match (skin(a), skin(b)) {
        (0.0, 0.0) => (loose(a).min(loose(b)), 0.0),
        (skin, 0.0) if is_flat(b) => (loose(b).min(LOOSE * skin), skin),
        (0.0, skin) if is_flat(a) => (loose(a).min(LOOSE * skin), -skin),
        _ => return Leash::default(),
    };
    // All of the smaller body is within its diameter from the contact.
    Leash { length, lever: 2.0 * radii[0].min(radii[1]), skin }
}

/// The radius of a shape around its core, if all of its surface is at that distance from a point or a line.
fn skin(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
        _ => 0.0,
    }
}

/// Whether a shape is flat wherever a ball touches it: a field bends, and a compound may have round parts.
fn is_flat(shape: &Shape) -> bool {
    loose(shape) > 0.0 && !matches!(shape, Shape::Field(_) | Shape::Compound(_))
}

/// What a shape allows that touches a flat one.
fn loose(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { .. }
        | Shape::Capsule { .. }
        | Shape::Cylinder { .. }
        | Shape::Cone { .. }
        | Shape::Ellipsoid { .. } => 0.0,
        Shape::Field(field) => {
            let scale = shape.contact_scale();
            (ERRING * field.settings().error).clamp(LOOSE * scale, LOOSEST * scale)
        }
        Shape::Mesh(mesh) if mesh.inner_ball.1 > 0.0 => LOOSE * shape.contact_scale(),
        // On a flat side, where the rounded ones lie, they are like all others; on an edge they turn by a few milliradians at
        // the most before they are looked at again.
        Shape::Box { .. } | Shape::Hull(_) | Shape::RoundedBox { .. } | Shape::RoundedHull { .. } => {
            LOOSE * shape.inner_radius()
        }
        Shape::HalfSpace { .. } | Shape::Mesh(_) | Shape::HeightField(_) => f32::INFINITY,
        Shape::Compound(compound) => {
            compound.parts().iter().map(|part| loose(&part.shape)).fold(f32::INFINITY, f32::min)
        }
    }
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
            let step = drift(Vec3::new(3e-4, 0.0, 0.0), Vec3::new(0.0, 1e-4, 0.0));
            let count = |steps: u32| start.wrapping_add(steps * way(&step, 1.0));
            assert!(recall.serves(count(0)) && recall.serves(count(2)) && !recall.serves(count(3)));
            recall.set(start, -1e-3);
            assert!(!recall.serves(start));
            // The largest leaps of both bodies from the furthest mark.
            recall.set(start, 1e9);
            let far = way(&drift(Vec3::splat(1e5), Vec3::ZERO), 1.0);
            assert!(!recall.serves(start.wrapping_add(2 * far)));
        }
        assert_eq!(way(&Drift::default(), 1.0), 0);
        assert!(way(&drift(Vec3::splat(1e-12), Vec3::ZERO), 1.0) > 0);
    }
}
