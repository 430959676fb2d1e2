//! The least overlap of two convex sets of any kind: the shortest way that parts them.
//!
//! A and B overlap as long as the origin is in the difference W = A − B, and the shortest translation that parts them is the
//! way from the origin to the surface of W. That surface is known by its support points alone. It is found in two steps.
//!
//! ```text
//!   polytope in W ── nearest face ──▶ support point beyond it ──▶ larger polytope     until both agree roughly
//!        │
//!   direction n ── B moved out along n, a little further than it needs ──▶ nearest points ──▶ n again, until it stays
//! ```
//!
//! The first is the expanding polytope of van den Bergen ("Proximity queries and penetration depth computation on 3D game
//! objects", GDC 2001), with one change: it need not hold the origin at the start, because the face that is expanded is the
//! one with the least *signed* distance, so that it comes to hold it by itself. The least distance of its faces is a lower
//! bound of the overlap, the support point beyond that face gives an upper one; where both agree to half a percent no other
//! side of W can be much nearer. But a polytope follows curved surfaces slowly, and its normals are off by the root of that.
//!
//! The second makes the direction exact. From a point p outside of W the nearest point of W lies along the normal there; and
//! where p is right over the place sought, at a small distance ε from it, that normal is the direction of p. With the overlap h
//! and the curvature radius R of W, a direction that is off by δ comes back off by δ (h + ε) / (R + ε): at a flat place, and for
//! the shallow overlaps of contacts at rest, once is enough. What is deep in something round comes nearer by a constant
//! factor each time, and the sum of that geometric series is taken (Aitken's method).

use crate::feature;
use crate::gjk::{Core, Near, Placed, Walk, walk_until};
use rockfall_math::DVec3;

/// Share of the overlap, and of the size, to which the polytope finds it.
const ROUGH: f64 = 5e-3;
const ROUGH_SIZE: f64 = 1e-4;

/// How much further B is moved than it needs, as a share of the size.
const FURTHER: f64 = 1e-3;

/// How exact the second step is, see [`walk_until`]; at this distance less would be rounding.
const GAP: f64 = 1e-14;

/// Rounds of the second step; directions that still change after these are those of sets as round as they overlap deeply.
const MOST_ROUNDS: usize = 24;

/// Corners of the polytope at which it is taken as it is. Two balls in one place need about so many.
const MOST_CORNERS: usize = 256;

/// Share of the size to which overlaps along two directions are the same.
const SAME: f64 = 1e-7;

/// Share of the size below which a length is rounding.
const ROUNDING: f64 = 1e-12;

/// The way out of an overlap: a distance that is negative, or 0 where the sets touch; see [`Near`].
pub(crate) fn least_overlap<A: Core + ?Sized, B: Core + ?Sized>(a: &A, b: &B, placed: &Placed) -> Near {
    let pair = Pair { a, b, placed };
    let mut polytope = Polytope::around(&pair);
    let rough = polytope.expand(&pair);
    let (mut normal, mut depth) = (rough.normal, rough.depth);
    let mut best: Option<Way> = None;
    let mut last: Option<DVec3> = None;
    for _ in 0..MOST_ROUNDS {
        let moved = placed.moved((depth + FURTHER * polytope.size) * normal);
        let Walk::Apart(near) = walk_until(a, b, &moved, f64::INFINITY, GAP) else { break };
        depth = pair.corner(near.normal).w.dot(near.normal);
        // Of the same overlaps the last: its points are nearest to a place that is right over the origin.
        if best.as_ref().is_none_or(|best| depth <= best.depth + SAME * polytope.size) {
            best = Some(Way { depth, normal: near.normal, on_a: near.on_a });
        }
        let change = near.normal - normal;
        normal = near.normal;
        if change.length_squared() < ROUNDING {
            break;
        }
        let share = last.map_or(0.0, |last| change.dot(last) / last.length_squared());
        last = Some(change);
        if (0.1..0.95).contains(&share) {
            normal = (normal + change * (share / (1.0 - share))).normalize();
            depth = pair.corner(normal).w.dot(normal);
            last = None;
        }
    }
    // The first step proves how good the second may be at the least.
    let best = best.filter(|best| best.depth <= rough.depth + SAME * polytope.size).unwrap_or(rough);
    Near {
        distance: -best.depth,
        normal: best.normal,
        on_a: best.on_a,
        on_b: best.on_a - best.depth * best.normal,
        feature: feature::pair(0x7ffe, 0xfd),
    }
}

