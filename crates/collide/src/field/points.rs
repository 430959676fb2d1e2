//! Corners and edges of what is no field, as points that are measured in one.
//!
//! Edges carry points that are no further apart than the field's samples, at places of their own, so that they keep their names when the field moves; only those near it
//! are made. The core of a sphere, a capsule or a rounded shape carries points with a skin: balls.

use super::side::Side;
use crate::convex;
use crate::form::{Form, Solid};
use crate::surface::Surface;
use rockfall_math::{Aabb, Vec3, hash, trig};
use rockfall_shape::{EdgeKind, Field, Frustum, Shape};
use std::f32::consts::TAU;

/// A point of a shape, in its frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) at: Vec3,
    /// Unit vector out of the shape; of no meaning where there is a skin, which has all.
    pub(super) out: Vec3,
    /// Cosine of the largest angle between that and the surface's normals around the point.
    pub(super) cone: f32,
    /// Distance of the surface from the point, metres.
    pub(super) skin: f32,
    pub(super) name: u32,
}

/// Names of the points of an edge; a longer one uses some again.
const PLACES: u32 = 1 << 12;

/// No more points than that lie along the reach. Along an ordinary one, shorter than the field, there are fewer anyway.
const MOST_AHEAD: f32 = 64.0;

/// The least number of points around a rim.
const SPOKES: u32 = 16;

/// Calls `put` with the points of `own` that may be within `reach` of a field.
pub(super) fn near(
    own: &Side,
    other: &Side,
    field: &Field,
    reach: f32,
    spacing: f32,
    put: &mut impl FnMut(Point),
) {
    let bounds = field.mesh().bounds;
    // From the field's frame to that of the shape.
    let seen = own.place.inverse().then_after(&other.place);
    let area = Area { center: seen.point(bounds.center()), radius: bounds.half_extents().length() + reach };
    // What is met from far off, by a fast body, is met coarser: else points would grow with the way ahead.
    let spacing = spacing.max(reach / MOST_AHEAD);
    match own.shape {
        Shape::Mesh(mesh) => surface(&**mesh, &area, spacing, put),
        Shape::HeightField(heights) => surface(&**heights, &area, spacing, put),
        shape => {
            if let Some(solid) = convex::solid(shape) {
                convex(&solid, &area, spacing, put);
            }
        }
    }
}

/// A ball around the field.
struct Area {
    center: Vec3,
    radius: f32,
}

impl Area {
    fn has(&self, p: Vec3, skin: f32) -> bool {
        p.distance_squared(self.center) <= (self.radius + skin) * (self.radius + skin)
    }

    /// Calls `f` with the points between two, and their numbers, that are no further apart than `spacing`: the middles of balls of radius `skin`.
    fn between(&self, [a, b]: [Vec3; 2], skin: f32, spacing: f32, mut f: impl FnMut(u32, Vec3)) {
        let along = b - a;
        let parts = (along.length() / spacing).ceil().max(1.0);
        let middle = (self.center - a).dot(along) / along.length_squared();
        // Of a chain of balls those are nearest to what is in the area that have their middle no further along than it reaches.
        let half = (self.radius + spacing) / along.length();
        let from = ((middle - half) * parts).ceil().max(1.0);
        let until = ((middle + half) * parts).floor().min(parts - 1.0);
        // Whole numbers: of an edge of more than 2²⁴ parts, single precision would not get on.
        for i in from as u64..=until as u64 {
            let p = a + along * (i as f32 / parts);
            if self.has(p, skin) {
                f((i % u64::from(u32::MAX)) as u32, p);
            }
        }
    }
}

fn convex(solid: &Solid, area: &Area, spacing: f32, put: &mut impl FnMut(Point)) {
    let skin = solid.skin;
    match &solid.form {
        Form::Segment(half) => {
            let ends = [-*half, *half].map(|z| Vec3::Z * z);
            let point = |at, name| Point { at, out: Vec3::Z, cone: 1.0, skin, name };
            put(point(ends[0], 0));
            if *half > 0.0 {
                put(point(ends[1], 1));
                area.between(ends, skin, spacing, |i, at| put(point(at, 1 + i)));
            }
        }
        Form::Frustum(frustum) => {
            rim(frustum, -1.0, area, spacing, put);
            rim(frustum, 1.0, area, spacing, put);
        }
        Form::Ellipsoid(half) => {
            for (at, name) in solid.points().into_iter().zip(0..) {
                let out = (at / (*half * *half)).normalize_or_zero();
                put(Point { at, out, cone: 1.0, skin, name });
            }
        }
        Form::Hull(_) | Form::Box(_) => {
            let Some(poly) = solid.poly() else { return };
            for (&at, name) in poly.vertices.iter().zip(0..) {
                if area.has(at, skin) {
                    let edges = poly.edges.iter().filter(|edge| edge.vertices.contains(&name));
                    let normals = || edges.clone().flat_map(|e| e.faces.map(|f| poly.normals[f as usize]));
                    let (out, cone) = cone(normals);
                    put(Point { at, out, cone, skin, name });
                }
            }
            for (edge, name) in poly.edges.iter().zip(1..) {
                let ends = edge.vertices.map(|v| poly.vertices[v as usize]);
                let (out, cone) = cone(|| edge.faces.map(|f| poly.normals[f as usize]).into_iter());
                area.between(ends, skin, spacing, |i, at| {
                    put(Point { at, out, cone, skin, name: name * PLACES + i % PLACES });
                });
            }
        }
    }
}

