//! Contact of a convex shape with a surface of triangles: a mesh or a height field.
//!
//! What flows in: a convex shape A, a surface, where the surface is in A's frame. What flows out: manifolds, as many as
//! the surface has directions under A.
//!
//! A body that slides over a floor of triangles must not feel their seams. Each triangle is therefore collided with
//! only those directions that the whole surface could push in: its own normal; between the normals of its two
//! triangles on an edge that bends away; and in the cone of all triangles around a corner. A seam in a flat floor
//! and the bottom of a valley have no such directions, so they never push. (The same restriction is known as Voronoi
//! regions, or as active edges.)
//!
//! 1. `gather` takes the triangles near A, in A's frame.
//! 2. `round` (spheres, capsules), `solid` (boxes, hulls) or `smooth` (all others) finds each triangle's contacts.
//! 3. `merge` drops what another triangle explains better and makes manifolds of the rest.
//!
//! Triangles are solid on the side opposite to their normals. A body that sank in is pushed out along the normal as
//! long as its centre is less than its inner radius behind the triangle, or at any depth in a height field. A closed mesh may be smaller than A:
//! what of A is behind a triangle, but out of the mesh again on its far side, did not sink in there.

pub(crate) mod facet;
mod height_field;
mod merge;
mod mesh;
mod round;
mod smooth;
mod solid;

use crate::Manifold;
use crate::convex;
use crate::poly::{BoxPoly, Poly};
use facet::Facet;
use rockfall_math::{Aabb, Isometry, Mat3, Vec3};
use rockfall_shape::{EdgeKind, HeightField, Mesh, Shape};

/// Contact of the convex shape `a` with a mesh, in A's frame, appended to `out`. Points further apart than `margin` are
/// left out. Normals point into the mesh. Nothing is appended where `a` is not convex or is a half-space. Returns a distance
/// by which both are surely apart, or 0, see [`collide`](crate::collide).
pub fn convex_mesh(
    a: &Shape,
    mesh: &Mesh,
    mesh_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    collide(a, mesh, mesh_in_a, margin, out)
}

/// Contact of the convex shape `a` with a height field; see [`convex_mesh`]. The field is solid all the way down.
pub fn convex_height_field(
    a: &Shape,
    field: &HeightField,
    field_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    collide(a, field, field_in_a, margin, out)
}

/// Triangles with neighbours, in their own frame. A triangle is named by an index.
pub(crate) trait Surface {
    /// Calls `f` with each triangle that may touch `area`, in any order.
    fn near(&self, area: &Aabb, f: impl FnMut(u64));
    /// Corners, counter-clockwise from outside.
    fn corners(&self, triangle: u64) -> [Vec3; 3];
    /// Names of the corners; triangles that share a corner share its name.
    fn ids(&self, triangle: u64) -> [u64; 3];
    /// Outward unit normal.
    fn normal(&self, triangle: u64) -> Vec3;
    /// How the surface bends at edge i, which runs from corner i to corner (i + 1) % 3, and the normal of the triangle
    /// beyond, its own where there is none; `corners` and `normal` are those of the triangle.
    fn beyond(&self, triangle: u64, edge: usize, corners: &[Vec3; 3], normal: Vec3) -> (EdgeKind, Vec3);
    /// The triangle on the other side of an edge.
    fn neighbour(&self, triangle: u64, edge: usize) -> Option<u64>;
    /// The triangle straight above or below a point, where everything below the surface is solid.
    fn cover(&self, point: Vec3) -> Option<u64>;
    /// Where the surface is closed, the radius of a ball inside, and the diagonal of the box around it, metres.
    fn inside(&self) -> Option<(f32, f32)>;
    /// Whether a point lies in front of the surface, by more than rounding.
    fn is_outside(&self, point: Vec3) -> bool;
    /// Whether everything below the surface (along z) is solid, so that no body can be on the wrong side of it.
    const BOTTOMLESS: bool;
}

/// A surface with its place in A's frame.
struct Placed<'a, S> {
    surface: &'a S,
    rotation: Mat3,
    /// Origin of A in the surface's frame. Corners are taken relative to it before they are rotated: far from
    /// the origin of a large terrain the differences are exact, the sums would not be.
    origin: Vec3,
}

