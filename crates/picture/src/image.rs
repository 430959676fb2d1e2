//! A picture as light, before it is made fit for a screen.

use rockfall_math::Vec3;

/// Light in each pixel, row by row from the top, and how far away it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear red, green and blue with the primaries of sRGB, not negative; 1 is a white wall in full sun, about.
    pub light: Vec<[f32; 3]>,
    /// Distance from the eye, metres; infinite where there is sky.
    pub depth: Vec<f32>,
}

impl Image {
    /// Adds the light of another one of the same size; depths are the nearest.
    pub(crate) fn add(&mut self, other: &Image) {
        for (sum, light) in self.light.iter_mut().zip(&other.light) {
            *sum = (Vec3::from_array(*sum) + Vec3::from_array(*light)).to_array();
        }
        for (depth, other) in self.depth.iter_mut().zip(&other.depth) {
            if *other < *depth {
                *depth = *other;
            }
        }
    }
}
