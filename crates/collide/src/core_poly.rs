//! A polyhedron against a sphere or a capsule: the core is a point or a segment, the skin is taken off the distance.

use crate::clip::{self, End, SLACK};
use crate::closest::Closest;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::Poly;
use crate::sat::{edge_axis, preference};
use crate::segments;
use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};

/// Cosine of the angle between the normal and a face above which a segment lies on that face: 11 degrees.
const FACE_COSINE: f32 = 0.98;

/// A point near a polyhedron, no further than `limit`, or how far away it is at least.
pub(crate) fn point(a: &Poly, p: Vec3, limit: f32) -> Result<Closest, f32> {
    let mut best = (0, f32::NEG_INFINITY);
    for (f, (n, offset)) in a.normals.iter().zip(a.offsets).enumerate() {
        let height = n.dot(p) - offset;
        if height > limit {
            return Err(height);
        }
        if height > best.1 {
            best = (f, height);
        }
    }
    // Inside, the nearest face is the highest one; outside, it is if the point is above the face itself.
    let (f, height) = best;
    if height <= 0.0 || is_above(a, f, p) {
        let normal = a.normals[f];
        return Ok(Closest {
            distance: height,
            normal,
            on_a: p - height * normal,
            on_b: p,
            feature: feature::pair(f, 0xfe),
        });
    }
    match gjk::proximity(a.vertices, &[p], &Isometry::IDENTITY, a.normals[f], limit) {
        Proximity::Apart(closest) => Ok(closest),
        Proximity::Beyond(axis) => Err(apart(a, &[p], axis).max(limit)),
        // On an edge or a corner, to the last digit.
        Proximity::Overlap => Ok(Closest {
            distance: 0.0,
            normal: a.normals[f],
            on_a: p,
            on_b: p,
            feature: feature::pair(f, 0xfe),
        }),
    }
}