impl<S: Surface> Placed<'_, S> {
    fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * (p - self.origin)
    }

    fn back(&self, p: Vec3) -> Vec3 {
        self.direction_back(p) + self.origin
    }

    fn direction_back(&self, v: Vec3) -> Vec3 {
        self.rotation.transpose() * v
    }

    /// The part of the surface's frame that is no further than `margin` from a box around A; its middle; and how exact that is.
    fn around(&self, bounds: &Aabb, margin: f32) -> (Aabb, Vec3, Vec3) {
        let back = self.rotation.transpose();
        let reach = Mat3::from_cols(back.x_axis.abs(), back.y_axis.abs(), back.z_axis.abs());
        let half = reach * bounds.half_extents() * (1.0 + 1e-5) + margin;
        let centre = self.back(bounds.center());
        let slack = centre.abs() * f32::EPSILON * 2.0;
        let area = Aabb::new(centre - half - slack, centre + half + slack);
        (area, centre, slack)
    }

    /// How far A is from a surface of which no triangle is within `margin` of the box around it: by as much as A is large, if
    /// there is none in a box so much larger either, else by the margin.
    fn apart(&self, bounds: &Aabb, ball: f32, margin: f32) -> f32 {
        let mut near = false;
        self.surface.near(&self.around(bounds, margin + ball).0, |_| near = true);
        if near { margin } else { margin + ball }
    }

    /// The triangles around A, which fills a ball of radius `ball` around the middle of `bounds`, in their order. What lies beyond their edges is looked up for those that are `close`.
    fn gather(&self, bounds: &Aabb, ball: f32, margin: f32, close: impl Fn(&Facet) -> bool) -> Vec<Facet> {
        let (area, centre, slack) = self.around(bounds, margin);
        let mut triangles = Vec::new();
        self.surface.near(&area, |triangle| triangles.push(triangle));
        triangles.sort_unstable();
        let around = |triangle| {
            let mut facet = Facet::new(self, triangle, bounds);
            facet.close = close(&facet);
            if facet.close {
                facet.look_beyond(self);
            }
            facet
        };
        // The corners of a box are empty where a ball fills it.
        let radius = ball + margin + slack.max_element();
        let reached = |triangle: &u64| {
            let mut area = Aabb::from_points(self.surface.corners(*triangle));
            if S::BOTTOMLESS {
                area.min.z = f32::NEG_INFINITY;
            }
            centre.distance_squared(centre.clamp(area.min, area.max)) <= radius * radius
        };
        triangles.into_iter().filter(reached).map(around).collect()
    }
}

/// What each triangle is collided with.
struct Probe<'a> {
    /// Corners of A's core.
    points: &'a [Vec3],
    margin: f32,
    /// Largest distance of a point of A from its origin: the unit of rounding errors, metres.
    size: f32,
    center: Vec3,
    /// Distance of A's core, which touches are made for, from its surface, metres.
    radius: f32,
    /// How far behind a triangle the centre may be, metres.
    limit: f32,
    /// Radius of the ball inside of A, metres.
    inner: f32,
    /// Radius of the ball inside of a closed surface, infinite where there is none, metres.
    thickness: f32,
    /// Depths that differ by less are equal, metres.
    tie: f32,
    /// Turns a direction in A's frame where outlines start; A's own frame where it has no need of another.
    frame: Mat3,
}

/// So many times as large as the ball inside of a closed surface is the ball inside of a body that is much larger.
const LARGE: f32 = 3.0;

impl Probe<'_> {
    /// Whether A is much larger than a closed surface.
    fn is_large(&self) -> bool {
        self.inner > LARGE * self.thickness
    }
}

/// A point of contact between A and one triangle.
#[derive(Clone, Copy)]
struct Touch {
    /// Unit vector out of the surface.
    out: Vec3,
    /// The point on A's surface.
    on_a: Vec3,
    /// Signed distance along `out`.
    distance: f32,
    feature: u32,
    /// Place of the triangle in the list of facets.
    facet: usize,
    /// Whether a point behind the triangle is pushed along the triangle's own normal, although it may have come in
    /// through another triangle.
    doubtful: bool,
}

