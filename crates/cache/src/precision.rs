//! Poses as whole numbers: exactly as they are, or within a bound that the user states.
//!
//! **Bits.** Without a bound a number is stored as the bits of its single precision.
//!
//! **Steps.** With one it is stored as a multiple of a step, rounded to the nearest, so it errs by half a step at most.
//!
//! - Position: three numbers that err by s/2 each make a distance of √3/2 · s.
//! - Rotation: four numbers that err by s/2 each move the quaternion q by a vector δ of length |δ| ≤ s. The angle between q, which
//!   has length 1, and q + δ is at most asin |δ|, and the rotation between the two, once q + δ has length 1 again, is twice
//!   that: 2 asin s.
//!
//! A step is a power of two. So a multiple below 2²⁴ steps (a kilometre at a bound of 0.1 mm) is exact in single precision, a reader's
//! arithmetic adds nothing to the bound, and what is rounded once stays as it is when it is rounded again. Every number is rounded
//! by itself: errors do not add up from frame to frame.

use crate::Error;

/// How far a pose on disk may be from that of the simulation. Lossless, to single precision, where nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Precision {
    /// Largest distance, metres: from 1e-6 to 1000.
    pub position: Option<f64>,
    /// Largest angle, radians: from 1.25e-4 (0.0072°) to 0.5.
    pub rotation: Option<f64>,
}

impl Precision {
    /// The numbers of positions and of orientations.
    ///
    /// # Errors
    /// [`Error::Precision`] for a bound out of range.
    pub(crate) fn numbers(self) -> Result<(Numbers, Numbers), Error> {
        let within = |bound: Option<f64>, least: f64, most: f64, unit| match bound {
            Some(bound) if !(least..=most).contains(&bound) => {
                Err(Error::Precision { bound, least, most, unit })
            }
            _ => Ok(()),
        };
        within(self.position, 1e-6, 1000.0, "m")?;
        within(self.rotation, 1.25e-4, 0.5, "rad")?;
        let position = self.position.map_or(Numbers::Bits, |bound| Numbers::Steps {
            step: power_below(2.0 / 3_f64.sqrt() * bound),
            absent: i32::MIN,
        });
        // A hundredth is left for single precision, whose unit quaternions have length 1 to 1e-7 only.
        let rotation = self.rotation.map_or(Numbers::Bits, |bound| {
            let step = power_below(0.99 * libm::sin(0.5 * bound));
            Numbers::Steps { step, absent: i16::MIN.into() }
        });
        Ok((position, rotation))
    }
}

/// The largest power of two that is not above `x`, which is a normal number.
fn power_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 52) - 1))
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Numbers {
    /// The bits of single precision.
    Bits,
    /// Multiples of `step`; `absent` stands for NaN, and the numbers that can be stored reach to the same on the other side.
    Steps { step: f64, absent: i32 },
}

impl Numbers {
    /// What stands for a number that is not there.
    pub(crate) fn absent(self) -> i32 {
        match self {
            Numbers::Bits => f32::NAN.to_bits().cast_signed(),
            Numbers::Steps { absent, .. } => absent,
        }
    }

    /// Stores numbers. Returns whether one was too large, and became absent.
    pub(crate) fn store(self, from: &[f32], to: &mut [i32]) -> bool {
        /// Adding and taking off this rounds to the nearest whole number, ties to even: doubles have no room for less.
        const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
        match self {
            Numbers::Bits => {
                for (to, x) in to.iter_mut().zip(from) {
                    *to = x.to_bits().cast_signed();
                }
                false
            }
            Numbers::Steps { step, absent } => {
                let (inverse, most) = (1.0 / step, -f64::from(absent) - 1.0);
                let mut too_large = false;
                for (to, &x) in to.iter_mut().zip(from) {
                    let steps = f64::from(x) * inverse;
                    let fits = steps.abs() <= most;
                    *to = if fits { (steps + ROUND - ROUND) as i32 } else { absent };
                    too_large |= !fits && !x.is_nan();
                }
                too_large
            }
        }
    }

