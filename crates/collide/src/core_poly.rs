//! A polyhedron against a sphere or a capsule: the core is a point or a segment, the skin is taken off the distance.

use crate::clip::{self, End, SLACK};
use crate::closest::Closest;
use crate::direction;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::{Poly, largest, smallest};
use crate::sat::{self, edge_axis, preference};
use crate::segments;
use crate::{Cache, ContactPoint, Manifold};
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::HULL_LANES;

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
    match Width::native().run(Lie { a, core, limit }) {
        Lies::Beyond(_) => None,
        Lies::Apart(closest) => Some(closest),
        Lies::In(overlap) => Some(overlap.least(a, core)),
    }
}

/// How far apart a direction (not unit) from the polyhedron to the points proves them to be.
fn apart(a: &Poly, points: &[Vec3], axis: Vec3) -> f32 {
    let axis = axis.normalize_or_zero();
    let nearest = points.iter().fold(f32::INFINITY, |least, p| least.min(axis.dot(*p)));
    nearest - axis.dot(a.support(axis))
}

/// The manifold of a polyhedron and a segment with a skin of `radius`, or how far apart they are at least: two points where
/// it lies on a face. The cache has the direction that parted them last.
pub(crate) fn capsule_manifold(
    a: &Poly,
    core: [Vec3; 2],
    radius: f32,
    margin: f32,
    cache: &mut Cache,
) -> Result<Manifold, f32> {
    let limit = margin + radius;
    if let Some(axis) = direction::unpack(cache.word) {
        let apart = surely_apart(a, core, axis);
        if apart > limit {
            return Err(apart - radius);
        }
    }
    match Width::native().run(Lie { a, core, limit }) {
        Lies::Beyond(axis) => {
            cache.word = direction::pack(axis);
            Err((surely_apart(a, core, axis.normalize_or_zero()) - radius).max(margin))
        }
        Lies::Apart(closest) => {
            cache.word = 0;
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
        Lies::In(overlap) => {
            cache.word = 0;
            let (f, separation) = overlap.face;
            let ahead = preference(a.inner_radius, separation);
            let over_face = over_face(a, f, a.normals[f], separation, core, radius, margin);
            let holds = over_face.deepest() + radius <= separation + ahead;
            Ok(match overlap.edge {
                Some(edge) if edge.distance > separation + ahead || !holds => {
                    edge.with_skins(0.0, radius).manifold()
                }
                _ if over_face.count > 0 => over_face,
                _ => over_best_face(a, core, overlap.face).0.with_skins(0.0, radius).manifold(),
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

/// How a segment lies to a polyhedron.
enum Lies {
    /// Further away than was asked; the direction (not unit) tells.
    Beyond(Vec3),
    /// The nearest points.
    Apart(Closest),
    /// They overlap.
    In(Overlap),
}

/// Finds out how a segment lies: by the faces, which tell whether it is beyond the limit, over one of them,
/// or in the polyhedron; by the edges that it crosses;
/// and by a walk where an end is nearest to an edge, or anything to a corner.
struct Lie<'a> {
    a: &'a Poly<'a>,
    core: [Vec3; 2],
    limit: f32,
}

impl Kernel for Lie<'_> {
    type Output = Lies;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Lies {
        let Lie { a, core, limit } = self;
        let (face, inside) = best_face::<L>(token, a, core);
        let (f, separation) = face;
        if separation > limit {
            return Lies::Beyond(a.normals[f]);
        }
        if inside {
            return Lies::In(Overlap { face, edge: best_edge::<L>(token, a, core, separation) });
        }
        // Below the plane of each face, half a micrometre per metre of size is nothing.
        let same = 2e-7 * (core[0].length() + core[1].length() + a.vertices[0].length());
        if separation > 0.0 {
            let (over_face, is_over) = over_best_face(a, core, face);
            if is_over && a.normals[f].dot(over_face.on_b) - a.offsets[f] <= separation + same {
                return Lies::Apart(over_face);
            }
        }
        let edge = best_edge::<L>(token, a, core, separation.max(0.0));
        if let Some(edge) = edge.filter(|edge| edge.distance > separation.max(0.0) + same) {
            return if edge.distance > limit { Lies::Beyond(edge.normal) } else { Lies::Apart(edge) };
        }
        let towards = a.normals[f];
        match gjk::proximity(a.vertices, &core, &Isometry::IDENTITY, towards, limit) {
            Proximity::Beyond(axis) => Lies::Beyond(axis),
            Proximity::Apart(closest) => Lies::Apart(closest),
            Proximity::Overlap => Lies::In(Overlap { face, edge }),
        }
    }
}

/// The face over which a segment stays furthest, how far, and whether a part of it is below all faces.
#[inline(always)]
fn best_face<L: Lanes>(token: L::Token, a: &Poly, core: [Vec3; 2]) -> ((usize, f32), bool) {
    let (zero, one) = (L::splat(token, 0.0), L::splat(token, 1.0));
    let (from, to) = (Lanes3::<L>::splat(token, core[0]), Lanes3::<L>::splat(token, core[1]));
    let mut best = (0, f32::NEG_INFINITY);
    let (mut enters, mut leaves) = (zero, one);
    for (k, face) in a.face_blocks.iter().enumerate() {
        let mut separations = [0.0; HULL_LANES];
        for l in (0..HULL_LANES).step_by(L::WIDTH) {
            let row = |k: usize| L::load(token, &face[k][l..]);
            let normal = Lanes3::new(row(0), row(1), row(2));
            let (first, second) = (normal.dot(from) - row(3), normal.dot(to) - row(3));
            first.min(second).store(&mut separations[l..]);
            // Where the segment crosses the plane, one way or the other.
            let t = first / (first - second);
            enters = L::select(zero.lt(first), t, zero).max(enters);
            leaves = L::select(zero.lt(second), t, one).min(leaves);
        }
        let most = largest(&separations);
        if most > best.1 {
            best = (k * HULL_LANES + separations.iter().position(|&s| s == most).unwrap_or(0), most);
        }
    }
    let (mut last, mut first) = ([0.0; HULL_LANES], [1.0; HULL_LANES]);
    enters.store(&mut last);
    leaves.store(&mut first);
    (best, best.1 <= 0.0 && largest(&last) <= smallest(&first))
}

/// The ways out of a polyhedron for a segment inside.
struct Overlap {
    /// The best face, and the separation along its normal.
    face: (usize, f32),
    /// The best edge: along the common perpendicular of it and the segment.
    edge: Option<Closest>,
}

impl Overlap {
    /// The shortest way out.
    fn least(&self, a: &Poly, core: [Vec3; 2]) -> Closest {
        let edge = self.edge.filter(|edge| edge.distance > self.face.1);
        edge.unwrap_or_else(|| over_best_face(a, core, self.face).0)
    }
}

/// Between a face and the lowest point of what its sides leave of a segment, or of all of it where they leave
/// nothing, and whether they leave something.
fn over_best_face(a: &Poly, core: [Vec3; 2], (f, separation): (usize, f32)) -> (Closest, bool) {
    let normal = a.normals[f];
    let stretch = clip(a, f, normal, core, 0.0);
    let [low, high] = stretch.map_or([0.0, 1.0], |ends| ends.map(|e| e.t));
    let (low, high) = (core[0].lerp(core[1], low), core[0].lerp(core[1], high));
    let on_b = if normal.dot(high) < normal.dot(low) { high } else { low };
    let on_a = on_b - separation * normal;
    let feature = feature::pair(f, 0xfe);
    (Closest { distance: separation, normal, on_a, on_b, feature }, stretch.is_some())
}

/// The edge that separates a polyhedron from a segment most along their common perpendicular, of those whose
/// two faces look to different sides of it. Those that
/// separate by less than `floor` may be passed over.
#[inline(always)]
fn best_edge<L: Lanes>(token: L::Token, a: &Poly, core: [Vec3; 2], floor: f32) -> Option<Closest> {
    let direction = core[1] - core[0];
    let mut best: Option<Closest> = None;
    for i in sat::open::<L>(token, a, core[0].midpoint(core[1]), 0.0, floor).numbers() {
        let e = &a.edges[i];
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
    best
}

/// The distance that a direction (unit) proves, with room for all rounding: the slow way must agree that
/// there is so much.
fn surely_apart(a: &Poly, core: [Vec3; 2], axis: Vec3) -> f32 {
    let furthest = a.reach(axis);
    let nearest = axis.dot(core[0]).min(axis.dot(core[1]));
    let rounding = 1e-5 * (furthest.abs() + nearest.abs() + core[0].abs().element_sum());
    (nearest - furthest) * (1.0 - 1e-5) - rounding
}