impl Touch {
    /// How far in front of the surface a point is along `out`, behind it negative.
    fn in_front(&self, p: Vec3) -> f32 {
        self.out.dot(p - self.on_a) + self.distance
    }
}

fn collide<S: Surface>(
    a: &Shape,
    surface: &S,
    surface_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    match a {
        Shape::Sphere { radius } => ball(&[Vec3::ZERO], *radius, surface, surface_in_a, margin, out),
        Shape::Capsule { half_length, radius } => {
            let end = Vec3::Z * *half_length;
            ball(&[-end, end], *radius, surface, surface_in_a, margin, out)
        }
        Shape::Box { half } => poly(&BoxPoly::new(*half).poly(), surface, surface_in_a, margin, out),
        Shape::Hull(hull) => poly(&Poly::from(&**hull), surface, surface_in_a, margin, out),
        Shape::Cylinder { .. }
        | Shape::Cone { .. }
        | Shape::Ellipsoid { .. }
        | Shape::RoundedBox { .. }
        | Shape::RoundedHull { .. } => any(a, surface, surface_in_a, margin, out),
        Shape::HalfSpace { .. }
        | Shape::Mesh(_)
        | Shape::Field(_)
        | Shape::HeightField(_)
        | Shape::Compound(_) => 0.0,
    }
}

fn place<'a, S: Surface>(surface: &'a S, surface_in_a: &Isometry) -> Placed<'a, S> {
    Placed {
        surface,
        rotation: surface_in_a.rotation,
        origin: surface_in_a.inverse_vector(-surface_in_a.translation),
    }
}

/// Radius of the ball inside of a closed surface, infinite where there is none, metres.
fn thickness<S: Surface>(surface: &S) -> f32 {
    surface.inside().map_or(f32::INFINITY, |(radius, _)| radius)
}

/// Spheres (one core point) and capsules (two).
fn ball<S: Surface>(
    core: &[Vec3],
    radius: f32,
    surface: &S,
    surface_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    let placed = place(surface, surface_in_a);
    let bounds = Aabb::from_points(core.iter().copied()).grown(radius);
    let reach = radius + margin;
    let facets = placed.gather(&bounds, core[0].length() + radius, margin, |facet| {
        let high = core.iter().fold(f32::INFINITY, |low, &p| low.min(facet.height(p)));
        let wide = |edge| core.iter().fold(f32::INFINITY, |low, &p| low.min(facet.outside(edge, p)));
        high <= reach && (0..3).all(|edge| wide(edge) <= reach + facet.allowance_below(high))
    });
    let size = core[0].length() + radius;
    if facets.is_empty() {
        return placed.apart(&bounds, size, margin);
    }
    let limit = if S::BOTTOMLESS { f32::INFINITY } else { radius };
    let (frame, thickness) = (Mat3::IDENTITY, thickness(surface));
    let probe = Probe {
        points: core,
        margin,
        size,
        center: Vec3::ZERO,
        radius,
        limit,
        inner: radius,
        thickness,
        tie: 0.0,
        frame,
    };
    let mut touches = Vec::new();
    for i in 0..facets.len() {
        round::touch(&placed, &facets, i, core, radius, &probe, &mut touches);
    }
    sunk(&placed, &facets, core, radius, &probe, &mut touches);
    merge::drop_passed(&placed, &facets, &probe, &mut touches);
    let mut kept = merge::keep(&facets, &probe, &touches);
    if kept.is_empty() && touches.is_empty() {
        kept.extend(round::nearest(&facets, core, radius, &probe));
    }
    merge::manifolds(&facets, core, &probe, kept, out);
    0.0
}

