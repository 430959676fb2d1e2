//! A slab of stone, dropped flat on a bed of stones in a walled square: one body with tens of thousands of neighbours, and a
//! hundred thousand times as heavy as each. The bed is three layers of a lattice in which each stone has a place of its own;
//! the slab is just above it and comes down with it.

use super::{Placed, Scene, pile, stones};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};

/// Under the slab.
pub(super) const STONES: usize = 100_000;

/// Of the bed.
const LAYERS: usize = 3;

/// Between the outermost cells and the walls, metres.
const GAP: f32 = 0.1;

/// Between the slab and the walls, and between it and the bed, metres.
const AROUND: f32 = 0.5;
const ABOVE: f32 = 0.05;

/// Thickness of the slab, metres.
const THICK: f32 = 1.0;

/// The slab and `count` − 1 stones.
pub(super) fn slab(count: usize, seed: u64) -> Scene {
    let stones = count.saturating_sub(1);
    let side = (1..).find(|n: &usize| LAYERS * n * n >= stones).unwrap_or(1);
    let layers = stones.div_ceil(side * side) as f32;
    let half_width = 0.5 * side as f32 * stones::PITCH + GAP;
    let top = layers * stones::PITCH;
    let mut scene = Scene::room(half_width, top + ABOVE + 2.0 * THICK);
    let half_slab = (half_width - AROUND).max(0.5 * half_width);
    let pose = Pose::at(DVec3::new(0.0, 0.0, f64::from(top + ABOVE + 0.5 * THICK)));
    scene.bodies.push(Placed { shape: scene.shapes.len(), pose });
    scene.shapes.push(Shape::Box { half: Vec3::new(half_slab, half_slab, 0.5 * THICK) });
    pile::drop(&mut scene, stones::stones(1.0, seed), stones, side, stones::PITCH, 0.0, seed);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slab_lies_over_tens_of_thousands_of_stones() {
        let scene = slab(STONES + 1, 1);
        let slab = &scene.bodies[0];
        let bounds = scene.shapes[slab.shape].placed_bounds(&slab.pose);
        let under = |b: &&Placed| {
            let p = b.pose.position;
            let above = f64::from(bounds.min.z) - p.z;
            above < f64::from(stones::PITCH) && p.x.abs().max(p.y.abs()) < f64::from(bounds.max.x)
        };
        let count = scene.bodies[1..].iter().filter(under).count();
        assert!(count > 30_000, "{count}");
        let mass = |b: &Placed| scene.shapes[b.shape].mass_properties(scene.density).expect("a solid").mass;
        let mean = scene.bodies[1..].iter().map(mass).sum::<f32>() / STONES as f32;
        assert!((1e5..1e6).contains(&(mass(slab) / mean)), "{}", mass(slab) / mean);
    }
}
