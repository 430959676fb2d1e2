//! Boxes and hulls against one triangle: separating axes, then clipping.

use super::facet::{Facet, corner_pushes};
use super::{Placed, Probe, Surface, Touch};
use crate::gjk::{Proximity, proximity};
use crate::poly::Poly;
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{EdgeKind, HullEdge};
use smallvec::SmallVec;

/// Cosine of 3°: a direction as near as this to a normal is that normal. Where A is much larger than a closed surface, that of a milliradian: it would reach far below the rim that it
/// leans over.
const ALIGNED: f32 = 0.9986;
const ALIGNED_OF_LARGE: f32 = 0.999_999_5;

/// Cosine of 10°: a face tilted less than this lies on what it touches.
const LIES: f32 = 0.985;

/// Sine up to which an edge counts as square to a direction.
const SQUARE: f32 = 1e-3;

/// Sine by which a direction may leave the cone of a corner.
const CONE: f32 = 2e-4;

/// Sine from which on an edge stands upright on a triangle.
const STEEP: f32 = 0.7;

/// Share of A's inner radius, or of the triangle's size where A is much larger than a closed surface, by which another direction must be better than the triangle's own normal.
const BETTER: f32 = 1e-3;
const BETTER_OF_TRIANGLE: f32 = 2.5e-4;

/// A way in which the surface can push A out of the triangle.
#[derive(Clone, Copy)]
enum Way {
    /// Along the triangle's normal.
    Face,
    /// Against a face of A.
    Against(usize),
    /// Along the normal of the neighbour over this edge.
    Beyond(usize),
    /// Square to this edge and to this edge of A, along this direction.
    Across(usize, usize, Vec3),
}

/// A number for each corner or face of A; for as many as most hulls have, without memory of their own.
type Numbers<T> = SmallVec<[T; 32]>;

/// How high each corner of A is over a triangle, metres.
type Heights = Numbers<f32>;

/// Contacts of a polyhedron with triangle `i`. Whether the two may be within the margin, with contacts or without.
pub(super) fn touch<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    i: usize,
    a: &Poly,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) -> bool {
    let facet = &facets[i];
    if !facet.close {
        return false;
    }
    let heights: Heights = a.vertices.iter().map(|&v| facet.height(v)).collect();
    let lowest = heights.iter().fold(f32::INFINITY, |low, &height| low.min(height));
    let Some(way) = shortest(placed, facet, a, lowest, probe) else {
        return false;
    };
    let before = touches.len();
    let put = |touch| touches.push(Touch { facet: i, ..touch });
    match way {
        Way::Face => {}
        Way::Against(face) => against(facet, a, face, probe, put),
        Way::Beyond(edge) => beyond(facet, a, edge, probe, put),
        Way::Across(edge, of_a, out) => across(facet, a, edge, of_a, out, probe, put),
    }
    if touches.len() == before {
        on_face(facet, i, a, &heights, probe, touches);
    }
    true
}

/// The nearest points of A and the nearest of `facets`: where a corner is near a corner no axis of a face or of a pair
/// of edges joins them.
pub(super) fn nearest<'a>(
    facets: impl Iterator<Item = (usize, &'a Facet)>,
    a: &Poly,
    probe: &Probe,
) -> Option<Touch> {
    let mut best: Option<Touch> = None;
    for (i, facet) in facets {
        let limit = best.map_or(probe.margin, |touch| touch.distance);
        let Proximity::Apart(closest) =
            proximity(a.vertices, &facet.corners, &Isometry::IDENTITY, -facet.normal, limit)
        else {
            continue;
        };
        if facet.height(closest.on_a) > 0.0 && best.is_none_or(|touch| closest.distance < touch.distance) {
            best = Some(Touch {
                out: -closest.normal,
                on_a: closest.on_a,
                distance: closest.distance,
                feature: facet.own_feature(6, closest.feature as usize, 0),
                facet: i,
                doubtful: false,
            });
        }
    }
    best
}

