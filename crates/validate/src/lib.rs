//! Rockfall against answers that are known from elsewhere: closed forms, published tables, other engines' test suites, experiments.
//!
//! A case is a small file in `cases`: where it is from, its set-up, and a function that drives an engine through it and says what came
//! out beside what is expected, how far off it may be, and why. [`run`] takes cases and engines, and its [`Report`] is a table for
//! terminals, JSON, or a page. A check that fails stays there as failed, with its figure.

#![deny(unsafe_code)] // But in peers that are written in C++.

mod case;
mod cases;
mod engine;
mod finding;
mod number;
mod page;
mod report;
mod stage;
mod table;

pub use case::{Case, Source};
pub use cases::cases;
pub use engine::EngineName;
pub use finding::{Check, Figure, Gate, Line, LineKind, Published};
pub use report::{Choice, Outcome, Report, run};

/// What keeps a case from having a result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An engine refuses what the case puts into it.
    #[error("{0}")]
    World(#[from] rockfall::Error),
    /// A shape of the case makes no sense.
    #[error("{0}")]
    Shape(#[from] rockfall::shape::ShapeError),
    /// A hull of the case makes no sense.
    #[error("{0}")]
    Hull(#[from] rockfall::shape::HullError),
    /// A peer lacks a shape of the case.
    #[error("{engine} has no {shape}")]
    NoShape {
        /// Which engine.
        engine: &'static str,
        /// Kind of shape.
        shape: &'static str,
    },
    /// A peer refuses what the case puts into it.
    #[error("{engine}: {reason}")]
    Peer {
        /// Which engine.
        engine: &'static str,
        /// What it says.
        reason: String,
    },
    /// A peer is not in this build.
    #[error("this build has no {engine}; build it with the cargo feature `{feature}`")]
    NotBuilt {
        /// Which engine.
        engine: &'static str,
        /// The feature that has it.
        feature: &'static str,
    },
    /// There is no case of that name.
    #[error("there is no case and no group `{name}`; expected one of {known}")]
    NoCase {
        /// What was asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// JSON could not be written.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
}
