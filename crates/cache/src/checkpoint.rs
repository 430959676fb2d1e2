//! `checkpoints/`: the whole state of a run at a frame, from which it goes on.
//!
//! A checkpoint is a file `frame-NUMBER`, a snapshot in the format of [`rockfall::snapshot`]. It is written under a hidden name, handed to
//! the disk, and then moved into place, so that whatever happens there is a whole one or none. Of those in place the last two are
//! kept: should the last one turn out to be damaged, there is the one before it.

use crate::store::{absent_is_fine, part_of, sync_folder};
use crate::{CHECKPOINTS, Error};
use rockfall::snapshot::{self, Reader, Writer};
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Checkpoints that are kept.
const KEPT: usize = 2;

/// What a read or a write takes at a time; columns are many megabytes.
const BUFFER: usize = 1 << 20;

/// What the names of checkpoints begin with.
const PREFIX: &str = "frame-";

/// A checkpoint on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// The frame that it is of.
    pub frame: u64,
    /// Its file.
    pub path: PathBuf,
}

impl Checkpoint {
    /// Those of the run in the folder `run`, the last one first.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn all(run: &Path) -> Result<Vec<Checkpoint>, Error> {
        let folder = run.join(CHECKPOINTS);
        let entries = match fs::read_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(|error| Error::io("read", &folder, &error))?,
        };
        let mut all = Vec::new();
        for entry in entries {
            let path = entry.map_err(|error| Error::io("read", &folder, &error))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if let Some(frame) = name.strip_prefix(PREFIX).and_then(|number| number.parse().ok()) {
                all.push(Checkpoint { frame, path });
            }
        }
        all.sort_unstable_by_key(|checkpoint| std::cmp::Reverse(checkpoint.frame));
        Ok(all)
    }

    /// Writes that of a frame of the run in the folder `run`, and removes those that are older than the one before it. Returns its bytes.
    ///
    /// # Errors
    /// [`Error::Io`]; the checkpoints before are as they were.
    pub fn write(
        run: &Path,
        frame: u64,
        save: impl FnOnce(&mut Writer<'_>) -> Result<(), snapshot::Error>,
    ) -> Result<u64, Error> {
        let folder = run.join(CHECKPOINTS);
        // The run's own folder is not made again: that somebody removed it is an error.
        match fs::create_dir(&folder) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                return Err(Error::io("create", &folder, &error));
            }
            _ => {}
        }
        let path = folder.join(format!("{PREFIX}{frame:09}"));
        let part = part_of(&path);
        let written = fill(&part, save)
            .and_then(|bytes| Ok(fs::rename(&part, &path).map(|()| bytes)?))
            .and_then(|bytes| Ok(sync_folder(&folder).map(|()| bytes)?));
        let bytes = written.map_err(|error| {
            // What is left takes space that a full disk lacks; that it may fail as well changes nothing.
            let _ = fs::remove_file(&part);
            Error::snapshot("write", &path, error)
        })?;
        sync_folder(run).map_err(|error| Error::io("write", run, &error))?;
        for old in Self::all(run)?.iter().skip(KEPT) {
            absent_is_fine(fs::remove_file(&old.path))
                .map_err(|error| Error::io("remove", &old.path, &error))?;
        }
        Ok(bytes)
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] says why it can't be used; [`Error::Io`].
    pub fn read<T>(
        &self,
        load: impl FnOnce(&mut Reader<'_>) -> Result<T, snapshot::Error>,
    ) -> Result<T, Error> {
        self.open(|mut reader| {
            let state = load(&mut reader)?;
            reader.finish()?;
            Ok(state)
        })
    }

    /// Checks every checksum. Returns the name of each column and the bytes of its values.
    ///
    /// # Errors
    /// As [`Checkpoint::read`].
    pub fn verify(&self) -> Result<Vec<(String, u64)>, Error> {
        self.open(|reader| reader.rest())
    }

    fn open<T>(&self, read: impl FnOnce(Reader<'_>) -> Result<T, snapshot::Error>) -> Result<T, Error> {
        let file = File::open(&self.path).map_err(|error| Error::io("read", &self.path, &error))?;
        let mut from = BufReader::with_capacity(BUFFER, file);
        let read = Reader::new(&mut from).and_then(read);
        read.map_err(|error| Error::snapshot("read", &self.path, error))
    }

    /// Removes all checkpoints of the run in the folder `run`: it needs them no more.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn remove_all(run: &Path) -> Result<(), Error> {
        let folder = run.join(CHECKPOINTS);
        absent_is_fine(fs::remove_dir_all(&folder)).map_err(|error| Error::io("remove", &folder, &error))
    }
}

