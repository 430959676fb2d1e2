//! What can go wrong with a picture.

use std::path::PathBuf;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// What is seen does not tell what colours or overlays are to show.
    #[error("cannot show {what}: {why}")]
    Unknown {
        /// What was asked for.
        what: &'static str,
        /// Why it is not known, and what to do about it.
        why: String,
    },
    /// The run can't be read, or its scene can't be laid out again.
    #[error(transparent)]
    Run(#[from] rockfall_export::Error),
    /// A file can't be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
}
