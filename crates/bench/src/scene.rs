//! What is simulated: shapes and poses that every engine builds from.

mod pile;
mod pyramid;
mod random;

use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// m/s², downwards along z.
pub(crate) const GRAVITY: f32 = 9.81;
/// Steps per second.
pub(crate) const RATE: f32 = 60.0;
/// kg/m³, of all bodies.
pub(crate) const DENSITY: f32 = 2600.0;
/// Coulomb's coefficient of all surfaces; equal everywhere, so that the rule by which an engine mixes does not matter.
pub(crate) const FRICTION: f32 = 0.6;
/// Of all surfaces.
pub(crate) const RESTITUTION: f32 = 0.0;

/// A shape of the scene in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    /// Into [`Scene::shapes`].
    pub(crate) shape: usize,
    /// Of the shape's frame.
    pub(crate) pose: Pose,
}

/// Bodies at rest, and what holds them.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    /// Spheres, boxes and hulls.
    pub(crate) shapes: Vec<Shape>,
    /// Immovable: ground and walls.
    pub(crate) fixed: Vec<Placed>,
    /// Dynamic.
    pub(crate) bodies: Vec<Placed>,
    /// Inner walls stand at ± this x and y, metres; infinite where there are none. The ground is at z = 0.
    pub(crate) half_width: f64,
    /// The body on top of all, where it matters how far it sinks.
    pub(crate) top: Option<usize>,
}

/// The scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Kind {
    /// Boxes with edges of 0.5 to 1 m dropped into a walled square.
    BoxPile,
    /// Balls with radii of 0.25 to 0.5 m dropped into a walled square.
    BallPit,
    /// Hulls of 12 to 20 corners, about 0.8 m across, dropped into a walled square.
    HullPile,
    /// Unit boxes, one less in each layer; 5,050 make the pyramid of base 100.
    Pyramid,
}

impl Kind {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::BoxPile => "box-pile",
            Kind::BallPit => "ball-pit",
            Kind::HullPile => "hull-pile",
            Kind::Pyramid => "pyramid",
        }
    }

    /// The scene with `count` bodies; for the pyramid the largest with at most so many.
    pub(crate) fn build(self, count: usize, seed: u64) -> Result<Scene, crate::Error> {
        match self {
            Kind::BoxPile => Ok(pile::boxes(count, seed)),
            Kind::BallPit => Ok(pile::balls(count, seed)),
            Kind::HullPile => pile::hulls(count, seed),
            Kind::Pyramid => Ok(pyramid::pyramid(count)),
        }
    }
}

/// Thickness of ground and walls, metres.
const THICK: f32 = 4.0;

impl Scene {
    /// A ground whose surface is z = 0, and nothing else. It is a box rather than a half-space: engines differ in how
    /// well they carry a shape without end.
    fn with_ground(half_width: f32) -> Scene {
        let half = Vec3::new(half_width, half_width, 0.5 * THICK);
        let pose = Pose::at(DVec3::new(0.0, 0.0, -0.5 * f64::from(THICK)));
        Scene {
            shapes: vec![Shape::Box { half }],
            fixed: vec![Placed { shape: 0, pose }],
            bodies: Vec::new(),
            half_width: f64::INFINITY,
            top: None,
        }
    }

    /// A square room, open above.
    fn room(half_width: f32, height: f32) -> Scene {
        let mut scene = Scene::with_ground(half_width + THICK);
        scene.half_width = f64::from(half_width);
        let off = scene.half_width + 0.5 * f64::from(THICK);
        let (long, high) = (half_width + THICK, 0.5 * height);
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let half = if x == 0.0 {
                Vec3::new(long, 0.5 * THICK, high)
            } else {
                Vec3::new(0.5 * THICK, long, high)
            };
            let pose = Pose::at(DVec3::new(off * x, off * y, f64::from(high)));
            scene.fixed.push(Placed { shape: scene.shapes.len(), pose });
            scene.shapes.push(Shape::Box { half });
        }
        scene
    }

    /// The same scene again? Folds every pose and size into one number.
    #[cfg(test)]
    fn fingerprint(&self) -> String {
        format!("{:?} {:?}", self.bodies, self.shapes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality;

    const ALL: [Kind; 4] = [Kind::BoxPile, Kind::BallPit, Kind::HullPile, Kind::Pyramid];

    #[test]
    fn nothing_overlaps_or_is_outside_at_the_start() {
        for kind in ALL {
            let scene = kind.build(700, 1).expect("a scene");
            let poses: Vec<Pose> = scene.bodies.iter().map(|b| b.pose).collect();
            let quality = quality::measure(&scene, &poses, &poses);
            assert_eq!((quality.overlapping, quality.escaped), (0, 0), "{}", kind.name());
        }
    }

    #[test]
    fn one_seed_makes_one_scene() {
        for kind in ALL {
            let of = |seed| kind.build(100, seed).expect("a scene").fingerprint();
            assert_eq!(of(1), of(1));
            assert_eq!(of(1) == of(2), kind == Kind::Pyramid, "{}", kind.name());
        }
    }

    #[test]
    fn the_number_of_bodies_is_as_asked_for() {
        for kind in ALL {
            assert_eq!(kind.build(5050, 3).expect("a scene").bodies.len(), 5050);
        }
        assert_eq!(Kind::Pyramid.build(5049, 3).expect("a scene").bodies.len(), 99 * 50);
    }
}
