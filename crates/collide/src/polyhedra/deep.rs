//! Points all over a deep overlap of polyhedra.
//!
//! Where two bodies are pressed into each other the shortest way out is often that of a small face, and what lies over it is a spot: pushed there alone they turn about it, and the rest of the
//! overlap grows. Coins of 3 cm came to overlap by 2 cm in a heap, and rocked for ever. So here the corners of each that are in the other one are the points: along the common normal, each is as deep as it has to go to leave.
//! So are corners that are open by less than the surfaces bulge: under the load of a heap a body tips over the edge of the face that it is held by onto the next one within a step, and back in the next step.
//! Four of them stay while others are no better, since each is a spring to the solver.

use crate::manifold::is_among;
use crate::poly::{Poly, smallest};
use crate::reduce::{area, reduce_keeping, start};
use crate::{ContactPoint, Manifold, feature};
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::HULL_LANES;
use smallvec::SmallVec;

/// Polyhedra that overlap by more than this share of the smaller inner radius overlap deeply.
const DEEP: f32 = 0.1;

/// And go on to do so down to this share of that.
const STILL: f32 = 0.5;

/// Corners may hide this share of the depth and of the inner radius.
const HIDDEN: f32 = 0.005;

/// Corners that are less far apart than this share of the points over the face are at one end of the overlap, or span less of the area.
const WIDE: f32 = 0.5;

/// Corners that are open by no more than this share of what the surfaces bulge between corners are points as well.
const OPEN: f32 = 0.5;

/// Bodies whose inner radius is a smaller share of the way from their middle to a corner are thin.
const THIN: f32 = 0.03;

/// Twice the area of the points, as a share of the square of their largest distance, that thin bodies need: needles and blades overlap by their thickness whenever they touch hard, and their corners do not say where.
const AREA: f32 = 0.3;

/// If the overlap is deeper than at its corners by more than this share of the smaller inner radius, they say too little of it.
const BULGE: f32 = 0.2;

/// Fewer corners than these span no area.
const FEWEST: usize = 3;

/// Faces that look along the normal by less than this cosine are passed by: the way out over them has no end.
const ALONG: f32 = 1e-3;

/// The manifold of polyhedra of which `spot` is what lies over one face: itself, or points all over the overlap where that is deep; and a byte of each of those points' names, or 0. `before` has these of the last time.
pub(super) fn spread(a: &Poly, b: &Poly, b_in_a: &Isometry, spot: Manifold, before: u32) -> (Manifold, u32) {
    let radius = a.inner_radius.min(b.inner_radius);
    let deep = DEEP * radius;
    if spot.deepest() >= if before == 0 { -deep } else { -STILL * deep } {
        return (spot, 0);
    }
    let mut points = corners(a, b, b_in_a, spot.normal, -spot.deepest());
    // Between corners of surfaces that bulge the overlap is deeper than at them.
    let shown = points.iter().fold(f32::INFINITY, |least, p| least.min(p.distance));
    let hidden = (shown - (1.0 - HIDDEN) * spot.deepest() - HIDDEN * radius).max(0.0);
    points.retain(|p| p.distance <= OPEN * hidden);
    if points.len() < FEWEST || hidden > BULGE * radius {
        return (spot, 0);
    }
    points.iter_mut().for_each(|p| p.distance -= hidden);
    let was_kept = |name| is_among(before, name);
    let manifold = reduce_keeping(spot.normal, &points, start(spot.normal), 0.0, was_kept);
    // A rod that lies across an edge is held by more than the corners of its end.
    let is_part = span(&manifold) < WIDE * span(&spot) || twice_area(&manifold) < WIDE * twice_area(&spot);
    let is_line = || twice_area(&manifold) < AREA * span(&manifold).powi(2);
    if is_part || (is_thin(a) || is_thin(b)) && is_line() {
        return (spot, 0);
    }
    let names = manifold.digests();
    (manifold, names)
}

fn is_thin(poly: &Poly) -> bool {
    poly.inner_radius < THIN * poly.vertices[0].distance(poly.center)
}

/// Twice the area that the points span, m².
fn twice_area(manifold: &Manifold) -> f32 {
    let points = manifold.points();
    let corner = |k: usize| points[k.min(points.len() - 1)].position;
    area(manifold.normal, [corner(0), corner(1), corner(2), corner(3)])
}

/// The largest distance of two points, metres.
fn span(manifold: &Manifold) -> f32 {
    let points = manifold.points();
    let far =
        |p: &ContactPoint| points.iter().fold(0.0_f32, |far, q| far.max(p.position.distance(q.position)));
    points.iter().fold(0.0, |span, p| span.max(far(p)))
}

/// Corners of each that are in the other one, or less than `open` metres from it, half-way on their way out along `normal`, which looks from A to B.
fn corners(a: &Poly, b: &Poly, b_in_a: &Isometry, normal: Vec3, open: f32) -> SmallVec<[ContactPoint; 24]> {
    let down = -b_in_a.inverse_vector(normal);
    // No corner of B is in A that is above its highest, and none of A in B that is below its lowest; by less than `open` they may be over it.
    let (top, bottom) = (a.reach(normal), normal.dot(b_in_a.translation) - b.reach(down));
    let placed = |(k, &v): (usize, &Vec3)| (k, b_in_a.point(v));
    let of_b: Corners =
        b.vertices.iter().enumerate().map(placed).filter(|c| normal.dot(c.1) <= top + open).collect();
    let of_a = a.vertices.iter().copied().enumerate().filter(|c| normal.dot(c.1) >= bottom - open);
    let of_a: Corners = of_a.map(|(k, v)| (k, b_in_a.inverse_point(v))).collect();
    let width = Width::native();
    let up = width.run(WaysOut { poly: a, along: normal, open, corners: &of_b });
    let out = width.run(WaysOut { poly: b, along: down, open, corners: &of_a });
    let point = |feature: u32, p: Vec3, depth: f32, way: Vec3| ContactPoint {
        position: p + 0.5 * depth * way,
        distance: -depth,
        feature,
    };
    let of_b = up.into_iter().map(|(i, depth)| (of_b[i], depth));
    let of_b = of_b.map(|((k, p), depth)| point(feature::corner_of_b(k), p, depth, normal));
    let of_a = out.into_iter().map(|(i, depth)| (of_a[i].0, depth));
    let of_a = of_a.map(|(k, depth)| point(feature::corner_of_a(k), a.vertices[k], depth, -normal));
    of_b.chain(of_a).collect()
}

