//! `trajectory.zarr`: the pose of every body at every frame, as a Zarr v3 group.
//!
//! | array | type | shape | what |
//! |---|---|---|---|
//! | `position` | float32, or int32 in steps | frame, body, 3 | metres from the group's attribute `origin` |
//! | `orientation` | float32, or int16 in steps | frame, body, 4 | unit quaternion x, y, z, w, body to world |
//! | `velocity` | float32 | frame, body, 3 | metres per second; on request |
//! | `angular_velocity` | float32 | frame, body, 3 | radians per second; on request |
//! | `time` | float64 | frame | simulated seconds |
//! | `hash` | uint64 | frame | hash of the state |
//! | `id` | uint64 | body | stable id, ascending |
//! | `name` | string | body | empty where a body has none |
//! | `shape` | uint32 | body | index of the shape, the scale included |
//! | `scale` | float32 | body | factor between the shape that the scene describes and the body's |
//! | `contacts`, `events` | groups | | what touches, and who begins to; on request (`contacts.rs`, `events.rs`) |
//! | any other name | | frame, body | a column of the program's own (`columns.rs`) |
//!
//! A body that is not in the world at a frame is NaN there. The arrays grow with the run, and `time` grows last: its
//! length is the number of frames that are complete, whatever happened to the program. Every file is written whole
//! and then moved into place; a chunk that has room for more frames is written anew when they have come.
//!
//! The format was chosen so that NumPy, xarray and any other reader of Zarr open it without a line of ours. How the numbers of the first
//! four lie in their chunks is told in `moving.rs`, and how they stay within a bound in `precision.rs`.

use crate::extras::{self, Extras};
use crate::moving::{Coder, Moving};
use crate::precision::Numbers;
use crate::store::WholeFiles;
use crate::{BodyTable, Column, Error, Frame, Precision, RunReader, WantedContacts, WantedEvents};
use rayon::ThreadPool;
use rayon::prelude::*;
use rockfall_math::DVec3;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::sync::Arc;
use zarrs::array::builder::ArrayBuilderFillValue;
use zarrs::array::codec::{BytesCodec, ZstdCodec};
use zarrs::array::{Array, ArrayBuilder, ArrayMetadataOptions, CodecOptions, DataType, Element, data_type};
use zarrs::group::GroupBuilder;
use zarrs::metadata::ChunkKeySeparator;

/// The version of this layout, the group's attribute `rockfall_trajectory`.
pub const LAYOUT: u64 = 2;

/// Values in a chunk of the arrays that have one for each body.
pub(crate) const CHUNK_BODIES: usize = 65_536;

/// Frames in a chunk of `time` and `hash`; a multiple of any number of frames in a chunk of poses.
pub(crate) const CHUNK_TIMES: usize = 1024;

/// Numbers that a thread stores at once; fewer are not worth waking it.
const PART: usize = 1 << 16;

/// A longer scene is left out of the attributes, which every reader has to go through; it is in `scene.toml` in any case.
const SCENE_BYTES: usize = 1 << 20;

/// zstd's fastest ordinary level.
const LEVEL: i32 = 1;

/// What a trajectory holds of each body at each frame, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Where positions start from, metres.
    pub origin: DVec3,
    /// How far poses may be off.
    pub precision: Precision,
    /// Whether there are velocities.
    pub velocities: bool,
    /// Which contacts there are.
    pub contacts: Option<WantedContacts>,
    /// Which events there are.
    pub events: Option<WantedEvents>,
    /// Columns of the program's own.
    pub columns: Vec<Column>,
    /// The scene as it was run, for the attributes of the group.
    pub scene: String,
    /// The program and its version, for the same.
    pub rockfall: String,
}

/// Poses as they are, and nothing else.
impl From<DVec3> for Contents {
    fn from(origin: DVec3) -> Self {
        Contents { origin, ..Contents::default() }
    }
}

