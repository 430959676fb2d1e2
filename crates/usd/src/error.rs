//! What can go wrong.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a file could not be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused something.
    #[error("cannot write {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
        /// The kind of the system's error.
        kind: ErrorKind,
    },
    /// A name that USD does not allow.
    #[error(
        "`{name}` can't be the name of a {what}: letters, digits and underscores, not a digit first{}",
        if *what == "property" { ", in parts with colons between them" } else { "" }
    )]
    Name {
        /// `prim` or `property`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A path that is not absolute, or has a name in it that is none.
    #[error("`{0}` is no path: expected one like /World/Ball or /World/Ball.radius")]
    Path(String),
    /// Two things have the same path.
    #[error("{0} is there twice")]
    Twice(String),
    /// An attribute of a type that this crate does not know.
    #[error("{path} is of the type `{type_name}`, which is not known here")]
    UnknownType {
        /// The attribute.
        path: String,
        /// Its type.
        type_name: String,
    },
    /// A value that does not fit the attribute's type.
    #[error("{path} is of the type `{type_name}`, and a value of it is not")]
    Type {
        /// The attribute.
        path: String,
        /// Its type.
        type_name: String,
    },
    /// Samples that don't ascend in time.
    #[error("{path} has a sample at {time} that does not come after the one before it")]
    Time {
        /// The attribute.
        path: String,
        /// The time code.
        time: f64,
    },
    /// Samples of an attribute that the layer does not have.
    #[error("{0} has samples, but the layer has no such attribute")]
    NoAttribute(String),
    /// Text with a zero in it.
    #[error("a text with a zero character can't be written: {0:?}")]
    Zero(String),
    /// More than the format can number.
    #[error("more {0} than a file can hold")]
    TooMany(&'static str),
}

impl Error {
    pub(crate) fn io(path: &Path, error: &io::Error) -> Self {
        Error::Io { path: path.to_owned(), reason: error.to_string(), kind: error.kind() }
    }
}
