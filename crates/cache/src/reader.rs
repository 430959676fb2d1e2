//! Reading a run.

use crate::{BodyTable, CHECKPOINTS, Error, FRAMES, Poses, SCENE, SUMMARY, Summary, TRAJECTORY};
use rockfall_math::DVec3;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::{Array, ElementOwned};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::Group;

/// A run on disk, finished or not.
#[derive(Debug)]
pub struct RunReader {
    path: PathBuf,
    summary: Summary,
    store: Arc<FilesystemStore>,
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
        let store = FilesystemStore::new(&trajectory).map_err(|error| Error::damaged(&trajectory, error))?;
        Ok(RunReader { path: path.to_owned(), summary, store: Arc::new(store) })
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
        let array = self.array("time")?;
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
        let group = Group::open(self.store.clone(), "/").map_err(|error| self.damaged("zarr.json", error))?;
        let origin = group.attributes().get("origin").cloned().unwrap_or_default();
        let [x, y, z] = serde_json::from_value(origin).map_err(|error| self.damaged("zarr.json", error))?;
        Ok(DVec3::new(x, y, z))
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

    /// The poses of one frame, 0 being the start.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn poses(&self, frame: u64) -> Result<Poses, Error> {
        let frames = self.frames()?;
        if frame >= frames {
            return Err(Error::NoFrame { frame, frames });
        }
        let read = |name| {
            let array = self.array(name)?;
            let [_, bodies, width] = *array.shape() else {
                return Err(self.damaged(name, "it has not three dimensions"));
            };
            array
                .retrieve_array_subset::<Vec<f32>>(&[frame..frame + 1, 0..bodies, 0..width])
                .map_err(|error| self.damaged(name, error))
        };
        Ok(Poses { positions: read("position")?, orientations: read("orientation")? })
    }

    /// The parts of the run and their sizes; a part that is missing has no files. Checkpoints are a part only where there are any.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn parts(&self) -> Result<Vec<Part>, Error> {
        let size = |name| {
            let (bytes, files) = size_of(&self.path.join(name))?;
            Ok(Part { name, bytes, files })
        };
        let parts = [SCENE, SUMMARY, FRAMES, TRAJECTORY, CHECKPOINTS].into_iter().map(size);
        parts
            .filter(|part| !part.as_ref().is_ok_and(|part| part.name == CHECKPOINTS && part.files == 0))
            .collect()
    }

    fn array(&self, name: &str) -> Result<Array<FilesystemStore>, Error> {
        Array::open(self.store.clone(), &format!("/{name}")).map_err(|error| self.damaged(name, error))
    }

    fn all<T: ElementOwned>(&self, name: &str) -> Result<Vec<T>, Error> {
        let array = self.array(name)?;
        array.retrieve_array_subset::<Vec<T>>(&array.subset_all()).map_err(|error| self.damaged(name, error))
    }

    fn damaged(&self, name: &str, reason: impl ToString) -> Error {
        Error::damaged(&self.path.join(TRAJECTORY).join(name), reason)
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
