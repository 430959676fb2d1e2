//! Bodies that a viewer adds.

use crate::Error;
use rockfall::{Body, BodyId, MaterialId, Shape, ShapeId};
use rockfall_math::{DVec3, Pose, Vec3};
use rockfall_scene::Running;

/// Sizes that make sense, metres.
const SIZES: std::ops::RangeInclusive<f32> = 1e-3..=1e3;

/// Boxes of a pile at most.
const MOST: u32 = 1000;

/// What was added, and its shapes.
#[derive(Debug, Default)]
pub(crate) struct Toys {
    shapes: Vec<(Toy, ShapeId)>,
    /// Ids of the bodies.
    pub(crate) bodies: Vec<BodyId>,
}

/// A shape to play with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Toy {
    /// Of this radius, metres.
    Ball(f32),
    /// As wide as this, metres.
    Cube(f32),
}

impl Toys {
    /// A ball that flies from a point.
    pub(crate) fn throw(
        &mut self,
        running: &mut Running,
        from: DVec3,
        velocity: Vec3,
        radius: f32,
    ) -> Result<(), Error> {
        check_size(radius)?;
        let shape = self.shape(running, Toy::Ball(radius))?;
        let body = Body { velocity, ..Body::new(shape, material(running)?, Pose::at(from)) };
        self.bodies.push(running.add(body)?);
        Ok(())
    }

    /// Boxes in layers over a point, `size` wide each and a little apart, so that they fall into a heap.
    pub(crate) fn pile(
        &mut self,
        running: &mut Running,
        over: DVec3,
        size: f32,
        count: u32,
    ) -> Result<(), Error> {
        check_size(size)?;
        if !(1..=MOST).contains(&count) {
            return Err(Error::Refused(format!("a pile has 1 to {MOST} boxes, and not {count}")));
        }
        let shape = self.shape(running, Toy::Cube(size))?;
        let material = material(running)?;
        // About twice as high as wide.
        let side = (f64::from(count) / 2.0).cbrt().ceil().max(1.0) as u32;
        let pitch = 1.15 * f64::from(size);
        for k in 0..count {
            let (i, j, layer) = (k % side, k / side % side, k / (side * side));
            let middle = 0.5 * f64::from(side - 1);
            // Every other layer is moved by half a box.
            let shift = 0.5 * f64::from(layer % 2);
            let place =
                DVec3::new(f64::from(i) - middle + shift, f64::from(j) - middle, f64::from(layer) + 2.0);
            self.bodies.push(running.add(Body::new(shape, material, Pose::at(over + pitch * place)))?);
        }
        Ok(())
    }

    /// The number of a shape in the world, which gets it where it has none such.
    fn shape(&mut self, running: &mut Running, toy: Toy) -> Result<ShapeId, Error> {
        if let Some((_, id)) = self.shapes.iter().find(|(known, _)| *known == toy) {
            return Ok(*id);
        }
        let id = running.world.add_shape(match toy {
            Toy::Ball(radius) => Shape::Sphere { radius },
            Toy::Cube(size) => Shape::Box { half: Vec3::splat(0.5 * size) },
        })?;
        self.shapes.push((toy, id));
        Ok(id)
    }
}

fn check_size(size: f32) -> Result<(), Error> {
    if SIZES.contains(&size) {
        return Ok(());
    }
    Err(Error::Refused(format!(
        "a body {size} m wide makes no sense, expected {} to {}",
        SIZES.start(),
        SIZES.end()
    )))
}

/// The scene's first material.
fn material(running: &Running) -> Result<MaterialId, Error> {
    let first = running.materials().first().copied();
    first.ok_or_else(|| Error::Refused("the scene has no material".into()))
}
