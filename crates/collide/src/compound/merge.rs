//! Manifolds of one pair that push the same way in one plane become one.
//!
//! Each manifold costs the solver as much as that of a body, and two cubes side by side on a plane are held by the four outer corners as
//! well as by eight. Manifolds that lie at different heights along their normal stay apart: friction acts in the plane of its manifold.
//!
//! Of the first manifold that leaves points out, the pair remembers which it kept: chosen anew in every step, points take turns with those that are left out, and what lies on them rattles.

use crate::manifold::is_among;
use crate::reduce::{reduce_keeping, reduce_within, start};
use crate::{ContactPoint, Manifold};
use smallvec::SmallVec;

/// Cosine of 2°: contacts whose normals differ less may share a manifold, as those of a mesh do.
const SAME: f32 = 0.999_39;

/// How far off the plane of the first point another may be, as a share of the way between the two: the sine of 2° and some more.
const IN_PLANE: f32 = 0.05;

/// Depths that differ by less than this share of the span are equal.
const EQUAL_DEPTH: f32 = 2.5e-4;

/// Merges the manifolds from number `first` on. They keep the order of the first ones, which is that of the parts and so changes
/// less than that of depths. `kept`, if points are to stay, has the digests of those that were kept in the last step, 0 for none, and gets those of this one.
pub(super) fn merge(manifolds: &mut Vec<Manifold>, first: usize, mut kept: Option<&mut u32>) {
    let before = kept.as_deref_mut().map_or(0, std::mem::take);
    let was_kept = |name: u32| is_among(before, name);
    if manifolds.len() < first + 2 {
        return;
    }
    let found: SmallVec<[Manifold; 16]> = manifolds.drain(first..).collect();
    let mut taken: SmallVec<[bool; 16]> = SmallVec::from_elem(false, found.len());
    let mut points: SmallVec<[ContactPoint; 32]> = SmallVec::new();
    for (i, one) in found.iter().enumerate() {
        if taken[i] {
            continue;
        }
        points.clear();
        points.extend_from_slice(one.points());
        for (j, other) in found.iter().enumerate().skip(i + 1) {
            if !taken[j] && goes_with(one, other) {
                taken[j] = true;
                points.extend_from_slice(other.points());
            }
        }
        if points.len() == one.count as usize {
            manifolds.push(*one);
            continue;
        }
        let from = points[0].position;
        let span = points.iter().fold(0.0_f32, |span, p| span.max(p.position.distance(from)));
        let tie = EQUAL_DEPTH * span;
        let from = start(one.normal);
        manifolds.push(match &mut kept {
            Some(kept) => {
                let merged = reduce_keeping(one.normal, &points, from, tie, was_kept);
                if **kept == 0 && points.len() > 4 {
                    **kept = merged.digests();
                }
                merged
            }
            None => reduce_within(one.normal, &points, from, tie),
        });
    }
}

/// Whether two manifolds push the same way, and all points of the second lie in the plane of the first.
fn goes_with(one: &Manifold, other: &Manifold) -> bool {
    let from = one.points[0].position;
    let in_plane = |p: &ContactPoint| {
        let way = p.position - from;
        // A point lies half-way between the two surfaces: overlaps alone put it off the plane.
        let overlap = 0.5 * (p.distance - one.points[0].distance).abs();
        way.dot(one.normal).abs() <= IN_PLANE * way.length() + overlap
    };
    one.normal.dot(other.normal) >= SAME && other.points().iter().all(in_plane)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::Vec3;

    fn manifold(normal: Vec3, points: &[(Vec3, f32)], name: u32) -> Manifold {
        let mut manifold = Manifold { normal, count: points.len() as u32, ..Manifold::default() };
        for (k, &(position, distance)) in points.iter().enumerate() {
            manifold.points[k] = ContactPoint { position, distance, feature: name + k as u32 };
        }
        manifold
    }

    fn square(x: f32, z: f32, name: u32) -> Manifold {
        let at = |i: f32, j: f32| (Vec3::new(x + i, j, z), 0.0);
        manifold(Vec3::Z, &[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)], name)
    }

    #[test]
    fn squares_side_by_side_become_one() {
        let mut all =
            vec![square(9.0, 9.0, 90), square(0.0, 0.0, 0), square(1.0, 0.0, 10), square(2.0, 0.0, 20)];
        merge(&mut all, 1, None);
        assert_eq!(all.len(), 2);
        let mut corners: Vec<(f32, f32)> =
            all[1].points().iter().map(|p| (p.position.x, p.position.y)).collect();
        corners.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        assert_eq!(corners, [(0.0, 0.0), (0.0, 1.0), (3.0, 0.0), (3.0, 1.0)]);
        assert_eq!(all[0], square(9.0, 9.0, 90));
    }

    #[test]
    fn steps_and_slopes_stay_apart() {
        let slope = Vec3::new(0.05, 0.0, 1.0).normalize();
        let mut all = vec![
            square(0.0, 0.0, 0),
            square(1.0, 0.5, 10),
            manifold(slope, &[(Vec3::new(2.0, 0.0, 0.0), 0.0)], 20),
        ];
        merge(&mut all, 0, None);
        assert_eq!(all.len(), 3);
    }

    #[test]
    fn the_deepest_point_stays() {
        let mut deep = square(1.0, 0.0, 10);
        deep.points[1].distance = -0.1;
        let mut all = vec![square(0.0, 0.0, 0), deep, square(2.0, 0.0, 20)];
        merge(&mut all, 0, None);
        assert_eq!((all.len(), all[0].deepest()), (1, -0.1));
    }

    /// Two squares side by side, whose inner corners are a little deeper in turns.
    #[test]
    fn points_stay_while_others_are_no_better() {
        let names = |m: &Manifold| m.points().iter().map(|p| p.feature).collect::<Vec<_>>();
        let mut kept = 0;
        let mut found = |deeper: usize, by: f32| {
            let mut all = vec![square(0.0, 0.0, 0), square(1.0, 0.0, 10)];
            all[deeper / 4].points[deeper % 4].distance = -by;
            merge(&mut all, 0, Some(&mut kept));
            assert_eq!(all.len(), 1);
            names(&all[0])
        };
        let first = found(0, 0.0);
        for point in 0..8 {
            assert_eq!(found(point, 1e-4), first);
        }
        // Deeper by more: nothing hides it, and it stays when it is no deeper than the others again.
        let second = found(1, 0.1);
        assert!(second.contains(&1) && second != first, "{second:?}");
        assert_eq!(found(0, 0.0), second);
    }
}