/// The arrays that have a value for each body at each frame, and the names of their last dimensions.
pub(crate) const MOVING: [(&str, &str); 4] =
    [("position", "xyz"), ("orientation", "xyzw"), ("velocity", "xyz"), ("angular_velocity", "xyz")];

/// One of them, with the chunks that are not full yet.
#[derive(Debug)]
struct Track {
    array: Moving,
    attributes: Map<String, Value>,
    /// Frame by frame.
    values: Vec<i32>,
    /// What the last chunk of each column was, where nobody in it moved.
    calm: Vec<Option<Calm>>,
}

/// A chunk in which nobody moves. The next one is the same, byte for byte, as long as that stays so: a pile at rest need not be compressed.
#[derive(Debug)]
struct Calm {
    /// The numbers of any of its frames.
    frame: Vec<i32>,
    bytes: Vec<u8>,
}

/// Writes a trajectory frame by frame.
#[derive(Debug)]
pub struct TrajectoryWriter {
    store: Arc<WholeFiles>,
    /// Those of [`MOVING`] that there are: two or four.
    tracks: Vec<Track>,
    /// Frames in a chunk.
    span: usize,
    /// Those who encode, where it is not the thread that writes.
    threads: Option<Arc<ThreadPool>>,
    /// One for each thread.
    coders: Vec<Coder>,
    extras: Extras,
    time: Array<WholeFiles>,
    hash: Array<WholeFiles>,
    /// The chunks that are not full yet.
    times: Vec<f64>,
    hashes: Vec<u64>,
    /// Frames that were appended.
    frames: u64,
    /// Frames that are in the store.
    stored: u64,
    /// Poses that were too far away.
    too_far: u64,
}

impl TrajectoryWriter {
    /// Starts a trajectory in the folder `path`, which exists and is empty.
    ///
    /// # Errors
    /// [`Error::Precision`], [`Error::Column`]; [`Error::Io`] names the file that could not be written.
    pub fn create(path: &Path, table: &BodyTable, contents: &Contents, rate: f64) -> Result<Self, Error> {
        let (position, rotation) = contents.precision.numbers()?;
        contents.check()?;
        let store = Arc::new(WholeFiles::new(path.to_owned()));
        let bodies = table.len();
        let mut group = attributes([
            ("rockfall_trajectory", json!(LAYOUT)),
            ("rockfall", json!(contents.rockfall)),
            ("origin", json!(contents.origin.to_array())),
            ("up", json!("z")),
            ("handedness", json!("right")),
            ("frames_per_second", json!(rate)),
            ("position_error_m", json!(contents.precision.position)),
            ("rotation_error_rad", json!(contents.precision.rotation)),
            ("velocities", json!(contents.velocities)),
            ("scene", json!(Some(&contents.scene).filter(|text| text.len() <= SCENE_BYTES))),
        ]);
        group.extend(extras::about(contents).map(|(name, value)| (name.to_owned(), value)));
        let built = GroupBuilder::new().attributes(group).build(store.clone(), "/");
        built
            .map_err(|error| store.explain(error))?
            .store_metadata()
            .map_err(|error| store.explain(error))?;

        let chunk = bodies.clamp(1, CHUNK_BODIES) as u64;
        let body = Layout { store: &store, shape: vec![bodies as u64], chunk: vec![chunk], names: &["body"] };
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

        let numbers = [position, rotation, Numbers::Bits, Numbers::Bits];
        let there = if contents.velocities { 4 } else { 2 };
        let arrays = MOVING.iter().zip(numbers).take(there);
        let arrays =
            arrays.map(|(&(name, dimension), numbers)| Moving::new(name, dimension, numbers, bodies));
        let extras = Extras::create(contents, bodies, &store)?;
        let mut writer = Self::empty(store, arrays.collect(), contents.origin, extras)?;
        writer.announce()?;
        Ok(writer)
    }

