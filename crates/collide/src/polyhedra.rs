//! Box and hull against hull: distance while they are apart, least overlap once they are not, faces clipped.

mod deep;

use crate::clip::{self, SLACK};
use crate::closest::Closest;
use crate::direction;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::Poly;
use crate::reduce::{reduce, reduce_polygon};
use crate::sat::{self, Axis, Choice, Kind, preference};
use crate::segments;
use crate::{Cache, ContactPoint, Manifold, core_poly};
use rockfall_math::{Isometry, Vec3};
use smallvec::SmallVec;

/// Cosine of the angle between the normal and the nearest face below which a contact of edges or corners is that alone: 37
/// degrees. Above it what lies over the face within the margin belongs to the manifold too. Near-parallel faces touch
/// first at a corner or a crossing of edges, and where they overlap deeply the crossing may even part them on the
/// shortest way; held at one point only, they would turn about it into each other.
pub(crate) const FACE_COSINE: f32 = 0.8;

/// Appends the manifold of two polyhedra if they come within `margin`. Returns how far apart they are at least, or 0.
pub(crate) fn collide(
    a: &Poly,
    b: &Poly,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    // The names of a deep overlap's points serve while it lasts.
    let before = std::mem::take(&mut cache.kept);
    if let Some(axis) = direction::unpack(cache.word) {
        let apart = surely_apart(a, b, b_in_a, axis);
        if apart > margin {
            return apart;
        }
    }
    let same = rounding(a, b, b_in_a);
    let faces = sat::best_faces(a, b, b_in_a, 2.0 * same);
    let widest = if faces[1].separation > faces[0].separation { faces[1] } else { faces[0] };
    if widest.separation > margin {
        cache.word = direction::pack(widest.normal);
        return surely_apart(a, b, b_in_a, widest.normal).max(margin);
    }
    // Closed forms while they apply; none do where a corner is nearest to an edge or to a corner, or where the overlap is no more than rounding.
    let (known, choice) = if widest.separation > 0.0 {
        let crossing = || {
            between_edges(a, b, b_in_a, sat::best_edges(a, b, b_in_a, widest.separation)?, widest.separation)
        };
        (over_faces(a, b, b_in_a, faces).or_else(crossing), None)
    } else {
        let choice = sat::least_overlap(a, b, b_in_a, faces, 2.0 * same);
        let (manifold, kept) = overlapping(a, b, b_in_a, margin, &choice, before);
        if overlap_at(a, b, b_in_a, &manifold) {
            *cache = Cache { word: direction::pack(manifold.normal), kept };
            out.push(manifold);
            return 0.0;
        }
        (choice.edges.and_then(|edges| between_edges(a, b, b_in_a, edges, 0.0)), Some(choice))
    };
    let proximity = match known {
        Some(closest) if closest.distance > margin => Proximity::Beyond(closest.normal),
        Some(closest) => Proximity::Apart(closest),
        None => {
            let towards = choice.as_ref().map_or(widest.normal, |choice| choice.least.normal);
            gjk::proximity(a.vertices, b.vertices, b_in_a, towards, margin)
        }
    };
    let (manifold, kept) = match proximity {
        Proximity::Beyond(axis) => {
            cache.word = direction::pack(axis);
            return surely_apart(a, b, b_in_a, axis.normalize()).max(margin);
        }
        Proximity::Apart(closest) => (around(a, b, b_in_a, margin, &closest), 0),
        Proximity::Overlap => {
            let choice = choice.unwrap_or_else(|| sat::least_overlap(a, b, b_in_a, faces, 2.0 * same));
            overlapping(a, b, b_in_a, margin, &choice, before)
        }
    };
    *cache = Cache { word: direction::pack(manifold.normal), kept };
    out.push(manifold);
    0.0
}

/// Cosine of the angle between two faces below which they are not parallel: 14 mrad.
const PARALLEL: f32 = 0.9999;

/// The nearest points of polyhedra that are apart, if their distance is that of a face of one from the other: the largest separation
/// along a face is a lower bound of the distance, and a point over that face an upper one.
fn over_faces(a: &Poly, b: &Poly, b_in_a: &Isometry, faces: [Axis; 2]) -> Option<Closest> {
    let [of_a, of_b] = faces.map(|axis| axis.separation);
    let (distance, same) = (of_a.max(of_b), rounding(a, b, b_in_a));
    faces.into_iter().filter(|axis| distance - axis.separation <= same).find_map(|axis| {
        let normal = axis.normal;
        let on_b = matches!(axis.kind, Kind::FaceOfB(_));
        let is_over = |p: Vec3| match axis.kind {
            Kind::FaceOfB(f) => core_poly::is_above(b, f, b_in_a.inverse_point(p)),
            Kind::FaceOfA(f) | Kind::Edges(f, _) => core_poly::is_above(a, f, p),
        };
        let half = 0.5 * distance * normal;
        let corner = corner(a, b, b_in_a, &axis).position;
        let at = if is_over(corner) {
            corner
        } else {
            // Of parallel faces a point between the corners may be over the other where none of them is.
            let (_, cosine) = if on_b {
                a.face_at_support(normal)
            } else {
                b.face_at_support(-b_in_a.inverse_vector(normal))
            };
            if cosine < PARALLEL {
                return None;
            }
            let points = over_face(a, b, b_in_a, distance + same, 0.0, &axis);
            middle(points.iter()).filter(|&p| is_over(p))?
        };
        Some(Closest { distance, normal, on_a: at - half, on_b: at + half, feature: feature::pair(0, 0) })
    })
}