/// A way out: along `normal`, by `depth`.
struct Way {
    depth: f64,
    normal: DVec3,
    on_a: DVec3,
}

/// Both sets, as their difference.
struct Pair<'a, A: ?Sized, B: ?Sized> {
    a: &'a A,
    b: &'a B,
    placed: &'a Placed,
}

/// A point of the difference, and that of A which made it.
#[derive(Clone, Copy)]
struct Corner {
    w: DVec3,
    on_a: DVec3,
}

impl<A: Core + ?Sized, B: Core + ?Sized> Pair<'_, A, B> {
    /// The point of the difference that is furthest along a direction.
    fn corner(&self, direction: DVec3) -> Corner {
        let on_a = self.a.point(self.a.support(direction));
        let on_b = self.b.point(self.b.support(self.placed.back(-direction)));
        Corner { w: on_a - self.placed.point(on_b), on_a }
    }
}

/// A triangle of the polytope, counter-clockwise from outside.
#[derive(Clone, Copy)]
struct Face {
    corners: [usize; 3],
    /// Faces over the edges from corner i to corner i + 1.
    beyond: [usize; 3],
    normal: DVec3,
    /// Signed distance from the origin.
    offset: f64,
    gone: bool,
}

struct Polytope {
    corners: Vec<Corner>,
    faces: Vec<Face>,
    size: f64,
}

impl Polytope {
    /// A tetrahedron of four support points that are not in a plane, or nearly so where the difference is flat.
    fn around<A: Core + ?Sized, B: Core + ?Sized>(pair: &Pair<'_, A, B>) -> Self {
        let further = |direction: DVec3, from: DVec3| {
            let [there, back] = [pair.corner(direction), pair.corner(-direction)];
            let away = |c: &Corner| (c.w - from).dot(direction).abs();
            if away(&back) > away(&there) { back } else { there }
        };
        let p = pair.corner(DVec3::X);
        let q = pair.corner(-DVec3::X);
        let along = (q.w - p.w).normalize_or(DVec3::X);
        let across = along.any_orthonormal_vector();
        let (one, other) = (further(across, p.w), further(along.cross(across), p.w));
        let off = |c: &Corner| (c.w - p.w).reject_from_normalized(along).length_squared();
        let r = if off(&other) > off(&one) { other } else { one };
        let s = further((q.w - p.w).cross(r.w - p.w).normalize_or(along.cross(across)), p.w);
        let mut corners = vec![p, q, r, s];
        if (q.w - p.w).cross(r.w - p.w).dot(s.w - p.w) > 0.0 {
            corners.swap(1, 2);
        }
        let size = corners.iter().fold(0.0_f64, |size, c| size.max((c.w - p.w).length()));
        let mut polytope = Polytope { corners, faces: Vec::new(), size };
        for (corners, beyond) in
            [([0, 1, 2], [1, 2, 3]), ([0, 3, 1], [3, 2, 0]), ([1, 3, 2], [1, 3, 0]), ([0, 2, 3], [0, 2, 1])]
        {
            polytope.push(corners, beyond, None);
        }
        polytope
    }

    /// Adds a face; a triangle without area takes the plane of `like`, which it lies in.
    fn push(&mut self, corners: [usize; 3], beyond: [usize; 3], like: Option<usize>) {
        let [a, b, c] = corners.map(|k| self.corners[k].w);
        let cross = (b - a).cross(c - a);
        let length = cross.length();
        let (normal, offset) = match like {
            Some(f) if length <= ROUNDING * self.size * self.size => {
                (self.faces[f].normal, self.faces[f].offset)
            }
            _ => {
                let normal = cross.normalize_or(DVec3::Z);
                (normal, normal.dot(a).max(normal.dot(b)).max(normal.dot(c)))
            }
        };
        self.faces.push(Face { corners, beyond, normal, offset, gone: false });
    }