    /// Goes on with the trajectory in the folder `path`, which `reader` reads and which has at least `frames` frames. Those are as they
    /// were, what is behind them is dropped.
    ///
    /// # Errors
    /// [`Error::Damaged`], before anything is touched; [`Error::Io`].
    pub(crate) fn resume(path: &Path, reader: &RunReader, frames: u64) -> Result<Self, Error> {
        let store = Arc::new(WholeFiles::new(path.to_owned()));
        let arrays = reader.arrays()?;
        let extras = Extras::resume(reader, path, arrays.first().map_or(0, |array| array.bodies), frames)?;
        let mut writer = Self::empty(store, arrays, reader.origin()?, extras)?;
        // Chunks that are not full have to be written anew. What is on disk goes back to it, number for number.
        let row = (frames - 1) / writer.span as u64;
        let kept = (frames - row * writer.span as u64) as usize;
        for track in &mut writer.tracks {
            let values = reader.row_of(&track.array, row)?;
            let kept = kept * track.array.bodies * track.array.width;
            track.values[..kept].copy_from_slice(&values[..kept]);
        }
        let full = (frames - 1) / CHUNK_TIMES as u64 * CHUNK_TIMES as u64;
        let (times, hashes) = (reader.times()?, reader.hashes()?);
        let lengths = [times.len(), hashes.len()];
        let (Some(times), Some(hashes)) =
            (times.get(full as usize..frames as usize), hashes.get(full as usize..frames as usize))
        else {
            return Err(Error::damaged(
                path,
                format!("its times and hashes are {lengths:?}, expected {frames}"),
            ));
        };
        writer.times[..times.len()].copy_from_slice(times);
        writer.hashes[..hashes.len()].copy_from_slice(hashes);
        writer.frames = frames;
        // First no more frames are said to be there than will be.
        writer.time.set_shape(vec![frames]).map_err(|error| writer.store.explain(error))?;
        writer.time.store_metadata().map_err(|error| writer.store.explain(error))?;
        writer.flush()?;
        Ok(writer)
    }

    /// Without frames; nothing of it is in the store.
    fn empty(
        store: Arc<WholeFiles>,
        arrays: Vec<Moving>,
        origin: DVec3,
        extras: Extras,
    ) -> Result<Self, Error> {
        let track = |array: Moving| Track {
            attributes: about(array.name, origin),
            values: vec![array.numbers.absent(); array.row()],
            calm: (0..array.columns()).map(|_| None).collect(),
            array,
        };
        let per_frame =
            || Layout { store: &store, shape: vec![0], chunk: vec![CHUNK_TIMES as u64], names: &["frame"] };
        let time = per_frame().build(
            "time",
            data_type::float64(),
            f64::NAN,
            attributes([("units", json!("s")), ("description", json!("simulated seconds"))]),
        )?;
        let hash = per_frame().build(
            "hash",
            data_type::uint64(),
            0u64,
            attributes([(
                "description",
                json!("hash of ids, poses and velocities of all bodies; 0 where it was not taken"),
            )]),
        )?;
        Ok(TrajectoryWriter {
            span: arrays.first().map_or(1, |array| array.span),
            tracks: arrays.into_iter().map(track).collect(),
            threads: None,
            coders: vec![Coder::new().map_err(|error| store.explain(error))?],
            extras,
            store,
            time,
            hash,
            times: vec![f64::NAN; CHUNK_TIMES],
            hashes: vec![0; CHUNK_TIMES],
            frames: 0,
            stored: 0,
            too_far: 0,
        })
    }

    /// From now on these threads encode, and the calling one only writes. The bytes are the same.
    ///
    /// # Errors
    /// [`Error::Damaged`] where there is no memory for them.
    pub fn encode_on(&mut self, threads: Arc<ThreadPool>) -> Result<(), Error> {
        let coders = (0..threads.current_num_threads()).map(|_| Coder::new());
        self.coders = coders.collect::<Result<_, _>>().map_err(|error| self.store.explain(error))?;
        self.threads = Some(threads);
        Ok(())
    }

    /// Frames in the store.
    pub fn stored(&self) -> u64 {
        self.stored
    }

    /// Poses that were farther from the origin than the steps of their bound reach, and are stored as those of absent bodies.
    pub fn too_far(&self) -> u64 {
        self.too_far
    }

