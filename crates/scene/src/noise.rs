//! Gradient noise and its octaves: the ups and downs of terrain, the same on every machine.

use rockfall_math::hash;

/// Smooth noise over the plane: zero at the integer points, within about ±0.8, no feature larger than about two units.
/// Lattice gradients of unit length, fifth-degree fade (Perlin, "Improving noise", SIGGRAPH 2002).
pub(crate) fn gradient_noise(seed: u64, x: f64, y: f64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let (u, v) = (x - i, y - j);
    let (i, j) = (i as i64, j as i64);
    let corner = |di: i64, dj: i64| {
        let (gx, gy) = gradient(seed, i + di, j + dj);
        gx * (u - di as f64) + gy * (v - dj as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let (s, t) = (fade(u), fade(v));
    mix(mix(corner(0, 0), corner(1, 0), s), mix(corner(0, 1), corner(1, 1), s), t)
}

fn gradient(seed: u64, i: i64, j: i64) -> (f64, f64) {
    let bits = hash::combine(hash::combine(seed, i as u64), j as u64);
    let angle = (bits >> 11) as f64 * (std::f64::consts::TAU / (1u64 << 53) as f64);
    let (sin, cos) = libm::sincos(angle);
    (cos, sin)
}

/// A sum of octaves, each of half the wavelength and `roughness` times the height of the one before (fractional
/// Brownian motion), divided by the sum of the heights.
pub(crate) fn octaves(seed: u64, x: f64, y: f64, count: u64, roughness: f64) -> f64 {
    let (mut sum, mut total, mut height, mut rate) = (0.0, 0.0, 1.0, 1.0);
    for octave in 0..count {
        // Shifted, so that the zeros of the octaves don't meet at the lattice points.
        let shift = 0.37 * octave as f64;
        sum += height * gradient_noise(seed.wrapping_add(octave), x * rate + shift, y * rate + shift);
        total += height;
        height *= roughness;
        rate *= 2.0;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_zero_on_the_lattice_smooth_between_and_bounded() {
        for i in 0..200 {
            let x = f64::from(i) * 0.173;
            assert_eq!(gradient_noise(5, f64::from(i), 3.0), 0.0);
            let (a, b) = (gradient_noise(5, x, 1.7), gradient_noise(5, x + 1e-4, 1.7));
            assert!((a - b).abs() < 1e-3 && a.abs() < 1.0);
        }
    }

    #[test]
    fn noise_is_not_flat_and_depends_on_the_seed() {
        let values = |seed| (0..64).map(move |i| octaves(seed, f64::from(i) * 0.31, 0.5, 6, 0.5));
        let spread = values(1).fold(f64::MIN, f64::max) - values(1).fold(f64::MAX, f64::min);
        assert!(spread > 0.3);
        assert!(values(1).ne(values(2)));
    }
}
