//! Points all over a deep overlap of polyhedra.
//!
//! Where two bodies overlap deeply the shortest way out is often that of a small face, and what lies over it is a spot: pushed there alone they turn about it, and the rest of the
//! overlap grows. Coins of 3 cm came to overlap by 2 cm in a heap, and rocked for ever. So here the corners of each that are in the other one are the points: along the common normal, each is as deep as it has to go to leave.
//! Four of them stay while others are no better, since each is a spring to the solver.

use crate::manifold::digest;
use crate::poly::Poly;
use crate::reduce::{reduce_keeping, start};
use crate::{ContactPoint, Manifold, feature};
use rockfall_math::{Isometry, Vec3};
use smallvec::SmallVec;

/// Polyhedra that overlap by more than this share of the smaller inner radius overlap deeply.
const DEEP: f32 = 0.03;

/// And go on to do so down to this share of that.
const STILL: f32 = 0.5;

/// Corners may hide this share of the depth and of the inner radius.
const HIDDEN: f32 = 0.01;

/// Corners that are less far apart than this share of the points over the face are at one end of the overlap.
const WIDE: f32 = 0.5;

/// Bodies whose inner radius is a smaller share of the way from their middle to a corner are thin.
const THIN: f32 = 0.03;

/// Fewer corners than these span no area.
const FEWEST: usize = 3;

/// Faces that look along the normal by less than this cosine are passed by: the way out over them has no end.
const ALONG: f32 = 1e-3;

/// The manifold of polyhedra of which `spot` is what lies over one face: itself, or points all over the overlap where that is deep. `kept` has a byte of each point's name, or is 0.
pub(super) fn spread(a: &Poly, b: &Poly, b_in_a: &Isometry, spot: Manifold, kept: &mut u32) -> Manifold {
    let radius = a.inner_radius.min(b.inner_radius);
    let deep = DEEP * radius;
    let before = std::mem::take(kept);
    if spot.deepest() >= if before == 0 { -deep } else { -STILL * deep } || is_thin(a) || is_thin(b) {
        return spot;
    }
    let mut points = corners(a, b, b_in_a, spot.normal);
    if points.len() < FEWEST {
        return spot;
    }
    // Between corners of surfaces that bulge the overlap is deeper than at them.
    let shown = points.iter().fold(f32::INFINITY, |least, p| least.min(p.distance));
    let hidden = (shown - (1.0 - HIDDEN) * spot.deepest() - HIDDEN * radius).max(0.0);
    points.iter_mut().for_each(|p| p.distance -= hidden);
    let digests = before.to_le_bytes();
    let was_kept = |name| digests.contains(&digest(name));
    let manifold = reduce_keeping(spot.normal, &points, start(spot.normal), 0.0, was_kept);
    // A rod that lies across an edge is held by more than the corners of its end.
    if span(&manifold) < WIDE * span(&spot) {
        return spot;
    }
    let mut names = [0; 4];
    names.iter_mut().zip(manifold.points()).for_each(|(name, p)| *name = digest(p.feature));
    *kept = u32::from_le_bytes(names);
    manifold
}

/// Plates and needles overlap by their thickness whenever they touch hard, and no corner says where.
fn is_thin(poly: &Poly) -> bool {
    poly.inner_radius < THIN * poly.vertices[0].distance(poly.center)
}

/// The largest distance of two points, metres.
fn span(manifold: &Manifold) -> f32 {
    let points = manifold.points();
    let far =
        |p: &ContactPoint| points.iter().fold(0.0_f32, |far, q| far.max(p.position.distance(q.position)));
    points.iter().fold(0.0, |span, p| span.max(far(p)))
}

/// Corners of each that are in the other one, half-way on their way out along `normal`, which looks from A to B.
fn corners(a: &Poly, b: &Poly, b_in_a: &Isometry, normal: Vec3) -> SmallVec<[ContactPoint; 24]> {
    let down = -b_in_a.inverse_vector(normal);
    // The highest of A and the lowest of B, each in its own frame.
    let (top, bottom) = (a.reach(normal), b.reach(down));
    let shift = normal.dot(b_in_a.translation);
    let mut points = SmallVec::new();
    for (k, &v) in b.vertices.iter().enumerate().filter(|(_, v)| shift - down.dot(**v) <= top) {
        let p = b_in_a.point(v);
        let Some(depth) = way_out(a, p, normal) else { continue };
        let position = p + 0.5 * depth * normal;
        points.push(ContactPoint { position, distance: -depth, feature: feature::corner_of_b(k) });
    }
    for (k, &p) in a.vertices.iter().enumerate().filter(|(_, p)| normal.dot(**p) >= shift - bottom) {
        let Some(depth) = way_out(b, b_in_a.inverse_point(p), down) else { continue };
        let position = p - 0.5 * depth * normal;
        points.push(ContactPoint { position, distance: -depth, feature: feature::corner_of_a(k) });
    }
    points
}

/// How far a point in a polyhedron has to go along a direction (unit) until it is outside, metres; nothing for one that is outside.
fn way_out(poly: &Poly, p: Vec3, along: Vec3) -> Option<f32> {
    let mut least = f32::INFINITY;
    for (normal, offset) in poly.normals.iter().zip(poly.offsets) {
        let below = offset - normal.dot(p);
        if below < 0.0 {
            return None;
        }
        let cosine = normal.dot(along);
        if cosine > ALONG {
            least = least.min(below / cosine);
        }
    }
    least.is_finite().then_some(least)
}