    /// Adds a frame, which has a row for each body of the table. It is in the store as soon as its chunk is full,
    /// or after [`TrajectoryWriter::flush`].
    ///
    /// # Errors
    /// [`Error::Io`] names the file that could not be written. The frames before stay readable.
    pub fn append(&mut self, frame: &Frame) -> Result<(), Error> {
        let slot = (self.frames % self.span as u64) as usize;
        let sources = [
            &frame.poses.positions,
            &frame.poses.orientations,
            &frame.velocities.linear,
            &frame.velocities.angular,
        ];
        let mut too_large = false;
        for (track, source) in self.tracks.iter_mut().zip(sources) {
            let absent = track.array.numbers.absent();
            if slot == 0 {
                track.values.fill(absent);
            }
            let size = track.array.bodies * track.array.width;
            // Where there is nothing to be had all are absent, as they are already.
            let (numbers, values) = (track.array.numbers, &mut track.values[slot * size..][..size]);
            too_large |= match &self.threads {
                Some(threads) if size > PART => threads.install(|| {
                    let parts = values.par_chunks_mut(PART).zip(source.par_chunks(PART));
                    parts.map(|(to, from)| numbers.store(from, to)).reduce(|| false, |a, b| a | b)
                }),
                _ => numbers.store(source, values),
            };
        }
        if too_large {
            self.take_out_too_far(slot, &frame.poses.positions);
        }
        self.extras.append(frame, &self.store)?;
        let time_slot = (self.frames % CHUNK_TIMES as u64) as usize;
        if time_slot == 0 {
            self.times.fill(f64::NAN);
            self.hashes.fill(0);
        }
        self.times[time_slot] = frame.time;
        self.hashes[time_slot] = frame.hash.unwrap_or_default();
        self.frames += 1;
        if self.frames.is_multiple_of(self.span as u64) { self.flush() } else { Ok(()) }
    }

    /// A body of which a number could not be stored is absent from the frame altogether.
    fn take_out_too_far(&mut self, slot: usize, positions: &[f32]) {
        for (body, position) in positions.as_chunks::<3>().0.iter().enumerate() {
            let at = |array: &Moving| {
                let row = slot * array.bodies + body;
                row * array.width..(row + 1) * array.width
            };
            let lacks =
                |track: &Track| track.values[at(&track.array)].contains(&track.array.numbers.absent());
            if !position[0].is_nan() && self.tracks.iter().take(2).any(lacks) {
                self.too_far += 1;
                for track in &mut self.tracks {
                    let at = at(&track.array);
                    track.values[at].fill(track.array.numbers.absent());
                }
            }
        }
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
        let (store, frames) = (&self.store, self.frames);
        let row = (frames - 1) / self.span as u64;
        let tracks = &mut self.tracks;
        let chunks: Vec<(usize, usize)> = (0..tracks.len())
            .flat_map(|track| (0..tracks[track].array.columns()).map(move |column| (track, column)))
            .collect();
        // As many at a time as there are threads: no more than that waits in memory for the disk.
        for chunks in chunks.chunks(self.coders.len()) {
            // Nothing where the chunk is the one before.
            let encode = |(coder, &(track, column)): (&mut Coder, &(usize, usize))| {
                let Track { array, values, calm, .. } = &tracks[track];
                let frame = array.calm(values, column);
                if calm[column].as_ref().is_some_and(|before| frame == Some(&before.frame[..])) {
                    return Ok(None);
                }
                let frame = frame.map(<[i32]>::to_vec);
                array.encode(values, column, coder).map(|bytes| Some((frame, bytes)))
            };
            let coders = &mut self.coders;
            let encoded: Vec<_> = match &self.threads {
                Some(threads) => threads.install(|| coders.par_iter_mut().zip(chunks).map(encode).collect()),
                None => coders.iter_mut().zip(chunks).map(encode).collect(),
            };
            for (&(track, column), new) in chunks.iter().zip(encoded) {
                let Track { array, calm, .. } = &mut tracks[track];
                let key = array.key(row, column);
                match new.map_err(|error| store.explain(error))? {
                    Some((frame, bytes)) => {
                        store.put(&key, &bytes)?;
                        calm[column] = frame.map(|frame| Calm { frame, bytes });
                    }
                    None => calm[column].iter().try_for_each(|before| store.put(&key, &before.bytes))?,
                }
            }
        }
        self.extras.flush(store)?;
        let index = [(frames - 1) / CHUNK_TIMES as u64];
        let whole = every_chunk();
        self.time.store_chunk_opt(&index, &self.times[..], &whole).map_err(|error| store.explain(error))?;
        self.hash.store_chunk_opt(&index, &self.hashes[..], &whole).map_err(|error| store.explain(error))?;
        for array in [&mut self.time, &mut self.hash] {
            array.set_shape(vec![frames]).map_err(|error| store.explain(error))?;
        }
        self.announce()?;
        self.stored = frames;
        Ok(())
    }