/// The lower or the upper rim of a cylinder or a cone.
fn rim(frustum: &Frustum, side: f32, area: &Area, spacing: f32, put: &mut impl FnMut(Point)) {
    let z = side * frustum.half_length;
    let radius = if side < 0.0 { frustum.lower } else { frustum.upper };
    let first = if side < 0.0 { 0 } else { 1 << 30 };
    let (across, along) = frustum.side();
    if radius == 0.0 {
        let cone = side * along as f32;
        put(Point { at: Vec3::Z * z, out: Vec3::Z * side, cone, skin: 0.0, name: first });
        return;
    }
    let count = ((TAU * radius / spacing).ceil() as u32).max(SPOKES);
    // Of a large rim only the arc that is near.
    let [x, y, _] = area.center.to_array();
    let wide = 1.6 * area.radius / radius;
    let (from, until) = if wide < 3.0 {
        let middle = trig::atan2(y, x) / TAU * count as f32;
        let half = (wide / TAU * count as f32).ceil();
        ((middle - half).floor() as i64, (middle + half).ceil() as i64)
    } else {
        (0, i64::from(count) - 1)
    };
    for i in from..=until {
        let spoke = i.rem_euclid(i64::from(count)) as u32;
        let (sin, cos) = trig::sin_cos(TAU * spoke as f32 / count as f32);
        let at = Vec3::new(radius * cos, radius * sin, z);
        if area.has(at, 0.0) {
            let flank = Vec3::new(cos * across as f32, sin * across as f32, along as f32);
            let (out, cone) = cone(|| [flank, Vec3::Z * side].into_iter());
            put(Point { at, out, cone, skin: 0.0, name: spoke.wrapping_add(first) });
        }
    }
}

/// The middle of some normals, and the cosine of the largest angle to one of them.
fn cone<I: Iterator<Item = Vec3>>(normals: impl Fn() -> I) -> (Vec3, f32) {
    let out = normals().sum::<Vec3>().normalize_or(Vec3::Z);
    (out, normals().fold(1.0, |least, n| least.min(out.dot(n))))
}

/// Corners of a surface and points on those edges that a body can touch.
fn surface<S: Surface>(surface: &S, area: &Area, spacing: f32, put: &mut impl FnMut(Point)) {
    let mut triangles = Vec::new();
    let around = Aabb::new(area.center - area.radius, area.center + area.radius);
    surface.near(&around, |triangle| triangles.push(triangle));
    triangles.sort_unstable();
    // Each corner once, with all triangles that have it: they are near as well.
    let mut corners: Vec<(u64, u64, usize)> = triangles
        .iter()
        .flat_map(|&t| surface.ids(t).into_iter().enumerate().map(move |(k, id)| (id, t, k)))
        .collect();
    corners.sort_unstable();
    for around in corners.chunk_by(|a, b| a.0 == b.0) {
        let (id, triangle, k) = around[0];
        let at = surface.corners(triangle)[k];
        if area.has(at, 0.0) {
            let (out, cone) = cone(|| around.iter().map(|(_, t, _)| surface.normal(*t)));
            put(Point { at, out, cone, skin: 0.0, name: hash::mix(id) as u32 });
        }
    }
    for &triangle in &triangles {
        let (corners, normal, ids) =
            (surface.corners(triangle), surface.normal(triangle), surface.ids(triangle));
        for edge in 0..3 {
            let (kind, beyond) = surface.beyond(triangle, edge, &corners, normal);
            let first = surface.neighbour(triangle, edge).is_none_or(|other| triangle < other);
            if !first || !matches!(kind, EdgeKind::Convex | EdgeKind::Boundary) {
                continue;
            }
            let (out, cone) = cone(|| [normal, beyond].into_iter());
            let name = hash::combine(ids[edge], ids[(edge + 1) % 3]);
            area.between([corners[edge], corners[(edge + 1) % 3]], 0.0, spacing, |i, at| {
                put(Point { at, out, cone, skin: 0.0, name: hash::combine(name, u64::from(i)) as u32 });
            });
        }
    }
}