/// The way that needs the least motion, among those that the surface allows; none where A and the triangle are
/// further apart than the margin.
fn shortest<S: Surface>(
    placed: &Placed<S>,
    facet: &Facet,
    a: &Poly,
    lowest: f32,
    probe: &Probe,
) -> Option<Way> {
    let large = probe.is_large();
    let aligned = if large { ALIGNED_OF_LARGE } else { ALIGNED };
    let step = BETTER * a.inner_radius;
    let step = if large { step.min(BETTER_OF_TRIANGLE * facet.size()) } else { step };
    let mut best = (lowest + step, Way::Face);
    let mut consider = |separation: f32, way: Way| {
        if separation > best.0 {
            best = (separation, way);
        }
    };
    for (f, (&normal, &offset)) in a.normals.iter().zip(a.offsets).enumerate() {
        let heights = facet.corners.map(|c| normal.dot(c) - offset);
        let separation = heights[0].min(heights[1]).min(heights[2]);
        if separation > probe.margin {
            return None;
        }
        if facet.normal.dot(normal) > -aligned
            && separation > lowest + step
            && pushes(placed, facet, &heights, -normal)
        {
            consider(separation, Way::Against(f));
        }
    }
    for edge in 0..3 {
        let limit = match facet.kinds[edge] {
            EdgeKind::Flat | EdgeKind::Concave => continue,
            EdgeKind::Boundary => facet.outward[edge],
            EdgeKind::Convex => facet.beyond[edge],
        };
        let corner = facet.corners[edge];
        if facet.kinds[edge] == EdgeKind::Convex && facet.normal.dot(limit) < aligned {
            let low = a.vertices.iter().fold(f32::INFINITY, |low, &v| low.min(limit.dot(v - corner)));
            if low > probe.margin {
                return None;
            }
            consider(low, Way::Beyond(edge));
        }
        let along = facet.corners[(edge + 1) % 3] - corner;
        // Which side of the arc between both triangles' normals each face of A is on: few edges have one on either.
        let arc = Arc::new(facet.normal, limit);
        let sides: Numbers<f32> = a.normals.iter().map(|&n| arc.side(-n)).collect();
        for (e, of_a) in a.edges.iter().enumerate() {
            let [c, d] = of_a.faces.map(|f| f as usize);
            if sides[c] * sides[d] >= 0.0 || !arc.crosses(-a.normals[c], -a.normals[d], sides[c]) {
                continue;
            }
            let [p, q] = ends(a, of_a);
            let out = (q - p).cross(along);
            if out.length_squared() < 1e-6 * (q - p).length_squared() * along.length_squared() {
                continue;
            }
            let out = out.normalize();
            let out = if out.dot(facet.normal + limit) < 0.0 { -out } else { out };
            let separation = out.dot(p - corner);
            if separation > probe.margin {
                return None;
            }
            if out.dot(facet.normal) < aligned {
                consider(separation, Way::Across(edge, e, out));
            }
        }
    }
    Some(best.1)
}

/// Whether the surface can push along `out`, where the triangle has these heights over a face of A.
fn pushes<S: Surface>(placed: &Placed<S>, facet: &Facet, heights: &[f32; 3], out: Vec3) -> bool {
    let first = (0..3).fold(0, |low, k| if heights[k] < heights[low] { k } else { low });
    let rises =
        |k: usize| heights[k] - heights[first] > SQUARE * facet.corners[k].distance(facet.corners[first]);
    let (next, previous) = ((first + 1) % 3, (first + 2) % 3);
    match (rises(next), rises(previous)) {
        (true, true) => {
            corner_pushes(placed.surface, facet.triangle, first, placed.direction_back(out), CONE)
        }
        (false, true) => facet.edge_pushes(first, out, CONE),
        (true, false) => facet.edge_pushes(previous, out, CONE),
        (false, false) => false,
    }
}

/// An arc on the unit sphere, from `a` to `b`.
struct Arc {
    a: Vec3,
    b: Vec3,
    /// Square to both.
    axis: Vec3,
}

impl Arc {
    fn new(a: Vec3, b: Vec3) -> Self {
        Arc { a, b, axis: b.cross(a) }
    }

    /// Which side of the arc's plane a direction is on.
    fn side(&self, direction: Vec3) -> f32 {
        direction.dot(self.axis)
    }

    /// Whether the arc from `c`, on that side, to `d`, on the other, crosses this one: two edges make a face of the
    /// Minkowski difference exactly then (Gregorius, "The separating axis test between convex polyhedra", GDC 2013).
    fn crosses(&self, c: Vec3, d: Vec3, side_of_c: f32) -> bool {
        let axis = d.cross(c);
        let (of_a, of_b) = (self.a.dot(axis), self.b.dot(axis));
        of_a * of_b < 0.0 && side_of_c * of_b > 0.0
    }
}

