//! Which rays stand for many: fixed patterns, so that the same picture has the same bits everywhere.
//!
//! Each pixel of a block of 4 × 4 has another sixteenth of the pattern, and a filter over as many pixels puts them together (Keller and Heidrich, "Interleaved
//! Sampling", Rendering Techniques 2001).

use rockfall_math::{Vec2, Vec3, trig};
use std::f32::consts::TAU;

/// Pixels of a block, along each side.
pub(crate) const BLOCK: u32 = 4;

/// Directions of a hemisphere, for blocks whose pixels take `each` of them.
pub(crate) struct Skies {
    each: usize,
    directions: Vec<Vec3>,
}

/// Points of a disc, for blocks of 2 × 2 pixels: a first one for each pixel, and more for those that are at the border of a shadow.
pub(crate) struct Suns {
    each: usize,
    points: Vec<Vec2>,
}

/// The order in which the pixels of a block are numbered: neighbours have numbers that are far apart (Bayer's matrix).
const ORDER: [u32; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];

impl Skies {
    /// For so many directions in a pixel, at least one.
    pub(crate) fn new(each: u32) -> Self {
        let each = each.max(1);
        let count = BLOCK * BLOCK * each;
        let direction = |k| {
            let (u, v) = hammersley(k, count);
            on_hemisphere(u, v)
        };
        Skies { each: each as usize, directions: (0..count).map(direction).collect() }
    }

    /// Numbers of the directions of a pixel: they are spread over the whole pattern.
    fn range(&self, x: u32, y: u32) -> impl Iterator<Item = usize> + use<> {
        let number = ORDER[(x % BLOCK + BLOCK * (y % BLOCK)) as usize] as usize;
        let count = (BLOCK * BLOCK) as usize;
        (0..self.each).map(move |k| number + count * k)
    }

    /// How many directions a pixel has.
    pub(crate) fn each(&self) -> usize {
        self.each
    }

    /// The directions of a pixel, about z, more of them near it: as the light that a dull surface gets.
    pub(crate) fn of(&self, x: u32, y: u32) -> impl Iterator<Item = Vec3> + '_ {
        self.range(x, y).map(|k| self.directions[k])
    }
}

impl Suns {
    /// For so many points in a pixel at the border of a shadow, at least one.
    pub(crate) fn new(each: u32) -> Self {
        let each = each.max(1);
        let point = |k| {
            let (u, v) = hammersley(k, 4 * each);
            on_disc(u, v)
        };
        Suns { each: each as usize, points: (0..4 * each).map(point).collect() }
    }

    /// The points of a pixel: a ring of the disc, all around; the first one by itself is one of four that stand for the disc.
    pub(crate) fn of(&self, x: u32, y: u32) -> &[Vec2] {
        let ring = [0, 2, 3, 1][(x % 2 + 2 * (y % 2)) as usize];
        &self.points[ring * self.each..][..self.each]
    }
}

/// Point `k` of Hammersley's set of `n` in the unit square.
pub(crate) fn hammersley(k: u32, n: u32) -> (f32, f32) {
    let mirrored = (k.reverse_bits() >> 8) as f32 / (1_u32 << 24) as f32;
    ((k as f32 + 0.5) / n as f32, mirrored)
}

/// With a density as the cosine of the angle to z (Malley's method).
fn on_hemisphere(u: f32, v: f32) -> Vec3 {
    let (sin, cos) = trig::sin_cos(TAU * v);
    let r = u.sqrt();
    Vec3::new(r * cos, r * sin, (1.0 - u).max(0.0).sqrt())
}

/// Evenly spread over the disc of radius 1.
pub(crate) fn on_disc(u: f32, v: f32) -> Vec2 {
    let (sin, cos) = trig::sin_cos(TAU * v);
    u.sqrt() * Vec2::new(cos, sin)
}

/// Two unit vectors across `n`, which has unit length. They change slowly but near z, where hardly anything is in the way of the sky: where they jump, neighbours
/// don't have one whole pattern together.
pub(crate) fn across(n: Vec3) -> [Vec3; 2] {
    let level = Vec3::new(-n.y, n.x, 0.0);
    let length = level.length();
    let side = if length > 1e-6 { level / length } else { Vec3::X };
    [side, n.cross(side)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_the_whole_pattern_and_each_point_once() {
        for each in [1, 2, 5] {
            let skies = Skies::new(each);
            let pixels = (0..16).flat_map(|k| skies.range(k % 4 + 8, k / 4 + 4));
            let mut numbers: Vec<usize> = pixels.collect();
            numbers.sort_unstable();
            assert_eq!(numbers, (0..16 * each as usize).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_mean_of_the_directions_is_two_thirds_up_and_that_of_the_disc_is_its_middle() {
        let directions = Skies::new(4).directions;
        let mean = directions.iter().sum::<Vec3>() / 64.0;
        assert!((mean - Vec3::Z * 2.0 / 3.0).length() < 0.02, "{mean}");
        let suns = Suns::new(16);
        let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| suns.of(x, y).iter().sum::<Vec2>());
        let middle = pixels.into_iter().sum::<Vec2>() / 64.0;
        assert!(middle.length() < 0.02, "{middle}");
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-6));
    }

    #[test]
    fn the_axes_are_at_right_angles() {
        for n in [Vec3::Z, -Vec3::Z, Vec3::new(0.6, -0.48, 0.64), Vec3::new(1e-9, 0.0, -1.0)] {
            let [a, b] = across(n);
            let off = [a.dot(b), a.dot(n), b.dot(n), a.length() - 1.0, b.length() - 1.0];
            // Near z they are off by as much as it.
            assert!(off.iter().all(|x| x.abs() < 1e-6), "{off:?}");
        }
    }
}
