//! The folder of a run: which one, and what may be replaced.

use crate::store::{absent_is_fine, part_of};
use crate::{Error, RunReader};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The scene as it was run.
pub const SCENE: &str = "scene.toml";
/// What was run and how it ended.
pub const SUMMARY: &str = "summary.json";
/// One row per step.
pub const FRAMES: &str = "frames.csv";
/// The poses.
pub const TRAJECTORY: &str = "trajectory.zarr";

/// An empty folder that a run may fill.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFolder {
    path: PathBuf,
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
        let mut entries = fs::read_dir(path).map_err(|error| Error::io("read", path, &error))?;
        if entries.next().is_some() { Err(Error::Occupied(path.to_owned())) } else { Ok(()) }
    }

    /// The folder `path`, created where it is missing. A former run in it is replaced if `overwrite` says so: its
    /// four parts are removed, other files stay.
    ///
    /// # Errors
    /// Those of [`RunFolder::check`], before anything is touched; [`Error::Io`].
    pub fn at(path: &Path, overwrite: bool) -> Result<Self, Error> {
        Self::check(path, overwrite)?;
        fs::create_dir_all(path).map_err(|error| Error::io("create", path, &error))?;
        if RunReader::is_run(path) {
            remove_run(path)?;
        }
        Ok(RunFolder { path: path.to_owned() })
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
                Ok(()) => return Ok(RunFolder { path }),
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
    let trajectory = path.join(TRAJECTORY);
    absent_is_fine(fs::remove_dir_all(&trajectory))
        .map_err(|error| Error::io("remove", &trajectory, &error))?;
    // The summary goes last: until then the folder still counts as a run.
    for part in [SCENE, FRAMES, SUMMARY] {
        for file in [part_of(&path.join(part)), path.join(part)] {
            absent_is_fine(fs::remove_file(&file)).map_err(|error| Error::io("remove", &file, &error))?;
        }
    }
    Ok(())
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
    fn numbered_folders_do_not_collide() {
        let folder = tempfile::tempdir().unwrap();
        let parent = folder.path().join("runs");
        let first = RunFolder::numbered(&parent, "hello").unwrap();
        let second = RunFolder::numbered(&parent, "hello").unwrap();
        assert_eq!(first.path(), parent.join("hello-1"));
        assert_eq!(second.path(), parent.join("hello-2"));
    }
}
