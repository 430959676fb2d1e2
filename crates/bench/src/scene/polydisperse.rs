//! Balls of sizes from 1 to 100, poured into a walled square.
//!
//! Radii are spread evenly over the logarithm in each of the two decades, and the larger decade has a thousandth of the balls of the
//! smaller: so both have the same volume. (A spectrum that falls with the cube of the size all the way would have it too, but
//! twenty thousand balls of it would hold none of the largest.)

use super::random::Random;
use super::{Scene, pile};
use rockfall::Shape;

/// Radius of the smallest, metres.
const SMALLEST: f32 = 0.02;

/// Balls of the smaller decade for each of the larger.
const RATIO: usize = 1000;

/// Between cells and the balls in them, and between cells and walls, metres.
const GAP: f32 = 0.05;

/// Key of the random stream that shuffles the radii.
const SHUFFLE: u64 = 4 << 60;

pub(super) fn balls(count: usize, seed: u64) -> Scene {
    let large = count.div_ceil(RATIO + 1);
    let small = count - large;
    let (of_large, of_small) = (radii(large, 10.0 * SMALLEST), radii(small, SMALLEST));
    let pitch = |radii: &[f32]| 2.0 * radii.iter().copied().fold(0.0, f32::max) + GAP;
    let (wide, narrow) = (pitch(&of_large), pitch(&of_small));
    let per_side = |count: usize| (1..).find(|n: &usize| n * n * n >= count).unwrap_or(1);
    let side = per_side(large);
    let width = (side as f32 * wide).max(per_side(small) as f32 * narrow);
    // As wide below as above: the small ones fall on all of the large ones.
    let side_of_small = (width / narrow) as usize;
    let low = large.div_ceil(side * side) as f32 * wide;
    let height = low + small.div_ceil(side_of_small * side_of_small) as f32 * narrow;

    let mut scene = Scene::room(0.5 * width + GAP, height + wide);
    let shape = |radius: f32| Shape::Sphere { radius };
    let shuffled = shuffle(of_small, seed).into_iter().map(shape).collect();
    pile::drop(&mut scene, of_large.into_iter().map(shape).collect(), large, side, wide, 0.0, seed);
    pile::drop(&mut scene, shuffled, small, side_of_small, narrow, low, seed);
    scene
}

/// So many radii from `least` to ten times that, even on a logarithmic axis, the largest first.
fn radii(count: usize, least: f32) -> Vec<f32> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| (f64::from(least) * 10f64.powf(1.0 - i as f64 / last)) as f32).collect()
}

fn shuffle(mut values: Vec<f32>, seed: u64) -> Vec<f32> {
    let mut random = Random::new(seed, SHUFFLE);
    for i in (1..values.len()).rev() {
        let other = random.between(0.0, (i + 1) as f32) as usize;
        values.swap(i, other.min(i));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_go_from_one_to_a_hundred_and_decades_have_equal_volumes() {
        let scene = balls(20_020, 1);
        let radius = |shape: &Shape| match shape {
            Shape::Sphere { radius } => f64::from(*radius),
            other => panic!("a {}", other.name()),
        };
        let radii: Vec<f64> = scene.bodies.iter().map(|b| radius(&scene.shapes[b.shape])).collect();
        let (least, most) = radii.iter().fold((f64::MAX, 0.0f64), |(l, m), &r| (l.min(r), m.max(r)));
        assert!((most / least - 100.0).abs() < 1e-3, "{least} to {most}");
        let middle = 10.0 * f64::from(SMALLEST) * (1.0 - 1e-5);
        let volume = |large: bool| -> f64 {
            let of = radii.iter().enumerate().filter(|(i, _)| (*i < 20) == large);
            of.map(|(_, r)| r.powi(3)).sum()
        };
        assert!(
            radii[..20].iter().all(|&r| r >= middle) && radii[20..].iter().all(|&r| r <= 1.0001 * middle)
        );
        // Twenty large balls are a coarse sum for an integral.
        let ratio = volume(true) / volume(false);
        assert!((0.7..1.5).contains(&ratio), "{ratio}");
    }
}
