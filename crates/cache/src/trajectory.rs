//! `trajectory.zarr`: the pose of every body at every frame, as a Zarr v3 group.
//!
//! | array | type | shape | what |
//! |---|---|---|---|
//! | `position` | float32 | frame, body, 3 | metres from the group's attribute `origin` |
//! | `orientation` | float32 | frame, body, 4 | unit quaternion x, y, z, w, body to world |
//! | `time` | float64 | frame | simulated seconds |
//! | `id` | uint64 | body | stable id, ascending |
//! | `name` | string | body | empty where a body has none |
//! | `shape` | uint32 | body | index of the shape, the scale included |
//! | `scale` | float32 | body | factor between the shape that the scene describes and the body's |
//!
//! A body that is not in the world at a frame is NaN there. The arrays grow with the run, and `time` grows last: its
//! length is the number of frames that are complete, whatever happened to the program. Every file is written whole
//! and then moved into place.
//!
//! The format was chosen so that NumPy, xarray and any other reader of Zarr open it without a line of ours. A chunk
//! is one frame of up to 65,536 bodies, because playback wants a moment; where bodies are few it holds several
//! frames, because a file costs the same for ten bodies as for ten thousand. Compression is zstd at its fastest
//! level: poses of moving bodies hardly compress, those of absent bodies vanish.

use crate::store::WholeFiles;
use crate::{BodyTable, Error, Poses, RunReader};
use rockfall_math::DVec3;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::sync::Arc;
use zarrs::array::builder::ArrayBuilderFillValue;
use zarrs::array::codec::{BytesCodec, ZstdCodec};
use zarrs::array::{Array, ArrayBuilder, ArrayMetadataOptions, DataType, Element, data_type};
use zarrs::group::GroupBuilder;
use zarrs::metadata::ChunkKeySeparator;

/// The version of this layout, the group's attribute `rockfall_trajectory`.
pub const LAYOUT: u64 = 1;

/// Bodies in a chunk, at most.
pub const CHUNK_BODIES: usize = 65_536;

/// A chunk holds as many frames as stay below this number of poses, at least one.
const CHUNK_POSES: usize = 16_384;

/// Frames in a chunk, at most.
const CHUNK_FRAMES: usize = 256;

/// Frames in a chunk of `time`; a multiple of any power of two up to [`CHUNK_FRAMES`].
const CHUNK_TIMES: usize = 1024;

/// zstd's fastest ordinary level.
const LEVEL: i32 = 1;

/// Writes a trajectory frame by frame.
#[derive(Debug)]
pub struct TrajectoryWriter {
    store: Arc<WholeFiles>,
    bodies: usize,
    /// Bodies in a chunk: the bodies shared out evenly, so that little of the last chunk is padding.
    chunk: usize,
    /// Frames in a chunk, a power of two; one where the bodies take several chunks.
    span: usize,
    position: Array<WholeFiles>,
    orientation: Array<WholeFiles>,
    time: Array<WholeFiles>,
    /// The chunks that are not full yet.
    positions: Vec<f32>,
    orientations: Vec<f32>,
    times: Vec<f64>,
    /// Frames that were appended.
    frames: u64,
    /// Frames that are in the store.
    stored: u64,
}

impl TrajectoryWriter {
    /// Starts a trajectory in the folder `path`, which exists and is empty.
    ///
    /// # Errors
    /// [`Error::Io`] names the file that could not be written.
    pub fn create(path: &Path, table: &BodyTable, origin: DVec3, rate: f64) -> Result<Self, Error> {
        let store = Arc::new(WholeFiles::new(path.to_owned()));
        let bodies = table.len();
        let chunk = bodies_in_chunk(bodies);
        let group = attributes([
            ("rockfall_trajectory", json!(LAYOUT)),
            ("origin", json!(origin.to_array())),
            ("up", json!("z")),
            ("handedness", json!("right")),
            ("frames_per_second", json!(rate)),
        ]);
        let built = GroupBuilder::new().attributes(group).build(store.clone(), "/");
        built
            .map_err(|error| store.explain(error))?
            .store_metadata()
            .map_err(|error| store.explain(error))?;

        let body =
            Layout { store: &store, shape: vec![bodies as u64], chunk: vec![chunk as u64], names: &["body"] };
        body.write("id", data_type::uint64(), 0u64, "stable id of the body", &table.ids)?;
        body.write("name", data_type::string(), "", "name of the body, empty without", &table.names)?;
        body.write(
            "shape",
            data_type::uint32(),
            0u32,
            "index of the body's shape; bodies of another scale have another one",
            &table.shapes,
        )?;
        body.write(
            "scale",
            data_type::float32(),
            f32::NAN,
            "factor between the shape that the scene describes and the body's",
            &table.scales,
        )?;

        let writer = Self::empty(store, bodies, origin)?;
        for array in [&writer.position, &writer.orientation, &writer.time] {
            array.store_metadata().map_err(|error| writer.store.explain(error))?;
        }
        Ok(writer)
    }