/// Numbers of corners, and where they are.
type Corners = SmallVec<[(usize, Vec3); 32]>;

/// How far those of some points that are in a polyhedron, or less than `open` metres above it, have to go along a direction (unit) until they are outside, less than nothing for those above: their places in the list, and metres.
struct WaysOut<'a> {
    poly: &'a Poly<'a>,
    along: Vec3,
    open: f32,
    corners: &'a [(usize, Vec3)],
}

impl Kernel for WaysOut<'_> {
    type Output = SmallVec<[(usize, f32); 24]>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
        let zero = L::splat(token, 0.0);
        let open = L::splat(token, self.open);
        let (one, never) = (L::splat(token, 1.0), L::splat(token, f32::INFINITY));
        let along = Lanes3::<L>::splat(token, self.along);
        // By a metre below a face the way out over it is so long; nothing where it has no end.
        let mut lengths: SmallVec<[[f32; HULL_LANES]; 8]> = SmallVec::new();
        for face in self.poly.face_blocks {
            let mut to = [0.0; HULL_LANES];
            for l in (0..HULL_LANES).step_by(L::WIDTH) {
                let row = |k: usize| L::load(token, &face[k][l..]);
                let cosine = Lanes3::new(row(0), row(1), row(2)).dot(along);
                L::select(L::splat(token, ALONG).lt(cosine), one / cosine, zero).store(&mut to[l..]);
            }
            lengths.push(to);
        }
        let mut ways = SmallVec::new();
        'corners: for (i, &(_, corner)) in self.corners.iter().enumerate() {
            let p = Lanes3::<L>::splat(token, corner);
            let mut least = never;
            for (face, length) in self.poly.face_blocks.iter().zip(&lengths) {
                for l in (0..HULL_LANES).step_by(L::WIDTH) {
                    let row = |k: usize| L::load(token, &face[k][l..]);
                    let below = row(3) - Lanes3::new(row(0), row(1), row(2)).dot(p);
                    let length = L::load(token, &length[l..]);
                    let rises = zero.lt(length);
                    let out = L::select(rises, zero, below);
                    if L::bits(out.lt(zero)) != 0 {
                        continue 'corners;
                    }
                    least = L::select(rises, below * length, never).min(least);
                    if L::bits(least.lt(-open)) != 0 {
                        continue 'corners;
                    }
                }
            }
            let mut all = [f32::INFINITY; HULL_LANES];
            least.store(&mut all);
            let least = smallest(&all);
            if least.is_finite() {
                ways.push((i, least));
            }
        }
        ways
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poly::BoxPoly;
    use rockfall_math::{Mat3, rotation};

    #[test]
    fn corners_of_a_tilted_box_are_as_deep_or_as_open_as_they_lie() {
        let (ground, brick) = (BoxPoly::new(Vec3::splat(1.0)), BoxPoly::new(Vec3::new(0.5, 0.4, 0.2)));
        let tilt = Mat3::from_quat(rotation::from_rotation_vector(0.1 * Vec3::Y));
        // Its lower corners are at ∓0.5 sin 0.1 about a height, the lower ones at +x; the upper ones 0.4 higher.
        for (height, open) in [(0.0, 0.06), (0.0, 0.04), (-0.1, 0.06), (0.1, 0.06)] {
            let b_in_a = Isometry { rotation: tilt, translation: Vec3::new(0.0, 0.0, 1.2 + height) };
            let found = corners(&ground.poly(), &brick.poly(), &b_in_a, Vec3::Z, open);
            let mut wanted: Vec<f32> = crate::poly::box_corners(Vec3::new(0.5, 0.4, 0.2))
                .into_iter()
                .map(|p| b_in_a.point(p).z - 1.0)
                .filter(|distance| *distance <= open)
                .collect();
            wanted.sort_by(f32::total_cmp);
            let mut distances: Vec<f32> = found.iter().map(|p| p.distance).collect();
            distances.sort_by(f32::total_cmp);
            assert_eq!(distances.len(), wanted.len(), "{height} {open}: {found:?}");
            assert!(
                distances.iter().zip(&wanted).all(|(d, w)| (d - w).abs() < 1e-6),
                "{distances:?} {wanted:?}"
            );
            // Half-way between the corner and the top of the ground.
            assert!(found.iter().all(|p| (p.position.z - 1.0 - 0.5 * p.distance).abs() < 1e-6), "{found:?}");
        }
        // Beside the ground nothing is over it.
        let aside = Isometry { rotation: tilt, translation: Vec3::new(1.2, 0.0, 1.2) };
        let found = corners(&ground.poly(), &brick.poly(), &aside, Vec3::Z, 0.06);
        assert!(found.iter().all(|p| p.position.x < 1.0) && found.len() == 2, "{found:?}");
    }
}
