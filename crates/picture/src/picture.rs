//! A picture as a screen shows it, and its files.

use crate::{Error, Image};
use rockfall_math::hash::combine;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Pixels in sRGB, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A hash of size and pixels.
    pub fn hash(&self) -> u64 {
        let size = u64::from(self.width) << 32 | u64::from(self.height);
        let word = |[r, g, b]: &[u8; 3]| u64::from(u32::from_le_bytes([*r, *g, *b, 0]));
        self.pixels.iter().map(word).fold(size, combine)
    }

    /// Writes it as PNG.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let failed = |reason: String| Error::Write { path: path.to_owned(), reason };
        let file = File::create(path).map_err(|error| failed(error.to_string()))?;
        self.encode(BufWriter::new(file)).map_err(|error| failed(error.to_string()))
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// [`Error::Write`] for a picture without pixels.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let failed =
            |error: png::EncodingError| Error::Write { path: "a picture".into(), reason: error.to_string() };
        self.encode(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }

    fn encode(&self, to: impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(to, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()
    }
}

impl Image {
    /// Writes its light and depth as OpenEXR, for those who composite: channels R, G, B and Z, the depth in metres.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write_exr(&self, path: &Path) -> Result<(), Error> {
        use exr::prelude::{
            AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, SmallVec, WritableImage,
        };
        let (width, height) = (self.width as usize, self.height as usize);
        let channel = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
        let of = |k: usize| self.light.iter().map(|light| light[k]).collect();
        let channels = AnyChannels::sort(SmallVec::from_vec(vec![
            channel("R", of(0)),
            channel("G", of(1)),
            channel("B", of(2)),
            channel("Z", self.depth.clone()),
        ]));
        let layer =
            Layer::new((width, height), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
        let written = exr::image::Image::from_layer(layer).write().to_file(path);
        written.map_err(|error| Error::Write { path: path.to_owned(), reason: error.to_string() })
    }
}