    fn nearest(&self) -> usize {
        let mut best = (0, f64::INFINITY);
        for (i, face) in self.faces.iter().enumerate() {
            if !face.gone && face.offset < best.1 {
                best = (i, face.offset);
            }
        }
        best.0
    }

    /// Grows until the nearest face is near enough to the surface.
    fn expand<A: Core + ?Sized, B: Core + ?Sized>(&mut self, pair: &Pair<'_, A, B>) -> Way {
        let mut best = Way { depth: f64::INFINITY, normal: DVec3::Z, on_a: DVec3::ZERO };
        loop {
            let f = self.nearest();
            let Face { normal, offset, .. } = self.faces[f];
            let corner = pair.corner(normal);
            let depth = corner.w.dot(normal);
            if depth < best.depth {
                best = Way { depth, normal, on_a: self.on_a(f) };
            }
            let near = best.depth - offset <= ROUGH * best.depth.abs() + ROUGH_SIZE * self.size;
            if near || depth - offset <= ROUNDING * self.size || self.corners.len() >= MOST_CORNERS {
                return best;
            }
            self.corners.push(corner);
            self.size = self.size.max((corner.w - self.corners[0].w).length());
            if !self.cover(f, self.corners.len() - 1) {
                return best;
            }
        }
    }

    /// Replaces all faces that see a new corner. Whether that made a surface: not where rounding made the border of those
    /// faces touch itself.
    fn cover(&mut self, first: usize, corner: usize) -> bool {
        let w = self.corners[corner].w;
        let mut seen = vec![first];
        self.faces[first].gone = true;
        // The edges around what is seen: from, to, and the face beyond.
        let mut border: Vec<(usize, usize, usize)> = Vec::new();
        let mut k = 0;
        while k < seen.len() {
            let Face { corners, beyond, .. } = self.faces[seen[k]];
            k += 1;
            for i in 0..3 {
                let other = &mut self.faces[beyond[i]];
                if other.gone {
                    continue;
                }
                if other.normal.dot(w) - other.offset > ROUNDING * self.size {
                    other.gone = true;
                    seen.push(beyond[i]);
                } else {
                    border.push((corners[i], corners[(i + 1) % 3], beyond[i]));
                }
            }
        }
        border.sort_unstable();
        if border.len() < 3 || border.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return false;
        }
        let start = self.faces.len();
        let place = |from: usize| border.binary_search_by_key(&from, |edge| edge.0);
        for (k, &(from, to, outer)) in border.iter().enumerate() {
            let Ok(next) = place(to) else { return false };
            let Some(previous) = border.iter().position(|edge| edge.1 == from) else { return false };
            self.push([from, to, corner], [outer, start + next, start + previous], Some(outer));
            let back = self.faces[outer].corners.iter().position(|&c| c == to).unwrap_or(0);
            self.faces[outer].beyond[back] = start + k;
        }
        true
    }

    /// Of A, the point of a face that is nearest to the origin.
    fn on_a(&self, f: usize) -> DVec3 {
        let face = &self.faces[f];
        let [p, q, r] = face.corners.map(|k| self.corners[k]);
        let foot = face.normal * face.offset;
        let area = |u: DVec3, v: DVec3| (u - foot).cross(v - foot).dot(face.normal).max(0.0);
        let weights = [area(q.w, r.w), area(r.w, p.w), area(p.w, q.w)];
        let sum: f64 = weights.iter().sum();
        if sum > 0.0 {
            (weights[0] * p.on_a + weights[1] * q.on_a + weights[2] * r.on_a) / sum
        } else {
            p.on_a
        }
    }
}
