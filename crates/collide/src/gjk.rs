//! The distance between two sets of points' convex hulls, by walking simplices of their difference.
//!
//! Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between complex objects in
//! three-dimensional space", IEEE Journal of Robotics and Automation 4, 1988; the sub-problems by Voronoi regions as
//! in Ericson, *Real-Time Collision Detection*, 2005, section 5.1. Inputs are single precision, everything inside is
//! double: the distance is then exact to the last bit of the inputs, and thin simplices keep their sense.

use crate::closest::Closest;
use crate::feature;
use rockfall_math::{DVec3, Isometry, Vec3};

/// A convex set that the walk can ask for its furthest point.
pub(crate) trait Core {
    /// A point of the set that was furthest in some direction.
    type Vertex: Copy + Default + PartialEq;
    /// The point furthest along a direction of any length.
    fn support(&self, direction: DVec3) -> Self::Vertex;
    /// Any point to start from.
    fn first(&self) -> Self::Vertex;
    fn point(&self, vertex: Self::Vertex) -> DVec3;
    /// The number of a corner; the same for all points of a smooth set.
    fn name(vertex: Self::Vertex) -> usize;
}

/// The convex hull of points.
impl Core for [Vec3] {
    type Vertex = usize;

    fn support(&self, direction: DVec3) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (i, p) in self.iter().enumerate() {
            let along = p.as_dvec3().dot(direction);
            if along > best.1 {
                best = (i, along);
            }
        }
        best.0
    }

    fn first(&self) -> usize {
        0
    }

    fn point(&self, vertex: usize) -> DVec3 {
        self[vertex].as_dvec3()
    }

    fn name(vertex: usize) -> usize {
        vertex
    }
}

/// The nearest points of two sets, in A's frame, in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) distance: f64,
    /// Unit vector from A to B.
    pub(crate) normal: DVec3,
    pub(crate) on_a: DVec3,
    pub(crate) on_b: DVec3,
    pub(crate) feature: u32,
}

impl Near {
    pub(crate) fn closest(&self) -> Closest {
        Closest {
            distance: self.distance as f32,
            normal: self.normal.as_vec3(),
            on_a: self.on_a.as_vec3(),
            on_b: self.on_b.as_vec3(),
            feature: self.feature,
        }
    }
}

/// How two sets lie, see [`Proximity`].
pub(crate) enum Walk {
    Apart(Near),
    Beyond(DVec3),
    Overlap,
}

/// How two convex sets lie.
pub(crate) enum Proximity {
    /// The nearest points.
    Apart(Closest),
    /// Further away than was asked; the direction (A to B, not unit) separates them by more than that.
    Beyond(Vec3),
    /// They overlap, or touch within rounding.
    Overlap,
}

/// A vertex of the difference A − B with the vertices that made it.
#[derive(Clone, Copy, Default)]
struct Corner<A, B> {
    w: DVec3,
    a: A,
    b: B,
}

/// Up to three corners around the point nearest to the origin, with its barycentric coordinates, and room for one more.
#[derive(Clone, Copy, Default)]
struct Simplex<A, B> {
    corners: [Corner<A, B>; 4],
    weights: [f64; 3],
    count: usize,
}

/// The part of a simplex that holds its point nearest to the origin.
#[derive(Clone, Copy, Default)]
struct Part {
    picks: [usize; 3],
    weights: [f64; 3],
    count: usize,
    /// The nearest point.
    point: DVec3,
}

/// Relative gap between the upper and the lower bound of the squared distance at which the walk ends.
const GAP: f64 = 1e-12;

/// Below this share of the sets' size the sets touch, and a direction would be made of rounding errors.
const TOUCH: f64 = 1e-9;

/// Walks end after a handful of steps, between smooth sets after two dozen; this many only if rounding drives them in
/// circles.
const MAX_STEPS: usize = 64;

/// The nearest points of the convex hulls of `a` and of `b`, the latter placed in A's frame by `b_in_a`; no further
/// than `limit` metres. The walk starts from the points that are furthest `towards` the other set, seen from A; the nearer that is to
/// the normal, the shorter the walk.
///
/// Points are asked one by one. By all lanes, and in double precision only where single precision can't decide, was tried: hulls gain nothing by it, and boxes lose.
pub(crate) fn proximity(a: &[Vec3], b: &[Vec3], b_in_a: &Isometry, towards: Vec3, limit: f32) -> Proximity {
    let (placed, towards) = (Placed::new(b_in_a), towards.as_dvec3());
    let first = (a.support(towards), b.support(placed.back(-towards)));
    match walk_from(first, a, b, &placed, f64::from(limit), GAP) {
        Walk::Apart(near) => Proximity::Apart(near.closest()),
        Walk::Beyond(axis) => Proximity::Beyond(axis.as_vec3()),
        Walk::Overlap => Proximity::Overlap,
    }
}

/// The nearest points of two sets of any kind, see [`proximity`].
pub(crate) fn walk<A: Core + ?Sized, B: Core + ?Sized>(a: &A, b: &B, placed: &Placed, limit: f64) -> Walk {
    walk_until(a, b, placed, limit, GAP)
}

