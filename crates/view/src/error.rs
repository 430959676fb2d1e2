//! What can go wrong.

use std::net::SocketAddr;
use std::path::PathBuf;

/// Why there is no page, or why something that was asked for on it was not done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Somebody else listens there.
    #[error("port {} of {} is taken by another program: choose another one with --port, or none for a free one", .0.port(), .0.ip())]
    Taken(SocketAddr),
    /// Nobody can listen there.
    #[error("cannot listen at {address}: {reason}")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// What the system says.
        reason: String,
    },
    /// A thread could not be started, or there are no random numbers for a token.
    #[error("cannot start: {0}")]
    Start(String),
    /// The scene is wrong.
    #[error(transparent)]
    Scene(#[from] rockfall_scene::SceneError),
    /// The run can't be read.
    #[error(transparent)]
    Run(#[from] rockfall_export::Error),
    /// What is to be seen is not known.
    #[error(transparent)]
    Picture(#[from] rockfall_picture::Error),
    /// The world refused something.
    #[error(transparent)]
    World(#[from] rockfall::Error),
    /// A file can't be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// What a viewer asks for can't be done here and now; the sentence says why.
    #[error("{0}")]
    Refused(String),
}

impl From<rockfall_cache::Error> for Error {
    fn from(error: rockfall_cache::Error) -> Self {
        Error::Run(error.into())
    }
}
