//! Colours, since a scene has none: one for each material.

use rockfall::Kind;

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

/// The colour of bodies of the material with index `material` that are moved by `kind`: linear red, green and blue from 0 to 1. Materials beyond the
/// eighth begin again with the first one's.
pub fn color(material: u32, kind: Kind) -> [f32; 3] {
    let color = PALETTE[material as usize % PALETTE.len()];
    if kind == Kind::Static { color.map(|x| 0.5 * (x + GROUND)) } else { color }
}
