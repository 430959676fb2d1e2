//! Reading a run.

use crate::group::Group;
use crate::moving::Moving;
use crate::precision::Numbers;
use crate::trajectory::{LAYOUT, MOVING};
use crate::{
    BodyTable, CHECKPOINTS, Error, FRAMES, Poses, Precision, SCENE, START, STATE, SUMMARY, State, Summary,
    TRAJECTORY, Velocities,
};
use rockfall_math::DVec3;
use serde_json::{Map, Value};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};
use zarrs::array::ElementOwned;

/// A run on disk, finished or not.
#[derive(Debug)]
pub struct RunReader {
    path: PathBuf,
    summary: Summary,
    trajectory: Group,
    /// The attributes of the trajectory, once they were read.
    attributes: OnceLock<Map<String, Value>>,
    /// What was read last: the frames that follow are most often those that are wanted next.
    last: Mutex<Option<Row>>,
}

/// The frames of a row of chunks.
#[derive(Debug)]
struct Row {
    /// Its number.
    index: u64,
    /// Frames that there were in the run when it was read: a run that goes on adds to its last row.
    frames: u64,
    /// What the arrays look like, and their numbers, frame by frame.
    arrays: Vec<(Moving, Vec<i32>)>,
}

/// A part of a run on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name in the run's folder.
    pub name: &'static str,
    /// Bytes of its files.
    pub bytes: u64,
    /// Number of its files.
    pub files: u64,
}

impl RunReader {
    /// Whether the folder `path` has the summary of a run, readable or not.
    pub fn is_run(path: &Path) -> bool {
        path.join(SUMMARY).is_file()
    }

