//! What is simulated: shapes and poses that every engine builds from.

mod box3d;
mod driven;
mod drum;
mod field;
mod net;
mod pile;
mod polydisperse;
mod pyramid;
mod random;
mod slab;
mod stones;
mod terrain;

use driven::Driven;
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::HeightField;

/// Steps per second.
pub(crate) const RATE: f32 = 60.0;
/// m/s², of our own scenes.
const GRAVITY: f32 = 9.81;
/// kg/m³, of our own scenes.
const DENSITY: f32 = 2600.0;
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

/// Bodies that come in on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wave {
    /// The first of them; the others follow it, up to the next wave.
    pub(crate) first: usize,
    /// They come in after so many steps.
    pub(crate) after: u32,
}

/// Bodies at rest, and what holds them.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    /// Convex ones, and one mesh for a terrain.
    pub(crate) shapes: Vec<Shape>,
    /// Immovable: ground and walls.
    pub(crate) fixed: Vec<Placed>,
    /// Follow a path.
    pub(crate) driven: Vec<Driven>,
    /// Dynamic.
    pub(crate) bodies: Vec<Placed>,
    /// Those of them that are not there from the start; ascending.
    pub(crate) late: Vec<Wave>,
    /// Of all dynamic bodies, kg/m³.
    pub(crate) density: f32,
    /// m/s², downwards along z.
    pub(crate) gravity: f32,
    /// No body has any business beyond ± this x and y, metres: inner walls, the edge of the ground, or infinite.
    pub(crate) half_width: f64,
    /// The ground; where there is none, the ground is flat and at z = 0.
    pub(crate) terrain: Option<HeightField>,
    /// The bodies on top of all, where it matters how far they sink.
    pub(crate) tops: Vec<usize>,
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
    /// Pyramids of 55 unit boxes; 22,000 make 400 of them.
    ManyPyramids,
    /// Boxes, balls, capsules and hulls dropped on hills of 128 × 128 × 2 triangles.
    MixedTerrain,
    /// Box3D's `large_pyramid`: 5,050 boxes.
    Box3dLargePyramid,
    /// Box3D's `many_pyramids`: 10,780 boxes.
    Box3dManyPyramids,
    /// Box3D's `convex_pile`: 5,120 hulls of 32 corners.
    Box3dConvexPile,
    /// Box3D's `junkyard`: 10,584 rocks of 10 corners and a pillar that moves among them.
    Box3dJunkyard,
    /// Box3D's `washer`: 8,000 cubes in a turning drum.
    Box3dWasher,
    /// Box3D's `rain`, in pieces: 4,200 capsules fall on a hundred arches, a column of them after the other.
    Box3dRain,
    /// Box3D's `large_world`: a million fixed boxes, on which a hundred balls come in one by one.
    Box3dLargeWorld,
    /// A slab of stone, as wide as the room, dropped flat on a bed of balls and boxes of 0.3 to 0.5 m.
    Slab,
    /// Balls and boxes of 0.3 to 0.5 m in a closed drum that turns.
    Drum,
    /// Four boxes of 10 m that carry a bed of balls and boxes of up to 1 cm.
    Net,
    /// Balls with radii of 2 cm to 2 m, both decades of the same volume, dropped into a walled square.
    Polydisperse,
    /// A thousand balls and boxes on a field of a million fixed unit boxes of different heights.
    StaticMillion,
}

