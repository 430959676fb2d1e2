//! Arrays that have a value for each body at each frame: what their chunks and their `zarr.json` look like.
//!
//! A chunk holds some frames of some bodies. Within it, the numbers of a body's frames lie side by side: what it did in a quarter of a second is
//! nearly the same from number to number, and the same where it rests. Four codecs that Zarr's readers know make few bytes of
//! that:
//!
//! | codec | what |
//! |---|---|
//! | `transpose` | frames last: x of body 0 at all frames, x of body 1, …, y of body 0, … |
//! | `numcodecs.delta` | of whole numbers, the difference to the number before |
//! | `numcodecs.shuffle` | first the lowest byte of all numbers, then the next one, … |
//! | `zstd` | at its fastest ordinary level, with a checksum |
//!
//! They are applied here in one pass, because the simulation waits for it: through `zarrs`, which lacks the second one, transposing and
//! shuffling are passes of their own, and slower than the compression.

use crate::precision::Numbers;
use serde_json::{Map, Value, json};
use std::fmt;
use std::io;
use std::ops::Range;
use zstd::bulk::{Compressor, Decompressor};
use zstd::zstd_safe::CParameter;

/// Poses in a chunk, about.
const CHUNK_POSES: usize = 131_072;
/// Frames in a chunk: this many where there are few bodies,
const MOST_FRAMES: usize = 256;
/// this many where there are many,
const FRAMES: usize = 16;
/// and this many where there are more than [`MANY`], whose frames take 28 bytes a body until their chunk is full.
const FEWEST_FRAMES: usize = 8;
/// A quarter of a million.
const MANY: usize = 1 << 18;

/// Frames that are turned over at once; it divides the frames of every chunk.
const STRIP: usize = 8;
/// Bodies whose numbers of eight frames, 8 KB at most, fit into the nearest cache,
const BLOCK: usize = 64;
/// with so many numbers each.
const MOST_WIDTH: usize = 4;

/// zstd's fastest ordinary level. Lower ones leave out the coding of single bytes, which does most of the work here, and with it kept on
/// they take as long.
pub(crate) const LEVEL: i32 = 1;

/// Binary logarithm of the entries of zstd's table of what it has met. One that fits into the nearest cache, with what is read and written, saves an eighth
/// of the time, and its frames are 1.5 % larger at most.
const TABLE: u32 = 11;

/// One array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moving {
    /// Its name in the group.
    pub(crate) name: &'static str,
    /// Numbers of a body at a frame, and the name of that dimension.
    pub(crate) width: usize,
    pub(crate) dimension: &'static str,
    pub(crate) numbers: Numbers,
    pub(crate) bodies: usize,
    /// Bodies in a chunk: shared out evenly, so that little of the last chunk is padding.
    pub(crate) chunk: usize,
    /// Frames in a chunk, a power of two from eight on.
    pub(crate) span: usize,
}

impl Moving {
    /// An array of so many bodies.
    pub(crate) fn new(name: &'static str, dimension: &'static str, numbers: Numbers, bodies: usize) -> Self {
        let span = frames_in_chunk(bodies);
        let chunks = bodies.div_ceil(CHUNK_POSES / span).max(1);
        let (width, chunk) = (dimension.len(), bodies.div_ceil(chunks).max(1));
        Moving { name, width, dimension, numbers, bodies, chunk, span }
    }

