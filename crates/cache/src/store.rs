//! Files that are there whole or not at all.

use crate::Error;
use crate::seal::seal;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use zarrs::storage::{
    Bytes, OffsetBytesIterator, StorageError, StoreKey, StorePrefix, WritableStorageTraits,
};

/// Writes a file under a hidden name and then moves it into place, so that a reader, or a run that is killed in the
/// middle, never meets half a file. There is no flush to the disk: a power cut may cost what came since [`WholeFiles::sync`].
pub(crate) fn write_whole(path: &Path, content: &[u8]) -> Result<(), Error> {
    let part = part_of(path);
    let written = fs::write(&part, content).and_then(|()| fs::rename(&part, path));
    written.map_err(|error| {
        // What is left of a failed write takes space that a full disk lacks; that it may fail as well changes nothing.
        let _ = fs::remove_file(&part);
        Error::io("write", path, &error)
    })
}

/// Hands a file to the disk.
pub(crate) fn sync_file(path: &Path) -> Result<(), Error> {
    File::open(path).and_then(|file| file.sync_all()).map_err(|error| Error::io("write", path, &error))
}

/// Hands the names in a folder to the disk, where the system knows how to.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(path)?.sync_all() } else { Ok(()) }
}

/// The hidden name of a file that is not complete.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.part"))
}

/// Where in a `zarr.json` its checksum is.
pub(crate) const ATTRIBUTES: [&str; 1] = ["attributes"];

/// A folder as a Zarr store that [`write_whole`] fills. The library's own store writes in place.
#[derive(Debug)]
pub(crate) struct WholeFiles {
    root: PathBuf,
    /// The library passes errors on as text; this keeps the first one as it was.
    failure: Mutex<Option<Error>>,
    /// Files that were written and may not be on the disk yet.
    fresh: Mutex<BTreeSet<PathBuf>>,
}

impl WholeFiles {
    pub(crate) fn new(root: PathBuf) -> Self {
        WholeFiles { root, failure: Mutex::new(None), fresh: Mutex::default() }
    }

    /// The error behind a failed operation of the library.
    pub(crate) fn explain(&self, error: impl ToString) -> Error {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.unwrap_or_else(|| Error::damaged(&self.root, error))
    }

    /// Hands everything that was written to the disk.
    pub(crate) fn sync(&self) -> Result<(), Error> {
        let fresh = std::mem::take(&mut *self.fresh.lock().unwrap_or_else(PoisonError::into_inner));
        let mut folders = BTreeSet::from([self.root.as_path()]);
        for path in &fresh {
            sync_file(path)?;
            folders.extend(path.parent());
        }
        let sync = |path: &Path| sync_folder(path).map_err(|error| Error::io("write", path, &error));
        folders.into_iter().try_for_each(sync)
    }

    fn path(&self, key: &StoreKey) -> PathBuf {
        self.root.join(key.as_str())
    }

    /// Writes one of its files. The JSON of groups and arrays gets a checksum.
    pub(crate) fn put(&self, key: &str, content: &[u8]) -> Result<(), Error> {
        let path = self.root.join(key);
        self.make_room(&path)?;
        if path.ends_with("zarr.json") {
            let mut metadata =
                serde_json::from_slice(content).map_err(|error| Error::damaged(&path, error))?;
            seal(&mut metadata, &ATTRIBUTES);
            write_whole(&path, metadata.to_string().as_bytes())?;
        } else {
            write_whole(&path, content)?;
        }
        self.fresh.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
        Ok(())
    }

    fn keep(&self, error: Error) -> StorageError {
        let text = error.to_string();
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        StorageError::Other(text)
    }

    /// Creates the folders above `path` that lie within the store. The store's own folder is not made again: when
    /// somebody removes it during a run, that is an error and not a run without its beginning.
    fn make_room(&self, path: &Path) -> Result<(), Error> {
        let Some(parent) = path.parent() else { return Ok(()) };
        if parent.is_dir() || parent == self.root {
            return Ok(());
        }
        self.make_room(parent)?;
        match fs::create_dir(parent) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                Err(Error::io("create", parent, &error))
            }
            _ => Ok(()),
        }
    }
}

impl WritableStorageTraits for WholeFiles {
    fn set(&self, key: &StoreKey, value: Bytes) -> Result<(), StorageError> {
        self.put(key.as_str(), &value).map_err(|error| self.keep(error))
    }

    fn set_partial_many(&self, key: &StoreKey, _values: OffsetBytesIterator) -> Result<(), StorageError> {
        Err(StorageError::Unsupported(format!("{key} can only be written whole")))
    }

    fn erase(&self, key: &StoreKey) -> Result<(), StorageError> {
        let path = self.path(key);
        absent_is_fine(fs::remove_file(&path)).map_err(|error| self.keep(Error::io("remove", &path, &error)))
    }

    fn erase_prefix(&self, prefix: &StorePrefix) -> Result<(), StorageError> {
        let path = self.root.join(prefix.as_str());
        absent_is_fine(fs::remove_dir_all(&path))
            .map_err(|error| self.keep(Error::io("remove", &path, &error)))
    }

    fn supports_set_partial(&self) -> bool {
        false
    }
}

/// Removing what is not there has succeeded.
pub(crate) fn absent_is_fine(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_replaces_the_former_one_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let store = WholeFiles::new(folder.path().to_owned());
        let key = StoreKey::new("a/c/0").unwrap();
        store.set(&key, Bytes::from_static(b"longer than the next")).unwrap();
        store.set(&key, Bytes::from_static(b"next")).unwrap();
        assert_eq!(fs::read(folder.path().join("a/c/0")).unwrap(), b"next");
        assert_eq!(fs::read_dir(folder.path().join("a/c")).unwrap().count(), 1);
        store.erase(&key).unwrap();
        store.erase(&key).unwrap();
        assert!(!folder.path().join("a/c/0").exists());
    }

    #[test]
    fn a_removed_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("trajectory.zarr");
        let store = WholeFiles::new(root.clone());
        let failed = store.set(&StoreKey::new("time/c/0").unwrap(), Bytes::from_static(b"x")).unwrap_err();
        let Error::Io { path, kind, .. } = store.explain(failed) else { panic!("another error") };
        assert_eq!((path, kind), (root.join("time"), ErrorKind::NotFound));
    }
}
