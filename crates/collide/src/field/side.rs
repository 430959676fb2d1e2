//! One of the two shapes, in its place.

use crate::point::nearest_point;
use rockfall_math::{DVec3, Isometry, Vec3};
use rockfall_shape::{Balls, Field, NearestOnMesh, SAMPLES_IN_A_BALL, Shape};

/// A shape in A's frame.
pub(super) struct Side<'a> {
    pub(super) shape: &'a Shape,
    /// Places the shape in A's frame.
    pub(super) place: Isometry,
    /// How far behind an open surface a point may be and still be pushed out, metres.
    depth: f32,
}

/// Signed distance from a shape, and the direction out of it, in A's frame.
#[derive(Clone, Copy)]
pub(crate) struct Near {
    pub(crate) distance: f32,
    pub(crate) normal: Vec3,
}

/// A point of a surface.
#[derive(Clone, Copy)]
pub(super) struct Foot {
    pub(super) point: Vec3,
    /// Of a field: the middle of the normals there, and the cosine of the largest angle to one of them.
    pub(super) cone: Option<(Vec3, f32)>,
}

impl<'a> Side<'a> {
    pub(super) fn new(shape: &'a Shape, place: Isometry, depth: f32) -> Self {
        Side { shape, place, depth }
    }

    pub(super) fn field(&self) -> Option<&'a Field> {
        match self.shape {
            Shape::Field(field) => Some(field),
            _ => None,
        }
    }

    /// A distance that a point of A's frame surely has, if that is below `limit`, which only surfaces ask for.
    #[inline]
    pub(super) fn least_distance(&self, p: Vec3, limit: f32) -> Option<f32> {
        match self.shape {
            Shape::Field(field) => Some(field.least_distance(self.place.inverse_point(p))),
            _ => self.nearest(p, limit).map(|near| near.distance),
        }
    }

    /// Signed distance alone.
    #[inline]
    pub(super) fn distance(&self, p: Vec3, limit: f32) -> Option<f32> {
        match self.shape {
            Shape::Field(field) => Some(field.distance(self.place.inverse_point(p))),
            _ => self.nearest(p, limit).map(|near| near.distance),
        }
    }

    /// How far eight balls, which `own` takes to A's frame, surely are, metres; without end where the middle of one has no distance.
    pub(super) fn least_gaps(&self, balls: &Balls, own: &Isometry) -> [f32; SAMPLES_IN_A_BALL] {
        let [x, y, z, radii] = balls;
        let surely = match self.shape {
            Shape::Field(field) => field.least_distances(balls, own, &self.place),
            _ => std::array::from_fn(|i| {
                let center = own.point(Vec3::new(x[i], y[i], z[i]));
                self.least_distance(center, f32::INFINITY).unwrap_or(f32::INFINITY)
            }),
        };
        std::array::from_fn(|i| surely[i] - radii[i])
    }

    /// The point of the surface nearest to a point that is at most `limit` metres off it, exactly.
    pub(super) fn foot(&self, p: Vec3, limit: f32) -> Option<Foot> {
        let Some(field) = self.field() else {
            let point = self.nearest(p, limit).map(|near| p - near.distance * near.normal)?;
            return Some(Foot { point, cone: None });
        };
        let own = self.place.inverse_point(p).as_dvec3();
        let near = field.mesh().nearest(own, f64::from(limit))?;
        let normal = near.normal.as_vec3();
        let cone = normal.dot(field.mesh().normals[near.triangle as usize]);
        let point = self.place.point(near.point.as_vec3());
        Some(Foot { point, cone: Some((self.place.vector(normal), cone)) })
    }

    /// The exact signed distance of a point from the mesh of a field, which says that it is `about` so much.
    pub(super) fn exact_distance(&self, p: Vec3, about: f32) -> Option<f32> {
        let field = self.field()?;
        let near = nearest_about(field, self.place.inverse_point(p).as_dvec3(), about)?;
        Some(near.distance as f32)
    }

    /// The exact signed distance of a point from the mesh of a field, which says that it is `about` so much, and the way along which it grows.
    pub(super) fn exact(&self, p: Vec3, about: f32) -> Option<Near> {
        let field = self.field()?;
        let own = self.place.inverse_point(p).as_dvec3();
        let limit = f64::from(about.abs() + field.bound(about));
        let near = nearest_about(field, own, about)?;
        // Next to the surface the way is rounding.
        let way = (own - near.point).normalize_or_zero() * near.distance.signum();
        let normal = if near.distance.abs() > 1e-3 * limit { way } else { near.normal };
        Some(Near { distance: near.distance as f32, normal: self.place.vector(normal.as_vec3()) })
    }

    pub(super) fn nearest(&self, p: Vec3, limit: f32) -> Option<Near> {
        let own = self.place.inverse_point(p);
        let (distance, normal) = match self.shape {
            Shape::Field(field) => {
                let near = field.nearest(own);
                (near.distance, near.normal)
            }
            Shape::Mesh(_) | Shape::HeightField(_) => {
                let near = nearest_point(self.shape, own.as_dvec3(), limit.max(self.depth))?;
                (near.distance, near.normal)
            }
            _ => {
                let near = nearest_point(self.shape, own.as_dvec3(), f32::INFINITY)?;
                (near.distance, near.normal)
            }
        };
        Some(Near { distance, normal: self.place.vector(normal) })
    }
}

/// The point of a field's mesh that is nearest to one which the field says to be `about` so far off.
fn nearest_about(field: &Field, p: DVec3, about: f32) -> Option<NearestOnMesh> {
    field.mesh().nearest(p, f64::from(about.abs() + field.bound(about)))
}
