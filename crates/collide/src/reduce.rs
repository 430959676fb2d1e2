//! Cuts a set of contact points down to the four that carry it.
//!
//! Four points that span a large area hold a body as well as twenty.
//!
//! Of a cloud of points the choice starts from the outline, not from the deepest point: in a flat contact the depths differ by rounding
//! only, and a choice by depth would name other points at every step. The deepest point then takes the place of its nearest
//! neighbour where it is not among them, so that the manifold never hides it.
//!
//! The corners of a polygon, what is left of one face over another, are few enough to try all sets of four. Those that touch come before
//! those that are open still, then the area decides, and a set without the deepest is worth nothing. A choice that leaves out a corner
//! which bears load lets that corner sink, until it is chosen and another one left out: so what the last choice kept is kept as long as
//! it is nearly as good. Without that some boxes of a deep pile, a few in a thousand, rattled for ever.

use crate::feature::corner_bit;
use crate::{ContactPoint, Manifold};
use rockfall_math::Vec3;
use smallvec::SmallVec;

/// A direction that no edge of a regular shape is parallel to: where to start, given A's frame.
const START: [Vec3; 2] = [Vec3::new(0.83, 0.47, 0.29), Vec3::new(-0.31, 0.79, -0.53)];

/// Corners of a polygon whose depths differ by less than this share of its span are as good as equally deep: a manifold hides no more of the
/// overlap than that.
const EQUAL_DEPTH: f32 = 2.5e-4;

/// Corners that are open by less than this share of the span touch as well.
const TOUCHING: f32 = 1e-3;

/// Sets whose areas have this ratio are as good as equal.
const EQUAL_AREA: f32 = 0.95;

/// The corners that were kept touch up to this share of the span, and stay while their area has this ratio to the largest. Less loose, a box
/// that rocks on its corner changes them at every swing, and is kept going by that.
const KEPT_TOUCHING: f32 = 4e-3;
const KEPT_AREA: f32 = 0.5;

/// So many corners are tried four by four; of more, an outline is taken.
const FEW: usize = 9;

/// The direction in which the outline starts, in A's frame.
pub(crate) fn start(normal: Vec3) -> Vec3 {
    if normal.dot(START[0]).abs() < 0.8 { START[0] } else { START[1] }
}

/// Makes a manifold from any number of points, at least one.
pub(crate) fn reduce(normal: Vec3, points: &[ContactPoint]) -> Manifold {
    reduce_within(normal, points, start(normal), 0.0)
}

/// The same with an outline that starts in another direction, where depths that differ by less than `tie` metres are equal
/// as well.
pub(crate) fn reduce_within(normal: Vec3, points: &[ContactPoint], start: Vec3, tie: f32) -> Manifold {
    let mut manifold = Manifold { normal, ..Manifold::default() };
    if points.len() <= 4 {
        manifold.points[..points.len()].copy_from_slice(points);
        manifold.count = points.len() as u32;
        return manifold;
    }
    let mut chosen = outline(normal, points, start);
    let at = |i: usize| points[i].position;
    let deepest = first_max(points, |p| -p.distance);
    let shown = chosen.iter().fold(f32::INFINITY, |d, &i| d.min(points[i].distance));
    // Depths that differ by less than the rounding of the span are equal.
    let tie = tie.max(2e-7 * (at(chosen[1]) - at(chosen[0])).length());
    if points[deepest].distance < shown - tie {
        let mut nearest = 0;
        for k in 1..4 {
            if at(chosen[k]).distance_squared(at(deepest)) < at(chosen[nearest]).distance_squared(at(deepest))
            {
                nearest = k;
            }
        }
        chosen[nearest] = deepest;
    }
    chosen.sort_unstable();
    for (k, &i) in chosen.iter().enumerate() {
        if k == 0 || chosen[k - 1] != i {
            manifold.points[manifold.count as usize] = points[i];
            manifold.count += 1;
        }
    }
    manifold
}

/// Makes a manifold from the corners of a polygon in their order, at least one; a point that is none may come last. `kept` has the bits
/// ([`corner_bit`]) of the corners that the last manifold kept, 0 where that is not known, and becomes those of this one.
pub(crate) fn reduce_polygon(normal: Vec3, points: &[ContactPoint], kept: &mut u8) -> Manifold {
    let mut manifold = Manifold { normal, ..Manifold::default() };
    if (5..=FEW).contains(&points.len()) {
        let bits = |set: &[usize; 4]| set.iter().fold(0, |bits, &i| bits | corner_bit(points[i].feature));
        manifold.points =
            best_four(normal, points, |set| *kept != 0 && bits(set) == *kept).map(|i| points[i]);
        manifold.count = 4;
    } else {
        manifold = reduce(normal, points);
    }
    *kept = manifold.points().iter().fold(0, |bits, p| bits | corner_bit(p.feature));
    manifold
}

