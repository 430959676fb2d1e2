//! Quickhull (Barber, Dobkin, Huhdanpaa 1996) over exact predicates.
//!
//! In: points, how many corners are wanted at most, how near to the hull is near enough. Out: the triangles
//! of the convex hull, counter-clockwise from outside.
//!
//! Whether a point sees a facet is decided by Shewchuk's exact `orient3d`. With the true sign, "sees" strict
//! and coplanar counting as not seeing, the facets that a point sees always form one disc and no new facet is
//! ever degenerate, so that coincident, collinear and coplanar points need no special care and the outcome is
//! a true convex surface for every input. Plain floating-point distances only choose which point comes next.
//!
//! The next point is always the one farthest outside, so that stopping early, at a number of corners or at a
//! distance, leaves a hull inside the full one that is good for its size.

use super::HullError;
use robust::{Coord3D, orient3d};
use rockfall_math::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// When to stop.
#[derive(Clone, Copy)]
pub(super) struct Goal {
    /// At most this many corners, at least 4.
    pub(super) corners: usize,
    /// Points nearer to the hull than this are left outside of it, metres.
    pub(super) near: f64,
    /// Points within this distance of a line or plane count as lying in it, metres.
    pub(super) flat: f64,
}

struct Facet {
    corners: [u32; 3],
    /// Facet over the edge from corner i to corner (i + 1) % 3.
    neighbours: [u32; 3],
    normal: DVec3,
    /// Points that see this facet and wait to be added.
    outside: Vec<u32>,
    alive: bool,
}

/// The farthest point of a facet: distance as bits (positive floats sort as their bits do), then the lowest
/// point.
type Candidate = (u64, Reverse<u32>, u32);

struct Builder<'a> {
    points: &'a [DVec3],
    facets: Vec<Facet>,
    heap: BinaryHeap<Candidate>,
    near: f64,
    /// For each point the new facet whose horizon edge starts there; valid during one `add`.
    starts: Vec<u32>,
}

/// Triangles of the convex hull of `points`, which are finite and at least one.
pub(super) fn quickhull(points: &[DVec3], goal: Goal) -> Result<Vec<[u32; 3]>, HullError> {
    let first = simplex(points, goal.flat)?;
    let mut builder = Builder {
        points,
        facets: Vec::new(),
        heap: BinaryHeap::new(),
        near: goal.near,
        starts: vec![u32::MAX; points.len()],
    };
    builder.start(first);
    let mut corners = 4;
    while corners < goal.corners {
        let Some((_, Reverse(point), facet)) = builder.heap.pop() else { break };
        if builder.facets[facet as usize].alive {
            builder.add(point, facet);
            corners += 1;
        }
    }
    Ok(builder.facets.into_iter().filter(|f| f.alive).map(|f| f.corners).collect())
}

/// Four points that span a tetrahedron as large as is quickly found; the first three are counter-clockwise
/// seen from the side where the fourth is not.
fn simplex(points: &[DVec3], flat: f64) -> Result<[u32; 4], HullError> {
    let lowest = |a: &usize, b: &usize| points[*a].x.total_cmp(&points[*b].x).then(a.cmp(b));
    let a = (0..points.len()).min_by(lowest).unwrap_or(0);
    let (b, ab) = farthest(points, |p| p.distance_squared(points[a]));
    if ab.sqrt() <= flat {
        return Err(HullError::Coincident);
    }
    let along = (points[b] - points[a]).normalize();
    let (c, ac) = farthest(points, |p| (p - points[a]).cross(along).length_squared());
    if ac.sqrt() <= flat {
        return Err(HullError::Collinear);
    }
    let normal = (points[b] - points[a]).cross(points[c] - points[a]).normalize();
    let (d, height) = farthest(points, |p| (p - points[a]).dot(normal).abs());
    if height <= flat {
        return Err(HullError::Coplanar);
    }
    let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
    Ok(if sees(points, d, [a, b, c]) { [a, c, b, d] } else { [a, b, c, d] })
}

