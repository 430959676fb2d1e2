//! Flat pyramids of unit boxes.

use super::{Placed, Scene};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// Between neighbours of a layer, metres: wider than the margin in which engines look for contacts, so that each box
/// touches those below and above only.
const GAP: f64 = 0.1;

/// Boxes in the lowest layer of each of many pyramids, and in all of one.
const SMALL: usize = 10;
const BOXES: usize = SMALL * (SMALL + 1) / 2;

/// Between pyramids, metres: along their layers, and across.
const ASIDE: f64 = 1.0;
const ACROSS: f64 = 2.0;

/// One pyramid, the largest of at most `count` boxes.
pub(super) fn pyramid(count: usize) -> Scene {
    let base = (1..).take_while(|n: &usize| n * (n + 1) / 2 <= count).last().unwrap_or(0);
    let mut scene = Scene::with_ground(base as f32 + 10.0);
    let shape = unit_box(&mut scene);
    build(&mut scene, shape, base, 1.0 + GAP, DVec3::ZERO);
    scene
}

/// Pyramids with a base of ten in a square, at most `count` boxes together.
pub(super) fn pyramids(count: usize) -> Scene {
    let pyramids = count / BOXES;
    let side = (1..).find(|n: &usize| n * n >= pyramids).unwrap_or(1);
    let (along, across) = (SMALL as f64 * (1.0 + GAP) + ASIDE, 1.0 + ACROSS);
    let mut scene = Scene::with_ground(0.5 * along as f32 * side as f32 + 10.0);
    let shape = unit_box(&mut scene);
    let middle = 0.5 * (side - 1) as f64;
    for i in 0..pyramids {
        let [x, y] = [(i % side) as f64 - middle, (i / side) as f64 - middle];
        build(&mut scene, shape, SMALL, 1.0 + GAP, DVec3::new(along * x, across * y, 0.0));
    }
    scene
}

pub(super) fn unit_box(scene: &mut Scene) -> usize {
    scene.shapes.push(Shape::Box { half: Vec3::splat(0.5) });
    scene.shapes.len() - 1
}

/// A pyramid of unit boxes around `foot`, their centres `pitch` metres apart.
pub(super) fn build(scene: &mut Scene, shape: usize, base: usize, pitch: f64, foot: DVec3) {
    for layer in 0..base {
        let boxes = base - layer;
        let left = -0.5 * pitch * (boxes - 1) as f64;
        scene.bodies.extend((0..boxes).map(|i| {
            let place = foot + DVec3::new(left + pitch * i as f64, 0.0, layer as f64 + 0.5);
            Placed { shape, pose: Pose::at(place) }
        }));
    }
    if base > 0 {
        scene.tops.push(scene.bodies.len() - 1);
    }
}