/// As [`reduce_within`]; those four by whose names `was_kept` stay while others are no better.
pub(crate) fn reduce_keeping(
    normal: Vec3,
    points: &[ContactPoint],
    start: Vec3,
    tie: f32,
    was_kept: impl Fn(u32) -> bool,
) -> Manifold {
    let is_kept = |set: &[usize; 4]| set.iter().all(|&i| was_kept(points[i].feature));
    let of = |set: [usize; 4]| Manifold { normal, points: set.map(|i| points[i]), count: 4 };
    if (5..=FEW).contains(&points.len()) {
        return of(best_four(normal, points, is_kept));
    }
    let chosen = reduce_within(normal, points, start, tie);
    let known: SmallVec<[usize; 8]> = (0..points.len()).filter(|&i| was_kept(points[i].feature)).collect();
    let Ok(known) = <[usize; 4]>::try_from(&known[..]) else { return chosen };
    if points.len() <= 4 || chosen.count < 4 {
        return chosen;
    }
    let worth = Worth::of(points);
    let most = worth.of_set(normal, &chosen.points, TOUCHING);
    let old = of(known);
    if worth.is_nearly(worth.of_set(normal, &old.points, KEPT_TOUCHING), most, KEPT_AREA) {
        old
    } else {
        chosen
    }
}

/// Of all sets of four one of the best, in ascending order; the first that `was_kept`, while it is nearly as good.
fn best_four(normal: Vec3, points: &[ContactPoint], was_kept: impl Fn(&[usize; 4]) -> bool) -> [usize; 4] {
    let deepest = first_max(points, |p| -p.distance);
    let worth = Worth::of(points);
    let of_set = |set: &[usize; 4], touching: f32| worth.of_set(normal, &set.map(|i| points[i]), touching);
    let with_deepest = fours(points.len()).filter(|set| set.contains(&deepest));
    let most = with_deepest.map(|set| of_set(&set, TOUCHING));
    let most = most.fold((0, true, 0.0), |most, worth| if worth > most { worth } else { most });
    let nearly =
        |set: &[usize; 4], touching: f32, share: f32| worth.is_nearly(of_set(set, touching), most, share);
    fours(points.len())
        .find(was_kept)
        .filter(|set| nearly(set, KEPT_TOUCHING, KEPT_AREA))
        // Of sets as good as each other the first: points come in the order of their names.
        .or_else(|| fours(points.len()).find(|set| nearly(set, TOUCHING, EQUAL_AREA)))
        .unwrap_or([0, 1, 2, 3])
}

/// What sets of four of some points are judged by.
struct Worth {
    /// Distance of the deepest of all, and how far the first is from the others at most.
    least: f32,
    span: f32,
}

impl Worth {
    fn of(points: &[ContactPoint]) -> Self {
        let from = points[0].position;
        Worth {
            least: points.iter().fold(f32::INFINITY, |least, p| least.min(p.distance)),
            span: points.iter().fold(0.0, |span, p| span.max(p.position.distance(from))),
        }
    }

    /// How many touch, whether one is as deep as the deepest, and the area.
    fn of_set(&self, normal: Vec3, set: &[ContactPoint; 4], touching: f32) -> (usize, bool, f32) {
        let below = |depth: f32| set.iter().filter(|p| p.distance <= depth).count();
        let touch = below(self.least.max(0.0) + touching * self.span);
        let deep = below(self.least + EQUAL_DEPTH * self.span) > 0;
        (touch, deep, area(normal, set.map(|p| p.position)))
    }

    /// Whether a set is as good as the best, but for a smaller share of the area.
    fn is_nearly(
        &self,
        (touch, deep, area): (usize, bool, f32),
        most: (usize, bool, f32),
        share: f32,
    ) -> bool {
        touch >= most.0 && deep && area >= share * most.2
    }
}

/// All sets of four out of `n`.
fn fours(n: usize) -> impl Iterator<Item = [usize; 4]> {
    (0..n).flat_map(move |i| {
        (i + 1..n).flat_map(move |j| (j + 1..n).flat_map(move |k| (k + 1..n).map(move |l| [i, j, k, l])))
    })
}

/// Twice the area of four points, seen along `normal`: of the three ways to go around them, the one that does not cross itself.
fn area(normal: Vec3, [a, b, c, d]: [Vec3; 4]) -> f32 {
    let diagonals = |p: Vec3, q: Vec3| p.cross(q).dot(normal).abs();
    diagonals(c - a, d - b).max(diagonals(b - a, d - c)).max(diagonals(d - a, c - b))
}

/// Four points, perhaps repeated, that span much of the area of all, seen along `normal`.
fn outline(normal: Vec3, points: &[ContactPoint], start: Vec3) -> [usize; 4] {
    let first = first_max(points, |p| p.position.dot(start));
    let from = points[first].position;
    let second = first_max(points, |p| p.position.distance_squared(from));
    // The largest areas on both sides of the diagonal; where one side is empty, the largest that the triangle leaves.
    let area = |i: usize, j: usize, p: &ContactPoint| {
        let from = points[i].position;
        (points[j].position - from).cross(p.position - from).dot(normal)
    };
    let mut left = first_max(points, |p| area(first, second, p));
    let mut right = first_max(points, |p| area(second, first, p));
    if area(second, first, &points[right]) <= 0.0 {
        right = first_max(points, |p| area(left, second, p).max(area(first, left, p)));
    } else if area(first, second, &points[left]) <= 0.0 {
        left = first_max(points, |p| area(second, right, p).max(area(right, first, p)));
    }
    [first, second, left, right]
}

