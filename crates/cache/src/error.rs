//! What can go wrong with a run on disk, and what a person can do about it.

use rockfall::snapshot;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a run could not be written or read.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused.
    #[error("cannot {action} {}: {reason}{}", path.display(), advice(*kind))]
    Io {
        /// "write", "read", "create" and the like.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        reason: String,
        /// Its kind, for callers that tell a full disk from a missing folder.
        kind: ErrorKind,
    },
    /// The output folder holds a run already.
    #[error("{} holds a run already; choose another folder, or replace that run with --overwrite", .0.display())]
    RunExists(PathBuf),
    /// The output folder holds something that is not a run.
    #[error("{} is neither empty nor a run; choose another folder, nothing in it was touched", .0.display())]
    Occupied(PathBuf),
    /// The output folder is a file.
    #[error("{} is a file, expected a folder", .0.display())]
    NotAFolder(PathBuf),
    /// This is not the folder of a run.
    #[error("{} is not a run: it has no {}", path.display(), missing)]
    NotARun {
        /// The folder.
        path: PathBuf,
        /// The part that is not there.
        missing: &'static str,
    },
    /// A part of the run can't be understood.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// The file or array.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Another program writes into the folder.
    #[error("{} is in use by another run; wait for its end or choose another folder", .0.display())]
    Locked(PathBuf),
    /// A checkpoint can't be used.
    #[error("{} can't be used: {reason}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A run can't go on, since none of its checkpoints can be used.
    #[error(
        "{} can't go on: none of its checkpoints can be used; to start again: rockfall run {0}/{scene} --out {0} --overwrite",
        path.display(), scene = crate::SCENE
    )]
    NoCheckpoint {
        /// The folder.
        path: PathBuf,
    },
    /// A run that a later version wrote.
    #[error("{} has format version {found}, this program reads up to {}; use a later rockfall", path.display(), crate::VERSION)]
    Version {
        /// The file that says so.
        path: PathBuf,
        /// The version.
        found: u32,
    },
    /// A bound for poses that can't be kept.
    #[error("poses can't be within {bound} {unit}: expected from {least} to {most} {unit}, or no bound")]
    Precision {
        /// What was asked for.
        bound: f64,
        /// The smallest bound.
        least: f64,
        /// The largest one.
        most: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A column that can't be written.
    #[error("the column `{name}` can't be written: {reason}")]
    Column {
        /// Its name.
        name: String,
        /// Why.
        reason: String,
    },
    /// A frame has a body that the table of bodies lacks.
    #[error("body {0} is not in the run's table of bodies")]
    UnknownBody(u64),
    /// A frame that the run does not have.
    #[error("frame {frame} is not in the run, which has {frames}")]
    NoFrame {
        /// The frame that was asked for.
        frame: u64,
        /// Frames in the run.
        frames: u64,
    },
    /// A body that the run does not have.
    #[error("the run has no row {0} in its table of bodies")]
    NoBody(usize),
    /// The thread that writes has ended without saying why.
    #[error("the thread that writes {} has stopped", .0.display())]
    WriterGone(PathBuf),
}

impl Error {
    /// An error of the system about one file.
    pub(crate) fn io(action: &'static str, path: &Path, error: &io::Error) -> Self {
        Error::Io { action, path: path.to_owned(), reason: error.to_string(), kind: error.kind() }
    }

    /// An error of a snapshot in a file.
    pub(crate) fn snapshot(action: &'static str, path: &Path, error: snapshot::Error) -> Self {
        match error {
            snapshot::Error::Io { reason, kind } => Error::Io { action, path: path.to_owned(), reason, kind },
            other => Error::Checkpoint { path: path.to_owned(), reason: other.to_string() },
        }
    }

    /// A part that can't be understood.
    pub(crate) fn damaged(path: &Path, reason: impl ToString) -> Self {
        Error::Damaged { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// What to do about the errors that people meet.
fn advice(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space and go on with --resume, or choose a folder on another disk with --out; the frames before are intact"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose a folder that you may write to with --out"
        }
        ErrorKind::NotFound => "; was the folder moved or removed?",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_names_the_file_and_the_way_out() {
        let error = Error::io("write", Path::new("runs/a/frames.csv"), &ErrorKind::StorageFull.into());
        assert_eq!(
            error.to_string(),
            "cannot write runs/a/frames.csv: no storage space; free some space and go on with --resume, or \
             choose a folder on another disk with --out; the frames before are intact"
        );
    }
}