fn fill(
    part: &Path,
    save: impl FnOnce(&mut Writer<'_>) -> Result<(), snapshot::Error>,
) -> Result<u64, snapshot::Error> {
    let mut to = BufWriter::with_capacity(BUFFER, File::create(part)?);
    let mut writer = Writer::new(&mut to)?;
    save(&mut writer)?;
    let bytes = writer.finish()?;
    to.flush()?;
    to.get_ref().sync_all()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(run: &Path) -> Vec<u64> {
        Checkpoint::all(run).unwrap().iter().map(|checkpoint| checkpoint.frame).collect()
    }

    #[test]
    fn the_last_two_are_kept_and_read_back() {
        let run = tempfile::tempdir().unwrap();
        assert_eq!(frames(run.path()), [0; 0]);
        for frame in [5, 10, 1_000_000_000_000, 7] {
            Checkpoint::write(run.path(), frame, |to| to.one("number", 2 * frame)).unwrap();
        }
        assert_eq!(frames(run.path()), [1_000_000_000_000, 10]);
        let last = &Checkpoint::all(run.path()).unwrap()[0];
        assert_eq!(last.read(|from| from.one::<u64>("number")).unwrap(), 2_000_000_000_000);
        assert_eq!(last.verify().unwrap(), [("number".to_owned(), 8)]);
        Checkpoint::remove_all(run.path()).unwrap();
        Checkpoint::remove_all(run.path()).unwrap();
        assert!(!run.path().join(CHECKPOINTS).exists());
    }

    #[test]
    fn one_that_fails_leaves_those_before() {
        let run = tempfile::tempdir().unwrap();
        Checkpoint::write(run.path(), 1, |to| to.one("number", 1_u32)).unwrap();
        let full = || snapshot::Error::Io { reason: "full".into(), kind: ErrorKind::StorageFull };
        let failed = Checkpoint::write(run.path(), 2, |_| Err(full())).unwrap_err();
        let text = failed.to_string();
        assert!(text.contains("frame-000000002") && text.contains("free some space"), "{text}");
        assert_eq!(fs::read_dir(run.path().join(CHECKPOINTS)).unwrap().count(), 1);
        fs::remove_dir_all(run.path()).unwrap();
        let gone = Checkpoint::write(run.path(), 3, |_| Ok(())).unwrap_err();
        assert!(gone.to_string().contains("was the folder moved or removed?"), "{gone}");
    }

    #[test]
    fn a_damaged_one_says_so() {
        let run = tempfile::tempdir().unwrap();
        Checkpoint::write(run.path(), 1, |to| to.column("numbers", &[1_u32; 1000])).unwrap();
        let checkpoint = Checkpoint::all(run.path()).unwrap().remove(0);
        let good = fs::read(&checkpoint.path).unwrap();
        let mut bad = good.clone();
        bad[2000] ^= 4;
        for bytes in [&bad[..], &good[..3000], &[]] {
            fs::write(&checkpoint.path, bytes).unwrap();
            let error = checkpoint.read(|from| from.column::<u32>("numbers")).unwrap_err();
            assert!(matches!(error, Error::Checkpoint { .. }) && checkpoint.verify().is_err(), "{error}");
        }
    }
}