/// Index of the first point with the largest key.
pub(crate) fn first_max(points: &[ContactPoint], key: impl Fn(&ContactPoint) -> f32) -> usize {
    let mut best = (0, f32::NEG_INFINITY);
    for (i, p) in points.iter().enumerate() {
        let k = key(p);
        if k > best.1 {
            best = (i, k);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feature;
    use rockfall_math::trig;

    fn ring(n: usize, depth: impl Fn(usize) -> f32) -> Vec<ContactPoint> {
        (0..n)
            .map(|i| {
                let (sin, cos) = trig::sin_cos(std::f32::consts::TAU * i as f32 / n as f32);
                ContactPoint { position: Vec3::new(cos, sin, 0.0), distance: depth(i), feature: i as u32 }
            })
            .collect()
    }

    #[test]
    fn a_regular_ring_keeps_its_area() {
        let m = reduce(Vec3::Z, &ring(8, |_| 0.0));
        assert_eq!(m.count, 4);
        let p: Vec<Vec3> = m.points().iter().map(|p| p.position).collect();
        let area = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]).length();
        assert!((area - 2.0).abs() < 1e-5, "{area}");
    }

    #[test]
    fn the_deepest_point_stays() {
        for k in 0..9 {
            let m = reduce(Vec3::Z, &ring(9, |i| if i == k { -1.0 } else { 0.0 }));
            assert_eq!(m.deepest(), -1.0);
            assert!(m.points().iter().any(|p| p.feature == k as u32));
        }
    }

    #[test]
    fn noise_in_depth_does_not_change_the_choice() {
        let ids = |m: Manifold| m.points().iter().map(|p| p.feature).collect::<Vec<_>>();
        let flat = ids(reduce(Vec3::Z, &ring(8, |_| 0.0)));
        assert_eq!(flat, ids(reduce(Vec3::Z, &ring(8, |i| if i % 3 == 0 { -1e-7 } else { 1e-7 }))));
    }

    /// Corners of a hexagon whose deepest one changes.
    #[test]
    fn a_polygon_keeps_its_corners_while_they_are_nearly_as_good() {
        let tags = |i: usize| feature::corner(0, feature::edge_tag(3), [0, 1, 2, 3, 0x80, 0x81][i]);
        let hexagon = |depth: &dyn Fn(usize) -> f32| -> Vec<ContactPoint> {
            let named = ring(6, depth).into_iter().enumerate();
            named.map(|(i, point)| ContactPoint { feature: tags(i), ..point }).collect()
        };
        let names = |m: Manifold| m.points().iter().map(|p| p.feature).collect::<Vec<_>>();
        let mut kept = 0;
        let first = names(reduce_polygon(Vec3::Z, &hexagon(&|_| -1e-3), &mut kept));
        assert_eq!(kept.count_ones(), 4);
        // Deeper by a tenth of a thousandth of the span.
        for i in 0..6 {
            let tilted = hexagon(&|k| if k == i { -1.2e-3 } else { -1e-3 });
            assert_eq!(names(reduce_polygon(Vec3::Z, &tilted, &mut kept)), first);
        }
        // Deeper by more: nothing hides it.
        let hidden = (0..6).find(|&i| !first.contains(&tags(i))).expect("six corners and four of them");
        let tilted = hexagon(&|k| if k == hidden { -1e-2 } else { -1e-3 });
        let second = names(reduce_polygon(Vec3::Z, &tilted, &mut kept));
        assert!(second.contains(&tags(hidden)));
        // Back again, and it stays.
        assert_eq!(names(reduce_polygon(Vec3::Z, &hexagon(&|_| -1e-3), &mut kept)), second);
    }

    #[test]
    fn corners_that_touch_come_before_those_that_are_open() {
        for open in 0..4 {
            let depth = |i: usize| if i == open || i == open + 2 { 0.02 } else { -1e-3 };
            let manifold = reduce_polygon(Vec3::Z, &ring(6, depth), &mut 0);
            assert_eq!(manifold.count, 4);
            assert!(manifold.points().iter().all(|p| p.distance < 0.0));
        }
    }

    #[test]
    fn points_on_a_line_or_on_one_spot_are_no_trouble() {
        let line: Vec<ContactPoint> = (0..7)
            .map(|i| ContactPoint { position: Vec3::X * i as f32, distance: 0.0, feature: i })
            .collect();
        let m = reduce(Vec3::Z, &line);
        assert!((2..=4).contains(&m.count));
        let spot = [ContactPoint::default(); 6];
        assert_eq!(reduce(Vec3::Z, &spot).count, 1);
    }
}
