//! What is to be seen: bodies with their shapes, places and colours.

use rockfall_math::{DVec3, Pose};
use rockfall_shape::Shape;

/// Everything that is in a picture but camera and light.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// Shapes, shared by any number of actors.
    pub shapes: Vec<Shape>,
    /// What stands on it.
    pub actors: Vec<Actor>,
}

/// One body as it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actor {
    /// Index of its shape; an actor whose shape is not there is not seen.
    pub shape: u32,
    /// Where the frame of its shape is.
    pub pose: Pose,
    /// Share of the light that it gives back, linear red, green and blue from 0 to 1.
    pub color: [f32; 3],
    /// Whether it can move: cameras that find their own place look at these.
    pub moves: bool,
}

impl Stage {
    /// The shape of an actor.
    pub(crate) fn shape_of(&self, actor: &Actor) -> Option<&Shape> {
        self.shapes.get(actor.shape as usize)
    }

    /// Balls around the actors that a camera should have in its picture: those that move, or, where nothing does, all; without those that have no
    /// end. Centres and radii, metres.
    pub fn balls(&self) -> Vec<(DVec3, f64)> {
        let ball = |actor: &Actor| {
            let shape = self.shape_of(actor)?;
            if matches!(shape, Shape::HalfSpace { .. }) || !actor.pose.position.is_finite() {
                return None;
            }
            let center = shape.bounds().center();
            let radius = f64::from(shape.radius_about(center));
            radius.is_finite().then(|| (actor.pose.point(center), radius))
        };
        let moving: Vec<_> = self.actors.iter().filter(|actor| actor.moves).filter_map(ball).collect();
        if moving.is_empty() { self.actors.iter().filter_map(ball).collect() } else { moving }
    }
}