    /// Opens a run; poses are read when asked for.
    ///
    /// # Errors
    /// [`Error::NotARun`], and those of [`Summary::read`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        if !Self::is_run(path) {
            return Err(Error::NotARun { path: path.to_owned(), missing: SUMMARY });
        }
        let summary = Summary::read(&path.join(SUMMARY))?;
        let trajectory = path.join(TRAJECTORY);
        if !trajectory.is_dir() {
            return Err(Error::NotARun { path: path.to_owned(), missing: TRAJECTORY });
        }
        Ok(RunReader {
            path: path.to_owned(),
            summary,
            trajectory: Group::open(&trajectory)?,
            attributes: OnceLock::new(),
            last: Mutex::default(),
        })
    }

    /// What the run says of itself. Of a run that was killed this is what was known at its start.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Complete frames in the trajectory, the start included.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn frames(&self) -> Result<u64, Error> {
        let array = self.trajectory.array("time")?;
        array.shape().first().copied().ok_or_else(|| self.damaged("time", "it has no length"))
    }

    /// Simulated time of each complete frame, seconds.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn times(&self) -> Result<Vec<f64>, Error> {
        self.all("time")
    }

    /// Where positions start from, metres.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn origin(&self) -> Result<DVec3, Error> {
        let origin = self.attributes()?.get("origin").cloned().unwrap_or_default();
        let [x, y, z] = serde_json::from_value(origin).map_err(|error| self.damaged("zarr.json", error))?;
        Ok(DVec3::new(x, y, z))
    }

    /// How far the poses may be from those of the simulation.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn precision(&self) -> Result<Precision, Error> {
        let attributes = self.attributes()?;
        let bound = |name: &str| attributes.get(name).and_then(Value::as_f64);
        Ok(Precision { position: bound("position_error_m"), rotation: bound("rotation_error_rad") })
    }

    /// Hash of the state at each complete frame, the start included; 0 where it was not taken. None in runs of versions that did not write
    /// them here.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn hashes(&self) -> Result<Vec<u64>, Error> {
        if self.layout()? == 1 {
            return Ok(Vec::new());
        }
        let (frames, mut hashes) = (self.frames()?, self.all("hash")?);
        // In a run that goes on they may be ahead.
        hashes.truncate(usize::try_from(frames).unwrap_or(usize::MAX));
        Ok(hashes)
    }

    /// The bodies.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn bodies(&self) -> Result<BodyTable, Error> {
        let table = BodyTable {
            ids: self.all("id")?,
            names: self.all("name")?,
            shapes: self.all("shape")?,
            scales: self.all("scale")?,
        };
        let n = table.len();
        if [table.names.len(), table.shapes.len(), table.scales.len()] != [n; 3] {
            return Err(self.damaged("id", "the arrays of the bodies differ in length"));
        }
        Ok(table)
    }

    /// The poses of one frame, 0 being the start. Reading frames in their order costs least: several share their files, and those
    /// of the last call are kept.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn poses(&self, frame: u64) -> Result<Poses, Error> {
        if self.layout()? == 1 {
            self.has(frame)?;
            let read = |name| self.poses_of_layout_1(name, frame);
            return Ok(Poses { positions: read("position")?, orientations: read("orientation")? });
        }
        let [positions, orientations] = self.at(frame, ["position", "orientation"])?;
        Ok(Poses { positions, orientations })
    }

    /// The velocities of one frame; `None` where the run has none.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn velocities(&self, frame: u64) -> Result<Option<Velocities>, Error> {
        self.has(frame)?;
        if !self.has_velocities()? {
            return Ok(None);
        }
        let [linear, angular] = self.at(frame, ["velocity", "angular_velocity"])?;
        Ok(Some(Velocities { linear, angular }))
    }

    /// The state at the end of the run, to the bit; `None` in a run that did not end, and in those of versions that did not write it.
    ///
    /// # Errors
    /// [`Error::Damaged`], [`Error::Version`].
    pub fn end(&self) -> Result<Option<State>, Error> {
        let path = self.path.join(STATE);
        let Some(state) = State::read(&path)? else { return Ok(None) };
        match self.hashes()?.get(state.frame as usize) {
            Some(&hash) if hash != 0 && hash != state.hash => Err(Error::damaged(
                &path,
                format!("it has another hash than frame {} of the run", state.frame),
            )),
            _ => Ok(Some(state)),
        }
    }

    /// The poses of one body at all complete frames; `row` is that of the table. Of many bodies it reads a small part of
    /// the files.
    ///
    /// # Errors
    /// [`Error::NoBody`], [`Error::Damaged`].
    pub fn history(&self, row: usize) -> Result<Poses, Error> {
        let frames = self.frames()?;
        let mut history = Poses::default();
        if self.layout()? == 1 {
            for frame in 0..frames {
                let poses = self.poses(frame)?;
                let one = |values: &[f32], width: usize| {
                    values.get(row * width..(row + 1) * width).map(<[f32]>::to_vec).ok_or(Error::NoBody(row))
                };
                history.positions.extend(one(&poses.positions, 3)?);
                history.orientations.extend(one(&poses.orientations, 4)?);
            }
            return Ok(history);
        }
        let arrays = self.arrays()?;
        for (array, values) in arrays.iter().zip([&mut history.positions, &mut history.orientations]) {
            if row >= array.bodies {
                return Err(Error::NoBody(row));
            }
            let column = row / array.chunk;
            let bodies = array.of_column(column);
            // Its column alone, as if there were no other.
            let part = Moving { bodies: bodies.len(), ..array.clone() };
            let mut chunk = vec![0; part.row()];
            for index in 0..frames.div_ceil(array.span as u64) {
                self.chunk(&array.key(index, column), &part, 0, &mut chunk)?;
                let there = (frames - index * array.span as u64).min(array.span as u64) as usize;
                for frame in 0..there {
                    let at = (frame * part.bodies + row - bodies.start) * array.width;
                    values
                        .extend(chunk[at..at + array.width].iter().map(|&stored| array.numbers.read(stored)));
                }
            }
            if array.name == "orientation" {
                unit(array, values);
            }
        }
        Ok(history)
    }

    /// The parts of the run and their sizes; a part that is missing has no files. Checkpoints, the state at the end and what the run began with are
    /// parts only where there are any.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn parts(&self) -> Result<Vec<Part>, Error> {
        let size = |name| {
            let (bytes, files) = size_of(&self.path.join(name))?;
            Ok(Part { name, bytes, files })
        };
        let parts = [SCENE, START, SUMMARY, FRAMES, TRAJECTORY, STATE, CHECKPOINTS].into_iter().map(size);
        let may_lack = [START, STATE, CHECKPOINTS];
        parts
            .filter(|part| !part.as_ref().is_ok_and(|part| may_lack.contains(&part.name) && part.files == 0))
            .collect()
    }

    /// The trajectory.
    pub(crate) fn group(&self) -> &Group {
        &self.trajectory
    }

    /// Its folder.
    pub(crate) fn folder(&self) -> PathBuf {
        self.path.join(TRAJECTORY)
    }

    /// Bodies in it.
    pub(crate) fn body_count(&self) -> Result<usize, Error> {
        Ok(self.all::<u64>("id")?.len())
    }

    /// Numbers of two arrays at one frame.
    fn at(&self, frame: u64, names: [&str; 2]) -> Result<[Vec<f32>; 2], Error> {
        let frames = self.has(frame)?;
        // Nobody panics while it is held; and what it guards is whole at any time.
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = |row: &Row| {
            row.arrays.first().is_some_and(|(array, _)| row.index == frame / array.span as u64)
                && frame < row.frames
        };
        if !last.as_ref().is_some_and(fresh) {
            *last = None;
            let mut arrays = Vec::new();
            let mut index = 0;
            for array in self.arrays()? {
                index = frame / array.span as u64;
                let values = self.row_of(&array, index)?;
                arrays.push((array, values));
            }
            *last = Some(Row { index, frames, arrays });
        }
        let arrays = last.as_ref().map_or(&[][..], |row| &row.arrays);
        let numbers = |name: &str| {
            let found = arrays.iter().find(|(array, _)| array.name == name);
            let (array, values) = found.ok_or_else(|| self.damaged(name, "it is missing"))?;
            let size = array.bodies * array.width;
            let start = (frame % array.span as u64) as usize * size;
            let mut read: Vec<f32> =
                values[start..start + size].iter().map(|&stored| array.numbers.read(stored)).collect();
            if name == "orientation" {
                unit(array, &mut read);
            }
            Ok(read)
        };
        Ok([numbers(names[0])?, numbers(names[1])?])
    }

    /// The arrays of poses and, where there are, of velocities. They have the same bodies and the same frames in a chunk.
    pub(crate) fn arrays(&self) -> Result<Vec<Moving>, Error> {
        let mut arrays: Vec<Moving> = Vec::new();
        let there = if self.has_velocities()? { 4 } else { 2 };
        for (name, dimension) in MOVING.into_iter().take(there) {
            let metadata = self.trajectory.metadata(&format!("{name}/zarr.json"))?;
            let (array, _) =
                Moving::of(name, dimension, &metadata).map_err(|reason| self.damaged(name, reason))?;
            let alike = |first: &Moving| {
                (first.bodies, first.span, first.chunk) == (array.bodies, array.span, array.chunk)
            };
            if !arrays.first().is_none_or(alike) {
                return Err(self.damaged(name, "it has not the chunks of the positions"));
            }
            arrays.push(array);
        }
        Ok(arrays)
    }

    /// The numbers of a row of chunks, frame by frame.
    pub(crate) fn row_of(&self, array: &Moving, row: u64) -> Result<Vec<i32>, Error> {
        let mut values = vec![0; array.row()];
        for column in 0..array.columns() {
            self.chunk(&array.key(row, column), array, column, &mut values)?;
        }
        Ok(values)
    }

    /// Reads a chunk, which is in a column of `array`, into the `values` of a row of its chunks.
    fn chunk(&self, key: &str, array: &Moving, column: usize, values: &mut [i32]) -> Result<(), Error> {
        let path = self.path.join(TRAJECTORY).join(key);
        // The writer leaves out no chunk, so one that is not there was lost.
        let bytes = fs::read(&path).map_err(|error| Error::damaged(&path, error))?;
        array.decode(&bytes, column, values).map_err(|error| Error::damaged(&path, error))
    }

    /// Whether there are velocities beside the poses.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn has_velocities(&self) -> Result<bool, Error> {
        Ok(self.attributes()?.get("velocities").and_then(Value::as_bool).unwrap_or(false))
    }

    /// Fails where the run has no such frame; returns how many it has.
    fn has(&self, frame: u64) -> Result<u64, Error> {
        let frames = self.frames()?;
        if frame < frames { Ok(frames) } else { Err(Error::NoFrame { frame, frames }) }
    }

    fn poses_of_layout_1(&self, name: &str, frame: u64) -> Result<Vec<f32>, Error> {
        let array = self.trajectory.array(name)?;
        let [_, bodies, width] = *array.shape() else {
            return Err(self.damaged(name, "it has not three dimensions"));
        };
        array
            .retrieve_array_subset::<Vec<f32>>(&[frame..frame + 1, 0..bodies, 0..width])
            .map_err(|error| self.damaged(name, error))
    }

    /// The version of the trajectory's layout, which this program knows.
    fn layout(&self) -> Result<u64, Error> {
        let layout = self.attributes()?.get("rockfall_trajectory").and_then(Value::as_u64);
        let layout = layout.ok_or_else(|| self.damaged("zarr.json", "it has no version"))?;
        if (1..=LAYOUT).contains(&layout) {
            return Ok(layout);
        }
        Err(self.damaged("zarr.json", format!("it has layout {layout}, this program reads up to {LAYOUT}")))
    }

    /// The attributes of the group, which never change.
    pub(crate) fn attributes(&self) -> Result<&Map<String, Value>, Error> {
        if let Some(attributes) = self.attributes.get() {
            return Ok(attributes);
        }
        let attributes = self.trajectory.attributes()?;
        Ok(self.attributes.get_or_init(|| attributes))
    }

    fn all<T: ElementOwned>(&self, name: &str) -> Result<Vec<T>, Error> {
        // Older versions left out chunks of nothing but fill values.
        if self.layout()? > 1 { self.trajectory.whole(name) } else { self.trajectory.all(name) }
    }

    fn damaged(&self, name: &str, reason: impl ToString) -> Error {
        self.trajectory.damaged(name, reason)
    }
}

/// Quaternions in steps have length 1 to a step only.
fn unit(array: &Moving, quaternions: &mut [f32]) {
    if array.numbers == Numbers::Bits {
        return;
    }
    for q in quaternions.as_chunks_mut::<4>().0 {
        let length = q.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        *q = q.map(|x| (f64::from(x) / length) as f32);
    }
}

/// Bytes and number of the files at and below `path`. Files that a run which goes on replaces meanwhile don't count.
fn size_of(path: &Path) -> Result<(u64, u64), Error> {
    let Ok(metadata) = fs::symlink_metadata(path) else { return Ok((0, 0)) };
    if !metadata.is_dir() {
        return Ok((metadata.len(), 1));
    }
    let mut sum = (0, 0);
    for entry in fs::read_dir(path).map_err(|error| Error::io("read", path, &error))? {
        let entry = entry.map_err(|error| Error::io("read", path, &error))?;
        let (bytes, files) = size_of(&entry.path())?;
        sum = (sum.0 + bytes, sum.1 + files);
    }
    Ok(sum)
}