/// The nearest points of two edges that separate by more than any face does: that is the distance then, since they cross.
fn between_edges(a: &Poly, b: &Poly, b_in_a: &Isometry, edges: Axis, widest: f32) -> Option<Closest> {
    let Kind::Edges(i, j) = edges.kind else { return None };
    (edges.separation > widest + rounding(a, b, b_in_a)).then(|| crossing(a, b, b_in_a, &edges, i, j))
}

/// The manifold of polyhedra that overlap, of what lies over one face or the other, or of all of the overlap; and what to keep of its points' names, as `before` has it of the last time.
fn overlapping(
    a: &Poly,
    b: &Poly,
    b_in_a: &Isometry,
    margin: f32,
    choice: &Choice,
    before: u32,
) -> (Manifold, u32) {
    let radius = a.inner_radius.min(b.inner_radius);
    let steady = choice.steady.separation;
    // The preferred face must have points to show for it.
    let spot = overlap(a, b, b_in_a, margin, SLACK * radius, &choice.steady)
        .filter(|m| m.deepest() <= steady + preference(radius, steady))
        .or_else(|| overlap(a, b, b_in_a, margin, SLACK * radius, &choice.least))
        .unwrap_or_else(|| single(&choice.least, corner(a, b, b_in_a, &choice.least)));
    deep::spread(a, b, b_in_a, spot, before)
}

/// Whether a manifold proves that its polyhedra overlap: between points half-way through the overlap lies one that is in both.
fn overlap_at(a: &Poly, b: &Poly, b_in_a: &Isometry, manifold: &Manifold) -> bool {
    middle(manifold.points().iter().filter(|p| p.distance < 0.0))
        .is_some_and(|p| a.holds(p) && b.holds(b_in_a.inverse_point(p)))
}

/// The mean of some points, if there are any.
fn middle<'a>(points: impl Iterator<Item = &'a ContactPoint>) -> Option<Vec3> {
    let (sum, count) = points.fold((Vec3::ZERO, 0.0), |(sum, count), p| (sum + p.position, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Signed distance of two polyhedra.
pub(crate) fn closest(a: &Poly, b: &Poly, b_in_a: &Isometry) -> Closest {
    if let Proximity::Apart(closest) =
        gjk::proximity(a.vertices, b.vertices, b_in_a, b_in_a.point(b.center) - a.center, f32::INFINITY)
    {
        return closest;
    }
    let same = rounding(a, b, b_in_a);
    let faces = sat::best_faces(a, b, b_in_a, 2.0 * same);
    let choice = sat::least_overlap(a, b, b_in_a, faces, 2.0 * same);
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
    let furthest = a.reach(axis);
    let nearest = axis.dot(b_in_a.translation) - b.reach(-b_in_a.inverse_vector(axis));
    let rounding = 1e-5 * (furthest.abs() + nearest.abs() + b_in_a.translation.abs().element_sum());
    (nearest - furthest) * (1.0 - 1e-5) - rounding
}

/// The manifold around the nearest points: these, and where a face looks along the normal, what lies over that face.
fn around(a: &Poly, b: &Poly, b_in_a: &Isometry, margin: f32, closest: &Closest) -> Manifold {
    let normal = closest.normal;
    let (face_of_a, cosine_of_a) = a.face_at_support(normal);
    let (face_of_b, cosine_of_b) = b.face_at_support(-b_in_a.inverse_vector(normal));
    if cosine_of_a.max(cosine_of_b) < FACE_COSINE {
        return closest.manifold();
    }
    // A's face unless B's is nearer by more than two degrees at a right contact: the choice must not flicker.
    let on_b = cosine_of_b > cosine_of_a + 1e-3;
    let kind = if on_b { Kind::FaceOfB(face_of_b) } else { Kind::FaceOfA(face_of_a) };
    let axis = Axis { normal, separation: closest.distance, kind };
    let slack = SLACK * a.inner_radius.min(b.inner_radius);
    let mut points = over_face(a, b, b_in_a, margin, slack, &axis);
    let deepest = points.iter().fold(f32::INFINITY, |d, p| d.min(p.distance));
    if deepest > closest.distance + rounding(a, b, b_in_a) {
        points.push(closest.point());
    }
    reduce_polygon(normal, &points)
}

/// The manifold of polyhedra that overlap, along an axis; nothing where what lies over its face is out of reach.
fn overlap(a: &Poly, b: &Poly, b_in_a: &Isometry, margin: f32, slack: f32, axis: &Axis) -> Option<Manifold> {
    if let Kind::Edges(i, j) = axis.kind {
        return Some(around(a, b, b_in_a, margin, &crossing(a, b, b_in_a, axis, i, j)));
    }
    let points = over_face(a, b, b_in_a, margin, slack, axis);
    (!points.is_empty()).then(|| reduce_polygon(axis.normal, &points))
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
    let in_a = |p: Vec3| b_in_a.point(p);
    let (reference, mut polygon, outward, offset, names): (SmallVec<[Vec3; 24]>, _, _, _, _) = match axis.kind
    {
        Kind::FaceOfB(f) => {
            let outward = b_in_a.vector(b.normals[f]);
            let (g, _) = a.face_at_support(axis.normal);
            let offset = b.offsets[f] + outward.dot(b_in_a.translation);
            let polygon = clip::incident(a.corners(g));
            (b.corners(f).map(in_a).collect(), polygon, outward, offset, feature::faces(true, f, g))
        }
        Kind::FaceOfA(f) | Kind::Edges(f, _) => {
            let (g, _) = b.face_at_support(-b_in_a.inverse_vector(axis.normal));
            let polygon = clip::incident(b.corners(g).map(in_a));
            (a.corners(f).collect(), polygon, a.normals[f], a.offsets[f], feature::faces(false, f, g))
        }
    };
    clip::clip(&mut polygon, &reference, outward, axis.normal, slack);

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
