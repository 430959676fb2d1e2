//! Several shapes that are one.

use crate::{LARGEST, MassProperties, Shape, ShapeError, mass};
use rockfall_math::{Aabb, Isometry, Mat3, Pose, Vec3, rotation};
use rockfall_tree::Tree;

/// One shape of a [`Compound`].
#[derive(Clone, Debug)]
pub struct Part {
    /// What it is; no compound.
    pub shape: Shape,
    /// Where it is in the frame of the compound.
    pub pose: Pose,
    /// The same as a matrix.
    pub place: Isometry,
}

/// Shapes at fixed places, which move as one. They may overlap.
#[derive(Clone, Debug)]
pub struct Compound {
    parts: Vec<Part>,
    tree: Tree,
    bounds: Aabb,
    /// The part with the smallest ball inside.
    thinnest: usize,
    /// Of density 1; none where a part has no inside.
    solid: Option<MassProperties>,
}

/// Why shapes make no compound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompoundError {
    /// Nothing there.
    #[error("the compound has no parts")]
    Empty,
    /// More than a 32-bit index can name.
    #[error("the compound has more than 4294967294 parts")]
    TooMany,
    /// A part is refused.
    #[error("part {part}: {why}")]
    Part {
        /// Which, counted from 0 in the order in which they were given.
        part: usize,
        /// Why.
        why: Box<ShapeError>,
    },
    /// A part has no end on some side.
    #[error("part {part} is a {shape}, expected a shape that ends on all sides: give it a body of its own")]
    Unbounded {
        /// Which.
        part: usize,
        /// Its kind.
        shape: &'static str,
    },
    /// A place that makes no sense.
    #[error(
        "the place of part {0} makes no sense, expected a position within 1000 km and a quaternion of length 1"
    )]
    Place(usize),
}

impl Compound {
    /// Cooks shapes, each at its place in the frame of the compound. Parts that are compounds themselves are taken apart.
    ///
    /// # Errors
    /// Nothing to put together; a part that makes no sense, is a half-space or a height field, or is in a place that makes no sense.
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::{DVec3, Pose};
    /// use rockfall_shape::{Compound, Shape};
    ///
    /// let ball = Shape::Sphere { radius: 0.2 };
    /// let end = |x: f64| (ball.clone(), Pose::at(DVec3::new(x, 0.0, 0.0)));
    /// let dumbbell = Compound::new(vec![end(-0.5), end(0.5)])?;
    /// assert_eq!(dumbbell.parts().len(), 2);
    /// assert!((dumbbell.bounds().max.x - 0.7).abs() < 1e-6);
    /// # Ok::<(), rockfall_shape::CompoundError>(())
    /// ```
    pub fn new(shapes: impl IntoIterator<Item = (Shape, Pose)>) -> Result<Compound, CompoundError> {
        let mut parts: Vec<Part> = Vec::new();
        let mut solids = Some(Vec::new());
        for (number, (shape, pose)) in shapes.into_iter().enumerate() {
            let pose = check(number, &shape, &pose)?;
            let solid = shape.mass_properties(1.0).map(|solid| (solid, pose));
            solids = solids.zip(solid).map(|(mut all, solid)| {
                all.push(solid);
                all
            });
            match &shape {
                Shape::Compound(inner) => {
                    let places = inner.parts.iter().map(|part| part.within(&pose));
                    if places.clone().any(|place| !is_near(&place)) {
                        return Err(CompoundError::Place(number));
                    }
                    let shapes = inner.parts.iter().map(|part| part.shape.clone());
                    parts.extend(shapes.zip(places).map(|(shape, place)| Part::new(shape, place)));
                }
                _ => parts.push(Part::new(shape, pose)),
            }
        }
        let Some(thinnest) = (0..parts.len()).min_by(|&i, &j| parts[i].inner().total_cmp(&parts[j].inner()))
        else {
            return Err(CompoundError::Empty);
        };
        if parts.len() >= u32::MAX as usize {
            return Err(CompoundError::TooMany);
        }
        let boxes: Vec<Aabb> = parts.iter().map(|part| part.shape.placed_bounds(&part.pose)).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, one| all.union(one));
        let solid = solids.as_deref().map(mass::compound::sum);
        Ok(Compound { tree: Tree::build(&boxes), bounds, thinnest, solid, parts })
    }

    /// The same parts, with the mass properties of a solid of 1 kg/m³ that they stand for.
    pub fn standing_for(self, solid: MassProperties) -> Compound {
        Compound { solid: Some(solid), ..self }
    }

    /// Mass properties at 1 kg/m³: the parts as they are, what overlaps twice, unless they stand for another solid.
    pub fn solid(&self) -> Option<&MassProperties> {
        self.solid.as_ref()
    }

    /// The parts, in the order in which they were given.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Broad phase over the boxes of the parts, in the frame of the compound.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The smallest box around the boxes of the parts.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The part with the smallest ball inside.
    pub(crate) fn thinnest(&self) -> &Part {
        &self.parts[self.thinnest]
    }
}

impl Part {
    fn new(shape: Shape, pose: Pose) -> Self {
        let place =
            Isometry { rotation: Mat3::from_quat(pose.rotation), translation: pose.position.as_vec3() };
        Part { shape, pose, place }
    }

    /// Where it is where `outer` is the place of the compound.
    pub fn within(&self, outer: &Pose) -> Pose {
        Pose {
            position: outer.point(self.place.translation),
            rotation: rotation::normalize(rotation::compose(outer.rotation, self.pose.rotation)),
        }
    }

    fn inner(&self) -> f32 {
        self.shape.inner_radius()
    }

    /// The distance of the farthest point from a point of the compound's frame, as [`Shape::radius_about`].
    pub(crate) fn radius_about(&self, center: Vec3) -> f32 {
        self.shape.radius_about(self.place.inverse_point(center))
    }
}

fn is_near(pose: &Pose) -> bool {
    pose.position.is_finite() && pose.position.abs().max_element() <= f64::from(LARGEST)
}

/// The pose with a rotation of length 1, if part `number` is usable.
fn check(number: usize, shape: &Shape, pose: &Pose) -> Result<Pose, CompoundError> {
    if matches!(shape, Shape::HalfSpace { .. } | Shape::HeightField(_)) {
        return Err(CompoundError::Unbounded { part: number, shape: shape.name() });
    }
    shape.validate().map_err(|why| CompoundError::Part { part: number, why: Box::new(why) })?;
    let unit = (pose.rotation.length() - 1.0).abs() < 1e-2;
    if !is_near(pose) || !unit {
        return Err(CompoundError::Place(number));
    }
    Ok(Pose { rotation: rotation::normalize(pose.rotation), ..*pose })
}

#[cfg(test)]
mod tests;