fn ends(a: &Poly, edge: &HullEdge) -> [Vec3; 2] {
    edge.vertices.map(|v| a.vertices[v as usize])
}

/// A under the triangle's normal: the parts of its edges in the prism, and the triangle's corners under its face.
fn on_face(facet: &Facet, i: usize, a: &Poly, heights: &Heights, probe: &Probe, touches: &mut Vec<Touch>) {
    // How far outside of each side of the prism each corner is, of those that somebody asks for.
    let mut outsides: Numbers<Option<[f32; 3]>> = SmallVec::from_elem(None, heights.len());
    let mut outside = |k: usize| {
        *outsides[k].get_or_insert_with(|| {
            [0, 1, 2].map(|side| facet.outside(side, a.vertices[k]) - facet.allowance(side, heights[k]))
        })
    };
    for (k, &v) in a.vertices.iter().enumerate() {
        if heights[k] <= probe.margin && outside(k).iter().all(|&by| by <= 0.0) {
            touches.push(facet.face_touch(i, v, 0.0, k));
        }
    }
    for (e, edge) in a.edges.iter().enumerate() {
        let [from, to] = edge.vertices.map(|v| v as usize);
        if heights[from].min(heights[to]) > probe.margin {
            continue;
        }
        let sides = outside(from).into_iter().zip(outside(to));
        let Some(ends) = clip(sides) else { continue };
        let ([p, q], rise) = (self::ends(a, edge), heights[to] - heights[from]);
        // Over a flat border the neighbour has the rest of an edge, and its end. Of an upright edge on the border rounding would
        // decide at which height it crosses.
        let upright = rise.abs() > STEEP * p.distance(q);
        for (k, (t, cut)) in ends.into_iter().enumerate() {
            let v = p + t * (q - p);
            let crosses = cut.is_some_and(|side| !upright || facet.kinds[side] != EdgeKind::Flat);
            if crosses && facet.height(v) <= probe.margin {
                let feature = facet.own_feature(3, e, k);
                touches.push(Touch { feature, ..facet.face_touch(i, v, 0.0, 0) });
            }
        }
    }
    let (face, cosine) = a.face_towards(-facet.normal);
    if cosine < LIES {
        return;
    }
    for (k, &corner) in facet.corners.iter().enumerate() {
        let distance = (a.normals[face].dot(corner) - a.offsets[face]) / cosine;
        if distance <= probe.margin && sides(a, face).all(|(from, outward)| outward.dot(corner - from) <= 0.0)
        {
            touches.push(Touch {
                out: facet.normal,
                on_a: corner + distance * facet.normal,
                distance,
                feature: facet.shared_feature([k, k], a.vertices.len() + face),
                facet: i,
                doubtful: true,
            });
        }
    }
}

/// Planes through the edges of a face of A, square to it: a point and the direction away from the face, not unit.
fn sides<'a>(a: &'a Poly, face: usize) -> impl Iterator<Item = (Vec3, Vec3)> + 'a {
    let corners = a.face(face);
    (0..corners.len()).map(move |k| {
        let from = a.vertices[corners[k] as usize];
        let to = a.vertices[corners[(k + 1) % corners.len()] as usize];
        (from, (to - from).cross(a.normals[face]))
    })
}

/// The part of a segment on the inner side of all planes: its two ends as parameters, each with the plane that cuts it there, if one does. For
/// each plane, how far outside both ends of the segment are.
pub(super) fn clip(planes: impl Iterator<Item = (f32, f32)>) -> Option<[(f32, Option<usize>); 2]> {
    let (mut first, mut last) = ((0.0_f32, None), (1.0_f32, None));
    for (plane, (from, to)) in planes.enumerate() {
        if from > 0.0 && to > 0.0 {
            return None;
        }
        let crossed = from / (from - to);
        if from > 0.0 && crossed > first.0 {
            first = (crossed, Some(plane));
        } else if to > 0.0 && crossed < last.0 {
            last = (crossed, Some(plane));
        }
    }
    (first.0 <= last.0).then_some([first, last])
}

/// Where a point of the surface touches a face of A, `height` over it.
fn under(facet: &Facet, a: &Poly, face: usize, out: Vec3, q: Vec3, height: f32, name: usize) -> Touch {
    Touch {
        out,
        on_a: q - height * a.normals[face],
        distance: height,
        feature: facet.own_feature(4, face, name),
        facet: 0,
        doubtful: false,
    }
}

