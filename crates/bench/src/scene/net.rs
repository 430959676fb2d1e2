//! Sizes of 1 to 1000: four boxes of 10 m stand side by side on the ground, closer than any grain is small, and carry a bed of
//! grains of up to 1 cm where they meet, within a frame. All of them can move, and each large one touches thousands of small ones.
//!
//! Why it is not a boulder that lies on grains: one of 10 m weighs a billion grains of 1 cm. No grain of real stone bears that.

use super::{Placed, Scene, pile, stones};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// Large boxes, and their edge in metres.
pub(super) const LARGE: usize = 4;
const EDGE: f64 = 10.0;

/// On their backs.
pub(super) const GRAINS: usize = 100_000;

/// Of stones, whose largest are half a metre.
const SCALE: f32 = 0.02;

/// Of the bed.
const LAYERS: usize = 4;

/// Between the large boxes, and between them and the frame, metres; the smallest grains have 6 mm.
const CRACK: f64 = 0.002;

/// Width of the frame's bars, metres.
const BAR: f32 = 0.1;

pub(super) fn net(count: usize, seed: u64) -> Scene {
    let large = count.min(LARGE);
    let grains = count - large;
    let pitch = SCALE * stones::PITCH;
    let side = (1..).find(|n: &usize| LAYERS * n * n >= grains).unwrap_or(1);
    let layers = grains.div_ceil(side * side);

    let mut scene = Scene::with_ground(3.0 * EDGE as f32);
    scene.half_width = EDGE + CRACK;
    let cube = scene.shapes.len();
    scene.shapes.push(Shape::Box { half: Vec3::splat(0.5 * EDGE as f32) });
    let off = 0.5 * (EDGE + CRACK);
    let corners = [(-off, -off), (off, -off), (-off, off), (off, off)];
    let place = |(x, y)| Placed { shape: cube, pose: Pose::at(DVec3::new(x, y, 0.5 * EDGE)) };
    scene.bodies.extend(corners.into_iter().take(large).map(place));

    let (half_width, half_height) =
        (0.5 * side as f32 * pitch + 0.2 * pitch, 0.5 * (layers + 2) as f32 * pitch);
    let bar = f64::from(half_width + 0.5 * BAR);
    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let (long, short) = (half_width + BAR, 0.5 * BAR);
        let half =
            if x == 0.0 { Vec3::new(long, short, half_height) } else { Vec3::new(short, long, half_height) };
        let height = EDGE + CRACK + f64::from(half_height);
        let pose = Pose::at(DVec3::new(bar * x, bar * y, height));
        scene.fixed.push(Placed { shape: scene.shapes.len(), pose });
        scene.shapes.push(Shape::Box { half });
    }
    // A hair above the boxes: at a height of 10 m a position in single precision is right to a micrometre.
    let low = (EDGE + 1e-4) as f32;
    pile::drop(&mut scene, stones::stones(SCALE, seed), grains, side, pitch, low, seed);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_large_box_carries_thousands_in_its_lowest_layer() {
        let scene = net(GRAINS + LARGE, 1);
        let pitch = f64::from(SCALE * stones::PITCH);
        for place in &scene.bodies[..LARGE] {
            let of = place.pose.position;
            let on = |b: &&Placed| {
                let p = b.pose.position;
                p.z < EDGE + pitch && p.x * of.x > 0.0 && p.y * of.y > 0.0
            };
            let count = scene.bodies[LARGE..].iter().filter(on).count();
            assert!(count > 6000, "{count}");
        }
    }
}
