//! Something of each pixel: beside each other in bands of rows, and in each band tile by tile, so that beams that are near each other come one after the other.

use crate::view::LANES;
use rayon::prelude::*;
use rockfall_math::lanes::{Kernel, Lanes, Width};

/// Rows of a band, and columns of a tile.
const ROWS: usize = 8;
const COLUMNS: usize = 16;

/// What is found out about a pixel.
pub(super) trait Step: Sync {
    /// What that is.
    type Out: Copy + Send + Sync;
    /// What is found out for all pixels of a tile at once.
    type Tile;
    /// That of the pixels from `low` up to `high`.
    fn tile<L: Lanes>(&self, token: L::Token, low: [u32; 2], high: [u32; 2]) -> Self::Tile;
    /// That of the pixel (x, y), in the tile.
    fn at<L: Lanes>(&self, token: L::Token, tile: &Self::Tile, x: u32, y: u32) -> Self::Out;
}

/// That of all pixels, row by row; `blank` is only there to have their room.
pub(super) fn each<S: Step>(width: u32, height: u32, blank: S::Out, step: &S) -> Vec<S::Out> {
    let width = width as usize;
    let mut all = vec![blank; width * height as usize];
    let lanes = Width::new(LANES);
    all.par_chunks_mut(ROWS * width).enumerate().for_each(|(number, out)| {
        lanes.run(Band { step, width, first: number * ROWS, out });
    });
    all
}

struct Band<'a, S: Step> {
    step: &'a S,
    width: usize,
    /// Its first row.
    first: usize,
    out: &'a mut [S::Out],
}

impl<S: Step> Kernel for Band<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) {
        // At no other width is it ever called, and need not be compiled.
        if L::WIDTH != LANES {
            return;
        }
        let rows = self.out.len() / self.width;
        for left in (0..self.width).step_by(COLUMNS) {
            let right = (left + COLUMNS).min(self.width);
            let low = [left, self.first].map(|x| x as u32);
            let high = [right, self.first + rows].map(|x| x as u32);
            let tile = self.step.tile::<L>(token, low, high);
            for row in 0..rows {
                for x in left..right {
                    let y = (self.first + row) as u32;
                    self.out[row * self.width + x] = self.step.at::<L>(token, &tile, x as u32, y);
                }
            }
        }
    }
}
