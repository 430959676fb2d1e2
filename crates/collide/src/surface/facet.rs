//! One triangle of a surface, in A's frame, with what its neighbours allow.

use super::{Placed, Surface, Touch};
use rockfall_math::{Aabb, DVec3, Vec3, hash};
use rockfall_shape::EdgeKind;

/// Rounding of a direction, radians.
pub(super) const ROUNDING: f32 = 1e-5;

pub(super) struct Facet {
    pub(super) triangle: u64,
    pub(super) ids: [u64; 3],
    pub(super) corners: [Vec3; 3],
    pub(super) normal: Vec3,
    /// Height of the plane over A's origin along `normal`.
    offset: f32,
    /// How the surface bends at each edge; known where the triangle is `close`.
    pub(super) kinds: [EdgeKind; 3],
    /// In the triangle's plane, square to each edge, away from the triangle.
    pub(super) outward: [Vec3; 3],
    /// Where each edge lies along its `outward`.
    edge_offsets: [f32; 3],
    /// Normal of each neighbour, this triangle's own where there is none; known where the triangle is `close`.
    pub(super) beyond: [Vec3; 3],
    /// Whether A may touch the triangle.
    pub(super) close: bool,
    /// Rounding error of a point near A, metres.
    slack: f32,
    /// Names the direction of the normal; triangles of one plane share it, so that a corner that slides from one to
    /// the next keeps its name.
    direction: u32,
}

impl Facet {
    pub(super) fn new<S: Surface>(placed: &Placed<S>, triangle: u64, bounds: &Aabb) -> Self {
        let surface = placed.surface;
        let local = surface.corners(triangle);
        let normal = surface.normal(triangle);
        let origin = placed.origin.as_dvec3();
        // In the surface's frame and in double precision: corners may be far away although A is not.
        let along = |direction: DVec3, point: Vec3| (point.as_dvec3() - origin).dot(direction) as f32;
        let sides: [DVec3; 3] = std::array::from_fn(|e| {
            let edge = local[(e + 1) % 3].as_dvec3() - local[e].as_dvec3();
            edge.cross(normal.as_dvec3()).normalize_or_zero()
        });
        let corners = local.map(|c| placed.point(c));
        let reach = corners.iter().fold(0.0_f32, |far, c| far.max(c.abs().max_element()));
        let step = (normal * 8.0).round().as_ivec3();
        Facet {
            triangle,
            ids: surface.ids(triangle),
            corners,
            normal: placed.rotation * normal,
            offset: along(normal.as_dvec3(), local[0]),
            kinds: [EdgeKind::Flat; 3],
            outward: sides.map(|side| placed.rotation * side.as_vec3()),
            edge_offsets: std::array::from_fn(|e| along(sides[e], local[e])),
            beyond: [Vec3::ZERO; 3],
            close: false,
            slack: 1e-5 * bounds.half_extents().length() + 4e-7 * reach.min(1e3),
            direction: ((step.x + 8) * 289 + (step.y + 8) * 17 + step.z + 8) as u32,
        }
    }

    /// Finds out what lies beyond the edges.
    pub(super) fn look_beyond<S: Surface>(&mut self, placed: &Placed<S>) {
        let corners = placed.surface.corners(self.triangle);
        let normal = placed.surface.normal(self.triangle);
        for edge in 0..3 {
            let (kind, beyond) = placed.surface.beyond(self.triangle, edge, &corners, normal);
            self.kinds[edge] = kind;
            self.beyond[edge] = placed.rotation * beyond;
        }
    }

    /// Length of the longest edge, metres.
    pub(super) fn size(&self) -> f32 {
        let squared = |edge: usize| self.corners[edge].distance_squared(self.corners[(edge + 1) % 3]);
        squared(0).max(squared(1)).max(squared(2)).sqrt()
    }

    /// Signed distance from the plane, positive in front.
    pub(super) fn height(&self, p: Vec3) -> f32 {
        self.normal.dot(p) - self.offset
    }

    /// How far a point lies outside of an edge, seen along the normal.
    pub(super) fn outside(&self, edge: usize, p: Vec3) -> f32 {
        self.outward[edge].dot(p) - self.edge_offsets[edge]
    }

    /// How far outside of an edge a point at `height` may be and still belong to the triangle. Behind an edge that
    /// bends inwards the prisms of the two triangles leave a gap, which both fill.
    pub(super) fn allowance(&self, edge: usize, height: f32) -> f32 {
        if self.kinds[edge] == EdgeKind::Concave { self.allowance_below(height) } else { self.slack }
    }

    /// The allowance at an edge that bends inwards.
    pub(super) fn allowance_below(&self, height: f32) -> f32 {
        self.slack + (-2.0 * height).max(0.0)
    }

