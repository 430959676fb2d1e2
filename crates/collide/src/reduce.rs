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
const FEW: std::ops::RangeInclusive<usize> = 5..=MOST;
pub(crate) const MOST: usize = 9;

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

/// Makes a manifold from the corners of a polygon, at least one; a point that is none may be among them.
pub(crate) fn reduce_polygon(normal: Vec3, points: &[ContactPoint]) -> Manifold {
    if !FEW.contains(&points.len()) {
        return reduce(normal, points);
    }
    Manifold { normal, points: Flat::of(normal, points).best_four(None).map(|i| points[i]), count: 4 }
}

/// The four of some names that have the bits ([`corner_bit`]) of `kept`, if they are there; one without a bit may be among them.
pub(crate) fn with_bits(names: impl Iterator<Item = u32>, kept: u8) -> Option<[usize; 4]> {
    let (mut set, mut count, mut bits) = ([0; 4], 0, 0);
    for (i, name) in names.enumerate() {
        let bit = corner_bit(name);
        if bit & kept != 0 || (bit == 0 && kept.count_ones() == 3) {
            if count == 4 {
                return None;
            }
            (set[count], count, bits) = (i, count + 1, bits | bit);
        }
    }
    (count == 4 && bits == kept).then_some(set)
}

/// As [`reduce_within`]; those four by whose names `was_kept` stay while others are no better.
pub(crate) fn reduce_keeping(
    normal: Vec3,
    points: &[ContactPoint],
    start: Vec3,
    tie: f32,
    was_kept: impl Fn(u32) -> bool,
) -> Manifold {
    let of = |set: [usize; 4]| Manifold { normal, points: set.map(|i| points[i]), count: 4 };
    let known: SmallVec<[usize; 8]> = (0..points.len()).filter(|&i| was_kept(points[i].feature)).collect();
    if FEW.contains(&points.len()) {
        let known = known.first_chunk::<4>();
        return of(Flat::of(normal, points).best_four(known.copied()));
    }
    let chosen = reduce_within(normal, points, start, tie);
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

/// Points seen along the normal of their contact, five to nine of them.
pub(crate) struct Flat {
    /// In any plane that the normal is not parallel to: only ratios of areas count.
    places: [[f32; 2]; MOST],
    distances: [f32; MOST],
    count: usize,
}

impl Flat {
    pub(crate) fn new() -> Self {
        Flat { places: [[0.0; 2]; MOST], distances: [0.0; MOST], count: 0 }
    }

    /// Nothing happens to points that are too many.
    pub(crate) fn push(&mut self, place: [f32; 2], distance: f32) {
        if self.count < MOST {
            (self.places[self.count], self.distances[self.count]) = (place, distance);
            self.count += 1;
        }
    }

    fn of(normal: Vec3, points: &[ContactPoint]) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        let mut flat = Self::new();
        points.iter().for_each(|p| flat.push([x.dot(p.position), y.dot(p.position)], p.distance));
        flat
    }

    /// Of all sets of four one of the best, in ascending order; the one that was `kept`, while it is nearly as good.
    pub(crate) fn best_four(&self, kept: Option<[usize; 4]>) -> [usize; 4] {
        let (places, distances) = (&self.places[..self.count], &self.distances[..self.count]);
        let mut deepest = 0;
        for (i, distance) in distances.iter().enumerate() {
            if *distance < distances[deepest] {
                deepest = i;
            }
        }
        let least = distances[deepest];
        let away = |p: &[f32; 2]| {
            let [x, y] = [p[0] - places[0][0], p[1] - places[0][1]];
            x * x + y * y
        };
        let span = places.iter().fold(0.0_f32, |most, p| most.max(away(p))).sqrt();
        let no_deeper = |depth: f32| {
            distances.iter().enumerate().fold(0_u32, |set, (i, &d)| set | u32::from(d <= depth) << i)
        };
        let touching = |share: f32| no_deeper(least.max(0.0) + share * span);
        let (touch, deep) = (touching(TOUCHING), no_deeper(least + EQUAL_DEPTH * span));
        let areas = Areas::of(places, deepest);

        let mut most = (0, 0.0);
        for i in (0..self.count).filter(|&i| i != deepest) {
            for j in (i + 1..self.count).filter(|&j| j != deepest) {
                for k in (j + 1..self.count).filter(|&k| k != deepest) {
                    let touch = (touch & (1 << deepest | 1 << i | 1 << j | 1 << k)).count_ones();
                    if touch >= most.0 {
                        let area = areas.with_origin(i, j, k);
                        if touch > most.0 || area > most.1 {
                            most = (touch, area);
                        }
                    }
                }
            }
        }
        let nearly = |set: [usize; 4], touch: u32, share: f32| {
            let bits = set.iter().fold(0, |bits, &i| bits | 1 << i);
            let touches = (touch & bits).count_ones() >= most.0 && deep & bits != 0;
            touches && areas.of_set(set) >= share * most.1
        };
        if let Some(set) = kept.filter(|&set| nearly(set, touching(KEPT_TOUCHING), KEPT_AREA)) {
            return set;
        }
        // Of sets as good as each other the first: points come in the order of their names.
        for i in 0..self.count {
            for j in i + 1..self.count {
                for k in j + 1..self.count {
                    for l in k + 1..self.count {
                        if nearly([i, j, k, l], touch, EQUAL_AREA) {
                            return [i, j, k, l];
                        }
                    }
                }
            }
        }
        [0, 1, 2, 3]
    }
}