/// The first of the points with the largest measure, and that measure.
fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, p) in points.iter().enumerate() {
        let m = measure(*p);
        if m > best.1 {
            best = (i, m);
        }
    }
    best
}

/// Whether the point lies strictly on the outer side of a counter-clockwise triangle. Exact.
fn sees(points: &[DVec3], point: u32, triangle: [u32; 3]) -> bool {
    let at = |i: u32| {
        let p = points[i as usize];
        Coord3D { x: p.x, y: p.y, z: p.z }
    };
    let [a, b, c] = triangle;
    orient3d(at(a), at(b), at(c), at(point)) < 0.0
}

impl Builder<'_> {
    fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        self.push([a, b, c], [1, 2, 3]);
        self.push([b, a, d], [0, 3, 2]);
        self.push([c, b, d], [0, 1, 3]);
        self.push([a, c, d], [0, 2, 1]);
        self.distribute((0..self.points.len() as u32).collect(), 0);
    }

    fn push(&mut self, corners: [u32; 3], neighbours: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.points[i as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        self.facets.push(Facet { corners, neighbours, normal, outside: Vec::new(), alive: true });
    }

    /// Gives each waiting point to the facet, among those from `from` on, that it sees from farthest. A point
    /// that sees none of them is inside.
    fn distribute(&mut self, waiting: Vec<u32>, from: usize) {
        for p in waiting {
            let mut best: Option<(f64, usize)> = None;
            for (i, facet) in self.facets.iter().enumerate().skip(from) {
                let height =
                    (self.points[p as usize] - self.points[facet.corners[0] as usize]).dot(facet.normal);
                if best.is_none_or(|b| height > b.0) && sees(self.points, p, facet.corners) {
                    best = Some((height, i));
                }
            }
            if let Some((_, i)) = best {
                self.facets[i].outside.push(p);
            }
        }
        for i in from..self.facets.len() {
            let facet = &self.facets[i];
            let origin = self.points[facet.corners[0] as usize];
            let height = |p: u32| (self.points[p as usize] - origin).dot(facet.normal).max(0.0);
            let top = facet.outside.iter().map(|&p| (height(p).to_bits(), Reverse(p), i as u32)).max();
            self.heap.extend(top.filter(|t| f64::from_bits(t.0) >= self.near));
        }
    }

    /// Replaces all facets that `point` sees, `seen` among them, by a fan from their horizon to it.
    fn add(&mut self, point: u32, seen: u32) {
        let mut waiting = Vec::new();
        let mut horizon: Vec<(u32, u32, u32, usize)> = Vec::new();
        let mut stack = vec![seen];
        self.facets[seen as usize].alive = false;
        while let Some(f) = stack.pop() {
            waiting.append(&mut self.facets[f as usize].outside);
            let Facet { corners, neighbours, .. } = self.facets[f as usize];
            for i in 0..3 {
                let n = neighbours[i];
                let beyond = &self.facets[n as usize];
                if !beyond.alive {
                    continue;
                }
                if sees(self.points, point, beyond.corners) {
                    self.facets[n as usize].alive = false;
                    stack.push(n);
                } else {
                    // The neighbour runs through the shared edge the other way.
                    let end = corners[(i + 1) % 3];
                    let side = beyond.corners.iter().position(|&c| c == end).unwrap_or(0);
                    horizon.push((corners[i], end, n, side));
                }
            }
        }
        let from = self.facets.len();
        for (k, &(u, v, beyond, side)) in horizon.iter().enumerate() {
            let new = (from + k) as u32;
            self.push([u, v, point], [beyond, u32::MAX, u32::MAX]);
            self.facets[beyond as usize].neighbours[side] = new;
            self.starts[u as usize] = new;
        }
        for (k, &(_, v, ..)) in horizon.iter().enumerate() {
            let next = self.starts[v as usize];
            self.facets[from + k].neighbours[1] = next;
            self.facets[next as usize].neighbours[2] = (from + k) as u32;
        }
        waiting.retain(|&p| p != point);
        self.distribute(waiting, from);
    }
}
