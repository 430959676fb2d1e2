//! Mass, centre of mass and inertia of solids of one density.

pub(crate) mod compound;
mod rounded;

use crate::{Frustum, Shape, polyhedron};
use rockfall_math::{DVec3, Mat3, Pose, Vec3};
use std::f64::consts::PI;

/// How a rigid body resists pushes and turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Kilograms.
    pub mass: f32,
    /// Centre of mass in the frame of the shape, metres.
    pub center: Vec3,
    /// Inertia about the centre of mass along the axes of the shape's frame, kg m². Symmetric.
    pub inertia: Mat3,
}

impl MassProperties {
    /// The same distribution of mass, scaled to a total of `mass` kilograms.
    pub fn with_mass(&self, mass: f32) -> Self {
        MassProperties { mass, center: self.center, inertia: self.inertia * (mass / self.mass) }
    }

    /// Those of the same solid, `by` times as long in all directions.
    pub fn scaled(&self, by: f32) -> Self {
        let cube = by * by * by;
        MassProperties {
            mass: self.mass * cube,
            center: self.center * by,
            inertia: self.inertia * (cube * by * by),
        }
    }

    /// Those of solids in their places, as one: what overlaps is there twice.
    pub fn sum(solids: &[(MassProperties, Pose)]) -> Self {
        compound::sum(solids)
    }

    /// From a diagonal inertia `squares` + `products` off the diagonal (yz, zx, xy), in double precision.
    fn new(mass: f64, center: DVec3, diagonal: DVec3, products: DVec3) -> Self {
        let (d, p) = (diagonal.as_vec3(), products.as_vec3());
        let inertia =
            Mat3::from_cols(Vec3::new(d.x, p.z, p.y), Vec3::new(p.z, d.y, p.x), Vec3::new(p.y, p.x, d.z));
        MassProperties { mass: mass as f32, center: center.as_vec3(), inertia }
    }
}

impl Shape {
    /// Mass properties of a solid of `density` kg/m³ in this shape, exact up to rounding: closed forms for
    /// the round shapes and the box, integrals over the polyhedron for hulls and closed meshes, and over what
    /// is around it for rounded hulls. The parts of a compound are taken as they are: where they overlap, the mass is there
    /// twice. `None` for shapes without an inside: see [`Shape::has_inside`].
    ///
    /// # Examples
    /// ```
    /// use rockfall_shape::Shape;
    ///
    /// let ball = Shape::Sphere { radius: 0.5 }.mass_properties(1000.0).unwrap();
    /// assert!((ball.mass - 523.6).abs() < 0.1);
    /// ```
    pub fn mass_properties(&self, density: f32) -> Option<MassProperties> {
        let density = f64::from(density);
        match self {
            Shape::Sphere { radius } => Some(ball(density, f64::from(*radius))),
            Shape::Box { half } => Some(cuboid(density, half.as_dvec3())),
            Shape::Capsule { half_length, radius } => {
                Some(capsule(density, f64::from(*half_length), f64::from(*radius)))
            }
            Shape::Cylinder { .. } | Shape::Cone { .. } => Frustum::of(self).map(|f| frustum(density, &f)),
            Shape::Ellipsoid { half } => Some(ellipsoid(density, half.as_dvec3())),
            Shape::RoundedBox { half, radius } => {
                Some(rounded::cuboid(density, half.as_dvec3(), f64::from(*radius)))
            }
            Shape::Hull(hull) => solid(density, hull.triangles()),
            Shape::RoundedHull { hull, radius } => rounded::hull(density, hull, f64::from(*radius)),
            Shape::Mesh(mesh) if mesh.closed => solid(density, mesh.corners()),
            Shape::Field(field) => solid(density, field.mesh().corners()),
            Shape::Mesh(_) | Shape::HeightField(_) | Shape::HalfSpace { .. } => None,
            Shape::Compound(parts) => {
                parts.solid().map(|unit| unit.with_mass((density * f64::from(unit.mass)) as f32))
            }
        }
    }
}

fn ball(density: f64, radius: f64) -> MassProperties {
    let mass = density * 4.0 / 3.0 * PI * radius * radius * radius;
    MassProperties::new(mass, DVec3::ZERO, DVec3::splat(0.4 * mass * radius * radius), DVec3::ZERO)
}

fn cuboid(density: f64, half: DVec3) -> MassProperties {
    let mass = density * 8.0 * half.x * half.y * half.z;
    let s = half * half;
    let diagonal = mass / 3.0 * DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
    MassProperties::new(mass, DVec3::ZERO, diagonal, DVec3::ZERO)
}

/// A cylinder and two half balls. The centre of mass of a half ball is 3/8 of the radius off its flat side,
/// and its inertia across its axis, about that centre, 83/320 m r².
fn capsule(density: f64, h: f64, r: f64) -> MassProperties {
    let cylinder = density * PI * r * r * 2.0 * h;
    let caps = density * 4.0 / 3.0 * PI * r * r * r;
    let off = h + 0.375 * r;
    let across = cylinder * (0.25 * r * r + h * h / 3.0) + caps * (83.0 / 320.0 * r * r + off * off);
    let along = (0.5 * cylinder + 0.4 * caps) * r * r;
    MassProperties::new(cylinder + caps, DVec3::ZERO, DVec3::new(across, across, along), DVec3::ZERO)
}

/// A cylinder or a truncated cone: discs of all radii from R at the lower end to r at the upper one. With the height H, the
/// integrals over the volume of 1, of the height over the lower end and of its square, and of the squared distance from
/// the axis are π H/3 (R² + Rr + r²), π H²/12 (R² + 2Rr + 3r²), π H³/30 (R² + 3Rr + 6r²), and
/// π H/10 (R⁴ + R³r + R²r² + Rr³ + r⁴).
fn frustum(density: f64, shape: &Frustum) -> MassProperties {
    let (big, small) = (f64::from(shape.lower), f64::from(shape.upper));
    let height = 2.0 * f64::from(shape.half_length);
    let (bb, bs, ss) = (big * big, big * small, small * small);
    let volume = PI * height / 3.0 * (bb + bs + ss);
    let first = PI * height * height / 12.0 * (bb + 2.0 * bs + 3.0 * ss);
    let second = PI * height * height * height / 30.0 * (bb + 3.0 * bs + 6.0 * ss);
    let around = PI * height / 10.0 * (bb * bb + bs * (bb + bs + ss) + ss * ss);
    let over_end = first / volume;
    let across = density * (0.5 * around + second - first * over_end);
    let center = DVec3::new(0.0, 0.0, over_end - 0.5 * height);
    let diagonal = DVec3::new(across, across, density * around);
    MassProperties::new(density * volume, center, diagonal, DVec3::ZERO)
}

fn ellipsoid(density: f64, half: DVec3) -> MassProperties {
    let mass = density * 4.0 / 3.0 * PI * half.x * half.y * half.z;
    let s = half * half;
    let diagonal = 0.2 * mass * DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
    MassProperties::new(mass, DVec3::ZERO, diagonal, DVec3::ZERO)
}

/// The inside of a closed surface; `None` if it is empty or the surface is inside out.
fn solid(density: f64, triangles: impl Iterator<Item = [DVec3; 3]>) -> Option<MassProperties> {
    let m = polyhedron::moments(triangles);
    let s = m.squares;
    let diagonal = DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
    (m.volume > 0.0)
        .then(|| MassProperties::new(density * m.volume, m.center, density * diagonal, -density * m.products))
}

#[cfg(test)]
mod tests;