/// Boxes and hulls.
fn poly<S: Surface>(
    a: &Poly,
    surface: &S,
    surface_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    let placed = place(surface, surface_in_a);
    let bounds = Aabb::from_points(a.vertices.iter().copied());
    let middle = bounds.center();
    let ball = a.vertices.iter().fold(0.0_f32, |far, v| far.max(v.distance(middle)));
    let facets =
        placed.gather(&bounds, ball, margin, |facet| a.vertices.iter().any(|&v| facet.height(v) <= margin));
    if facets.is_empty() {
        return placed.apart(&bounds, ball, margin);
    }
    let size = bounds.min.abs().max(bounds.max.abs()).length();
    let limit = if S::BOTTOMLESS { f32::INFINITY } else { a.inner_radius };
    let (center, frame, thickness) = (a.center, Mat3::IDENTITY, thickness(surface));
    let probe = Probe {
        points: a.vertices,
        margin,
        size,
        center,
        radius: 0.0,
        limit,
        inner: a.inner_radius,
        thickness,
        tie: 0.0,
        frame,
    };
    let mut touches = Vec::new();
    let reached: Vec<bool> =
        (0..facets.len()).map(|i| solid::touch(&placed, &facets, i, a, &probe, &mut touches)).collect();
    sunk(&placed, &facets, a.vertices, 0.0, &probe, &mut touches);
    merge::drop_passed(&placed, &facets, &probe, &mut touches);
    let mut kept = merge::keep(&facets, &probe, &touches);
    if kept.is_empty() {
        let reached = facets.iter().enumerate().filter(|(i, _)| reached[*i]);
        kept.extend(solid::nearest(reached, a, &probe));
    }
    merge::manifolds(&facets, a.vertices, &probe, kept, out);
    0.0
}

/// Cylinders, cones, ellipsoids, rounded boxes and hulls.
fn any<S: Surface>(
    a: &Shape,
    surface: &S,
    surface_in_a: &Isometry,
    margin: f32,
    out: &mut Vec<Manifold>,
) -> f32 {
    let Some(solid) = convex::solid(a) else { return 0.0 };
    let placed = place(surface, surface_in_a);
    let bounds = a.bounds();
    let reach = solid.skin + margin;
    let ball = a.radius_about(bounds.center());
    let facets = placed
        .gather(&bounds, ball, margin, |facet| facet.height(smooth::lowest(&solid, facet.normal)) <= reach);
    if facets.is_empty() {
        return placed.apart(&bounds, ball, margin);
    }
    let points = solid.points();
    let size = bounds.min.abs().max(bounds.max.abs()).length();
    let limit = if S::BOTTOMLESS { f32::INFINITY } else { a.inner_radius() };
    let probe = Probe {
        points: &points,
        margin,
        size,
        center: a.inner_center(),
        radius: solid.skin,
        limit,
        inner: a.inner_radius(),
        thickness: thickness(surface),
        tie: smooth::tie(&solid),
        frame: surface_in_a.rotation,
    };
    let mut touches = Vec::new();
    for i in 0..facets.len() {
        smooth::touch(&placed, &facets, i, &solid, &probe, &mut touches);
    }
    sunk(&placed, &facets, &points, solid.skin, &probe, &mut touches);
    merge::drop_passed(&placed, &facets, &probe, &mut touches);
    let mut kept = merge::keep(&facets, &probe, &touches);
    if kept.is_empty() {
        kept.extend(smooth::nearest(&facets, &solid, &probe));
    }
    merge::manifolds(&facets, &solid.form, &probe, kept, out);
    0.0
}

/// Points of A deep in a bottomless surface, perhaps so deep that A touches no triangle any more: the triangle straight
/// above pushes them out.
fn sunk<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    points: &[Vec3],
    radius: f32,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    if !S::BOTTOMLESS {
        return;
    }
    for (k, &p) in points.iter().enumerate() {
        // Asked first: to find the triangle takes longer.
        if !facets.iter().any(|facet| facet.height(p) < -probe.margin) {
            continue;
        }
        let Some(triangle) = placed.surface.cover(placed.back(p)) else {
            continue;
        };
        let Ok(i) = facets.binary_search_by_key(&triangle, |facet| facet.triangle) else {
            continue;
        };
        if facets[i].height(p) < -probe.margin {
            touches.push(facets[i].face_touch(i, p, radius, k));
        }
    }
}
