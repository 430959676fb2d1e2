//! A polyhedron against a sphere or a capsule: the core is a point or a segment, the skin is taken off the distance.

use crate::clip::SLACK;
use crate::closest::Closest;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::Poly;
use crate::sat::preference;
use crate::segments;
use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};

/// Cosine above which a segment lies on a face: see the one of polyhedra.
const FACE_COSINE: f32 = 0.98;

/// A point near a polyhedron, no further than `limit`.
pub(crate) fn point(a: &Poly, p: Vec3, limit: f32) -> Option<Closest> {
    let mut best = (0, f32::NEG_INFINITY);
    for (f, (n, offset)) in a.normals.iter().zip(a.offsets).enumerate() {
        let height = n.dot(p) - offset;
        if height > limit {
            return None;
        }
        if height > best.1 {
            best = (f, height);
        }
    }
    // Inside, the nearest face is the highest one; outside, it is if the point is above the face itself.
    let (f, height) = best;
    if height <= 0.0 || above_face(a, f, p) {
        let normal = a.normals[f];
        return Some(Closest {
            distance: height,
            normal,
            on_a: p - height * normal,
            on_b: p,
            feature: feature::pair(f, 0xfe),
        });
    }
    match gjk::proximity(a.vertices, &[p], &Isometry::IDENTITY, limit) {
        Proximity::Apart(closest) => Some(closest),
        Proximity::Beyond(_) => None,
        // On an edge or a corner, to the last digit.
        Proximity::Overlap => Some(Closest {
            distance: 0.0,
            normal: a.normals[f],
            on_a: p,
            on_b: p,
            feature: feature::pair(f, 0xfe),
        }),
    }
}

fn above_face(a: &Poly, f: usize, p: Vec3) -> bool {
    sides(a, f).all(|(corner, outward)| outward.dot(p - corner) <= 0.0)
}

/// A corner and the outward direction (not unit) of every side of a face.
fn sides<'a>(a: &Poly<'a>, f: usize) -> impl Iterator<Item = (Vec3, Vec3)> + use<'a> {
    let (corners, vertices, normal) = (a.face(f), a.vertices, a.normals[f]);
    (0..corners.len()).map(move |k| {
        let from = vertices[corners[k] as usize];
        let to = vertices[corners[if k + 1 == corners.len() { 0 } else { k + 1 }] as usize];
        (from, (to - from).cross(normal))
    })
}

/// How a segment lies to a polyhedron.
struct Axis {
    closest: Closest,
    /// The face to clip to, where there is one.
    face: Option<usize>,
}

/// A segment near a polyhedron, or in it, no further than `limit`.
pub(crate) fn segment(a: &Poly, core: [Vec3; 2], limit: f32) -> Option<Closest> {
    axis(a, core, limit, false).map(|axis| axis.closest)
}

