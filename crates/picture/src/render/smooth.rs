//! What neighbours on one surface saw, put together.

use super::{Pass, SAME, Seen, Spot};

/// Weights of the pixels across: a block of the sky's pattern, and one of the sun's, wherever it begins.
const SKY: [f32; 5] = [0.5, 1.0, 1.0, 1.0, 0.5];
const SUN: [f32; 5] = [0.0, 0.5, 1.0, 0.5, 0.0];

/// The mean over the pixels around (x, y) that show its surface.
pub(super) fn smooth(pass: &Pass<'_>, spots: &[Spot], raw: &[Seen], x: u32, y: u32) -> Seen {
    let here = pass.index(x, y);
    let spot = &spots[here];
    if spot.is_sky() {
        return raw[here];
    }
    let direction = pass.middle(x, y);
    let (place, normal) = (spot.t * direction, spot.normal.as_dvec3());
    let near = 2.5 * pass.frame.pixel * spot.t;
    let (mut sun, mut suns, mut sky, mut skies) = (0.0, 0.0, 0.0, 0.0);
    for (dy, row) in (-2..).zip(0..5) {
        for (dx, column) in (-2..).zip(0..5) {
            let Some((px, py)) = pass.beside(x, y, dx, dy) else { continue };
            let index = pass.index(px, py);
            let there = &spots[index];
            if there.is_sky() || there.normal.dot(spot.normal) < SAME {
                continue;
            }
            // Along a surface that is seen from the side, pixels are far apart; off its plane they are not.
            if (there.t * pass.middle(px, py) - place).dot(normal).abs() > near {
                continue;
            }
            let [of_sun, of_sky] = [SUN[row] * SUN[column], SKY[row] * SKY[column]];
            sun += of_sun * raw[index].sun;
            suns += of_sun;
            sky += of_sky * raw[index].sky;
            skies += of_sky;
        }
    }
    // The pixel itself is among them.
    Seen { sun: sun / suns, sky: sky / skies }
}
