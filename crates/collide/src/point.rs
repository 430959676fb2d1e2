//! The signed distance of a point from a shape of any kind.

use crate::compound;
use crate::surface::Surface;
use rockfall_math::{Aabb, DVec3, Isometry, Vec3, trig};
use rockfall_shape::{HeightField, Mesh, Shape, TrianglePart, nearest_on_triangle};

/// The point of a shape's surface that is nearest to a given point, in the frame of the shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Metres; negative where the given point is inside.
    pub distance: f32,
    /// On the surface.
    pub point: Vec3,
    /// Unit vector out of the shape, along which the distance grows: from the surface to a point outside, from a point inside to the surface.
    pub normal: Vec3,
}

/// The signed distance of point `p`, in the frame of the shape, from its surface, if that is not further than `limit` metres; a
/// point that is inside always has one. What is convex, half-spaces included, is solid, and height fields are solid all the way down. A point is inside of a closed mesh,
/// and behind an open one, where it lies behind what it is nearest to; behind an open one the limit holds as well (Bærentzen and Aanæs, "Signed distance computation using
/// the angle weighted pseudonormal", IEEE Transactions on Visualization and Computer Graphics 11(3), 2005). Of a compound it is the distance from the part that is
/// nearest, or that the point is deepest in.
///
/// Nothing where a number is not finite, but for the limit, which may be infinite.
///
/// # Examples
/// ```
/// use rockfall_collide::nearest_point;
/// use rockfall_math::{DVec3, Vec3};
/// use rockfall_shape::Shape;
///
/// let cube = Shape::Box { half: Vec3::ONE };
/// let near = nearest_point(&cube, DVec3::new(3.0, 0.5, 0.0), f32::INFINITY).expect("no limit");
/// assert_eq!((near.distance, near.point, near.normal), (2.0, Vec3::new(1.0, 0.5, 0.0), Vec3::X));
/// assert_eq!(nearest_point(&cube, DVec3::new(3.0, 0.5, 0.0), 1.0), None);
/// ```
pub fn nearest_point(shape: &Shape, p: DVec3, limit: f32) -> Option<Nearest> {
    if !p.as_vec3().is_finite() || limit.is_nan() {
        return None;
    }
    let near = match shape {
        Shape::Mesh(mesh) => mesh_point(mesh, p, limit)?,
        Shape::Field(field) => mesh_point(field.mesh(), p, limit)?,
        Shape::HeightField(field) => field_point(field, p, limit)?,
        Shape::Compound(compound) => compound::nearest_point(compound, p, limit)?,
        _ => {
            let place = Isometry { translation: p.as_vec3(), ..Isometry::IDENTITY };
            let near = crate::distance(shape, &Shape::Sphere { radius: 0.0 }, &place)?;
            Nearest { distance: near.distance, point: near.on_a, normal: near.normal }
        }
    };
    (near.distance <= limit).then_some(near)
}

/// Up to that distance from a surface the way to it is rounding, metres.
fn rounding(p: DVec3) -> f64 {
    1e-10 * p.abs().max_element()
}

fn mesh_point(mesh: &Mesh, p: DVec3, limit: f32) -> Option<Nearest> {
    // A point inside may be further from the surface than the limit.
    let within = p.cmpge(mesh.bounds.min.as_dvec3()).all() && p.cmple(mesh.bounds.max.as_dvec3()).all();
    let limit = if mesh.closed && within { f32::INFINITY } else { limit };
    let near = mesh.nearest(p, f64::from(limit))?;
    let is_on = near.distance.abs() <= rounding(p);
    let away = if is_on { near.normal } else { (p - near.point) / near.distance };
    Some(Nearest { distance: near.distance as f32, point: near.point.as_vec3(), normal: away.as_vec3() })
}

/// The nearest of the triangles of a height field that were asked, the one with the lowest number where several are.
struct Search<'a> {
    surface: &'a HeightField,
    p: DVec3,
    squared: f64,
    nearest: Option<(u64, DVec3, TrianglePart)>,
}

impl<'a> Search<'a> {
    fn new(surface: &'a HeightField, p: DVec3, limit: f64) -> Self {
        Search { surface, p, squared: limit * limit, nearest: None }
    }

    fn ask(&mut self, triangle: u64) {
        let corners = self.surface.corners(triangle).map(|c| c.as_dvec3() - self.p);
        let (to, part) = nearest_on_triangle(corners);
        let squared = to.length_squared();
        let known = self.nearest.map_or(u64::MAX, |(known, ..)| known);
        if squared < self.squared || (squared == self.squared && triangle < known) {
            (self.squared, self.nearest) = (squared, Some((triangle, to, part)));
        }
    }