    /// Reads a number.
    #[inline]
    pub(crate) fn read(self, stored: i32) -> f32 {
        match self {
            Numbers::Bits => f32::from_bits(stored.cast_unsigned()),
            Numbers::Steps { absent, .. } if stored == absent => f32::NAN,
            Numbers::Steps { step, .. } => (f64::from(stored) * step) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    /// Numbers from -1 to 1, the same in every run of the test.
    fn random(i: u64) -> f64 {
        (mix(i) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn through(numbers: Numbers, from: &[f32]) -> Vec<f32> {
        let mut stored = vec![0; from.len()];
        assert!(!numbers.store(from, &mut stored));
        stored.into_iter().map(|stored| numbers.read(stored)).collect()
    }

    /// Promise: whatever the bound, no position is farther off, near the origin and a kilometre away from it.
    #[test]
    fn positions_are_within_the_bound() {
        for (bound, reach) in
            [(1e-6, 5.0), (1e-4, 1000.0), (1e-4, 1.0), (1.3e-3, 1000.0), (0.5, 1000.0), (1000.0, 1e5)]
        {
            let (numbers, _) = Precision { position: Some(bound), rotation: None }.numbers().unwrap();
            let mut worst = 0.0_f64;
            for i in 0..20_000 {
                let p: [f32; 3] = std::array::from_fn(|axis| (reach * random(3 * i + axis as u64)) as f32);
                let q = through(numbers, &p);
                let off = p
                    .iter()
                    .zip(&q)
                    .map(|(p, q)| (f64::from(*p) - f64::from(*q)).powi(2))
                    .sum::<f64>()
                    .sqrt();
                worst = worst.max(off);
                assert_eq!(through(numbers, &q), q, "rounding again changes nothing");
            }
            // The step is a power of two, so up to half of the bound is given away.
            assert!(worst <= bound && worst > 0.4 * bound, "{worst} of {bound}");
        }
    }

    /// Promise: the same of rotations, in radians.
    #[test]
    fn rotations_are_within_the_bound() {
        for bound in [1.25e-4, 1e-3, 0.1_f64.to_radians(), 0.02, 0.5] {
            let (_, numbers) = Precision { position: None, rotation: Some(bound) }.numbers().unwrap();
            let mut worst = 0.0_f64;
            for i in 0..20_000 {
                let p: [f64; 4] = std::array::from_fn(|axis| random(4 * i + axis as u64));
                let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                // Axes of the unit sphere too, where a number is as large as it gets.
                let p = if i < 4 {
                    std::array::from_fn(|axis| f64::from(u8::from(axis as u64 == i)))
                } else {
                    p.map(|x| x / length)
                };
                let q = through(numbers, &p.map(|x| x as f32));
                let length = q.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
                let half = 0.5
                    * p.iter().zip(&q).map(|(p, q)| (p - f64::from(*q) / length).powi(2)).sum::<f64>().sqrt();
                worst = worst.max(4.0 * half.asin());
            }
            assert!(worst <= bound && worst > 0.3 * bound, "{worst} of {bound}");
        }
    }

    #[test]
    fn what_is_not_there_stays_so_and_what_is_too_far_is_told() {
        let (position, _) = Precision { position: Some(1e-4), rotation: None }.numbers().unwrap();
        for numbers in [position, Numbers::Bits] {
            assert!(through(numbers, &[f32::NAN])[0].is_nan());
            assert_eq!(numbers.read(numbers.absent()).to_bits(), f32::NAN.to_bits());
        }
        let mut stored = [0; 3];
        assert!(position.store(&[1.0, 2e5, -f32::INFINITY], &mut stored));
        assert_eq!(stored, [16_384, i32::MIN, i32::MIN]);
        assert!(!Numbers::Bits.store(&[f32::INFINITY], &mut stored[..1]));
    }

    #[test]
    fn bounds_out_of_range_are_refused() {
        for (position, rotation) in
            [(Some(0.0), None), (Some(f64::NAN), None), (None, Some(1e-4)), (None, Some(-1.0))]
        {
            let error = Precision { position, rotation }.numbers().unwrap_err();
            assert!(error.to_string().contains("expected"), "{error}");
        }
    }
}
