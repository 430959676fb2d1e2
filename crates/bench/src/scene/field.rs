//! A field of fixed unit boxes of different heights, with a few balls and boxes dropped all over it: nearly all that the broad phase
//! holds stands still.

use super::random::Random;
use super::{Placed, Scene, pile};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// Dynamic bodies where nobody says how many; for each of so many there are as many fixed boxes, up to a million.
pub(super) const MOVERS: usize = 1000;

/// Fixed boxes along each side, at most.
const SIDE: usize = 1000;

/// Tops of the fixed boxes are at heights from 0 up to this, metres.
const STEP: f32 = 0.4;

/// Width of a cell that a mover is put into, metres: more than the diagonal of a unit box.
const PITCH: f32 = 1.75;

/// Boxes along each edge on which nothing falls.
const EDGE: usize = 2;

/// Keys of the random streams of heights and of places.
const HEIGHTS: u64 = 5 << 60;
const PLACES: u64 = 6 << 60;

pub(super) fn field(count: usize, seed: u64) -> Scene {
    let side = (1..SIDE).find(|n| n * n >= MOVERS * count).unwrap_or(SIDE);
    let half_width = 0.5 * side as f64;
    let mut scene = Scene { half_width, ..Scene::empty() };
    scene.shapes.push(Shape::Box { half: Vec3::splat(0.5) });
    scene.fixed.extend((0..side * side).map(|i| {
        let height = f64::from(Random::new(seed, HEIGHTS + i as u64).between(0.0, STEP)) - 0.5;
        let [x, y] = [i % side, i / side].map(|i| i as f64 + 0.5 - half_width);
        Placed { shape: 0, pose: Pose::at(DVec3::new(x, y, height)) }
    }));

    // Each mover has a square of the field to itself; only where they are very many they come in layers.
    let inside = (side - 2 * EDGE) as f32;
    let most = (inside / PITCH) as usize;
    let squares = (1..most).find(|n| n * n >= count).unwrap_or(most);
    let width = inside / squares as f32;
    let spare = 0.5 * (width - PITCH);
    for i in 0..count {
        let mut random = Random::new(seed, PLACES + i as u64);
        let [x, y] = [i % squares, i / squares % squares]
            .map(|i| (i as f32 + 0.5 - 0.5 * squares as f32) * width + random.between(-spare, spare));
        let rotation = random.rotation();
        let layer = (i / (squares * squares)) as f32;
        let position = Vec3::new(x, y, STEP + (0.5 + layer) * PITCH).as_dvec3();
        scene.bodies.push(Placed { shape: scene.shapes.len(), pose: Pose { position, rotation } });
        scene.shapes.push(match i % 2 {
            0 => pile::ball_shape(i, seed),
            _ => pile::box_shape(i, seed),
        });
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_movers_have_a_million_boxes_to_fall_on() {
        let scene = field(MOVERS, 1);
        assert_eq!((scene.bodies.len(), scene.fixed.len()), (1000, 1_000_000));
        assert_eq!(field(2 * MOVERS, 1).fixed.len(), 1_000_000);
        assert_eq!(field(10, 1).fixed.len(), 10_000);
        let spread = scene.bodies.iter().map(|b| b.pose.position.x).fold(0.0, f64::max);
        assert!(spread > 450.0, "{spread}");
    }
}
