//! What can go wrong with a film.

use std::path::PathBuf;

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The codec keeps colours for every other pixel only.
    #[error("a film of {width} × {height} pixels can't be made: both have to be even, from 16 to 65534")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Too slow, too fast, or no number.
    #[error("a film can't show {0} pictures a second, expected from 0.001 to 1000")]
    Rate(f64),
    /// A picture has another size than the film.
    #[error("a picture has {found} pixels, and the film {expected}")]
    Picture {
        /// Pixels of the film.
        expected: usize,
        /// Pixels of the picture.
        found: usize,
    },
    /// The file can't be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The encoder gave up.
    #[error("cannot encode {}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What it says.
        reason: String,
    },
}
