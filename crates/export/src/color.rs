//! Colours: those of the scene, and one for each material that has none.

use rockfall::Kind;
use rockfall_math::trig;
use rockfall_scene::Color;

/// Colours of stone, clay, slate, sandstone, moss, metal, porphyry and copper: linear red, green and blue from 0 to 1.
const PALETTE: [[f32; 3]; 8] = [
    [0.33, 0.29, 0.24],
    [0.42, 0.16, 0.08],
    [0.14, 0.24, 0.34],
    [0.52, 0.40, 0.16],
    [0.17, 0.27, 0.13],
    [0.36, 0.37, 0.40],
    [0.27, 0.14, 0.27],
    [0.10, 0.30, 0.29],
];

/// What bodies that nobody moves fade to, halfway, so that they stand back behind those of the same material that move.
const GROUND: f32 = 0.6;

/// The colour of bodies of the material with index `material`, which has none of its own, that are moved by `kind`: linear red, green and blue from 0 to 1. Materials beyond the
/// eighth begin again with the first one's.
pub fn color(material: u32, kind: Kind) -> [f32; 3] {
    let color = PALETTE[material as usize % PALETTE.len()];
    if kind == Kind::Static { color.map(|x| 0.5 * (x + GROUND)) } else { color }
}

/// A colour of a scene: linear red, green and blue from 0 to 1 (IEC 61966-2-1).
pub fn linear(color: Color) -> [f32; 3] {
    color.map(|byte| {
        let x = f32::from(byte) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { trig::pow((x + 0.055) / 1.055, 2.4) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_of_srgb() {
        for (byte, expected) in
            [(0, 0.0), (10, 0.003_035_3), (128, 0.215_860_5), (188, 0.502_886_5), (255, 1.0)]
        {
            let found = linear([byte; 3])[1];
            assert!((found - expected).abs() < 1e-6, "{byte}: {found}");
        }
    }
}