    /// Goes on with the trajectory in the folder `path`, which `reader` reads and which has at least `frames` frames. Those are as they
    /// were, what is behind them is dropped.
    ///
    /// # Errors
    /// [`Error::Damaged`], before anything is touched; [`Error::Io`].
    pub(crate) fn resume(
        path: &Path,
        table: &BodyTable,
        reader: &RunReader,
        frames: u64,
    ) -> Result<Self, Error> {
        let store = Arc::new(WholeFiles::new(path.to_owned()));
        let mut writer = Self::empty(store, table.len(), reader.origin()?)?;
        // Chunks that are not full have to be written anew.
        let first = frames - 1 - (frames - 1) % writer.span as u64;
        let times = reader.times()?;
        let times = times.get(..frames as usize).unwrap_or(&times);
        let full = first - first % CHUNK_TIMES as u64;
        writer.frames = first;
        let (before, behind) = times[full as usize..].split_at((first - full) as usize);
        writer.times[..before.len()].copy_from_slice(before);
        // None of these fills a chunk but the last one.
        for (frame, &time) in (first..).zip(behind) {
            let poses = reader.poses(frame)?;
            if poses.positions.len() != 3 * writer.bodies || poses.orientations.len() != 4 * writer.bodies {
                return Err(Error::damaged(path, format!("frame {frame} has another number of bodies")));
            }
            writer.put(time, &poses);
        }
        // First no more frames are said to be there than will be.
        writer.time.set_shape(vec![frames]).map_err(|error| writer.store.explain(error))?;
        writer.time.store_metadata().map_err(|error| writer.store.explain(error))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Without frames; nothing of it is in the store.
    fn empty(store: Arc<WholeFiles>, bodies: usize, origin: DVec3) -> Result<Self, Error> {
        let (chunk, span) = (bodies_in_chunk(bodies), frames_in_chunk(bodies));
        let moving = |last: usize, names| Layout {
            store: &store,
            shape: vec![0, bodies as u64, last as u64],
            chunk: vec![span as u64, chunk as u64, last as u64],
            names,
        };
        let position = moving(3, &["frame", "body", "xyz"]).build(
            "position",
            data_type::float32(),
            f32::NAN,
            attributes([
                ("units", json!("m")),
                ("axes", json!(["x", "y", "z"])),
                ("origin", json!(origin.to_array())),
            ]),
        )?;
        let orientation = moving(4, &["frame", "body", "xyzw"]).build(
            "orientation",
            data_type::float32(),
            f32::NAN,
            attributes([
                ("units", json!("1")),
                ("axes", json!(["x", "y", "z", "w"])),
                ("description", json!("unit quaternion, body to world")),
            ]),
        )?;
        let time =
            Layout { store: &store, shape: vec![0], chunk: vec![CHUNK_TIMES as u64], names: &["frame"] }
                .build(
                    "time",
                    data_type::float64(),
                    f64::NAN,
                    attributes([("units", json!("s")), ("description", json!("simulated seconds"))]),
                )?;
        Ok(TrajectoryWriter {
            store,
            bodies,
            chunk,
            span,
            position,
            orientation,
            time,
            positions: vec![f32::NAN; span * bodies * 3],
            orientations: vec![f32::NAN; span * bodies * 4],
            times: vec![f64::NAN; CHUNK_TIMES],
            frames: 0,
            stored: 0,
        })
    }

    /// Frames in the store.
    pub fn stored(&self) -> u64 {
        self.stored
    }

    /// Adds a frame; `poses` has a row for each body of the table. It is in the store as soon as its chunk is full,
    /// or after [`TrajectoryWriter::flush`].
    ///
    /// # Errors
    /// [`Error::Io`] names the file that could not be written. The frames before stay readable.
    pub fn append(&mut self, time: f64, poses: &Poses) -> Result<(), Error> {
        self.put(time, poses);
        if self.frames.is_multiple_of(self.span as u64) { self.flush() } else { Ok(()) }
    }

    /// Puts a frame into the chunks that are not full yet.
    fn put(&mut self, time: f64, poses: &Poses) {
        let slot = (self.frames % self.span as u64) as usize;
        if slot == 0 {
            self.positions.fill(f32::NAN);
            self.orientations.fill(f32::NAN);
        }
        self.positions[slot * 3 * self.bodies..][..3 * self.bodies].copy_from_slice(&poses.positions);
        self.orientations[slot * 4 * self.bodies..][..4 * self.bodies].copy_from_slice(&poses.orientations);
        let time_slot = (self.frames % CHUNK_TIMES as u64) as usize;
        if time_slot == 0 {
            self.times.fill(f64::NAN);
        }
        self.times[time_slot] = time;
        self.frames += 1;
    }

    /// Puts all frames into the store, and hands it to the disk.
    ///
    /// # Errors
    /// As [`TrajectoryWriter::append`].
    pub fn sync(&mut self) -> Result<(), Error> {
        self.flush()?;
        self.store.sync()
    }

    /// Puts all frames into the store.
    ///
    /// # Errors
    /// As [`TrajectoryWriter::append`].
    pub fn flush(&mut self) -> Result<(), Error> {
        if self.stored == self.frames {
            return Ok(());
        }
        let (store, frames, bodies) = (&self.store, self.frames, self.bodies as u64);
        for (array, shape) in [
            (&mut self.position, vec![frames, bodies, 3]),
            (&mut self.orientation, vec![frames, bodies, 4]),
            (&mut self.time, vec![frames]),
        ] {
            array.set_shape(shape).map_err(|error| store.explain(error))?;
        }
        let index = (frames - 1) / self.span as u64;
        for (array, values) in [(&self.position, &self.positions), (&self.orientation, &self.orientations)] {
            let width = array.shape()[2] as usize;
            store_chunks(array, store, index, self.span * self.chunk * width, values)?;
        }
        let index = (frames - 1) / CHUNK_TIMES as u64;
        self.time.store_chunk(&[index], &self.times[..]).map_err(|error| store.explain(error))?;
        // What is there may be seen; `time` says so last.
        for array in [&self.position, &self.orientation, &self.time] {
            array.store_metadata().map_err(|error| store.explain(error))?;
        }
        self.stored = frames;
        Ok(())
    }
}

/// The bodies shared out evenly among chunks.
fn bodies_in_chunk(bodies: usize) -> usize {
    bodies.div_ceil(bodies.div_ceil(CHUNK_BODIES).max(1)).max(1)
}

/// A power of two, so that no chunk of poses straddles two chunks of times.
fn frames_in_chunk(bodies: usize) -> usize {
    let fit = (CHUNK_POSES / bodies.max(1)).clamp(1, CHUNK_FRAMES);
    1 << fit.ilog2()
}

/// Stores `values`, one or more chunks of `size` values side by side along the bodies; the last one is padded.
fn store_chunks(
    array: &Array<WholeFiles>,
    store: &WholeFiles,
    index: u64,
    size: usize,
    values: &[f32],
) -> Result<(), Error> {
    for (column, part) in values.chunks(size).enumerate() {
        let at = [index, column as u64, 0];
        let stored = if part.len() == size {
            array.store_chunk(&at, part)
        } else {
            let mut padded = part.to_vec();
            padded.resize(size, f32::NAN);
            array.store_chunk(&at, padded)
        };
        stored.map_err(|error| store.explain(error))?;
    }
    Ok(())
}

fn attributes<const N: usize>(entries: [(&str, Value); N]) -> Map<String, Value> {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// How an array lies in the store.
struct Layout<'a> {
    store: &'a Arc<WholeFiles>,
    shape: Vec<u64>,
    chunk: Vec<u64>,
    names: &'a [&'static str],
}