/// Whether a point is between the sides of face `f`.
pub(crate) fn is_above(a: &Poly, f: usize, p: Vec3) -> bool {
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

/// A segment near a polyhedron, or in it, no further than `limit`.
pub(crate) fn segment(a: &Poly, core: [Vec3; 2], limit: f32) -> Option<Closest> {
    match gjk::proximity(a.vertices, &core, &Isometry::IDENTITY, core[0].midpoint(core[1]) - a.center, limit)
    {
        Proximity::Beyond(_) => None,
        Proximity::Apart(closest) => Some(closest),
        Proximity::Overlap => Some(least_overlap(a, core).least()),
    }
}

/// How far apart a direction (not unit) from the polyhedron to the points proves them to be.
fn apart(a: &Poly, points: &[Vec3], axis: Vec3) -> f32 {
    let axis = axis.normalize_or_zero();
    let nearest = points.iter().fold(f32::INFINITY, |least, p| least.min(axis.dot(*p)));
    nearest - axis.dot(a.support(axis))
}

/// The manifold of a polyhedron and a segment with a skin of `radius`, or how far apart they are at least: two points where
/// it lies on a face.
pub(crate) fn capsule_manifold(a: &Poly, core: [Vec3; 2], radius: f32, margin: f32) -> Result<Manifold, f32> {
    match gjk::proximity(
        a.vertices,
        &core,
        &Isometry::IDENTITY,
        core[0].midpoint(core[1]) - a.center,
        margin + radius,
    ) {
        Proximity::Beyond(axis) => Err((apart(a, &core, axis) - radius).max(margin)),
        Proximity::Apart(closest) => {
            let nearest = closest.with_skins(0.0, radius);
            let (f, cosine) = a.face_towards(closest.normal);
            let rounding = 4e-7 * (core[0].distance(core[1]) + a.vertices[0].length());
            let mut manifold = Manifold::default();
            if cosine >= FACE_COSINE {
                manifold = over_face(a, f, closest.normal, closest.distance, core, radius, margin);
            }
            manifold.normal = closest.normal;
            if manifold.deepest() > nearest.distance + rounding {
                manifold.points[manifold.count as usize] = nearest.point();
                manifold.count += 1;
            }
            Ok(manifold)
        }
        Proximity::Overlap => {
            let overlap = least_overlap(a, core);
            let (f, separation) = overlap.face;
            let ahead = preference(a.inner_radius, separation);
            let over_face = over_face(a, f, a.normals[f], separation, core, radius, margin);
            let holds = over_face.deepest() + radius <= separation + ahead;
            Ok(match overlap.edge {
                Some(edge) if edge.distance > separation + ahead || !holds => {
                    edge.with_skins(0.0, radius).manifold()
                }
                _ if over_face.count > 0 => over_face,
                _ => overlap.over_face.with_skins(0.0, radius).manifold(),
            })
        }
    }
}

/// The points of the core over face `f`, seen along `normal`, which is near to that of the face: both ends of what
/// its sides leave of the core, or the lower one where it is short. No core is nearer than `least`.
fn over_face(
    a: &Poly,
    f: usize,
    normal: Vec3,
    least: f32,
    core: [Vec3; 2],
    radius: f32,
    margin: f32,
) -> Manifold {
    let mut manifold = Manifold { normal, ..Manifold::default() };
    let Some(stretch) = clip(a, f, normal, core, SLACK * a.inner_radius) else { return manifold };
    let lean = a.normals[f].dot(normal);
    let points = stretch.map(|End { t, before, after }| {
        let p = core[0].lerp(core[1], t);
        let gap = ((a.normals[f].dot(p) - a.offsets[f]) / lean).max(least);
        let distance = gap - radius;
        ContactPoint {
            position: p - (radius + 0.5 * distance) * normal,
            distance,
            feature: feature::corner(feature::faces(false, f, 0), before, after),
        }
    });
    // Too short a stretch for two points; upright on the face, the far end is out of reach anyway.
    let short = points[0].position.distance(points[1].position) <= 0.1 * radius;
    let lower = usize::from(points[1].distance < points[0].distance);
    for (k, point) in points.into_iter().enumerate() {
        if point.distance <= margin && !(short && k != lower) {
            manifold.points[manifold.count as usize] = point;
            manifold.count += 1;
        }
    }
    manifold
}

/// The part of a segment over face `f` when it moves along `along`; the sides of the face stand back by `slack`.
fn clip(a: &Poly, f: usize, along: Vec3, core: [Vec3; 2], slack: f32) -> Option<[End; 2]> {
    clip::segment(sides(a, f), a.normals[f], along, core, slack)
}

/// The ways out of a polyhedron for a segment inside.
struct Overlap {
    /// The best face, and the separation along its normal.
    face: (usize, f32),
    /// The best edge: along the common perpendicular of it and the segment.
    edge: Option<Closest>,
    /// The nearest points for the face.
    over_face: Closest,
}

impl Overlap {
    fn least(&self) -> Closest {
        self.edge.filter(|edge| edge.distance > self.face.1).unwrap_or(self.over_face)
    }
}

/// The shortest way out: along a face normal, or along the common perpendicular of the segment and an edge whose
/// two faces look to different sides of it.
fn least_overlap(a: &Poly, core: [Vec3; 2]) -> Overlap {
    let direction = core[1] - core[0];
    let mut face = (0, f32::NEG_INFINITY);
    for (f, (n, offset)) in a.normals.iter().zip(a.offsets).enumerate() {
        let separation = n.dot(core[0]).min(n.dot(core[1])) - offset;
        if separation > face.1 {
            face = (f, separation);
        }
    }
    let (f, separation) = face;
    let normal = a.normals[f];
    let [low, high] = clip(a, f, normal, core, 0.0).map_or([0.0, 1.0], |ends| ends.map(|e| e.t));
    let (low, high) = (core[0].lerp(core[1], low), core[0].lerp(core[1], high));
    let on_b = if normal.dot(high) < normal.dot(low) { high } else { low };
    let over_face = Closest {
        distance: separation,
        normal,
        on_a: on_b - separation * normal,
        on_b,
        feature: feature::pair(f, 0xfe),
    };

    let mut best: Option<Closest> = None;
    for (i, e) in a.edges.iter().enumerate() {
        let left = a.normals[e.faces[0] as usize].dot(direction);
        let right = a.normals[e.faces[1] as usize].dot(direction);
        if left * right >= 0.0 {
            continue;
        }
        let edge = e.vertices.map(|v| a.vertices[v as usize]);
        let Some((normal, distance)) = edge_axis(edge, core, a.center) else { continue };
        if best.is_none_or(|b| distance > b.distance) {
            let (on_a, on_b) = segments::nearest(edge, core).points();
            best = Some(Closest { distance, normal, on_a, on_b, feature: feature::pair(i, 0xff) });
        }
    }
    Overlap { face, edge: best, over_face }
}
