//! The few points of a pair that carry it.
//!
//! A bowl in a bowl touches it all around, by dozens of points in as many directions. Each is a spring of its own to the solver, and all of them together are stiffer than its sweeps keep up with: stacks of
//! bowls shake. Eight points that are far from each other, and look as differently as they can, hold a body as well.
//!
//! Points that touch come first; of these the outermost along a fixed direction, then always the one that is farthest from those taken. The deepest takes the place of its nearest if none is as deep.

use crate::Manifold;
use crate::reduce::start;
use rockfall_math::Vec3;

/// So many points hold a pair.
pub(super) const MOST: usize = 8;

/// Depths that differ by less than this share of the span are equal.
const EQUAL: f32 = 1e-3;

/// A point with the number of its manifold.
#[derive(Clone, Copy)]
struct Held {
    manifold: usize,
    point: usize,
    at: Vec3,
    normal: Vec3,
    distance: f32,
}

/// Leaves the manifolds from number `first` on at most [`MOST`] points.
pub(super) fn keep_few(manifolds: &mut Vec<Manifold>, first: usize) {
    let all: Vec<Held> = manifolds[first..]
        .iter()
        .enumerate()
        .flat_map(|(manifold, m)| {
            m.points().iter().enumerate().map(move |(point, p)| Held {
                manifold,
                point,
                at: p.position,
                normal: m.normal,
                distance: p.distance,
            })
        })
        .collect();
    if all.len() <= MOST {
        return;
    }
    let mut kept = [[false; 4]; 1].repeat(manifolds.len() - first);
    for held in chosen(&all) {
        kept[held.manifold][held.point] = true;
    }
    for (manifold, kept) in manifolds[first..].iter_mut().zip(kept) {
        let old = *manifold;
        manifold.count = 0;
        for (point, _) in old.points().iter().zip(kept).filter(|(_, kept)| *kept) {
            manifold.points[manifold.count as usize] = *point;
            manifold.count += 1;
        }
    }
    manifolds.retain(|manifold| manifold.count > 0);
}

/// [`MOST`] of more points.
fn chosen(all: &[Held]) -> [Held; MOST] {
    let from = all[0].at;
    let span = all.iter().fold(0.0_f32, |span, held| span.max(held.at.distance(from)));
    // A turn of the normal by a radian counts as much as a way as long as the contact.
    let apart = |one: &Held, two: &Held| {
        one.at.distance_squared(two.at) + span * span * one.normal.distance_squared(two.normal)
    };
    let direction = start(all[0].normal);
    let worth = |held: &Held, by: f32| (held.distance <= 0.0, by);
    let best = |by: &dyn Fn(&Held) -> f32| {
        all.iter().fold((all[0], worth(&all[0], by(&all[0]))), |best, held| {
            let this = worth(held, by(held));
            if this > best.1 { (*held, this) } else { best }
        })
    };
    let mut chosen = [best(&|held| held.at.dot(direction)).0; MOST];
    for k in 1..MOST {
        let taken = chosen;
        let lonely =
            |held: &Held| taken[..k].iter().fold(f32::INFINITY, |near, other| near.min(apart(held, other)));
        // Where all that touch are taken, those that are open come next.
        let (next, _) = best(&|held| if lonely(held) > 0.0 { lonely(held) } else { f32::NEG_INFINITY });
        chosen[k] = if lonely(&next) > 0.0 {
            next
        } else {
            all.iter()
                .copied()
                .reduce(|one, two| if lonely(&two) > lonely(&one) { two } else { one })
                .unwrap_or(next)
        };
    }
    let deepest = all.iter().copied().reduce(|one, two| if two.distance < one.distance { two } else { one });
    let shown = chosen.iter().fold(f32::INFINITY, |least, held| least.min(held.distance));
    if let Some(deepest) = deepest.filter(|deepest| deepest.distance < shown - EQUAL * span) {
        let nearest = (1..MOST).fold(0, |near, k| {
            if apart(&chosen[k], &deepest) < apart(&chosen[near], &deepest) { k } else { near }
        });
        chosen[nearest] = deepest;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ContactPoint;
    use rockfall_math::trig;
    use std::f32::consts::TAU;

    /// A cone that touches another one around three circles, in twelve manifolds.
    fn cone(distance: impl Fn(usize, usize) -> f32) -> Vec<Manifold> {
        (0..12)
            .map(|i| {
                let (sin, cos) = trig::sin_cos(TAU * i as f32 / 12.0);
                let mut manifold = Manifold {
                    normal: Vec3::new(cos, sin, -1.0).normalize(),
                    count: 3,
                    ..Manifold::default()
                };
                for k in 0..3 {
                    let r = 1.0 + k as f32;
                    let position = Vec3::new(r * cos, r * sin, r);
                    manifold.points[k] =
                        ContactPoint { position, distance: distance(i, k), feature: (3 * i + k) as u32 };
                }
                manifold
            })
            .collect()
    }

    fn names(manifolds: &[Manifold]) -> Vec<u32> {
        manifolds.iter().flat_map(|m| m.points().iter().map(|p| p.feature)).collect()
    }

    #[test]
    fn eight_points_of_a_cone_are_all_around_it() {
        let mut manifolds = cone(|_, _| -1e-3);
        keep_few(&mut manifolds, 0);
        let points: Vec<Vec3> =
            manifolds.iter().flat_map(|m| m.points().iter().map(|p| p.position)).collect();
        assert_eq!(points.len(), MOST);
        for quarter in 0..8 {
            let (sin, cos) = trig::sin_cos(TAU * quarter as f32 / 8.0);
            let ahead = points
                .iter()
                .any(|p| p.truncate().normalize().dot(Vec3::new(cos, sin, 0.0).truncate()) > 0.8);
            assert!(ahead, "{quarter}: {points:?}");
        }
    }

    #[test]
    fn the_deepest_stays_and_what_is_open_comes_last() {
        for (i, k) in [(3, 0), (7, 1), (11, 2)] {
            let mut manifolds = cone(|a, b| if (a, b) == (i, k) { -0.1 } else { -1e-3 });
            keep_few(&mut manifolds, 0);
            assert!(names(&manifolds).contains(&((3 * i + k) as u32)));
        }
        // Four touch, and four of the others are kept.
        let mut manifolds = cone(|a, b| if a % 3 == 0 && b == 1 { -1e-3 } else { 1e-3 });
        keep_few(&mut manifolds, 0);
        let names = names(&manifolds);
        assert_eq!(names.len(), MOST);
        assert!([1, 10, 19, 28].iter().all(|name| names.contains(name)), "{names:?}");
    }

    #[test]
    fn depths_that_differ_by_rounding_do_not_change_the_choice() {
        let names = |tilt: f32| {
            let mut manifolds = cone(|i, k| -1e-3 + tilt * ((7 * i + 3 * k) % 5) as f32);
            keep_few(&mut manifolds, 0);
            names(&manifolds)
        };
        assert_eq!(names(0.0), names(1e-6));
    }
}
