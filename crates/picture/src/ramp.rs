//! Colours of numbers, and colours of things that have no order.

use rockfall_math::{Vec3, hash::mix};

/// From little to much: cool to warm, and from dark to light but for the end, so that it can be told from the shading. Linear red, green and blue at even
/// steps.
const RAMP: [Vec3; 7] = [
    Vec3::new(0.030, 0.055, 0.220),
    Vec3::new(0.015, 0.170, 0.440),
    Vec3::new(0.015, 0.370, 0.400),
    Vec3::new(0.170, 0.530, 0.170),
    Vec3::new(0.720, 0.600, 0.070),
    Vec3::new(0.800, 0.250, 0.030),
    Vec3::new(0.560, 0.035, 0.025),
];

/// Stones, linear: granite, sandstone, slate, clay, moss, chalk, ochre, basalt.
const STONES: [Vec3; 8] = [
    Vec3::new(0.40, 0.36, 0.31),
    Vec3::new(0.55, 0.39, 0.22),
    Vec3::new(0.20, 0.26, 0.33),
    Vec3::new(0.47, 0.19, 0.10),
    Vec3::new(0.23, 0.29, 0.15),
    Vec3::new(0.66, 0.62, 0.54),
    Vec3::new(0.58, 0.33, 0.08),
    Vec3::new(0.17, 0.16, 0.17),
];

/// What nobody moves.
pub(crate) const GROUND: Vec3 = Vec3::new(0.30, 0.285, 0.26);

/// What a colour mode has nothing to say of.
pub(crate) const MUTE: Vec3 = Vec3::new(0.34, 0.34, 0.35);

/// The colour of a number from 0 to 1.
pub fn ramp(x: f32) -> Vec3 {
    let at = x.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let k = (at as usize).min(RAMP.len() - 2);
    RAMP[k].lerp(RAMP[k + 1], at - k as f32)
}

/// A stone's colour for each number, no two quite alike.
pub fn stone(id: u64) -> Vec3 {
    let bits = mix(id ^ 0x5ee_2007);
    let share = |shift: u32| (bits >> shift & 0xffff) as f32 / 65535.0;
    // Most are as the first, some as any.
    let [a, b] = [bits & 7, bits >> 3 & 7].map(|k| STONES[k as usize]);
    let mixed = a.lerp(b, 0.5 * share(16));
    mixed * (0.72 + 0.56 * share(32))
}

/// A clear colour for each number: hues around the circle by the golden ratio, so that small numbers differ most.
pub fn hue(id: u64) -> Vec3 {
    let turn = (id.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1_u64 << 24) as f32;
    let part = |shift: f32| {
        let x = (turn + shift).fract() * 6.0;
        ((x - 3.0).abs() - 1.0).clamp(0.0, 1.0)
    };
    let pure = Vec3::new(part(0.0), part(2.0 / 3.0), part(1.0 / 3.0));
    Vec3::splat(0.06).lerp(pure * pure * 0.62 + Vec3::splat(0.03), 0.92)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_begins_and_ends_with_its_ends_and_no_number_is_its_beginning() {
        assert_eq!(ramp(-1.0), RAMP[0]);
        assert_eq!(ramp(2.0), RAMP[6]);
        assert!((ramp(0.5) - RAMP[3]).length() < 1e-6);
    }

    #[test]
    fn colours_of_a_thousand_ids_differ_and_are_colours() {
        for color in [stone as fn(u64) -> Vec3, hue] {
            let mut all: Vec<[u32; 3]> =
                (1..=1000).map(|id| color(id).to_array().map(f32::to_bits)).collect();
            all.sort_unstable();
            all.dedup();
            assert!(all.len() > 990, "{}", all.len());
            assert!(
                (1..=1000).all(|id| color(id).cmpge(Vec3::ZERO).all() && color(id).cmple(Vec3::ONE).all())
            );
        }
    }
}