/// The triangle, cut to the outline of a face of A.
fn against(facet: &Facet, a: &Poly, face: usize, probe: &Probe, mut put: impl FnMut(Touch)) {
    let mut polygon: SmallVec<[(Vec3, usize); 24]> =
        facet.corners.iter().enumerate().map(|(k, &c)| (c, k)).collect();
    for (side, (from, outward)) in sides(a, face).enumerate() {
        let mut inner = SmallVec::new();
        for k in 0..polygon.len() {
            let ((p, name), (q, _)) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            let (at_p, at_q) = (outward.dot(p - from), outward.dot(q - from));
            if at_p <= 0.0 {
                inner.push((p, name));
            }
            if (at_p > 0.0) != (at_q > 0.0) {
                inner.push((p + (at_p / (at_p - at_q)) * (q - p), 8 * (side + 1) + name % 8));
            }
        }
        polygon = inner;
    }
    for (q, name) in polygon {
        let height = a.normals[face].dot(q) - a.offsets[face];
        if height <= probe.margin {
            put(under(facet, a, face, -a.normals[face], q, height, name));
        }
    }
}

/// An edge of the triangle, cut to the outline of a face of A that lies on it; whether there was any of it.
fn edge_under(
    facet: &Facet,
    a: &Poly,
    edge: usize,
    face: usize,
    out: Vec3,
    probe: &Probe,
    mut put: impl FnMut(Touch),
) {
    let (p, q) = (facet.corners[edge], facet.corners[(edge + 1) % 3]);
    let outside = sides(a, face).map(|(from, outward)| (outward.dot(p - from), outward.dot(q - from)));
    let Some(ends) = clip(outside) else {
        return;
    };
    for (end, (t, _)) in ends.into_iter().enumerate() {
        let point = p + t * (q - p);
        let height = a.normals[face].dot(point) - a.offsets[face];
        if height <= probe.margin {
            put(under(facet, a, face, out, point, height, 2 * edge + end));
        }
    }
}

/// A on an edge, pushed along the normal of the triangle beyond.
fn beyond(facet: &Facet, a: &Poly, edge: usize, probe: &Probe, mut put: impl FnMut(Touch)) {
    let out = facet.beyond[edge];
    let (face, cosine) = a.face_towards(-out);
    if cosine > LIES {
        edge_under(facet, a, edge, face, out, probe, put);
        return;
    }
    for (k, &v) in a.vertices.iter().enumerate() {
        let distance = out.dot(v - facet.corners[edge]);
        let height = facet.height(v);
        if distance <= probe.margin && height <= probe.margin && facet.holds(v, height) {
            let feature = facet.own_feature(5, edge, k);
            put(Touch { out, on_a: v, distance, feature, facet: 0, doubtful: true });
        }
    }
}

/// An edge of A across an edge of the surface.
fn across(
    facet: &Facet,
    a: &Poly,
    edge: usize,
    of_a: usize,
    out: Vec3,
    probe: &Probe,
    mut put: impl FnMut(Touch),
) {
    let faces = a.edges[of_a].faces.map(|f| (f as usize, -a.normals[f as usize].dot(out)));
    let (face, cosine) = if faces[0].1 >= faces[1].1 { faces[0] } else { faces[1] };
    if cosine > LIES {
        edge_under(facet, a, edge, face, out, probe, put);
        return;
    }
    let [p, q] = ends(a, &a.edges[of_a]);
    let (c, d) = (facet.corners[edge], facet.corners[(edge + 1) % 3]);
    // Both edges lie in planes square to `out`: where they cross, seen along it.
    let (u, v, w) = (q - p, d - c, c - p);
    let area = u.cross(v).dot(out);
    let (s, t) = (w.cross(v).dot(out) / area, w.cross(u).dot(out) / area);
    let inside = |x: f32| (-1e-4..=1.0 + 1e-4).contains(&x);
    if inside(s) && inside(t) {
        let (on_a, on_b) = (p + s * u, c + t * v);
        let distance = out.dot(on_a - on_b);
        let feature = facet.shared_feature([edge, edge + 1], of_a);
        put(Touch { out, on_a, distance, feature, facet: 0, doubtful: false });
    }
}