/// Twice the areas of the triangles that pairs of points make with one of them, the origin, with a sign.
struct Areas([[f32; MOST]; MOST]);

impl Areas {
    fn of(places: &[[f32; 2]], origin: usize) -> Self {
        let mut seen = [[0.0; 2]; MOST];
        for (to, p) in seen.iter_mut().zip(places) {
            *to = [p[0] - places[origin][0], p[1] - places[origin][1]];
        }
        Areas(seen.map(|p| seen.map(|q| p[0] * q[1] - p[1] * q[0])))
    }

    /// Twice the area of four points: of the three ways to go around them, the one that does not cross itself.
    fn of_set(&self, [a, b, c, d]: [usize; 4]) -> f32 {
        let x = &self.0;
        let one = x[a][b] + x[b][c] + x[c][d] - x[a][d];
        let two = x[b][d] - x[b][c] - x[a][d] + x[a][c];
        let three = x[a][b] + x[b][d] - x[c][d] - x[a][c];
        one.abs().max(two.abs()).max(three.abs())
    }

    /// The same where the origin is one of them.
    fn with_origin(&self, b: usize, c: usize, d: usize) -> f32 {
        let x = &self.0;
        let (bc, cd, bd) = (x[b][c], x[c][d], x[b][d]);
        (bc + cd).abs().max((bd - bc).abs()).max((bd - cd).abs())
    }
}

/// What sets of four of many points are judged by.
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

/// Twice the area of four points, seen along `normal`: of the three ways to go around them, the one that does not cross itself.
pub(crate) fn area(normal: Vec3, [a, b, c, d]: [Vec3; 4]) -> f32 {
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
        let mut kept = 0;
        let mut choose = |depth: &dyn Fn(usize) -> f32| -> Vec<u32> {
            let points = hexagon(depth);
            let kept_set = with_bits(points.iter().map(|p| p.feature), kept);
            let names = Flat::of(Vec3::Z, &points).best_four(kept_set).map(|i| points[i].feature);
            kept = names.iter().fold(0, |bits, &name| bits | corner_bit(name));
            assert_eq!(kept.count_ones(), 4);
            names.to_vec()
        };
        let first = choose(&|_| -1e-3);
        // Deeper by a tenth of a thousandth of the span.
        for i in 0..6 {
            assert_eq!(choose(&|k| if k == i { -1.2e-3 } else { -1e-3 }), first);
        }
        // Deeper by more: nothing hides it.
        let hidden = (0..6).find(|&i| !first.contains(&tags(i))).expect("six corners and four of them");
        let second = choose(&|k| if k == hidden { -1e-2 } else { -1e-3 });
        assert!(second.contains(&tags(hidden)));
        // Back again, and it stays.
        assert_eq!(choose(&|_| -1e-3), second);
    }

    #[test]
    fn corners_that_touch_come_before_those_that_are_open() {
        for open in 0..4 {
            let depth = |i: usize| if i == open || i == open + 2 { 0.02 } else { -1e-3 };
            let manifold = reduce_polygon(Vec3::Z, &ring(6, depth));
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
