//! Random numbers that are the same everywhere.

use rockfall::math::hash::{combine, mix};
use rockfall::math::{Quat, Vec3, rotation};

/// A stream of numbers, named by the seed and a key.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64, key: u64) -> Self {
        Random(combine(mix(seed), key))
    }

    /// Uniform in [`low`, `high`).
    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        // The golden ratio's bits, as in SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        low + (high - low) * ((mix(self.0) >> 40) as f32 / (1u32 << 24) as f32)
    }

    /// A unit vector, all directions equally likely: a point in the ball, pushed out.
    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            let mut side = || self.between(-1.0, 1.0);
            let v = Vec3::new(side(), side(), side());
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v / v.length();
            }
        }
    }

    /// All orientations equally likely: a point in the four-dimensional ball, pushed out.
    pub(super) fn rotation(&mut self) -> Quat {
        loop {
            let mut side = || self.between(-1.0, 1.0);
            let [x, y, z, w] = [side(), side(), side(), side()];
            let squared = x * x + y * y + z * z + w * w;
            if (0.01..=1.0).contains(&squared) {
                return rotation::normalize(Quat::from_xyzw(x, y, z, w));
            }
        }
    }
}