/// The same until the bounds of the squared distance are as near to each other as `gap`; the normal errs by the root of it.
pub(crate) fn walk_until<A: Core + ?Sized, B: Core + ?Sized>(
    a: &A,
    b: &B,
    placed: &Placed,
    limit: f64,
    gap: f64,
) -> Walk {
    walk_from((a.first(), b.first()), a, b, placed, limit, gap)
}

/// The same from a point of each set.
fn walk_from<A: Core + ?Sized, B: Core + ?Sized>(
    first: (A::Vertex, B::Vertex),
    a: &A,
    b: &B,
    placed: &Placed,
    limit: f64,
    gap: f64,
) -> Walk {
    let corner =
        |ia: A::Vertex, ib: B::Vertex| Corner { w: a.point(ia) - placed.point(b.point(ib)), a: ia, b: ib };

    let mut simplex = Simplex { count: 1, weights: [1.0, 0.0, 0.0], ..Simplex::default() };
    simplex.corners[0] = corner(first.0, first.1);
    let mut v = simplex.corners[0].w;
    let mut scale = v.length_squared();
    // Whether a plane was found between the sets.
    let mut apart = false;
    for _ in 0..MAX_STEPS {
        let squared = v.length_squared();
        if squared <= TOUCH * TOUCH * scale {
            return Walk::Overlap;
        }
        let next = corner(a.support(-v), b.support(placed.back(v)));
        scale = scale.max(next.w.length_squared());
        let bound = v.dot(next.w);
        if bound > 0.0 && bound * bound > limit * limit * squared {
            return Walk::Beyond(-v);
        }
        let known = simplex.corners[..simplex.count].iter().any(|c| c.a == next.a && c.b == next.b);
        if known || squared - bound <= gap * squared {
            break;
        }
        simplex.corners[simplex.count] = next;
        apart |= bound > 0.0 && bound * bound > TOUCH * TOUCH * scale * squared;
        let Some(part) = nearest(&simplex.corners.map(|c| c.w), simplex.count + 1) else {
            // Of four corners that are nearly in a plane rounding may say that the origin is among them.
            if apart {
                break;
            }
            return Walk::Overlap;
        };
        if part.point.length_squared() >= squared {
            break;
        }
        v = part.point;
        simplex.reduce(&part);
    }

    let distance = v.length();
    let (mut on_a, mut on_b) = (DVec3::ZERO, DVec3::ZERO);
    for (c, &weight) in simplex.corners[..simplex.count].iter().zip(&simplex.weights) {
        on_a += weight * a.point(c.a);
        on_b += weight * placed.point(b.point(c.b));
    }
    if distance > limit {
        return Walk::Beyond(-v);
    }
    let feature = simplex.feature(A::name, B::name);
    Walk::Apart(Near { distance, normal: -v / distance, on_a, on_b, feature })
}

/// B's frame seen from A's, in double precision.
#[derive(Clone, Copy)]
pub(crate) struct Placed {
    axes: [DVec3; 3],
    origin: DVec3,
}

impl Placed {
    pub(crate) fn new(b_in_a: &Isometry) -> Self {
        let r = &b_in_a.rotation;
        Placed {
            axes: [r.x_axis.as_dvec3(), r.y_axis.as_dvec3(), r.z_axis.as_dvec3()],
            origin: b_in_a.translation.as_dvec3(),
        }
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.axes[0] * p.x + self.axes[1] * p.y + self.axes[2] * p.z + self.origin
    }

    /// B elsewhere.
    pub(crate) fn moved(&self, by: DVec3) -> Self {
        Placed { origin: self.origin + by, ..*self }
    }

    /// A direction, seen from B.
    pub(crate) fn back(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }
}

impl Part {
    /// The corners with these numbers and weights, those of no weight left out.
    fn of(corners: &[DVec3; 4], pick: &[(usize, f64)]) -> Self {
        let mut part = Part::default();
        for &(i, weight) in pick {
            if weight > 0.0 {
                part.picks[part.count] = i;
                part.weights[part.count] = weight;
                part.point += weight * corners[i];
                part.count += 1;
            }
        }
        part
    }

    /// The one that is nearer, the first of equals.
    fn or_nearer(self, other: Part) -> Self {
        if other.point.length_squared() < self.point.length_squared() { other } else { self }
    }
}

impl<A: Copy + Default, B: Copy + Default> Simplex<A, B> {
    fn reduce(&mut self, part: &Part) {
        let corners = self.corners;
        for (corner, &i) in self.corners.iter_mut().zip(&part.picks[..part.count]) {
            *corner = corners[i];
        }
        (self.weights, self.count) = (part.weights, part.count);
    }