    /// What its `zarr.json` says when it has so many frames.
    pub(crate) fn metadata(&self, frames: u64, attributes: &Map<String, Value>) -> Value {
        let mut attributes = attributes.clone();
        // The conventions for climate and forecast, which readers of Zarr know, for numbers in steps.
        if let Numbers::Steps { step, absent } = self.numbers {
            attributes.insert("scale_factor".into(), step.into());
            attributes.insert("_FillValue".into(), absent.into());
        }
        let (data_type, fill_value, kind) = match self.numbers {
            Numbers::Bits => ("float32", json!("NaN"), None),
            Numbers::Steps { absent, .. } if self.bytes() == 2 => ("int16", json!(absent), Some("<i2")),
            Numbers::Steps { absent, .. } => ("int32", json!(absent), Some("<i4")),
        };
        let codec = |name: &str, configuration| json!({"name": name, "configuration": configuration});
        let delta = kind.map(|kind| codec("numcodecs.delta", json!({"dtype": kind, "astype": kind})));
        let before = [Some(codec("transpose", json!({"order": [2, 1, 0]}))), delta];
        let after = [
            codec("bytes", json!({"endian": "little"})),
            codec("numcodecs.shuffle", json!({"elementsize": self.bytes()})),
            codec("zstd", json!({"level": LEVEL, "checksum": true})),
        ];
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": [frames, self.bodies, self.width],
            "data_type": data_type,
            "chunk_grid": {
                "name": "regular",
                "configuration": {"chunk_shape": [self.span, self.chunk, self.width]},
            },
            // One folder per array instead of one per chunk.
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": fill_value,
            "codecs": before.into_iter().flatten().chain(after).collect::<Vec<Value>>(),
            "attributes": attributes,
            "dimension_names": ["frame", "body", self.dimension],
        })
    }

    /// The array whose `zarr.json` says this, and its number of frames. It is one that this version writes.
    pub(crate) fn of(
        name: &'static str,
        dimension: &'static str,
        metadata: &Value,
    ) -> Result<(Self, u64), String> {
        let number = |pointer: &str| {
            let number = metadata.pointer(pointer).and_then(Value::as_u64);
            number
                .and_then(|n| usize::try_from(n).ok())
                .ok_or_else(|| format!("{pointer} is missing or no size"))
        };
        let attribute = |name: &str| metadata.get("attributes").and_then(|all| all.get(name));
        let numbers = match attribute("scale_factor").map(Value::as_f64) {
            None => Numbers::Bits,
            Some(Some(step)) if step.is_normal() && step > 0.0 => Numbers::Steps {
                step,
                absent: if metadata["data_type"] == "int16" { i16::MIN.into() } else { i32::MIN },
            },
            Some(_) => return Err("its scale_factor is no positive number".into()),
        };
        let (span, chunk) = (
            number("/chunk_grid/configuration/chunk_shape/0")?,
            number("/chunk_grid/configuration/chunk_shape/1")?,
        );
        let (frames, bodies) = (number("/shape/0")? as u64, number("/shape/1")?);
        let found = Moving { name, width: dimension.len(), dimension, numbers, bodies, chunk, span };
        let sizes = chunk > 0
            && span.is_power_of_two()
            && span >= STRIP
            && span
                .checked_mul(chunk)
                .and_then(|size| size.checked_mul(4 * found.width))
                .is_some_and(|size| size < 1 << 31);
        let expected = found.metadata(frames, &Map::new());
        let differs =
            |(key, value): (&String, &Value)| key != "attributes" && metadata.get(key) != Some(value);
        match expected.as_object().and_then(|all| all.iter().find(|entry| differs(*entry))) {
            Some((key, _)) => Err(format!("its {key} is not what this program writes")),
            None if sizes => Ok((found, frames)),
            None => Err("its chunks have no size that there can be".into()),
        }
    }

    /// Bytes of a number.
    fn bytes(&self) -> usize {
        match self.numbers {
            Numbers::Steps { absent, .. } if absent == i32::from(i16::MIN) => 2,
            _ => 4,
        }
    }

    /// Numbers in all frames of a row of chunks.
    pub(crate) fn row(&self) -> usize {
        self.span * self.bodies * self.width
    }

    /// Chunks side by side.
    pub(crate) fn columns(&self) -> usize {
        self.bodies.div_ceil(self.chunk)
    }

    /// The file of a chunk within the group's folder.
    pub(crate) fn key(&self, row: u64, column: usize) -> String {
        format!("{}/c.{row}.{column}.0", self.name)
    }

    /// The bodies of a column.
    pub(crate) fn of_column(&self, column: usize) -> Range<usize> {
        (column * self.chunk).min(self.bodies)..((column + 1) * self.chunk).min(self.bodies)
    }

    /// The numbers of a column's bodies at any frame of `values`, those of a row of chunks, where they are the same at all of them.
    pub(crate) fn calm<'a>(&self, values: &'a [i32], column: usize) -> Option<&'a [i32]> {
        let bodies = self.of_column(column);
        let mut frames = values
            .chunks_exact((self.bodies * self.width).max(1))
            .map(|frame| &frame[bodies.start * self.width..bodies.end * self.width]);
        let first = frames.next()?;
        frames.all(|frame| frame == first).then_some(first)
    }

    /// The bytes of a chunk. `values` are those of a row of chunks, frame by frame.
    pub(crate) fn encode(&self, values: &[i32], column: usize, coder: &mut Coder) -> io::Result<Vec<u8>> {
        let numbers = self.span * self.chunk * self.width;
        // Every byte is written.
        coder.planes.resize(numbers * self.bytes(), 0);
        match self.bytes() {
            2 => self.shuffle::<2>(values, column, &mut coder.planes),
            _ => self.shuffle::<4>(values, column, &mut coder.planes),
        }
        coder.compressor.compress(&coder.planes)
    }

    /// The numbers of a few bodies, all axes, are copied into the nearest cache, and turned over there: from frame by frame to body by body.
    fn shuffle<const BYTES: usize>(&self, values: &[i32], column: usize, planes: &mut [u8]) {
        let delta = self.numbers != Numbers::Bits;
        let (bodies, width) = (self.of_column(column), self.width);
        let mut parts = planes.chunks_exact_mut(self.span * self.chunk * width);
        let mut planes: [&mut [u8]; BYTES] = std::array::from_fn(|_| parts.next().unwrap_or_default());
        let frames: Vec<&[i32]> = values.chunks_exact((self.bodies * width).max(1)).collect();
        let absent = self.numbers.absent();
        let value = |frame: usize, axis: usize, body: usize| {
            let body = bodies.start + body;
            if body < bodies.end { frames[frame][body * width + axis] } else { absent }
        };
        // Differences go on from body to body and from axis to axis.
        let before = |frame: usize, axis: usize, body: usize| match (frame, body, axis) {
            (0, 0, 0) => 0,
            (0, 0, _) => value(self.span - 1, axis - 1, self.chunk - 1),
            (0, ..) => value(self.span - 1, axis, body - 1),
            _ => value(frame - 1, axis, body),
        };
        let mut tile = [[absent; BLOCK * MOST_WIDTH]; STRIP];
        for first in (0..self.chunk).step_by(BLOCK) {
            let end = (first + BLOCK).min(self.chunk);
            // Bodies that fill up the last chunk are none.
            let [from, to] = [first, end].map(|body| (bodies.start + body).min(bodies.end) * width);
            for frame in (0..self.span).step_by(STRIP) {
                for (row, values) in tile.iter_mut().zip(&frames[frame..frame + STRIP]) {
                    let (there, none) = row.split_at_mut(to - from);
                    there.copy_from_slice(&values[from..to]);
                    none.fill(absent);
                }
                for axis in 0..width {
                    for body in first..end {
                        // The remainder changes nothing, and tells that it is within the row.
                        let at = ((body - first) * width + axis) % (BLOCK * MOST_WIDTH);
                        let strip: [i32; STRIP] = std::array::from_fn(|i| tile[i][at]);
                        let stored = if delta {
                            let before = before(frame, axis, body);
                            std::array::from_fn(|i| {
                                strip[i].wrapping_sub(if i == 0 { before } else { strip[i - 1] })
                            })
                        } else {
                            strip
                        };
                        let place = (axis * self.chunk + body) * self.span + frame;
                        for (byte, plane) in planes.iter_mut().enumerate() {
                            let bytes = stored.map(|number| (number >> (8 * byte)) as u8);
                            plane[place..place + STRIP].copy_from_slice(&bytes);
                        }
                    }
                }
            }
        }
    }

    /// Puts the numbers of a chunk where they are in the `values` of a row of chunks.
    pub(crate) fn decode(&self, bytes: &[u8], column: usize, values: &mut [i32]) -> io::Result<()> {
        let size = self.span * self.chunk * self.width * self.bytes();
        let planes = Decompressor::new()?.decompress(bytes, size)?;
        if planes.len() != size {
            return Err(io::Error::other(format!("it has {} bytes, and not {size}", planes.len())));
        }
        match self.bytes() {
            2 => self.unshuffle::<2>(&planes, column, values),
            _ => self.unshuffle::<4>(&planes, column, values),
        }
        Ok(())
    }

    fn unshuffle<const BYTES: usize>(&self, planes: &[u8], column: usize, values: &mut [i32]) {
        let stride = self.bodies * self.width;
        let delta = self.numbers != Numbers::Bits;
        let bodies = self.of_column(column);
        let mut parts = planes.chunks_exact(self.span * self.chunk * self.width);
        let planes: [&[u8]; BYTES] = std::array::from_fn(|_| parts.next().unwrap_or_default());
        let (mut before, mut at) = (0_i32, 0);
        for axis in 0..self.width {
            for body in bodies.start..bodies.start + self.chunk {
                for frame in 0..self.span {
                    let mut word = [0; 4];
                    for (byte, plane) in word.iter_mut().zip(planes) {
                        *byte = plane[at];
                    }
                    let stored = i32::from_le_bytes(word);
                    let value = if delta { before.wrapping_add(stored) } else { stored };
                    // The sign of two bytes fills the other two.
                    before = if BYTES == 2 { i32::from(value as i16) } else { value };
                    if body < bodies.end {
                        values[frame * stride + body * self.width + axis] = before;
                    }
                    at += 1;
                }
            }
        }
    }
}

