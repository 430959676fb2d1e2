//! The place of the output: filled under a hidden name, then moved into place, so that what is there is whole.

use crate::{Error, Makes};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// An output that is being made. What is there of it goes away unless [`Target::finish`] is called.
#[derive(Debug)]
pub(crate) struct Target {
    path: PathBuf,
    part: PathBuf,
    makes: Makes,
}

impl Target {
    /// Whether there may be output at `path`; touches nothing.
    pub(crate) fn check(path: &Path, makes: Makes, overwrite: bool) -> Result<(), Error> {
        let Ok(metadata) = fs::metadata(path) else { return Ok(()) };
        let occupied = |what: &str| Err(Error::Occupied { path: path.to_owned(), what: what.to_owned() });
        match (makes, metadata.is_dir()) {
            (Makes::File { .. }, true) => return occupied("a folder"),
            (Makes::Folder { .. }, false) => return occupied("a file"),
            (Makes::Folder { extensions }, true) => {
                if let Some(other) = stranger(path, extensions)? {
                    return occupied(&format!("a folder that holds {other}"));
                }
            }
            (Makes::File { .. }, false) => {}
        }
        if overwrite || is_empty_folder(path) { Ok(()) } else { Err(Error::Exists(path.to_owned())) }
    }

    /// Starts an output, with the folders that lead to it.
    pub(crate) fn start(path: &Path, makes: Makes, overwrite: bool) -> Result<Self, Error> {
        Self::check(path, makes, overwrite)?;
        if let Some(parent) = path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(|error| Error::io("create", parent, &error))?;
        }
        let target = Target { path: path.to_owned(), part: hidden(path, "part"), makes };
        target.clear();
        if matches!(makes, Makes::Folder { .. }) {
            fs::create_dir(&target.part).map_err(|error| Error::io("create", &target.part, &error))?;
        }
        Ok(target)
    }

    /// Where to write: a file that does not exist, or an empty folder.
    pub(crate) fn part(&self) -> &Path {
        &self.part
    }

    /// Moves the output into place. A former one is replaced.
    pub(crate) fn finish(self) -> Result<(), Error> {
        let failed = |error: io::Error| Error::io("write", &self.path, &error);
        // A file takes the place of another one in one go; a folder does not.
        if matches!(self.makes, Makes::Folder { .. }) && self.path.is_dir() {
            let former = hidden(&self.path, "former");
            fs::rename(&self.path, &former).map_err(failed)?;
            fs::rename(&self.part, &self.path).map_err(|error| {
                // The former one comes back; the error at hand is the one to tell.
                let _ = fs::rename(&former, &self.path);
                failed(error)
            })?;
            return fs::remove_dir_all(&former).map_err(|error| Error::io("remove", &former, &error));
        }
        fs::rename(&self.part, &self.path).map_err(failed)
    }

    /// Removes what was written. That it may fail changes nothing: it is hidden, and the next export takes its own.
    fn clear(&self) {
        let _ = match self.makes {
            Makes::File { .. } => fs::remove_file(&self.part),
            Makes::Folder { .. } => fs::remove_dir_all(&self.part),
        };
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        self.clear();
    }
}

/// A hidden name beside `path`, another one for each program that runs.
fn hidden(path: &Path, what: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.{what}", std::process::id()))
}

/// The first thing in a folder that no export of this format makes.
fn stranger(folder: &Path, extensions: &[&str]) -> Result<Option<String>, Error> {
    let failed = |error: io::Error| Error::io("read", folder, &error);
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        let ours = path.extension().is_some_and(|end| extensions.iter().any(|known| end == *known));
        if !ours || entry.file_type().map_err(failed)?.is_dir() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    // In no order of the system's.
    Ok(names.into_iter().min())
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Bytes and number of the files of an output.
pub(crate) fn size(path: &Path) -> Result<(u64, u64), Error> {
    let failed = |error: io::Error| Error::io("read", path, &error);
    match fs::read_dir(path) {
        Err(error) if error.kind() == ErrorKind::NotADirectory => {
            Ok((fs::metadata(path).map_err(failed)?.len(), 1))
        }
        Err(error) => Err(failed(error)),
        Ok(entries) => {
            let mut sum = (0, 0);
            for entry in entries {
                sum.0 += entry.and_then(|entry| entry.metadata()).map_err(failed)?.len();
                sum.1 += 1;
            }
            Ok(sum)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: Makes = Makes::File { extension: "csv" };
    const FOLDER: Makes = Makes::Folder { extensions: &["vtp", "pvd"] };

    #[test]
    fn nothing_is_there_until_all_of_it_is() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("deep/a.csv");
        let target = Target::start(&path, FILE, false).unwrap();
        fs::write(target.part(), "half").unwrap();
        assert!(!path.exists());
        drop(target);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);

        let target = Target::start(&path, FILE, false).unwrap();
        fs::write(target.part(), "whole").unwrap();
        target.finish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        assert!(matches!(Target::start(&path, FILE, false), Err(Error::Exists(there)) if there == path));
        let target = Target::start(&path, FILE, true).unwrap();
        fs::write(target.part(), "new").unwrap();
        target.finish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_is_replaced_only_if_an_export_made_all_of_it() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        let fill = |overwrite| {
            let target = Target::start(&path, FOLDER, overwrite)?;
            fs::write(target.part().join("0.vtp"), "").unwrap();
            target.finish()
        };
        fs::create_dir(&path).unwrap();
        fill(false).unwrap();
        assert!(matches!(fill(false), Err(Error::Exists(_))));
        fs::write(path.join("1.vtp"), "").unwrap();
        fill(true).unwrap();
        assert_eq!(size(&path).unwrap(), (0, 1));
        fs::write(path.join("thesis.txt"), "years of work").unwrap();
        let refused = fill(true).unwrap_err();
        assert!(refused.to_string().contains("a folder that holds thesis.txt"), "{refused}");
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }

    #[test]
    fn files_and_folders_do_not_replace_each_other() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "x").unwrap();
        assert!(matches!(Target::check(&file, FOLDER, true), Err(Error::Occupied { .. })));
        assert!(matches!(Target::check(place.path(), FILE, true), Err(Error::Occupied { .. })));
    }
}
