//! The folder of a run: which one, and what may be replaced.

use crate::lock::Lock;
use crate::store::{absent_is_fine, part_of};
use crate::{Checkpoint, Error, RunReader};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scene as it was run.
pub const SCENE: &str = "scene.toml";
/// What was run and how it ended.
pub const SUMMARY: &str = "summary.json";
/// One row per step.
pub const FRAMES: &str = "frames.csv";
/// The poses.
pub const TRAJECTORY: &str = "trajectory.zarr";
/// The state at the end.
pub const STATE: &str = "state.zarr";
/// What the run began with, where that was a frame of another run.
pub const START: &str = "start.zarr";
/// The whole state at some frames.
pub const CHECKPOINTS: &str = "checkpoints";
/// Tells who writes into the folder; empty, and of no meaning when nobody does.
pub const LOCK: &str = ".lock";

/// A folder that a run may fill, and no other one at the same time.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    _lock: Arc<Lock>,
}

impl RunFolder {
    /// Whether [`RunFolder::at`] would accept the folder `path`; touches nothing.
    ///
    /// # Errors
    /// [`Error::RunExists`], [`Error::Occupied`] or [`Error::NotAFolder`] where there is something else.
    pub fn check(path: &Path, overwrite: bool) -> Result<(), Error> {
        if !path.exists() {
            return Ok(());
        }
        if !path.is_dir() {
            return Err(Error::NotAFolder(path.to_owned()));
        }
        if RunReader::is_run(path) {
            return if overwrite { Ok(()) } else { Err(Error::RunExists(path.to_owned())) };
        }
        let entries = fs::read_dir(path).map_err(|error| Error::io("read", path, &error))?;
        let mut others = entries.filter(|entry| !entry.as_ref().is_ok_and(|entry| entry.file_name() == LOCK));
        if others.next().is_some() { Err(Error::Occupied(path.to_owned())) } else { Ok(()) }
    }

    /// The folder `path`, created where it is missing. A former run in it is replaced if `overwrite` says so: its
    /// parts are removed, other files stay.
    ///
    /// # Errors
    /// Those of [`RunFolder::check`], and [`Error::Locked`], before anything is touched; [`Error::Io`].
    pub fn at(path: &Path, overwrite: bool) -> Result<Self, Error> {
        Self::check(path, overwrite)?;
        fs::create_dir_all(path).map_err(|error| Error::io("create", path, &error))?;
        let lock = Lock::take(path)?;
        // What came while it was not locked is not touched either.
        Self::check(path, overwrite)?;
        if RunReader::is_run(path) {
            remove_run(path)?;
        }
        Ok(RunFolder { path: path.to_owned(), _lock: Arc::new(lock) })
    }

    /// The folder `path` of a run that is to go on.
    ///
    /// # Errors
    /// [`Error::NotARun`], [`Error::Locked`], [`Error::Io`].
    pub fn of_run(path: &Path) -> Result<Self, Error> {
        if !RunReader::is_run(path) {
            return Err(Error::NotARun { path: path.to_owned(), missing: SUMMARY });
        }
        Ok(RunFolder { path: path.to_owned(), _lock: Arc::new(Lock::take(path)?) })
    }

    /// Removes what the run has written, but for the scene and the summary.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn clear(&self) -> Result<(), Error> {
        remove_frames(&self.path)
    }

    /// The first of `NAME-1`, `NAME-2`, … within `parent` that does not exist yet, created.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn numbered(parent: &Path, name: &str) -> Result<Self, Error> {
        fs::create_dir_all(parent).map_err(|error| Error::io("create", parent, &error))?;
        let mut number = 1u64;
        loop {
            let path = parent.join(format!("{name}-{number}"));
            // Creation itself is the test, so that two programs never take the same folder.
            match fs::create_dir(&path) {
                Ok(()) => return Ok(RunFolder { _lock: Arc::new(Lock::take(&path)?), path }),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(Error::io("create", &path, &error)),
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn remove_run(path: &Path) -> Result<(), Error> {
    remove_frames(path)?;
    remove_group(&path.join(START))?;
    // The summary goes last: until then the folder still counts as a run.
    for part in [SCENE, SUMMARY] {
        for file in [part_of(&path.join(part)), path.join(part)] {
            absent_is_fine(fs::remove_file(&file)).map_err(|error| Error::io("remove", &file, &error))?;
        }
    }
    Ok(())
}

fn remove_frames(path: &Path) -> Result<(), Error> {
    Checkpoint::remove_all(path)?;
    remove_group(&path.join(TRAJECTORY))?;
    remove_group(&path.join(STATE))?;
    let rows = path.join(FRAMES);
    absent_is_fine(fs::remove_file(&rows)).map_err(|error| Error::io("remove", &rows, &error))
}

/// Removes a folder, out of the way first, so that nobody meets half of it.
fn remove_group(path: &Path) -> Result<(), Error> {
    let hidden = part_of(path);
    absent_is_fine(fs::remove_dir_all(&hidden))
        .and_then(|()| absent_is_fine(fs::rename(path, &hidden)))
        .and_then(|()| absent_is_fine(fs::remove_dir_all(&hidden)))
        .map_err(|error| Error::io("remove", path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_run_is_never_touched() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("thesis.txt"), "years of work").unwrap();
        for overwrite in [false, true] {
            let refused = RunFolder::at(folder.path(), overwrite);
            assert!(matches!(refused, Err(Error::Occupied(path)) if path == folder.path()));
        }
        let file = folder.path().join("thesis.txt");
        assert!(matches!(RunFolder::at(&file, true), Err(Error::NotAFolder(path)) if path == file));
        assert_eq!(fs::read_to_string(file).unwrap(), "years of work");
    }

    #[test]
    fn a_folder_is_one_run_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let first = RunFolder::at(&path, false).unwrap();
        assert!(matches!(RunFolder::at(&path, true), Err(Error::Locked(locked)) if locked == path));
        fs::write(path.join(SUMMARY), "{}").unwrap();
        assert!(matches!(RunFolder::of_run(&path), Err(Error::Locked(_))));
        assert!(path.join(SUMMARY).exists());
        drop(first);
        drop(RunFolder::of_run(&path).unwrap());
        RunFolder::at(&path, true).unwrap();
    }

    #[test]
    fn numbered_folders_do_not_collide() {
        let folder = tempfile::tempdir().unwrap();
        let parent = folder.path().join("runs");
        let first = RunFolder::numbered(&parent, "hello").unwrap();
        let second = RunFolder::numbered(&parent, "hello").unwrap();
        assert_eq!(first.path(), parent.join("hello-1"));
        assert_eq!(second.path(), parent.join("hello-2"));
    }
}