/// What encoding needs room for.
pub(crate) struct Coder {
    compressor: Compressor<'static>,
    planes: Vec<u8>,
}

impl fmt::Debug for Coder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Coder").finish_non_exhaustive()
    }
}

impl Coder {
    pub(crate) fn new() -> io::Result<Self> {
        let mut compressor = Compressor::new(LEVEL)?;
        compressor.include_checksum(true)?;
        compressor.set_parameter(CParameter::HashLog(TABLE))?;
        Ok(Coder { compressor, planes: Vec::new() })
    }
}

/// A power of two, so that no chunk of poses straddles two chunks of times.
fn frames_in_chunk(bodies: usize) -> usize {
    let fewest = if bodies > MANY { FEWEST_FRAMES } else { FRAMES };
    1 << (CHUNK_POSES / bodies.max(1)).clamp(fewest, MOST_FRAMES).ilog2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precision;
    use rockfall_math::hash::mix;

    #[test]
    fn chunks_have_about_as_many_poses_whatever_the_number_of_bodies() {
        let shape = |bodies| {
            let array = Moving::new("position", "xyz", Numbers::Bits, bodies);
            (array.span, array.chunk, array.columns())
        };
        assert_eq!(shape(0), (256, 1, 0));
        assert_eq!(shape(10), (256, 10, 1));
        assert_eq!(shape(1000), (128, 1000, 1));
        assert_eq!(shape(20_000), (16, 6667, 3));
        assert_eq!(shape(100_000), (16, 7693, 13));
        assert_eq!(shape(1_000_000), (8, 16_130, 62));
    }

    /// Promise: what was encoded is decoded, and its `zarr.json` tells how.
    #[test]
    fn every_number_comes_back() {
        let precision = Precision { position: Some(1e-4), rotation: Some(1e-3) };
        let (steps, turns) = precision.numbers().unwrap();
        let mut coder = Coder::new().unwrap();
        for (numbers, dimension, small) in
            [(steps, "xyz", false), (turns, "xyzw", true), (Numbers::Bits, "xyz", false)]
        {
            let array = Moving {
                bodies: 1000,
                chunk: 300,
                span: 8,
                ..Moving::new("position", dimension, numbers, 1000)
            };
            let number = |i: u64| mix(i) as i32 >> (mix(i + 77) % 32);
            let values: Vec<i32> = (0..array.row() as u64)
                .map(|i| match i % 11 {
                    0 => numbers.absent(),
                    1 => !numbers.absent(),
                    _ if small => i32::from(number(i) as i16),
                    _ => number(i),
                })
                .collect();
            let mut back = vec![0; values.len()];
            for column in 0..array.columns() {
                let bytes = array.encode(&values, column, &mut coder).unwrap();
                array.decode(&bytes, column, &mut back).unwrap();
                let torn = array.decode(&bytes[..bytes.len() - 1], column, &mut vec![0; values.len()]);
                assert!(torn.is_err());
            }
            assert!(values == back);
            let metadata = array.metadata(12, &Map::new());
            assert_eq!(Moving::of("position", dimension, &metadata).unwrap(), (array.clone(), 12));
            let mut other = metadata.clone();
            other["codecs"][0]["configuration"]["order"] = json!([0, 1, 2]);
            assert_eq!(
                Moving::of("position", dimension, &other).unwrap_err(),
                "its codecs is not what this program writes"
            );
        }
    }
}
