//! What can go wrong with an export, and what a person can do about it.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a run could not be exported.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The run can't be read.
    #[error(transparent)]
    Run(#[from] rockfall_cache::Error),
    /// The scene in the run's folder can't be read, or its shapes can't be made again.
    #[error(transparent)]
    Scene(#[from] rockfall_scene::SceneError),
    /// The scene in the run's folder describes other bodies than the run has.
    #[error(
        "{} has other bodies than the run beside it: expected {expected}, found {found}; was it changed since?",
        path.display()
    )]
    OtherScene {
        /// The scene.
        path: PathBuf,
        /// What the run has.
        expected: String,
        /// What the scene has.
        found: String,
    },
    /// The system refused.
    #[error("cannot {action} {}: {reason}{}", path.display(), advice(*kind))]
    Io {
        /// "write", "create" and the like.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        reason: String,
        /// Its kind, for callers that tell a full disk from a missing folder.
        kind: ErrorKind,
    },
    /// There is something at the place of the output.
    #[error("{} exists; choose another path with -o, or replace it with --overwrite", .0.display())]
    Exists(PathBuf),
    /// There is something that an export never replaces.
    #[error("{} is {what}, which is never replaced; choose another path with -o", path.display())]
    Occupied {
        /// The place of the output.
        path: PathBuf,
        /// What is there.
        what: String,
    },
    /// A frame that the run does not have.
    #[error("frame {frame} is not in the run, which has frames 0 to {last}")]
    NoFrame {
        /// The frame that was asked for.
        frame: u64,
        /// The last one that there is.
        last: u64,
    },
    /// The run has no frame at all.
    #[error("{} has no complete frame yet", .0.display())]
    NoFrames(PathBuf),
    /// A body that the run does not have.
    #[error("the run has no body {0}; its ids are in the array `id` of its trajectory")]
    NoBody(String),
    /// A format can't hold what was asked of it.
    #[error("{0}")]
    Limit(String),
    /// There are no threads to be had.
    #[error("cannot start threads: {0}")]
    Threads(String),
    /// Somebody stopped it; nothing is left of it.
    #[error("the export was stopped")]
    Stopped,
}

impl Error {
    /// An error of the system about one file.
    pub(crate) fn io(action: &'static str, path: &Path, error: &io::Error) -> Self {
        Error::Io { action, path: path.to_owned(), reason: error.to_string(), kind: error.kind() }
    }
}

/// What to do about the errors that people meet.
fn advice(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space, or choose a path on another disk with -o"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose a path that you may write to with -o"
        }
        ErrorKind::NotFound => "; was the folder moved or removed?",
        _ => "",
    }
}
