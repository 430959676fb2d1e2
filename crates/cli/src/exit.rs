//! How the program ends.

use crate::say;
use rockfall_scene::SceneError;
use std::io::{IsTerminal, stderr};
use std::process::ExitCode;

/// Why the program did not do what it was asked for. Each has its exit code; `docs/run.md` lists them.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Something outside the scene: disk, threads.
    Run(String),
    /// What was asked for makes no sense, or is not in this build.
    Usage(String),
    /// The scene is wrong; the text is complete, with its place and what was expected.
    Scene(String),
    /// The last state has another hash.
    Hash {
        /// What was asked for.
        expected: u64,
        /// What came out.
        found: u64,
    },
    /// Two runs differ, or a result is not the known one; that has been said.
    Different,
    /// Somebody stopped the run; what it had done is on disk.
    Interrupted,
}

impl Failure {
    /// Says what went wrong, on standard error, and gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        match self {
            Failure::Run(text) | Failure::Usage(text) => say::error(&format!("Error: {text}")),
            Failure::Scene(text) => say::error(text.trim_end()),
            Failure::Hash { expected, found } => {
                say::error(&format!("Error: the hash is {found:016x}, expected {expected:016x}"));
            }
            Failure::Different | Failure::Interrupted => {}
        }
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Failure::Run(_) => 1,
            Failure::Usage(_) => 2,
            Failure::Scene(_) => 3,
            Failure::Hash { .. } | Failure::Different => 4,
            Failure::Interrupted => INTERRUPTED,
        }
    }
}

/// What shells expect of a program that Ctrl-C ended: 128 + SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Failure::Scene(error.render(stderr().is_terminal()))
    }
}

impl From<rockfall_cache::Error> for Failure {
    fn from(error: rockfall_cache::Error) -> Self {
        Failure::Run(error.to_string())
    }
}

impl From<rockfall_film::Error> for Failure {
    fn from(error: rockfall_film::Error) -> Self {
        use rockfall_film::Error;
        match error {
            Error::Size { .. } | Error::Rate(_) => Failure::Usage(error.to_string()),
            other => Failure::Run(other.to_string()),
        }
    }
}

impl From<rockfall_picture::Error> for Failure {
    fn from(error: rockfall_picture::Error) -> Self {
        use rockfall_picture::Error;
        match error {
            Error::Run(error) => error.into(),
            Error::Unknown { .. } => Failure::Usage(error.to_string()),
            other => Failure::Run(other.to_string()),
        }
    }
}

impl From<rockfall_view::Error> for Failure {
    fn from(error: rockfall_view::Error) -> Self {
        use rockfall_view::Error;
        match error {
            Error::Scene(error) => error.into(),
            Error::Run(error) => error.into(),
            other => Failure::Run(other.to_string()),
        }
    }
}

impl From<rockfall_export::Error> for Failure {
    fn from(error: rockfall_export::Error) -> Self {
        use rockfall_export::Error;
        match error {
            Error::Scene(error) => error.into(),
            Error::Stopped => Failure::Interrupted,
            Error::NoFrame { .. } | Error::NoBody(_) | Error::Limit(_) => Failure::Usage(error.to_string()),
            other => Failure::Run(other.to_string()),
        }
    }
}
