//! What a format is.

use crate::{Error, Job};
use std::path::Path;

/// A way to write a run. To add one, copy the file of a neighbour, and name it where the program reads `--to`.
pub trait Format: Sync {
    /// What `--to` calls it.
    fn name(&self) -> &'static str;

    /// A file or a folder.
    fn makes(&self) -> Makes;

    /// Writes the output at `to`: a file that does not exist yet, or a folder that is empty. It is moved into its place afterwards, so that names
    /// within the output must be relative.
    ///
    /// # Errors
    /// Those of [`Job::stream`], [`Error::Io`], and what the format can't hold.
    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error>;
}

/// What a format makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Makes {
    /// One file.
    File {
        /// How its name ends.
        extension: &'static str,
    },
    /// A folder of files.
    Folder {
        /// How their names end. A folder with anything else in it is never replaced.
        extensions: &'static [&'static str],
    },
}
