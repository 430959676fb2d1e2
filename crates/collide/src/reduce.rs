//! Cuts a set of contact points down to the four that carry it.
//!
//! Four points that span a large area hold a body as well as twenty. The choice starts from the outline, not from
//! the deepest point: in a flat contact the depths differ by rounding only, and a choice by depth would name other
//! points at every step. The deepest point then takes the place of its nearest neighbour where it is not among
//! them, so that the manifold never hides it.

use crate::{ContactPoint, Manifold};
use rockfall_math::Vec3;

/// A direction that no edge of a regular shape is parallel to: where to start, given A's frame.
const START: [Vec3; 2] = [Vec3::new(0.83, 0.47, 0.29), Vec3::new(-0.31, 0.79, -0.53)];

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
fn first_max(points: &[ContactPoint], key: impl Fn(&ContactPoint) -> f32) -> usize {
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