impl Kind {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::BoxPile => "box-pile",
            Kind::BallPit => "ball-pit",
            Kind::HullPile => "hull-pile",
            Kind::Pyramid => "pyramid",
            Kind::ManyPyramids => "many-pyramids",
            Kind::MixedTerrain => "mixed-terrain",
            Kind::Box3dLargePyramid => "box3d-large-pyramid",
            Kind::Box3dManyPyramids => "box3d-many-pyramids",
            Kind::Box3dConvexPile => "box3d-convex-pile",
            Kind::Box3dJunkyard => "box3d-junkyard",
            Kind::Box3dWasher => "box3d-washer",
            Kind::Box3dRain => "box3d-rain",
            Kind::Box3dLargeWorld => "box3d-large-world",
            Kind::Slab => "slab",
            Kind::Drum => "drum",
            Kind::Net => "net",
            Kind::Polydisperse => "polydisperse",
            Kind::StaticMillion => "static-million",
        }
    }

    /// Bodies and steps where nobody says how many.
    pub(crate) fn usual(self) -> (usize, u32) {
        match self {
            Kind::BoxPile | Kind::BallPit | Kind::HullPile => (10_000, 600),
            Kind::Pyramid => (5050, 600),
            Kind::ManyPyramids => (22_000, 600),
            Kind::MixedTerrain => (20_000, 600),
            Kind::Box3dLargePyramid => (box3d::LARGE_PYRAMID, 200),
            Kind::Box3dManyPyramids => (box3d::MANY_PYRAMIDS, 100),
            Kind::Box3dConvexPile => (box3d::CONVEX_PILE, 500),
            Kind::Box3dJunkyard => (box3d::JUNKYARD, 500),
            Kind::Box3dWasher => (box3d::WASHER, 1000),
            Kind::Box3dRain => (box3d::RAIN, 400),
            Kind::Box3dLargeWorld => (box3d::LARGE_WORLD, 500),
            Kind::Slab => (slab::STONES + 1, 600),
            Kind::Drum => (100_000, 600),
            Kind::Net => (net::GRAINS + net::LARGE, 600),
            Kind::Polydisperse => (20_000, 600),
            Kind::StaticMillion => (field::MOVERS, 600),
        }
    }

    /// The scene with `count` bodies; pyramids are the largest or the most of at most so many, and Box3D's scenes
    /// have no more bodies than they have.
    pub(crate) fn build(self, count: usize, seed: u64) -> Result<Scene, crate::Error> {
        match self {
            Kind::BoxPile => Ok(pile::boxes(count, seed)),
            Kind::BallPit => Ok(pile::balls(count, seed)),
            Kind::HullPile => pile::hulls(count, seed),
            Kind::Pyramid => Ok(pyramid::pyramid(count)),
            Kind::ManyPyramids => Ok(pyramid::pyramids(count)),
            Kind::MixedTerrain => terrain::mixed(count, seed),
            Kind::Box3dLargePyramid => Ok(box3d::large_pyramid(count)),
            Kind::Box3dManyPyramids => Ok(box3d::many_pyramids(count)),
            Kind::Box3dConvexPile => box3d::convex_pile(count),
            Kind::Box3dJunkyard => box3d::junkyard(count),
            Kind::Box3dWasher => box3d::washer(count),
            Kind::Box3dRain => box3d::rain(count),
            Kind::Box3dLargeWorld => Ok(box3d::large_world(count)),
            Kind::Slab => Ok(slab::slab(count, seed)),
            Kind::Drum => drum::drum(count, seed),
            Kind::Net => Ok(net::net(count, seed)),
            Kind::Polydisperse => Ok(polydisperse::balls(count, seed)),
            Kind::StaticMillion => Ok(field::field(count, seed)),
        }
    }
}

#[cfg(test)]
impl Kind {
    /// Bodies for a test that builds the scene in every engine: few where each has thousands of fixed ones.
    pub(crate) fn few(self) -> usize {
        match self {
            Kind::Box3dLargeWorld => 4,
            Kind::StaticMillion => 10,
            _ => 500,
        }
    }
}

/// Thickness of ground and walls, metres.
const THICK: f32 = 4.0;

impl Scene {
    /// Nothing at all.
    pub(crate) fn empty() -> Scene {
        Scene {
            shapes: Vec::new(),
            fixed: Vec::new(),
            driven: Vec::new(),
            bodies: Vec::new(),
            late: Vec::new(),
            density: DENSITY,
            gravity: GRAVITY,
            half_width: f64::INFINITY,
            terrain: None,
            tops: Vec::new(),
        }
    }

    /// A ground whose surface is z = 0, and nothing else. It is a box rather than a half-space: engines differ in how
    /// well they carry a shape without end.
    fn with_ground(half_width: f32) -> Scene {
        let mut scene = Scene::empty();
        scene.add_ground(half_width);
        scene
    }

    /// A square room, open above.
    fn room(half_width: f32, height: f32) -> Scene {
        let mut scene = Scene::walls(half_width, height, 0.0);
        scene.add_ground(half_width + THICK);
        scene
    }

    fn add_ground(&mut self, half_width: f32) {
        let half = Vec3::new(half_width, half_width, 0.5 * THICK);
        let pose = Pose::at(DVec3::new(0.0, 0.0, -0.5 * f64::from(THICK)));
        self.fixed.push(Placed { shape: self.shapes.len(), pose });
        self.shapes.push(Shape::Box { half });
    }

