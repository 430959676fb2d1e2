//! A flat pyramid of unit boxes.

use super::{Placed, Scene};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// Between neighbours of a layer, metres: wider than the margin in which engines look for contacts, so that each box
/// touches those below and above only.
const GAP: f64 = 0.1;

pub(super) fn pyramid(count: usize) -> Scene {
    let base = (1..).take_while(|n: &usize| n * (n + 1) / 2 <= count).last().unwrap_or(0);
    let pitch = 1.0 + GAP;
    let mut scene = Scene::with_ground(base as f32 + 10.0);
    let shape = scene.shapes.len();
    scene.shapes.push(Shape::Box { half: Vec3::splat(0.5) });
    for layer in 0..base {
        let boxes = base - layer;
        let left = -0.5 * pitch * (boxes - 1) as f64;
        scene.bodies.extend((0..boxes).map(|i| {
            let pose = Pose::at(DVec3::new(left + pitch * i as f64, 0.0, layer as f64 + 0.5));
            Placed { shape, pose }
        }));
    }
    scene.top = scene.bodies.len().checked_sub(1);
    scene
}
