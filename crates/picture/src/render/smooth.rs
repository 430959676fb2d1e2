//! What neighbours on one surface saw, put together.

use super::bands::Step;
use super::{Pass, SAME, Seen, Spot};
use rockfall_math::lanes::Lanes;

/// Weights of the pixels across that looked: a block of the sky's pattern, and one of the sun's, wherever it begins.
const SKY: [f32; 5] = [0.5, 1.0, 1.0, 1.0, 0.5];
const SUN: [f32; 5] = [0.0, 0.5, 1.0, 0.5, 0.0];

/// The mean over the pixels around each that show its surface and looked for themselves.
pub(super) struct Smooth<'a> {
    pub(super) pass: &'a Pass<'a>,
    pub(super) spots: &'a [Spot],
    pub(super) raw: &'a [Seen],
}

impl Step for Smooth<'_> {
    type Out = Seen;
    type Tile = ();

    #[inline(always)]
    fn tile<L: Lanes>(&self, _: L::Token, _: [u32; 2], _: [u32; 2]) {}

    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::Token, (): &(), x: u32, y: u32) -> Seen {
        let Smooth { pass, spots, raw } = self;
        let here = pass.index(x, y);
        let spot = &spots[here];
        if spot.is_sky() {
            return raw[here];
        }
        let stride = pass.stride;
        let near = 2.5 * stride as f32 * pass.frame.pixel as f32 * spot.t;
        let (mut sun, mut suns, mut sky, mut skies) = (0.0, 0.0, 0.0, 0.0);
        for (dy, row) in (-2..).zip(0..5) {
            let Some(py) =
                (y / stride).checked_add_signed(dy).map(|y| y * stride).filter(|&y| y < pass.height)
            else {
                continue;
            };
            for (dx, column) in (-2..).zip(0..5) {
                let px = (x / stride).checked_add_signed(dx).map(|x| x * stride);
                let Some(px) = px.filter(|&x| x < pass.width) else { continue };
                let index = pass.index(px, py);
                let there = &spots[index];
                if there.is_sky() || there.normal.dot(spot.normal) < SAME {
                    continue;
                }
                // Along a surface that is seen from the side, pixels are far apart; off its plane they are not.
                if (there.place - spot.place).dot(spot.normal).abs() > near {
                    continue;
                }
                let [of_sun, of_sky] = [SUN[row] * SUN[column], SKY[row] * SKY[column]];
                sun += of_sun * raw[index].sun;
                suns += of_sun;
                sky += of_sky * raw[index].sky;
                skies += of_sky;
            }
        }
        // The pixel itself is among them where it looked. Where none did, on something small, it looks now.
        if suns == 0.0 {
            pass.look::<L>(token, spot, x, y)
        } else {
            Seen { sun: sun / suns, sky: sky / skies }
        }
    }
}
