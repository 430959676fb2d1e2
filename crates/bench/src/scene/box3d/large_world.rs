//! `large_world`: a floor of a million fixed boxes, on which balls come in, one every five steps, far from each other. What it
//! measures is whether bodies that stand still cost anything.
//!
//! Fewer balls come with as much less of the floor.

use super::{LARGE_WORLD, WATER, up};
use crate::scene::{Placed, Scene, Wave};
use rockfall::Shape;
use rockfall::math::{Pose, Vec3};

/// Width of a box of the floor, metres.
const CELL: f64 = 10.0;
/// Boxes of the floor along its side for each ball along the side of their square.
const BOXES: usize = 100;
/// Share of the floor along each edge on which nothing falls.
const EDGE: f64 = 0.1;
/// Steps from one ball to the next.
const EVERY: u32 = 5;

pub(in crate::scene) fn large_world(count: usize) -> Scene {
    let count = count.min(LARGE_WORLD);
    let side = (1..).find(|n: &usize| n * n >= count).unwrap_or(1);
    let boxes = BOXES * side;
    let half_width = 0.5 * CELL * boxes as f64;
    let mut scene = Scene { density: WATER, gravity: super::GRAVITY, half_width, ..Scene::empty() };
    scene.shapes.push(Shape::Box { half: Vec3::new(0.5 * CELL as f32, 0.5 * CELL as f32, 0.25) });
    scene.shapes.push(Shape::Sphere { radius: 0.5 });
    let middle = |i: usize, width: f64| (i as f64 + 0.5) * width;
    scene.fixed.extend((0..boxes * boxes).map(|i| {
        let [x, z] = [i / boxes, i % boxes].map(|i| middle(i, CELL) - half_width);
        Placed { shape: 0, pose: Pose::at(up(x, 0.0, z)) }
    }));
    let inside = (1.0 - 2.0 * EDGE) * half_width;
    scene.bodies.extend((0..count).map(|i| {
        let [x, z] = [i % side, i / side].map(|i| middle(i, 2.0 * inside / side as f64) - inside);
        Placed { shape: 1, pose: Pose::at(up(x, 1.5, z)) }
    }));
    scene.late = (0..count).map(|first| Wave { first, after: EVERY * (first as u32 + 1) }).collect();
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_times_are_those_of_box3d() {
        let scene = large_world(usize::MAX);
        assert_eq!(scene.fixed[0].pose.position, up(-4995.0, 0.0, -4995.0));
        assert_eq!(scene.bodies[0].pose.position, up(-3600.0, 1.5, -3600.0));
        assert_eq!(scene.bodies[99].pose.position, up(3600.0, 1.5, 3600.0));
        assert_eq!([4, 5, 9, 10, 499, 500].map(|steps| scene.present(steps)), [0, 1, 1, 2, 99, 100]);
    }

    #[test]
    fn a_ball_of_few_has_as_much_floor_as_one_of_all() {
        let few = large_world(4);
        assert_eq!((few.bodies.len(), few.fixed.len()), (4, 40_000));
    }
}
