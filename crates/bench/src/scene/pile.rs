//! A cube of bodies with room between them that falls into a walled square.
//!
//! The room is as wide as the cube, so that a pile of eight times the bodies is twice as deep.

use super::random::Random;
use super::{Placed, Scene};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Quat, Vec3, rotation};
use rockfall::shape::Hull;
use std::sync::Arc;

/// Hulls differ, and are shared: there are so many.
const HULLS: usize = 256;

/// Between the outermost cells and the walls, metres.
const GAP: f32 = 0.25;

/// Keys of the random streams of shapes and of places.
pub(super) const SHAPES: u64 = 1 << 60;
const PLACES: u64 = 2 << 60;

pub(super) fn boxes(count: usize, seed: u64) -> Scene {
    fill((0..count).map(|i| box_shape(i, seed)).collect(), count, 1.25, seed)
}

pub(super) fn balls(count: usize, seed: u64) -> Scene {
    fill((0..count).map(|i| ball_shape(i, seed)).collect(), count, 1.1, seed)
}

pub(super) fn hulls(count: usize, seed: u64) -> Result<Scene, crate::Error> {
    Ok(fill(hull_shapes(HULLS, seed)?, count, 1.1, seed))
}

/// Edges of 0.5 to 1 m.
pub(super) fn box_shape(i: usize, seed: u64) -> Shape {
    let mut random = Random::new(seed, SHAPES + i as u64);
    let mut half = || 0.5 * random.between(0.5, 1.0);
    Shape::Box { half: Vec3::new(half(), half(), half()) }
}

/// Radii of 0.25 to 0.5 m.
pub(super) fn ball_shape(i: usize, seed: u64) -> Shape {
    Shape::Sphere { radius: Random::new(seed, SHAPES + i as u64).between(0.25, 0.5) }
}

/// So many hulls of 12 to 20 corners, about 0.8 m across.
pub(super) fn hull_shapes(count: usize, seed: u64) -> Result<Vec<Shape>, crate::Error> {
    let hull = |i: usize| {
        let mut random = Random::new(seed, SHAPES + i as u64);
        let corners = random.between(12.0, 21.0) as usize;
        let axes = Vec3::new(0.5, random.between(0.35, 0.5), random.between(0.3, 0.45));
        let points: Vec<Vec3> = (0..corners).map(|_| random.direction() * axes).collect();
        Ok(Shape::Hull(Arc::new(Hull::from_points(&points)?)))
    };
    (0..count).map(hull).collect()
}

/// A room, and a cube of bodies in it.
fn fill(shapes: Vec<Shape>, count: usize, pitch: f32, seed: u64) -> Scene {
    let side = (1..).find(|n: &usize| n * n * n >= count).unwrap_or(1);
    let layers = count.div_ceil(side * side);
    let mut scene = Scene::room(0.5 * side as f32 * pitch + GAP, (layers + 2) as f32 * pitch);
    drop(&mut scene, shapes, count, side, pitch, 0.0, seed);
    scene
}

/// `count` bodies of these shapes, one in each cell of a grid that holds the body in a random place. Cells are `pitch`
/// metres wide, `side` times `side` in a layer, and the lowest layer begins at the height `low`, metres.
pub(super) fn drop(
    scene: &mut Scene,
    shapes: Vec<Shape>,
    count: usize,
    side: usize,
    pitch: f32,
    low: f32,
    seed: u64,
) {
    let width = side as f32 * pitch;
    let first = scene.shapes.len();
    let kinds = shapes.len();
    scene.shapes.extend(shapes);
    scene.bodies.reserve(count);
    for i in 0..count {
        let mut random = Random::new(seed, PLACES + i as u64);
        let shape = first + i % kinds;
        let rotation = fitting(&scene.shapes[shape], random.rotation(), pitch);
        let bounds = scene.shapes[shape].placed_bounds(&Pose { position: DVec3::ZERO, rotation });
        let spare = 0.5 * Vec3::splat(pitch) - bounds.half_extents();
        let mut jitter = || 0.99 * random.between(-1.0, 1.0);
        let shift = Vec3::new(jitter(), jitter(), jitter()) * spare - bounds.center();
        let cell = [i % side, i / side % side, i / (side * side)].map(|n| (n as f32 + 0.5) * pitch);
        let position = Vec3::new(cell[0] - 0.5 * width, cell[1] - 0.5 * width, cell[2] + low) + shift;
        scene.bodies.push(Placed { shape, pose: Pose { position: position.as_dvec3(), rotation } });
    }
}

/// The rotation itself where the turned shape fits a cell, else the nearest of half, a quarter, … of its angle.
fn fitting(shape: &Shape, mut turn: Quat, pitch: f32) -> Quat {
    for _ in 0..8 {
        let bounds = shape.placed_bounds(&Pose { position: DVec3::ZERO, rotation: turn });
        if bounds.half_extents().max_element() < 0.499 * pitch {
            return turn;
        }
        // Half-way to the identity on the shorter arc.
        let w = if turn.w < 0.0 { -1.0 } else { 1.0 };
        turn = rotation::normalize(Quat::from_xyzw(w * turn.x, w * turn.y, w * turn.z, w * turn.w + 1.0));
    }
    Quat::IDENTITY
}
