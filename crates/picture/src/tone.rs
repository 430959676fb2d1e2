//! From light to what a screen shows.

use crate::{Image, Picture};
use rayon::prelude::*;
use rockfall_math::trig;

/// Light is multiplied by this first.
const EXPOSURE: f32 = 0.45;

/// Steps of the table from linear to sRGB: fine enough that dark colours are off by no more than half of one of 255 steps.
const STEPS: usize = 1 << 13;

/// The curve of film: bright light runs out slowly, shadows keep some contrast. Narkowicz's fit of the curve of ACES ("ACES filmic tone mapping
/// curve", 2015).
pub fn curve(x: f32) -> f32 {
    let x = x.max(0.0);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// A linear value from 0 to 1 as sRGB from 0 to 255 (IEC 61966-2-1).
pub fn encode(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * trig::pow(x, 1.0 / 2.4) - 0.055 }
}

/// The picture that a screen shows.
pub fn tone(image: &Image) -> Picture {
    let table: Vec<u8> = (0..=STEPS).map(|k| encode(k as f32 / STEPS as f32).round() as u8).collect();
    let byte = |light: f32| {
        let light = curve(EXPOSURE * light);
        // No number is black.
        table[((light * STEPS as f32 + 0.5) as usize).min(STEPS)]
    };
    let pixels = image.light.par_iter().map(|light| light.map(byte)).collect();
    Picture { width: image.width, height: image.height, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_of_srgb() {
        for (linear, expected) in
            [(0.0, 0.0), (0.001, 3.2946), (0.2158605, 128.0), (0.5, 187.516), (1.0, 255.0)]
        {
            assert!((encode(linear) - expected).abs() < 0.01, "{linear}: {}", encode(linear));
        }
    }

    #[test]
    fn more_light_is_never_darker_and_all_of_it_fits() {
        let values: Vec<f32> = (0..2000).map(|k| curve(0.01 * k as f32)).collect();
        assert!(values.is_sorted() && values[0] == 0.0 && values[1999] <= 1.0);
        let dark = Image { width: 2, height: 1, light: vec![[f32::NAN; 3], [1e9; 3]], depth: vec![1.0; 2] };
        assert_eq!(tone(&dark).pixels, [[0; 3], [255; 3]]);
    }
}
