//! Why a snapshot could not be written or read.

use std::io::{self, ErrorKind};

/// Why a snapshot could not be written or read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused.
    #[error("{reason}")]
    Io {
        /// What the system said.
        reason: String,
        /// Its kind, for callers that tell a full disk from a missing folder.
        kind: ErrorKind,
    },
    /// It starts with other bytes.
    #[error("it is no snapshot of Rockfall")]
    Format,
    /// It comes from a machine whose numbers lie the other way round.
    #[error("it comes from a machine with another byte order")]
    ByteOrder,
    /// Another version of the format or of the engine wrote it.
    #[error("it has version {found}, this program reads version {expected}")]
    Version {
        /// That of the snapshot.
        found: String,
        /// The one that is read.
        expected: String,
    },
    /// Its state belongs to another world.
    #[error("it belongs to a world with other {0}")]
    OtherWorld(&'static str),
    /// Another column than expected.
    #[error("it has the column {found}, expected {expected}")]
    Column {
        /// The one that was to come.
        expected: String,
        /// The one that came.
        found: String,
    },
    /// It ends too early.
    #[error("it ends within the column `{column}`")]
    Truncated {
        /// Where.
        column: String,
    },
    /// The bytes are not those that were written.
    #[error("the checksum of `{column}` is wrong")]
    Checksum {
        /// Where.
        column: String,
    },
    /// The bytes are those that were written, and no world has such a state.
    #[error("the column `{column}` makes no sense: {reason}")]
    Invalid {
        /// Where.
        column: String,
        /// What is wrong.
        reason: String,
    },
}

impl Error {
    /// A column that makes no sense.
    pub fn invalid(column: &str, reason: impl ToString) -> Self {
        Error::Invalid { column: column.to_owned(), reason: reason.to_string() }
    }

    /// [`Error::Invalid`] unless something is `true`.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn unless(good: bool, column: &str, reason: &str) -> Result<(), Self> {
        if good { Ok(()) } else { Err(Error::invalid(column, reason)) }
    }
}

impl From<io::Error> for Error {
    fn from(error: io::Error) -> Self {
        Error::Io { reason: error.to_string(), kind: error.kind() }
    }
}
