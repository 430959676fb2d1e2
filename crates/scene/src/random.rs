//! Random numbers that are the same everywhere: ChaCha with 8 rounds, one stream per purpose.
//!
//! The 256-bit key is the scene's seed (8 bytes, little endian) followed by the 24 bytes `Rockfall scene, version `
//! (with the space); the 64-bit stream number is the FNV-1a hash of a label such as `generators.2`. A float is
//! the upper 53 bits of a 64-bit output (low word first) times 2⁻⁵³, so that no crate's distribution code takes part.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rockfall_math::{DVec3, Quat};

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Random(ChaCha8Rng);

const NAME: &[u8; 24] = b"Rockfall scene, version ";

impl Random {
    /// The stream of a purpose.
    pub(crate) fn new(seed: u64, label: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..].copy_from_slice(NAME);
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(fnv1a(label));
        Random(rng)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [min, max).
    pub(crate) fn within(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.unit()
    }

    /// Uniform in 0..n, for n > 0 (the upper half of a 128-bit product; the bias is below n / 2⁶⁴).
    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// Uniform in a box.
    pub(crate) fn point(&mut self, min: DVec3, max: DVec3) -> DVec3 {
        let x = self.within(min.x, max.x);
        let y = self.within(min.y, max.y);
        let z = self.within(min.z, max.z);
        DVec3::new(x, y, z)
    }

    /// Uniform over all rotations (Shoemake, "Uniform random rotations", Graphics Gems III, 1992).
    pub(crate) fn rotation(&mut self) -> Quat {
        let u = self.unit();
        let (a, b) = (self.within(0.0, std::f64::consts::TAU), self.within(0.0, std::f64::consts::TAU));
        let ((sa, ca), (sb, cb)) = (libm::sincos(a), libm::sincos(b));
        let (p, q) = ((1.0 - u).sqrt(), u.sqrt());
        Quat::from_xyzw((p * sa) as f32, (p * ca) as f32, (q * sb) as f32, (q * cb) as f32)
    }
}

/// The 64-bit FNV-1a hash.
fn fnv1a(label: &str) -> u64 {
    label.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_never_change() {
        // Computed by an independent ChaCha8 in Python from the key and stream in the head of this file.
        let mut random = Random::new(1, "generators.1");
        assert_eq!(fnv1a("a"), 0xaf63_dc4c_8601_ec8c);
        let first: Vec<u64> = (0..3).map(|_| random.bits()).collect();
        assert_eq!(first, [0xf7f22d86d22133c2, 0x540d6c53d5146fb9, 0xb4cda710744bf296]);
    }

    #[test]
    fn streams_differ_by_seed_and_label() {
        let first = |seed, label| Random::new(seed, label).bits();
        assert_ne!(first(1, "a"), first(2, "a"));
        assert_ne!(first(1, "a"), first(1, "b"));
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut random = Random::new(7, "moments");
        let n = 20_000;
        let mean = |f: &mut dyn FnMut() -> f64| (0..n).map(|_| f()).sum::<f64>() / f64::from(n);
        assert!((mean(&mut || random.unit()) - 0.5).abs() < 0.01);
        let mut random = Random::new(10, "moments");
        assert!((mean(&mut || random.below(5) as f64) - 2.0).abs() < 0.05);
    }

    #[test]
    fn rotations_are_unit_and_favour_no_direction() {
        let mut random = Random::new(7, "rotations");
        let mut sum = rockfall_math::Vec3::ZERO;
        for _ in 0..20_000 {
            let q = random.rotation();
            assert!((q.length() - 1.0).abs() < 1e-6);
            sum += rockfall_math::rotation::rotate(q, rockfall_math::Vec3::X);
        }
        assert!(sum.length() < 20_000.0 * 0.02);
    }
}