    /// Whether a point, `height` over the plane, is in the prism over the triangle.
    pub(super) fn holds(&self, p: Vec3, height: f32) -> bool {
        (0..3).all(|edge| self.outside(edge, p) <= self.allowance(edge, height))
    }

    /// The point of the triangle's rim nearest to `p`, its edge and its parameter there.
    pub(super) fn rim(&self, p: Vec3) -> (Vec3, usize, f32) {
        let mut best = (Vec3::ZERO, 0, 0.0);
        let mut nearest = f32::INFINITY;
        for edge in 0..3 {
            let (a, b) = (self.corners[edge], self.corners[(edge + 1) % 3]);
            let along = b - a;
            let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let q = if t == 1.0 { b } else { a + t * along };
            let squared = p.distance_squared(q);
            if squared < nearest {
                nearest = squared;
                best = (q, edge, t);
            }
        }
        best
    }

    /// Distance of a point from the triangle.
    pub(super) fn distance(&self, p: Vec3) -> f32 {
        if (0..3).all(|edge| self.outside(edge, p) <= 0.0) {
            self.height(p).abs()
        } else {
            self.rim(p).0.distance(p)
        }
    }

    /// In the plane of the neighbour, square to the shared edge, away from the neighbour.
    pub(super) fn back_from_beyond(&self, edge: usize) -> Vec3 {
        let along = self.corners[(edge + 1) % 3] - self.corners[edge];
        self.beyond[edge].cross(along).normalize_or_zero()
    }

    /// Whether the surface can push along `out` from this edge.
    pub(super) fn edge_pushes(&self, edge: usize, out: Vec3, tolerance: f32) -> bool {
        let own = self.outward[edge].dot(out) >= -tolerance;
        match self.kinds[edge] {
            EdgeKind::Boundary => own && self.normal.dot(out) >= -tolerance,
            EdgeKind::Convex => own && self.back_from_beyond(edge).dot(out) >= -tolerance,
            EdgeKind::Flat | EdgeKind::Concave => false,
        }
    }

    /// Name of feature `k` of A on triangles that look like this one.
    pub(super) fn feature(&self, k: usize) -> u32 {
        fold(&[1, u64::from(self.direction), k as u64])
    }

    /// Name of something that belongs to this triangle alone.
    pub(super) fn own_feature(&self, sort: u64, of_a: usize, of_b: usize) -> u32 {
        fold(&[sort, self.triangle, of_a as u64, of_b as u64])
    }

    /// Name of a corner or an edge of the surface: the same from each triangle that has it.
    pub(super) fn shared_feature(&self, corners: [usize; 2], of_a: usize) -> u32 {
        let [a, b] = corners.map(|c| self.ids[c % 3]);
        fold(&[2, a.min(b), a.max(b), of_a as u64])
    }

    /// Contact of a point of A's core, `radius` inside A's surface, along the normal.
    pub(super) fn face_touch(&self, facet: usize, p: Vec3, radius: f32, k: usize) -> Touch {
        let height = self.height(p);
        Touch {
            out: self.normal,
            on_a: p - radius * self.normal,
            distance: height - radius,
            feature: self.feature(k),
            facet,
            doubtful: height < 0.0,
        }
    }
}

fn fold(words: &[u64]) -> u32 {
    (words.iter().fold(0, |h, &word| hash::combine(h, word)) >> 32) as u32
}

/// Whether the surface can push along `out` from a corner: `out` makes no acute angle with any edge that leaves
/// it. In the frame of the surface.
pub(crate) fn corner_pushes<S: Surface>(
    surface: &S,
    triangle: u64,
    corner: usize,
    out: Vec3,
    tolerance: f32,
) -> bool {
    let id = surface.ids(triangle)[corner];
    // Once around; where the surface ends, once more the other way.
    for backwards in [false, true] {
        let mut here = triangle;
        for _ in 0..MAX_VALENCE {
            let ids = surface.ids(here);
            let Some(k) = ids.iter().position(|&i| i == id) else {
                return true;
            };
            let corners = surface.corners(here);
            for other in [(k + 1) % 3, (k + 2) % 3] {
                let edge = corners[other] - corners[k];
                if out.dot(edge) > tolerance * edge.length() {
                    return false;
                }
            }
            let edge = if backwards { k } else { (k + 2) % 3 };
            match surface.neighbour(here, edge) {
                Some(next) if next == triangle => return true,
                Some(next) => here = next,
                None => break,
            }
        }
    }
    true
}

/// Triangles around a corner that are looked at: more only in a damaged mesh.
const MAX_VALENCE: usize = 4096;