impl Layout<'_> {
    fn build(
        &self,
        name: &str,
        data_type: DataType,
        fill: impl Into<ArrayBuilderFillValue>,
        attributes: Map<String, Value>,
    ) -> Result<Array<WholeFiles>, Error> {
        let text = data_type == data_type::string();
        let mut builder = ArrayBuilder::new(self.shape.clone(), self.chunk.clone(), data_type, fill);
        if !text {
            // The same bytes from every machine.
            builder.array_to_bytes_codec(Arc::new(BytesCodec::little()));
        }
        let array = builder
            // One folder per array instead of one per chunk.
            .chunk_key_encoding_default_separator(ChunkKeySeparator::Dot)
            .bytes_to_bytes_codecs(vec![Arc::new(ZstdCodec::new(LEVEL, true))])
            .dimension_names(Some(self.names.iter().copied()))
            .attributes(attributes)
            .build(self.store.clone(), &format!("/{name}"))
            .map_err(|error| self.store.explain(error))?
            .with_metadata_options(ArrayMetadataOptions::default().with_include_zarrs_metadata(false));
        Ok(array)
    }

    /// Creates an array of one value per body and fills it.
    fn write<T: Element + Clone + Default>(
        &self,
        name: &str,
        data_type: DataType,
        fill: impl Into<ArrayBuilderFillValue>,
        description: &str,
        values: &[T],
    ) -> Result<(), Error> {
        let attributes = attributes([("description", json!(description))]);
        let array = self.build(name, data_type, fill, attributes)?;
        array.store_metadata().map_err(|error| self.store.explain(error))?;
        let chunk = self.chunk[0] as usize;
        for (index, part) in values.chunks(chunk).enumerate() {
            let mut part = part.to_vec();
            part.resize(chunk, T::default());
            array.store_chunk(&[index as u64], &part[..]).map_err(|error| self.store.explain(error))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_bodies_share_a_chunk_and_many_do_not() {
        assert_eq!(frames_in_chunk(0), 256);
        assert_eq!(frames_in_chunk(10), 256);
        assert_eq!(frames_in_chunk(1000), 16);
        assert_eq!(frames_in_chunk(16_384), 1);
        assert_eq!(frames_in_chunk(1_000_000), 1);
        assert_eq!(CHUNK_TIMES % CHUNK_FRAMES, 0);
    }
}
