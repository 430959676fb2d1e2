//! The axis along which two overlapping polyhedra overlap least.
//!
//! The shortest translation that parts two convex polyhedra is along a face normal of one of them or along the
//! cross product of two edges. Of the edge pairs only those count that make a face of the Minkowski difference: the
//! arcs of their face normals on the sphere cross (Gregorius, "The Separating Axis Test between Convex Polyhedra",
//! GDC 2013). A second filter is ours, and the first to be asked: what the inner ball of the other polyhedron
//! leaves a face or an edge to
//! separate by at the most.

mod edges;
mod faces;

pub(crate) use edges::open;

use crate::poly::Poly;
use rockfall_math::{Isometry, Vec3};

/// A candidate for the contact normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Unit vector from A to B.
    pub(crate) normal: Vec3,
    /// Metres, negative where the polyhedra overlap along the axis.
    pub(crate) separation: f32,
    /// What made it.
    pub(crate) kind: Kind,
}

/// Where an [`Axis`] comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    FaceOfA(usize),
    FaceOfB(usize),
    /// An edge of A and one of B.
    Edges(usize, usize),
}

/// How much better, metres, an axis further down the list (face of A, face of B, edges) must be to win. Contacts at
/// rest then do not flicker between axes that differ by rounding. At most 0.2 % of the smaller polyhedron's inner
/// radius and 0.5 % of the overlap.
pub(crate) fn preference(smaller_inner_radius: f32, separation: f32) -> f32 {
    2e-3 * smaller_inner_radius + 5e-3 * separation.abs()
}

/// The axes to take the normal from.
pub(crate) struct Choice {
    /// Faces before edges and faces of A before those of B, within [`preference`].
    pub(crate) steady: Axis,
    /// That of least overlap.
    pub(crate) least: Axis,
    /// The best pair of edges.
    pub(crate) edges: Option<Axis>,
}

/// Of each of two polyhedra the face that separates it from the other most: of A, then of B. Where those of B
/// separate by less than that
/// of A and the `tie`, one that does not separate at all.
pub(crate) fn best_faces(a: &Poly, b: &Poly, b_in_a: &Isometry, tie: f32) -> [Axis; 2] {
    let [(f, of_a), (g, of_b)] = faces::best(a, b, b_in_a, tie);
    [
        Axis { normal: a.normals[f], separation: of_a, kind: Kind::FaceOfA(f) },
        Axis { normal: -b_in_a.vector(b.normals[g]), separation: of_b, kind: Kind::FaceOfB(g) },
    ]
}

/// The pair of edges that separates two polyhedra most, if that is by more than `floor`, and perhaps if it is
/// not.
pub(crate) fn best_edges(a: &Poly, b: &Poly, b_in_a: &Isometry, floor: f32) -> Option<Axis> {
    edges::best(a, b, b_in_a, floor)
}

/// The axis of least overlap of two polyhedra, and the one to prefer. `faces` are their best; edges that
/// separate by less than those and the `tie` don't count.
pub(crate) fn least_overlap(
    a: &Poly,
    b: &Poly,
    b_in_a: &Isometry,
    [of_a, of_b]: [Axis; 2],
    tie: f32,
) -> Choice {
    let edges = best_edges(a, b, b_in_a, of_a.separation.max(of_b.separation) - tie);
    let mut choice = Choice { steady: of_a, least: of_a, edges };
    let radius = a.inner_radius.min(b.inner_radius);
    for axis in std::iter::once(of_b).chain(edges) {
        let steady = choice.steady.separation;
        if axis.separation > steady + preference(radius, steady) {
            choice.steady = axis;
        }
        if axis.separation > choice.least.separation {
            choice.least = axis;
        }
    }
    choice
}

/// The common perpendicular of two edges that points away from `inside` of the first, and the way along it from
/// the first to the second. In double precision: the cross product of nearly parallel edges has few good digits.
///
/// Nothing for edges that do not cross, seen along it: the nearest points of the polyhedra are then elsewhere, and
/// a normal of this pair would have no point to go with it.
pub(crate) fn edge_axis(first: [Vec3; 2], second: [Vec3; 2], inside: Vec3) -> Option<(Vec3, f32)> {
    let [p, q] = first.map(|v| v.as_dvec3());
    let [s, t] = second.map(|v| v.as_dvec3());
    let cross = (q - p).cross(t - s);
    let squared = cross.length_squared();
    // Edges that are parallel to 0.1 mrad: a face axis is as good.
    if squared <= 1e-8 * (q - p).length_squared() * (t - s).length_squared() {
        return None;
    }
    // Where they cross, as shares of both edges, times the squared length.
    let along_first = (t - s).cross(p - s).dot(cross);
    let along_second = (q - p).cross(p - s).dot(cross);
    let within = 0.0..=squared;
    if !within.contains(&along_first) || !within.contains(&along_second) {
        return None;
    }
    let normal = cross / squared.sqrt();
    let outward = normal.dot(p - inside.as_dvec3());
    let normal = if outward < 0.0 { -normal } else { normal };
    Some((normal.as_vec3(), normal.dot(s - p) as f32))
}