/// The manifold of a polyhedron and a segment with a skin of `radius`: two points where it lies on a face.
pub(crate) fn capsule_manifold(a: &Poly, core: [Vec3; 2], radius: f32, margin: f32) -> Option<Manifold> {
    let Axis { closest, face } = axis(a, core, margin + radius, true)?;
    let nearest = closest.with_skins(0.0, radius);
    let mut manifold = nearest.manifold();
    let Some(f) = face else { return Some(manifold) };

    // Cut the core by the sides of the face.
    let direction = core[1] - core[0];
    let slack = SLACK * a.inner_radius;
    let (mut low, mut high) = ((0.0, feature::edge_tag(0)), (1.0, feature::edge_tag(1)));
    for (k, (corner, outward)) in sides(a, f).enumerate() {
        let height = outward.dot(core[0] - corner) - slack * outward.length();
        let slope = outward.dot(direction);
        if slope > 0.0 && -height < slope * high.0 {
            high = (-height / slope, feature::side_tag(k));
        } else if slope < 0.0 && height > -slope * low.0 {
            low = (height / -slope, feature::side_tag(k));
        } else if slope == 0.0 && height > 0.0 {
            return Some(manifold);
        }
    }
    // Too short a stretch for two points, or upright on the face.
    if (high.0 - low.0) * direction.length() <= 0.1 * radius {
        return Some(manifold);
    }
    let lean = a.normals[f].dot(closest.normal);
    manifold.count = 0;
    for ((t, tag), end) in [(low, 0), (high, 1)] {
        let p = core[0] + t * direction;
        let gap = ((a.normals[f].dot(p) - a.offsets[f]) / lean).max(closest.distance);
        let distance = gap - radius;
        if distance <= margin {
            manifold.points[manifold.count as usize] = ContactPoint {
                position: p - (radius + 0.5 * distance) * closest.normal,
                distance,
                feature: feature::corner(feature::faces(false, f, 0), tag, end),
            };
            manifold.count += 1;
        }
    }
    let size = direction.length() + a.vertices[0].length();
    if manifold.count == 0 || manifold.deepest() > nearest.distance + 4e-7 * size {
        manifold.points[manifold.count as usize] = nearest.point();
        manifold.count += 1;
    }
    Some(manifold)
}

fn axis(a: &Poly, core: [Vec3; 2], limit: f32, steady: bool) -> Option<Axis> {
    match gjk::proximity(a.vertices, &core, &Isometry::IDENTITY, limit) {
        Proximity::Beyond(_) => None,
        Proximity::Apart(closest) => {
            let (f, cosine) = a.face_towards(closest.normal);
            Some(Axis { closest, face: (cosine >= FACE_COSINE).then_some(f) })
        }
        Proximity::Overlap => Some(least_overlap(a, core, steady)),
    }
}

/// The shortest way out: along a face normal, or along the common perpendicular of the segment and an edge whose
/// two faces look to different sides of it.
fn least_overlap(a: &Poly, core: [Vec3; 2], steady: bool) -> Axis {
    let direction = core[1] - core[0];
    let mut best = (0, f32::NEG_INFINITY, core[0]);
    for (f, (n, offset)) in a.normals.iter().zip(a.offsets).enumerate() {
        let (first, second) = (n.dot(core[0]), n.dot(core[1]));
        let (least, at) = if second < first { (second, core[1]) } else { (first, core[0]) };
        if least - offset > best.1 {
            best = (f, least - offset, at);
        }
    }
    let (f, separation, at) = best;
    let normal = a.normals[f];
    let on_a = at - separation * normal;
    let mut closest = Closest { distance: separation, normal, on_a, on_b: at, feature: feature::pair(f, 0xfe) };
    let mut face = Some(f);

    let ahead = if steady { preference(a.inner_radius, separation) } else { 0.0 };
    for (i, e) in a.edges.iter().enumerate() {
        let left = a.normals[e.faces[0] as usize].dot(direction);
        let right = a.normals[e.faces[1] as usize].dot(direction);
        if left * right >= 0.0 {
            continue;
        }
        let edge = e.vertices.map(|v| a.vertices[v as usize]);
        let along = (edge[1] - edge[0]).as_dvec3();
        let cross = along.cross(direction.as_dvec3());
        let squared = cross.length_squared();
        if squared <= 1e-8 * along.length_squared() * direction.as_dvec3().length_squared() {
            continue;
        }
        let n = cross / squared.sqrt();
        let n = if n.dot((edge[0] - a.center).as_dvec3()) < 0.0 { -n } else { n };
        let separation = n.dot((core[0] - edge[0]).as_dvec3()) as f32;
        let least = if face.is_some() { closest.distance + ahead } else { closest.distance };
        if separation > least {
            let (on_a, on_b) = segments::nearest(edge, core).points();
            let feature = feature::pair(i, 0xff);
            closest = Closest { distance: separation, normal: n.as_vec3(), on_a, on_b, feature };
            face = None;
        }
    }
    Axis { closest, face }
}
