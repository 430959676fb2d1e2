//! Balls and boxes of different sizes, in turns.

use super::random::Random;
use rockfall::Shape;
use rockfall::math::Vec3;

/// Least and largest diameter or edge, metres.
pub(super) const SMALLEST: f32 = 0.3;
pub(super) const LARGEST: f32 = 0.5;

/// Width of the cell that a stone is put into, metres.
pub(super) const PITCH: f32 = 0.52;

/// Shapes differ, and are shared: there are so many.
const SHAPES: usize = 1024;

/// Shapes of stones, all sizes times `scale`; every other one is a ball.
pub(super) fn stones(scale: f32, seed: u64) -> Vec<Shape> {
    let stone = |i: usize| {
        let mut random = Random::new(seed, super::pile::SHAPES + i as u64);
        let mut half = || 0.5 * scale * random.between(SMALLEST, LARGEST);
        match i % 2 {
            0 => Shape::Sphere { radius: half() },
            _ => Shape::Box { half: Vec3::new(half(), half(), half()) },
        }
    };
    (0..SHAPES).map(stone).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_them_are_balls_and_all_fit_their_cells() {
        let stones = stones(0.1, 3);
        assert_eq!(stones.iter().filter(|s| s.name() == "sphere").count(), SHAPES / 2);
        for stone in &stones {
            let half = stone.placed_bounds(&Default::default()).half_extents();
            assert!(half.min_element() >= 0.05 * SMALLEST && half.max_element() < 0.05 * PITCH, "{half}");
        }
    }
}