    /// Names the corner or edge of each set that holds the nearest point; all faces share a name.
    fn feature(&self, of_a: fn(A) -> usize, of_b: fn(B) -> usize) -> u32 {
        let name = |of: &dyn Fn(&Corner<A, B>) -> usize| {
            let mut seen = [usize::MAX; 4];
            let mut count = 0;
            for c in &self.corners[..self.count] {
                if !seen[..count].contains(&of(c)) {
                    seen[count] = of(c);
                    count += 1;
                }
            }
            match count {
                1 => 3 * seen[0],
                2 => 3 * (seen[0].min(seen[1]) * 37 + seen[0].max(seen[1])) + 1,
                _ => 2,
            }
        };
        feature::pair(name(&|c| of_a(c.a)), name(&|c| of_b(c.b)))
    }
}

/// The part of the simplex of the first `count` corners that holds its point nearest to the origin; nothing where the origin is inside.
fn nearest(corners: &[DVec3; 4], count: usize) -> Option<Part> {
    Some(match count {
        2 => nearest_on_segment(corners, 0, 1),
        3 => nearest_on_triangle(corners, 0, 1, 2),
        _ => return nearest_on_tetrahedron(corners),
    })
}

fn nearest_on_segment(corners: &[DVec3; 4], i: usize, j: usize) -> Part {
    let (a, b) = (corners[i], corners[j]);
    let ab = b - a;
    let t = -a.dot(ab);
    let squared = ab.length_squared();
    if t <= 0.0 {
        Part::of(corners, &[(i, 1.0)])
    } else if t >= squared {
        Part::of(corners, &[(j, 1.0)])
    } else {
        let t = t / squared;
        Part::of(corners, &[(i, 1.0 - t), (j, t)])
    }
}

fn nearest_on_triangle(corners: &[DVec3; 4], i: usize, j: usize, k: usize) -> Part {
    let (a, b, c) = (corners[i], corners[j], corners[k]);
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    // Twice the signed areas of the triangles that the origin, seen along the normal, makes with the edges.
    let (u, v, w) = (b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal));
    if u > 0.0 && v > 0.0 && w > 0.0 {
        let sum = u + v + w;
        return Part::of(corners, &[(i, u / sum), (j, v / sum), (k, w / sum)]);
    }
    nearest_on_segment(corners, i, j)
        .or_nearer(nearest_on_segment(corners, j, k))
        .or_nearer(nearest_on_segment(corners, k, i))
}

fn nearest_on_tetrahedron(w: &[DVec3; 4]) -> Option<Part> {
    let volume = (w[1] - w[0]).cross(w[2] - w[0]).dot(w[3] - w[0]);
    let span = (w[1] - w[0]).length() * (w[2] - w[0]).length() * (w[3] - w[0]).length();
    // A flat tetrahedron has no inside: each of its faces is asked.
    let flat = volume.abs() <= 1e-14 * span;
    let mut best: Option<Part> = None;
    for [i, j, k, l] in [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 3, 2, 0]] {
        let normal = (w[j] - w[i]).cross(w[k] - w[i]);
        let origin_side = -w[i].dot(normal);
        let inner_side = (w[l] - w[i]).dot(normal);
        if flat || origin_side * inner_side < 0.0 {
            let other = nearest_on_triangle(w, i, j, k);
            best = Some(best.map_or(other, |best| best.or_nearer(other)));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &[Vec3], b: &[Vec3], limit: f32) -> Proximity {
        proximity(a, b, &Isometry::IDENTITY, Vec3::Z, limit)
    }

    fn apart(a: &[Vec3], b: &[Vec3]) -> Closest {
        match near(a, b, f32::INFINITY) {
            Proximity::Apart(c) => c,
            _ => panic!("the sets do not overlap"),
        }
    }

    #[test]
    fn point_and_triangle_by_hand() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let c = apart(&triangle, &[Vec3::new(0.25, 0.25, 0.5)]);
        assert_eq!((c.distance, c.normal), (0.5, Vec3::Z));
        let c = apart(&triangle, &[Vec3::new(0.5, -1.0, 0.0)]);
        assert_eq!((c.distance, c.on_a), (1.0, Vec3::new(0.5, 0.0, 0.0)));
        let c = apart(&triangle, &[Vec3::new(2.0, 0.0, 0.0)]);
        assert_eq!((c.distance, c.on_a), (1.0, Vec3::X));
    }

    #[test]
    fn a_point_inside_overlaps_and_a_far_one_is_beyond() {
        let tetrahedron = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let at = |p: Vec3, limit: f32| near(&tetrahedron, &[p], limit);
        assert!(matches!(at(Vec3::splat(0.2), 1.0), Proximity::Overlap));
        assert!(matches!(at(Vec3::splat(5.0), 1.0), Proximity::Beyond(d) if d.dot(Vec3::ONE) > 0.0));
        assert!(matches!(at(Vec3::splat(0.0), 1.0), Proximity::Overlap));
    }

    #[test]
    fn sets_of_one_repeated_point_are_no_trouble() {
        let c = apart(&[Vec3::ZERO; 5], &[Vec3::X; 7]);
        assert_eq!((c.distance, c.normal), (1.0, Vec3::X));
        assert!(matches!(near(&[Vec3::ONE; 3], &[Vec3::ONE; 3], 1.0), Proximity::Overlap));
    }
}
