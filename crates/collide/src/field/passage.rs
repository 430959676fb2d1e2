//! Where a field has to be stopped so that it does not pass through another field or a convex body.
//!
//! The rule is that of convex bodies (`crate::passage`), and so is the walk, conservative advancement. The distance is the least that a sample of one has from the other, so what is smaller than the spacing
//! is not seen. A surface that is a layer below the other one has reached its core.

use super::side::Side;
use crate::passage::{gone, stay_apart};
use crate::time_of_impact::{LAYERS, MAX_STEPS, NEAR, SUNK};
use crate::{Sweep, Toi};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{Balls, SAMPLES_IN_A_BALL, Shape};
use std::cell::Cell;

/// What counts as reached, as a share of the smaller inner radius.
const REACHED: f32 = 0.02;

/// The sample that is furthest in the other body, or nearest to it.
#[derive(Clone, Copy)]
struct Gap {
    /// A distance that it surely has where it is outside, else what a field says, metres.
    distance: f32,
    /// Whose sample it is, 0 or 1, and its number.
    side: usize,
    sample: usize,
}

/// Two bodies on their way, each in its own frame.
struct Course<'a> {
    sides: [Side<'a>; 2],
    sweep: &'a Sweep,
    /// No point of one goes by more than that, seen from the other, metres.
    rate: f32,
    /// The smaller inner radius, metres.
    thin: f32,
}

/// When a field `a` has to be stopped at `b`, a field, a half-space or anything convex: `target` metres from it, or on its way into it.
pub(crate) fn passage(a: &Shape, b: &Shape, sweep: &Sweep, target: f32) -> Option<Toi> {
    let radii = [radius(a, sweep.a.center), radius(b, sweep.b.center)];
    let rate = gone(radii, sweep);
    let thin = a.inner_radius().min(b.inner_radius());
    let layer = SUNK * thin;
    if !sweep.is_finite() || target.is_nan() || rate < layer || stay_apart(radii, sweep, target) {
        return None;
    }
    let sides = [a, b].map(|shape| Side::new(shape, Isometry::IDENTITY, 0.0));
    let course = Course { sides, sweep, rate, thin };
    let start = course.gap(0.0, Gap { distance: f32::INFINITY, side: 0, sample: 0 });
    if start.distance > NEAR * thin {
        let (touch, gap) = course.advance(start, 0.0, target.max(0.0))?;
        course.advance(gap, touch, -layer)?;
        return course.toi(touch, gap);
    }
    // Near each other from the start: when one sinks into the other by one layer more than it has.
    let sunk = (0..=LAYERS).find(|&layers| start.distance > -layer * layers as f32)?;
    let (time, gap) = course.advance(start, 0.0, -layer * (sunk + 1) as f32)?;
    course.toi(time, gap)
}

/// Of a ball around a shape about a point, metres; of a field around its bounds, since for the smallest one all corners would be asked.
fn radius(shape: &Shape, center: Vec3) -> f32 {
    match shape {
        Shape::Field(field) => {
            let bounds = &field.mesh().bounds;
            (center - bounds.min).abs().max((bounds.max - center).abs()).length()
        }
        _ => shape.radius_about(center),
    }
}

impl Course<'_> {
    /// The first time from `time` on, where the gap is `gap`, at which it is no more than `level`.
    fn advance(&self, mut gap: Gap, mut time: f32, level: f32) -> Option<(f32, Gap)> {
        for _ in 0..MAX_STEPS {
            let left = gap.distance - level;
            if left <= REACHED * self.thin {
                break;
            }
            time += left / self.rate;
            if time >= 1.0 {
                return None;
            }
            gap = self.gap(time, gap);
        }
        Some((time, gap))
    }

    /// The least distance of a sample at a time. `guess` is one that is looked at first, since most others are further off.
    fn gap(&self, time: f32, guess: Gap) -> Gap {
        let [a, b] = [self.sweep.a.at(time), self.sweep.b.at(time)];
        let to_other = [b.inverse().then_after(&a), a.inverse().then_after(&b)];
        let first = self.sides[guess.side].field().map_or(f32::INFINITY, |own| {
            let p = own.samples().points()[guess.sample].position;
            let alone = [p.x, p.y, p.z, 0.0].map(|x| [x; SAMPLES_IN_A_BALL]);
            self.distances(guess.side, &alone, &to_other[guess.side])[0]
        });
        let least = Cell::new(Gap { distance: first, ..guess });
        for (side, to_other) in to_other.iter().enumerate() {
            let (Some(own), other) = (self.sides[side].field(), &self.sides[1 - side]) else { continue };
            own.samples().search(
                |balls| other.least_gaps(balls, to_other),
                |gap| gap < least.get().distance,
                |numbers, points| {
                    for (sample, distance) in numbers.zip(self.distances(side, points, to_other)) {
                        if distance < least.get().distance {
                            least.set(Gap { distance, side, sample });
                        }
                    }
                },
            );
        }
        least.get()
    }

    /// Of eight samples, see [`Gap::distance`].
    fn distances(&self, side: usize, points: &Balls, to_other: &Isometry) -> [f32; SAMPLES_IN_A_BALL] {
        let other = &self.sides[1 - side];
        match other.field() {
            // Out of the box that the field covers, what is sure is more than what it estimates less its bound.
            Some(field) => field.distances_below(points, to_other, &other.place, f32::NEG_INFINITY).map(
                |said| match said {
                    Ok(distance) if distance > 0.0 => (distance - field.bound(distance)).max(0.0),
                    Ok(distance) | Err(distance) => distance,
                },
            ),
            None => std::array::from_fn(|i| {
                let p = to_other.point(Vec3::new(points[0][i], points[1][i], points[2][i]));
                other.nearest(p, f32::INFINITY).map_or(f32::INFINITY, |near| near.distance)
            }),
        }
    }

    fn toi(&self, time: f32, gap: Gap) -> Option<Toi> {
        let places = [self.sweep.a.at(time), self.sweep.b.at(time)];
        let sample = self.sides[gap.side].field()?.samples().points()[gap.sample];
        let point = places[gap.side].point(sample.position);
        let other = places[1 - gap.side];
        let near = self.sides[1 - gap.side].nearest(other.inverse_point(point), f32::INFINITY)?;
        let out = other.vector(near.normal);
        let distance = gap.distance.max(0.0);
        let (normal, point) = if gap.side == 0 { (-out, point) } else { (out, point - near.distance * out) };
        Some(Toi { time, normal, point, distance })
    }
}
