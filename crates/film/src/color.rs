//! From red, green and blue to what a codec keeps: brightness of each pixel, and two differences of colour for four of them.
//!
//! The matrix and the range are those of ITU-R BT.709-6 (8 bit, black at 16, white at 235). Values come in sRGB and keep its curve; the stream says so.

/// Black, and the steps from there to white.
const BLACK: f32 = 16.0;
const STEPS: f32 = 219.0;

/// The middle of a difference of colour, and its steps from end to end.
const MIDDLE: f32 = 128.0;
const SPREAD: f32 = 224.0;

/// Shares of red, green and blue in brightness.
const SHARES: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A picture in three planes, row by row; those of colour are half as wide and half as high.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planes {
    /// Brightness (Y), `width × height`.
    pub luma: Vec<u8>,
    /// Blue less brightness (Cb).
    pub blue: Vec<u8>,
    /// Red less brightness (Cr).
    pub red: Vec<u8>,
}

/// The planes of a picture in sRGB with an even number of pixels in a row and of rows. A sample of colour lies beside the left one of its pixels, in the
/// middle between two rows, as in most films.
pub fn planes(pixels: &[[u8; 3]], width: usize) -> Planes {
    let height = pixels.len().checked_div(width).unwrap_or(0);
    let brightness = |rgb: [f32; 3]| rgb[0] * SHARES[0] + rgb[1] * SHARES[1] + rgb[2] * SHARES[2];
    let luma = pixels.iter().map(|pixel| {
        let y = brightness(pixel.map(f32::from)) / 255.0;
        (BLACK + STEPS * y).round() as u8
    });
    let luma = luma.collect();
    let (columns, rows) = (width / 2, height / 2);
    let mut planes =
        Planes { luma, blue: Vec::with_capacity(columns * rows), red: Vec::with_capacity(columns * rows) };
    for row in 0..rows {
        // The two rows together, a value of four for a mean of one.
        let sum = |x: usize| {
            let [a, b] = [2 * row, 2 * row + 1].map(|y| pixels[y * width + x]);
            [0, 1, 2].map(|k| u32::from(a[k]) + u32::from(b[k]))
        };
        for column in 0..columns {
            let x = 2 * column;
            let [left, here, right] = [x.saturating_sub(1), x, x + 1].map(sum);
            let rgb = [0, 1, 2].map(|k| (left[k] + 2 * here[k] + right[k]) as f32 / (8.0 * 255.0));
            let y = brightness(rgb);
            let difference = |color: f32, share: f32| {
                (MIDDLE + SPREAD * (color - y) / (2.0 * (1.0 - share))).round() as u8
            };
            planes.blue.push(difference(rgb[2], SHARES[2]));
            planes.red.push(difference(rgb[0], SHARES[0]));
        }
    }
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours() {
        // ITU-R BT.709-6, 3.4 and 3.5: bars of 100 %, 8 bit.
        for (rgb, expected) in [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
            ([255, 255, 0], [219, 16, 138]),
        ] {
            let planes = planes(&[rgb; 8], 4);
            assert_eq!([planes.luma[5], planes.blue[1], planes.red[1]], expected, "{rgb:?}");
            assert_eq!((planes.luma.len(), planes.blue.len()), (8, 2));
        }
    }

    #[test]
    fn colours_lie_beside_the_left_pixel() {
        // A red column at x = 2 colours the sample there by half, and the one beside it not at all; one at x = 3 both by a quarter.
        let red_at = |column: usize| {
            let pixels: Vec<[u8; 3]> = (0..12).map(|k| [u8::from(k % 6 == column) * 255, 0, 0]).collect();
            planes(&pixels, 6).red
        };
        assert_eq!(red_at(2), [128, 184, 128]);
        assert_eq!(red_at(3), [128, 156, 156]);
    }
}
