//! What kind of shape it is, and whether its numbers make sense.

use crate::{CompoundError, HeightFieldError, HullDefect, LARGEST, MeshError, SMALLEST, Shape};
use rockfall_math::Vec3;

/// Why a shape is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A size is NaN, zero, negative, too small or too large.
    #[error("the {what} of the {shape} is {value}, expected {expected}")]
    Size {
        /// Kind of shape.
        shape: &'static str,
        /// Which number.
        what: &'static str,
        /// What it was.
        value: f32,
        /// What it may be.
        expected: &'static str,
    },
    /// The hull breaks a promise.
    #[error("the hull is broken: {0}")]
    Hull(#[from] HullDefect),
    /// The mesh is not usable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The height field is not usable.
    #[error(transparent)]
    HeightField(#[from] HeightFieldError),
    /// The compound is not usable.
    #[error(transparent)]
    Compound(#[from] CompoundError),
}

impl Shape {
    /// The name of the kind of shape, as in "a half-space".
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Sphere { .. } => "sphere",
            Shape::Box { .. } => "box",
            Shape::Capsule { .. } => "capsule",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Cone { .. } => "cone",
            Shape::Ellipsoid { .. } => "ellipsoid",
            Shape::RoundedBox { .. } => "rounded box",
            Shape::Hull(_) => "hull",
            Shape::RoundedHull { .. } => "rounded hull",
            Shape::HalfSpace { .. } => "half-space",
            Shape::Mesh(_) => "mesh",
            Shape::Field(_) => "field",
            Shape::HeightField(_) => "height field",
            Shape::Compound(_) => "compound",
        }
    }

    /// Whether the straight line between any two points of the shape stays in it. Half-spaces are convex.
    pub fn is_convex(&self) -> bool {
        !matches!(self, Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) | Shape::Compound(_))
    }

    /// Whether the shape encloses a finite volume, so that it has a mass: all convex shapes but the
    /// half-space, fields, closed meshes whose normals point outwards, and compounds of such.
    pub fn has_inside(&self) -> bool {
        self.mass_properties(1.0).is_some()
    }

    /// Whether forces may move a body of this shape: it has an inside, and its contacts with all shapes are found.
    pub fn can_move(&self) -> bool {
        match self {
            Shape::HalfSpace { .. } | Shape::HeightField(_) => false,
            Shape::Mesh(mesh) => mesh.inner_ball.1 > 0.0,
            Shape::Compound(compound) => compound.parts().iter().all(|part| part.shape.can_move()),
            _ => true,
        }
    }

    /// Whether all numbers make sense: sizes from [`SMALLEST`] to [`LARGEST`], unit normals, columns that fit
    /// each other. Hulls are checked in full ([`Hull::check`](crate::Hull::check)).
    ///
    /// # Errors
    /// The first number that does not.
    pub fn validate(&self) -> Result<(), ShapeError> {
        let shape = self.name();
        let size = |what, value: f32| match (SMALLEST..=LARGEST).contains(&value) {
            true => Ok(()),
            false => Err(ShapeError::Size { shape, what, value, expected: "a length from 1e-6 m to 1e6 m" }),
        };
        let sizes = |what: [&'static str; 3], values: &Vec3| {
            what.into_iter().zip(values.to_array()).try_for_each(|(what, value)| size(what, value))
        };
        let size_or_none = |what, value: f32| match (0.0..=LARGEST).contains(&value) {
            true => Ok(()),
            false => Err(ShapeError::Size { shape, what, value, expected: "a length from 0 to 1e6 m" }),
        };
        match self {
            Shape::Sphere { radius } => size("radius", *radius),
            Shape::Box { half } => sizes(["half extent x", "half extent y", "half extent z"], half),
            Shape::Capsule { half_length, radius } => {
                size("radius", *radius)?;
                size_or_none("half length", *half_length)
            }
            Shape::Cylinder { half_length, radius } => {
                size("radius", *radius)?;
                size("half length", *half_length)
            }
            Shape::Cone { half_length, lower, upper } => {
                size("half length", *half_length)?;
                size_or_none("lower radius", *lower)?;
                size_or_none("upper radius", *upper)?;
                size("larger radius", if *lower < *upper { *upper } else { *lower })
            }
            Shape::Ellipsoid { half } => sizes(["half axis x", "half axis y", "half axis z"], half),
            Shape::RoundedBox { half, radius } => {
                size("radius", *radius)?;
                sizes(["half extent x", "half extent y", "half extent z"], half)
            }
            Shape::Hull(hull) => Ok(hull.check()?),
            Shape::RoundedHull { hull, radius } => {
                size("radius", *radius)?;
                Ok(hull.check()?)
            }
            Shape::HalfSpace { normal, offset } => {
                let length = normal.length();
                if !(1.0 - 1e-5..=1.0 + 1e-5).contains(&length) {
                    let expected = "1: a unit vector";
                    return Err(ShapeError::Size {
                        shape,
                        what: "length of the normal",
                        value: length,
                        expected,
                    });
                }
                match (-LARGEST..=LARGEST).contains(offset) {
                    true => Ok(()),
                    false => Err(ShapeError::Size {
                        shape,
                        what: "offset",
                        value: *offset,
                        expected: "a distance from -1e6 m to 1e6 m",
                    }),
                }
            }
            Shape::Mesh(mesh) => Ok(mesh.check()?),
            Shape::Field(field) => Ok(field.mesh().check()?),
            Shape::HeightField(field) => Ok(field.check()?),
            // It was checked when it was made, and nobody can change it.
            Shape::Compound(_) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hull;
    use std::sync::Arc;

    fn message(shape: Shape) -> String {
        shape.validate().unwrap_err().to_string()
    }

    #[test]
    fn sizes_that_make_no_sense_are_refused() {
        let expected = "expected a length from 1e-6 m to 1e6 m";
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-7, 1e7] {
            assert_eq!(
                message(Shape::Sphere { radius }),
                format!("the radius of the sphere is {radius}, {expected}")
            );
        }
        assert_eq!(
            message(Shape::Box { half: Vec3::new(1.0, -2.0, 1.0) }),
            format!("the half extent y of the box is -2, {expected}")
        );
        assert_eq!(
            message(Shape::Capsule { half_length: -0.5, radius: 1.0 }),
            "the half length of the capsule is -0.5, expected a length from 0 to 1e6 m"
        );
        assert_eq!(
            message(Shape::Cylinder { half_length: 0.0, radius: 1.0 }),
            format!("the half length of the cylinder is 0, {expected}")
        );
        assert_eq!(
            message(Shape::Cone { half_length: 1.0, lower: 1.0, upper: -1.0 }),
            "the upper radius of the cone is -1, expected a length from 0 to 1e6 m"
        );
        assert_eq!(
            message(Shape::Cone { half_length: 1.0, lower: 0.0, upper: 0.0 }),
            format!("the larger radius of the cone is 0, {expected}")
        );
        assert_eq!(
            message(Shape::Ellipsoid { half: Vec3::new(1.0, 1.0, f32::NAN) }),
            format!("the half axis z of the ellipsoid is NaN, {expected}")
        );
        assert_eq!(
            message(Shape::RoundedBox { half: Vec3::ONE, radius: 0.0 }),
            format!("the radius of the rounded box is 0, {expected}")
        );
        assert_eq!(
            message(Shape::HalfSpace { normal: Vec3::splat(1.0), offset: 0.0 }),
            "the length of the normal of the half-space is 1.7320508, expected 1: a unit vector"
        );
        assert_eq!(
            message(Shape::HalfSpace { normal: Vec3::NAN, offset: 0.0 }),
            "the length of the normal of the half-space is NaN, expected 1: a unit vector"
        );
        assert_eq!(
            message(Shape::HalfSpace { normal: Vec3::Z, offset: f32::NAN }),
            "the offset of the half-space is NaN, expected a distance from -1e6 m to 1e6 m"
        );
        let mut hull = Hull::cuboid(Vec3::ONE);
        hull.vertices[3].z = f32::NAN;
        let hull = Arc::new(hull);
        assert_eq!(message(Shape::Hull(hull.clone())), "the hull is broken: a number is not finite");
        let rounded = Shape::RoundedHull { hull, radius: 0.1 };
        assert_eq!(message(rounded), "the hull is broken: a number is not finite");
    }

    #[test]
    fn sizes_that_make_sense_pass() {
        assert_eq!(Shape::Sphere { radius: 1.0 }.validate(), Ok(()));
        assert_eq!(Shape::Box { half: Vec3::ONE }.validate(), Ok(()));
        assert_eq!(Shape::Capsule { half_length: 0.0, radius: 1.0 }.validate(), Ok(()));
        assert_eq!(Shape::HalfSpace { normal: Vec3::Z, offset: -3.0 }.validate(), Ok(()));
        assert_eq!(Shape::Hull(Arc::new(Hull::cuboid(Vec3::ONE))).validate(), Ok(()));
        assert_eq!(Shape::Cylinder { half_length: 0.1, radius: 1.0 }.validate(), Ok(()));
        assert_eq!(Shape::Cone { half_length: 0.1, lower: 0.0, upper: 1.0 }.validate(), Ok(()));
        assert_eq!(Shape::Ellipsoid { half: Vec3::ONE }.validate(), Ok(()));
        let hull = Arc::new(Hull::cuboid(Vec3::ONE));
        assert_eq!(Shape::RoundedHull { hull, radius: 0.1 }.validate(), Ok(()));
    }

    #[test]
    fn what_has_an_inside_and_what_is_convex() {
        let floor = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
        assert!(floor.is_convex() && !floor.has_inside());
        assert!(Shape::Sphere { radius: 1.0 }.has_inside());
    }
}
