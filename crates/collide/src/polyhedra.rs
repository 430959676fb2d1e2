//! Box and hull against hull: distance while they are apart, least overlap once they are not, faces clipped.

use crate::clip::{self, SLACK};
use crate::closest::Closest;
use crate::direction;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::Poly;
use crate::reduce::{reduce, reduce_polygon};
use crate::sat::{self, Axis, Kind};
use crate::segments;
use crate::{Cache, ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};
use smallvec::SmallVec;

/// Cosine of the angle between the normal and the nearest face below which a contact of edges or corners is that alone: 37
/// degrees. Above it what lies over the face within the margin belongs to the manifold too. Near-parallel faces touch
/// first at a corner or a crossing of edges, and where they overlap deeply the crossing may even part them on the
/// shortest way; held at one point only, they would turn about it into each other.
const FACE_COSINE: f32 = 0.8;

/// Appends the manifold of two polyhedra if they come within `margin`. Returns how far apart they are at least, or 0.
pub(crate) fn collide(
    a: &Poly,
    b: &Poly,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    if let Some(axis) = direction::unpack(cache.word) {
        let apart = surely_apart(a, b, b_in_a, axis);
        if apart > margin {
            return apart;
        }
    }
    match gjk::proximity(a.vertices, b.vertices, b_in_a, margin) {
        Proximity::Beyond(axis) => {
            cache.word = direction::pack(axis);
            return surely_apart(a, b, b_in_a, axis.normalize()).max(margin);
        }
        Proximity::Apart(closest) => {
            cache.word = direction::pack(closest.normal);
            out.push(around(a, b, b_in_a, margin, &closest, &mut Grip::default()));
        }
        Proximity::Overlap => {
            let choice = sat::least_overlap(a, b, b_in_a);
            let radius = a.inner_radius.min(b.inner_radius);
            let steady = choice.steady.separation;
            // The preferred face must have points to show for it.
            let manifold = overlap(a, b, b_in_a, margin, SLACK * radius, &choice.steady)
                .filter(|m| m.deepest() <= steady + sat::preference(radius, steady))
                .or_else(|| overlap(a, b, b_in_a, margin, SLACK * radius, &choice.least))
                .unwrap_or_else(|| single(&choice.least, corner(a, b, b_in_a, &choice.least)));
            cache.word = direction::pack(manifold.normal);
            out.push(manifold);
        }
    }
    0.0
}

/// Signed distance of two polyhedra.
pub(crate) fn closest(a: &Poly, b: &Poly, b_in_a: &Isometry) -> Closest {
    if let Proximity::Apart(closest) = gjk::proximity(a.vertices, b.vertices, b_in_a, f32::INFINITY) {
        return closest;
    }
    let choice = sat::least_overlap(a, b, b_in_a);
    let same = rounding(a, b, b_in_a);
    let deepest = |axis: &Axis, slack: f32| {
        if let Kind::Edges(i, j) = axis.kind {
            return Some((*axis, crossing(a, b, b_in_a, axis, i, j).point()));
        }
        let manifold = overlap(a, b, b_in_a, f32::INFINITY, slack, axis)?;
        let first = manifold.points[0];
        let at = manifold.points().iter().fold(first, |m, p| if p.distance < m.distance { *p } else { m });
        (at.distance <= axis.separation + same).then_some((*axis, at))
    };
    // The deepest point lies over the face. If it does not, rounding chose that face before a pair of edges, or put
    // the point a hair beside.
    let edges = choice.edges.filter(|e| e.separation >= choice.least.separation - same);
    let (axis, at) = deepest(&choice.least, 0.0)
        .or_else(|| deepest(&edges?, 0.0))
        .or_else(|| deepest(&choice.least, SLACK * a.inner_radius.min(b.inner_radius)))
        .unwrap_or_else(|| (choice.least, corner(a, b, b_in_a, &choice.least)));
    let half = 0.5 * axis.separation * axis.normal;
    Closest {
        distance: axis.separation,
        normal: axis.normal,
        on_a: at.position - half,
        on_b: at.position + half,
        feature: at.feature,
    }
}

/// The distance that `axis` proves, with room for all rounding: the slow way must agree that there is so much.
fn surely_apart(a: &Poly, b: &Poly, b_in_a: &Isometry, axis: Vec3) -> f32 {
    let furthest = a.support(axis).dot(axis);
    let back = b_in_a.inverse_vector(axis);
    let nearest = b.support(-back).dot(back) + axis.dot(b_in_a.translation);
    let rounding = 1e-5 * (furthest.abs() + nearest.abs() + b_in_a.translation.abs().element_sum());
    (nearest - furthest) * (1.0 - 1e-5) - rounding
}

/// What a manifold of two boxes was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Grip {
    /// Whether the reference face was B's.
    pub(crate) on_b: bool,
    /// Bits of the corners that were kept, see [`feature::corner_bit`]; 0 where there was none.
    pub(crate) corners: u8,
}