    /// What is there may be seen; `time` says so last.
    fn announce(&mut self) -> Result<(), Error> {
        for Track { array, attributes, .. } in &self.tracks {
            let metadata = array.metadata(self.frames, attributes).to_string();
            self.store.put(&format!("{}/zarr.json", array.name), metadata.as_bytes())?;
        }
        self.extras.announce(&self.store)?;
        for array in [&self.hash, &self.time] {
            array.store_metadata().map_err(|error| self.store.explain(error))?;
        }
        Ok(())
    }
}

/// The attributes of an array of [`MOVING`].
fn about(name: &str, origin: DVec3) -> Map<String, Value> {
    let xyz = json!(["x", "y", "z"]);
    match name {
        "position" => {
            attributes([("units", json!("m")), ("axes", xyz), ("origin", json!(origin.to_array()))])
        }
        "orientation" => attributes([
            ("units", json!("1")),
            ("axes", json!(["x", "y", "z", "w"])),
            ("description", json!("unit quaternion, body to world")),
        ]),
        "velocity" => attributes([
            ("units", json!("m s-1")),
            ("axes", xyz),
            ("description", json!("of the body's centre of mass")),
        ]),
        _ => attributes([("units", json!("rad s-1")), ("axes", xyz)]),
    }
}

/// Chunks of nothing but fill values are written as well: so one that is not there was lost.
pub(crate) fn every_chunk() -> CodecOptions {
    CodecOptions::default().with_store_empty_chunks(true)
}

pub(crate) fn attributes<const N: usize>(entries: [(&str, Value); N]) -> Map<String, Value> {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// How an array lies in the store.
pub(crate) struct Layout<'a> {
    pub(crate) store: &'a Arc<WholeFiles>,
    pub(crate) shape: Vec<u64>,
    pub(crate) chunk: Vec<u64>,
    pub(crate) names: &'a [&'static str],
}

impl Layout<'_> {
    pub(crate) fn build(
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
        let about = attributes([("description", json!(description))]);
        self.write_whole(name, data_type, fill, about, values)
    }

    /// Creates an array whose first dimension alone is in chunks, and fills it.
    pub(crate) fn write_whole<T: Element + Clone + Default>(
        &self,
        name: &str,
        data_type: DataType,
        fill: impl Into<ArrayBuilderFillValue>,
        attributes: Map<String, Value>,
        values: &[T],
    ) -> Result<(), Error> {
        let array = self.build(name, data_type, fill, attributes)?;
        array.store_metadata().map_err(|error| self.store.explain(error))?;
        let chunk = self.chunk.iter().product::<u64>() as usize;
        let mut index = vec![0; self.chunk.len()];
        for (row, part) in (0..).zip(values.chunks(chunk)) {
            let mut part = part.to_vec();
            part.resize(chunk, T::default());
            index[0] = row;
            let stored = array.store_chunk_opt(&index, &part[..], &every_chunk());
            stored.map_err(|error| self.store.explain(error))?;
        }
        Ok(())
    }
}
