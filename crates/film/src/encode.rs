//! Pictures as AV1, by `rav1e`.

use crate::color::planes;
use crate::{Effort, Format, TICKS};
use rav1e::color::{
    ChromaSamplePosition, ColorDescription, ColorPrimaries, MatrixCoefficients, PixelRange,
    TransferCharacteristics,
};
use rav1e::data::Rational;
use rav1e::prelude::{ChromaSampling, SceneDetectionSpeed, Tune};
use rav1e::{Config, Context, EncoderConfig, EncoderStatus};

/// Where levels end (AV1 specification, A.3): 31 says that there is no bound.
const ENDLESS: u8 = 31;

/// Pixels of a tile, about. Tiles are encoded beside each other, and each knows a little less of the others; their number must not depend on threads.
const TILE: u32 = 640 * 360;

/// The encoder.
pub(crate) struct Encoder {
    context: Context<u8>,
    width: usize,
    pub(crate) level: u8,
}

/// A picture in the stream.
pub(crate) struct Sample {
    pub(crate) data: Vec<u8>,
    /// Whether it stands by itself.
    pub(crate) key: bool,
}

impl Effort {
    /// The speed of `rav1e`, from 0 to 10, and the base of its quantizer, from 0 to 255.
    fn speed(self) -> (u8, usize) {
        match self {
            Effort::Draft => (10, 150),
            Effort::Standard => (9, 100),
            Effort::Fine => (6, 60),
        }
    }
}

impl Encoder {
    /// # Errors
    /// What the encoder says of a format that it can't encode.
    pub(crate) fn new(format: &Format) -> Result<Self, String> {
        let (speed, quantizer) = format.effort.speed();
        let mut config = EncoderConfig::with_speed_preset(speed);
        // Pictures that stand by themselves come by the clock.
        config.speed_settings.scene_detection_mode = SceneDetectionSpeed::None;
        // The filter that takes off ringing is a quarter of the work of a draft.
        config.speed_settings.cdef &= format.effort != Effort::Draft;
        config.set_key_frame_interval(format.group(), format.group());
        (config.width, config.height) = (format.width as usize, format.height as usize);
        config.time_base = Rational::new(TICKS.into(), format.timescale().into());
        config.chroma_sampling = ChromaSampling::Cs420;
        config.chroma_sample_position = ChromaSamplePosition::Vertical;
        config.pixel_range = PixelRange::Limited;
        config.color_description = Some(ColorDescription {
            color_primaries: ColorPrimaries::BT709,
            transfer_characteristics: TransferCharacteristics::SRGB,
            matrix_coefficients: MatrixCoefficients::BT709,
        });
        // One picture in is one picture out, in the same order.
        config.low_latency = true;
        config.tune = Tune::Psnr;
        config.quantizer = quantizer;
        config.tiles = ((format.width * format.height).div_ceil(TILE) as usize).min(16);
        // The lowest level that allows such pictures so fast.
        let of_level = |level: u8| {
            let config = EncoderConfig { level_idx: Some(level), ..config.clone() };
            let config = Config::new().with_encoder_config(config).with_threads(format.threads);
            config.validate().map(|()| (level, config))
        };
        let allowed = (0..ENDLESS).find_map(|level| of_level(level).ok());
        let (level, config) =
            allowed.map_or_else(|| of_level(ENDLESS), Ok).map_err(|error| error.to_string())?;
        let context = config.new_context().map_err(|error| error.to_string())?;
        Ok(Encoder { context, width: format.width as usize, level })
    }

    /// Takes the next picture; `None` says that there are no more. Gives what is ready to `out`.
    ///
    /// # Errors
    /// What the encoder says.
    pub(crate) fn push<E: From<String>>(
        &mut self,
        pixels: Option<&[[u8; 3]]>,
        mut out: impl FnMut(Sample) -> Result<(), E>,
    ) -> Result<(), E> {
        let said = |status: EncoderStatus| E::from(status.to_string());
        match pixels {
            Some(pixels) => {
                let planes = planes(pixels, self.width);
                let mut frame = self.context.new_frame();
                let sides = [
                    (&planes.luma, self.width),
                    (&planes.blue, self.width / 2),
                    (&planes.red, self.width / 2),
                ];
                for (plane, (from, stride)) in frame.planes.iter_mut().zip(sides) {
                    plane.copy_from_raw_u8(from, stride, 1);
                }
                self.context.send_frame(frame).map_err(said)?;
            }
            None => self.context.flush(),
        }
        loop {
            match self.context.receive_packet() {
                Ok(packet) => out(Sample { key: packet.frame_type.all_intra(), data: packet.data })?,
                Err(EncoderStatus::Encoded) => {}
                Err(EncoderStatus::NeedMoreData | EncoderStatus::LimitReached) => return Ok(()),
                Err(status) => return Err(said(status)),
            }
        }
    }
}