/// The manifold around the nearest points: these, and where a face looks along the normal, what lies over that face. Of faces and corners
/// that are as good as each other, those of the last `grip`, which becomes that of this manifold.
pub(crate) fn around(
    a: &Poly,
    b: &Poly,
    b_in_a: &Isometry,
    margin: f32,
    closest: &Closest,
    grip: &mut Grip,
) -> Manifold {
    let normal = closest.normal;
    let (face_of_a, cosine_of_a) = a.face_at_support(normal);
    let (face_of_b, cosine_of_b) = b.face_at_support(-b_in_a.inverse_vector(normal));
    if cosine_of_a.max(cosine_of_b) < FACE_COSINE {
        *grip = Grip::default();
        return closest.manifold();
    }
    // A's face unless B's is nearer by more than two degrees at a right contact, or the last one: the choice must not flicker.
    let same = if grip.on_b && grip.corners != 0 { -1e-3 } else { 1e-3 };
    let on_b = cosine_of_b > cosine_of_a + same;
    if grip.on_b != on_b {
        *grip = Grip { on_b, corners: 0 };
    }
    let kind = if on_b { Kind::FaceOfB(face_of_b) } else { Kind::FaceOfA(face_of_a) };
    let axis = Axis { normal, separation: closest.distance, kind };
    let slack = SLACK * a.inner_radius.min(b.inner_radius);
    let mut points = over_face(a, b, b_in_a, margin, slack, &axis);
    let deepest = points.iter().fold(f32::INFINITY, |d, p| d.min(p.distance));
    if deepest > closest.distance + rounding(a, b, b_in_a) {
        points.push(closest.point());
    }
    reduce_polygon(normal, &points, &mut grip.corners)
}

/// The manifold of polyhedra that overlap, along an axis; nothing where what lies over its face is out of reach.
fn overlap(a: &Poly, b: &Poly, b_in_a: &Isometry, margin: f32, slack: f32, axis: &Axis) -> Option<Manifold> {
    if let Kind::Edges(i, j) = axis.kind {
        return Some(around(a, b, b_in_a, margin, &crossing(a, b, b_in_a, axis, i, j), &mut Grip::default()));
    }
    let points = over_face(a, b, b_in_a, margin, slack, axis);
    (!points.is_empty()).then(|| reduce_polygon(axis.normal, &points, &mut 0))
}

fn single(axis: &Axis, point: ContactPoint) -> Manifold {
    reduce(axis.normal, &[point])
}

/// A length below which distances of these polyhedra are equal, metres.
fn rounding(a: &Poly, b: &Poly, b_in_a: &Isometry) -> f32 {
    let size = a.vertices[0].length() + b.vertices[0].length() + b_in_a.translation.length();
    2e-7 * size
}

type Points = SmallVec<[ContactPoint; 24]>;

/// The points of the incident face that lie over the reference face of `axis`, no further than `margin`.
fn over_face(a: &Poly, b: &Poly, b_in_a: &Isometry, margin: f32, slack: f32, axis: &Axis) -> Points {
    let loop_of = |poly: &Poly, f: usize, place: &dyn Fn(Vec3) -> Vec3| -> SmallVec<[Vec3; 24]> {
        poly.face(f).iter().map(|&v| place(poly.vertices[v as usize])).collect()
    };
    let in_a = |p: Vec3| p;
    let from_b = |p: Vec3| b_in_a.point(p);
    let (reference, incident, outward, offset, names) = match axis.kind {
        Kind::FaceOfB(f) => {
            let outward = b_in_a.vector(b.normals[f]);
            let (g, _) = a.face_at_support(axis.normal);
            let offset = b.offsets[f] + outward.dot(b_in_a.translation);
            (loop_of(b, f, &from_b), loop_of(a, g, &in_a), outward, offset, feature::faces(true, f, g))
        }
        Kind::FaceOfA(f) | Kind::Edges(f, _) => {
            let outward = a.normals[f];
            let (g, _) = b.face_at_support(-b_in_a.inverse_vector(axis.normal));
            (loop_of(a, f, &in_a), loop_of(b, g, &from_b), outward, a.offsets[f], feature::faces(false, f, g))
        }
    };
    let polygon =
        clip::clip(clip::incident(incident.iter().copied()), &reference, outward, axis.normal, slack);

    // From the incident corner back to the reference plane along the normal; `outward` leans to it by the cosine.
    let lean = outward.dot(axis.normal);
    polygon
        .iter()
        .filter_map(|c| {
            let distance = ((outward.dot(c.position) - offset) / lean.abs()).max(axis.separation);
            // The corner is on B when the reference is A, and on A when it is B.
            let half = 0.5 * distance * if lean > 0.0 { -axis.normal } else { axis.normal };
            (distance <= margin).then(|| ContactPoint {
                position: c.position + half,
                distance,
                feature: feature::corner(names, c.before, c.after),
            })
        })
        .collect()
}

/// The point where two edges cross.
fn crossing(a: &Poly, b: &Poly, b_in_a: &Isometry, axis: &Axis, i: usize, j: usize) -> Closest {
    let [p, q] = a.edges[i].vertices.map(|v| a.vertices[v as usize]);
    let [s, t] = b.edges[j].vertices.map(|v| b_in_a.point(b.vertices[v as usize]));
    let (on_a, on_b) = segments::nearest([p, q], [s, t]).points();
    Closest { distance: axis.separation, normal: axis.normal, on_a, on_b, feature: feature::pair(i, j) }
}

/// The corner of the incident polyhedron that is deepest along the axis.
fn corner(a: &Poly, b: &Poly, b_in_a: &Isometry, axis: &Axis) -> ContactPoint {
    let half = 0.5 * axis.separation * axis.normal;
    let position = if let Kind::FaceOfB(_) = axis.kind {
        a.support(axis.normal) + half
    } else {
        b_in_a.point(b.support(-b_in_a.inverse_vector(axis.normal))) - half
    };
    ContactPoint { position, distance: axis.separation, feature: feature::pair(0, 0) }
}