    /// Four walls around a square, from the height `low` to the height `high`, metres.
    fn walls(half_width: f32, high: f32, low: f32) -> Scene {
        let mut scene = Scene { half_width: f64::from(half_width), ..Scene::empty() };
        let off = scene.half_width + 0.5 * f64::from(THICK);
        let (long, half_height, middle) = (half_width + THICK, 0.5 * (high - low), 0.5 * (high + low));
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let half = if x == 0.0 {
                Vec3::new(long, 0.5 * THICK, half_height)
            } else {
                Vec3::new(0.5 * THICK, long, half_height)
            };
            let pose = Pose::at(DVec3::new(off * x, off * y, f64::from(middle)));
            scene.fixed.push(Placed { shape: scene.shapes.len(), pose });
            scene.shapes.push(Shape::Box { half });
        }
        scene
    }

    /// How many of the bodies take part in the step after so many.
    pub(crate) fn present(&self, steps: u32) -> usize {
        self.late.iter().find(|wave| wave.after > steps).map_or(self.bodies.len(), |wave| wave.first)
    }

    /// All that dynamic bodies can't move, where it is after so many steps.
    pub(crate) fn immovable(&self, steps: u32) -> Vec<Placed> {
        self.fixed.iter().copied().chain(self.driven.iter().map(|driven| driven.placed(steps))).collect()
    }

    /// Height of the ground, metres; none beyond the edge of a terrain.
    pub(crate) fn ground_at(&self, x: f64, y: f64) -> Option<f64> {
        match &self.terrain {
            None => Some(0.0),
            Some(field) => field.height_at(x as f32, y as f32).map(f64::from),
        }
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
    use clap::ValueEnum;

    /// At these places, as long as nothing has moved.
    fn judge(scene: &Scene) -> quality::Quality {
        let poses: Vec<Pose> = scene.bodies.iter().map(|b| b.pose).collect();
        quality::measure(scene, 0, &poses, &poses)
    }

    #[test]
    fn nothing_overlaps_or_is_outside_at_the_start() {
        for &kind in Kind::value_variants() {
            let mut scene = kind.build(4 * kind.few(), 1).expect("a scene");
            // Box3D's pillar starts in the lowest layer of its rocks.
            scene.driven.retain(|_| kind != Kind::Box3dJunkyard);
            let quality = judge(&scene);
            // What stands exactly on each other in doubles may overlap by a rounding error in single precision.
            assert!(quality.deepest_mm < 1e-2 && quality.escaped == 0, "{} {quality:?}", kind.name());
        }
    }

    #[test]
    fn one_seed_makes_one_scene() {
        for &kind in Kind::value_variants() {
            let of = |seed| kind.build(kind.few() / 4, seed).expect("a scene").fingerprint();
            assert_eq!(of(1), of(1));
            let random = !kind.name().starts_with("box3d") && !kind.name().ends_with("pyramids");
            assert_eq!(of(1) != of(2), random && kind != Kind::Pyramid, "{}", kind.name());
        }
    }

    #[test]
    fn the_number_of_bodies_is_as_asked_for() {
        let piles = [Kind::BoxPile, Kind::BallPit, Kind::HullPile, Kind::Pyramid, Kind::MixedTerrain];
        let others = [Kind::Slab, Kind::Drum, Kind::Net, Kind::Polydisperse];
        for kind in piles.into_iter().chain(others) {
            assert_eq!(kind.build(5050, 3).expect("a scene").bodies.len(), 5050);
        }
        assert_eq!(Kind::Pyramid.build(5049, 3).expect("a scene").bodies.len(), 99 * 50);
        assert_eq!(Kind::ManyPyramids.build(5050, 3).expect("a scene").bodies.len(), 91 * 55);
    }

    #[test]
    fn the_usual_number_of_bodies_is_met_exactly() {
        for &kind in Kind::value_variants() {
            let (count, _) = kind.usual();
            assert_eq!(kind.build(count, 1).expect("a scene").bodies.len(), count, "{}", kind.name());
        }
        assert_eq!(Kind::ManyPyramids.build(22_000, 1).expect("a scene").tops.len(), 400);
    }

    #[test]
    fn bodies_that_come_in_are_there_from_then_on() {
        let mut scene = Kind::Pyramid.build(10, 1).expect("a scene");
        assert_eq!(scene.present(0), 10);
        scene.late = vec![Wave { first: 3, after: 5 }, Wave { first: 7, after: 6 }];
        assert_eq!([0, 4, 5, 6, 1000].map(|steps| scene.present(steps)), [3, 3, 7, 10, 10]);
    }

    #[test]
    fn each_name_is_the_one_of_the_command_line() {
        for kind in Kind::value_variants() {
            assert_eq!(kind.to_possible_value().expect("shown").get_name(), kind.name());
        }
    }
}