    fn distance(&self) -> f64 {
        self.squared.sqrt()
    }

    /// What was found.
    fn found(&self, inside: bool) -> Option<Nearest> {
        let (triangle, to, part) = self.nearest?;
        let sign = if inside { -1.0 } else { 1.0 };
        let distance = self.distance();
        let away = if distance > rounding(self.p) {
            -to * (sign / distance)
        } else {
            pseudonormal(self.surface, triangle, part).normalize_or(DVec3::Z)
        };
        Some(Nearest {
            distance: (sign * distance) as f32,
            point: (self.p + to).as_vec3(),
            normal: away.as_vec3(),
        })
    }
}

/// Ring by ring of cells around the one that is nearest, seen from above.
fn field_point(field: &HeightField, p: DVec3, limit: f32) -> Option<Nearest> {
    let height = field.height_at(p.x as f32, p.y as f32);
    let inside = height.is_some_and(|height| p.z < f64::from(height));
    let mut search = Search::new(field, p, if inside { f64::INFINITY } else { f64::from(limit) });
    let cells = [field.columns - 1, field.rows - 1].map(i64::from);
    let steps = [field.spacing.x, field.spacing.y].map(f64::from);
    let middle = [0, 1].map(|k| {
        let place = p[k] / steps[k] + 0.5 * cells[k] as f64;
        place.floor().clamp(0.0, cells[k] as f64 - 1.0) as i64
    });
    for ring in 0..=cells[0].max(cells[1]) {
        // Rings begin as far from the field's point that is nearest from above as there are whole cells between.
        let between = (ring - 1).max(0) as f64 * steps[0].min(steps[1]);
        if between * (1.0 - 1e-6) > search.distance() {
            break;
        }
        let rows = (middle[1] - ring).max(0)..=(middle[1] + ring).min(cells[1] - 1);
        for j in rows {
            let whole = (j - middle[1]).abs() == ring;
            let step = if whole { 1 } else { (2 * ring).max(1) };
            let mut i = middle[0] - ring;
            while i <= middle[0] + ring {
                if (0..cells[0]).contains(&i) {
                    ask_cell(&mut search, i as u32, j as u32);
                }
                i += step;
            }
        }
    }
    search.found(inside)
}

fn ask_cell(search: &mut Search<'_>, i: u32, j: u32) {
    let field = search.surface;
    let [[a, b, c], [_, _, d]] = field.cell(i, j);
    let area = Aabb::from_points([a, b, c, d]);
    let gap = search.p.clamp(area.min.as_dvec3(), area.max.as_dvec3()) - search.p;
    if gap.length_squared() <= search.squared {
        let cell = 2 * (u64::from(j) * u64::from(field.columns - 1) + u64::from(i));
        search.ask(cell);
        search.ask(cell + 1);
    }
}

/// The outward direction, not of unit length, of a part of a triangle: its own normal, the sum of two at an edge, at a corner the sum over all triangles around it,
/// weighted by their angles there.
fn pseudonormal(surface: &HeightField, triangle: u64, part: TrianglePart) -> DVec3 {
    let own = surface.normal(triangle).as_dvec3();
    match part {
        TrianglePart::Corner(corner) => around_corner(surface, triangle, corner),
        TrianglePart::Edge(edge) => {
            own + surface.neighbour(triangle, edge).map_or(own, |other| surface.normal(other).as_dvec3())
        }
        TrianglePart::Face => own,
    }
}

fn around_corner(surface: &HeightField, triangle: u64, corner: usize) -> DVec3 {
    let id = surface.ids(triangle)[corner];
    let weighted = |triangle: u64, corner: usize| {
        let corners = surface.corners(triangle);
        let [a, b] = [1, 2].map(|k| corners[(corner + k) % 3] - corners[corner]);
        surface.normal(triangle).as_dvec3() * f64::from(trig::atan2(a.cross(b).length(), a.dot(b)))
    };
    let mut sum = weighted(triangle, corner);
    // Around the corner over the edge that ends in it; where there is an end, from the start the other way round.
    for back in [2, 0] {
        let (mut here, mut at) = (triangle, corner);
        while let Some(next) = surface.neighbour(here, (at + back) % 3) {
            if next == triangle {
                return sum;
            }
            let Some(k) = surface.ids(next).iter().position(|&other| other == id) else { break };
            (here, at) = (next, k);
            sum += weighted(here, at);
        }
    }
    sum
}
