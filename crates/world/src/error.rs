//! What can go wrong.

use crate::BodyId;

/// Why the world refused something. It is left as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting is out of its range.
    #[error("setting `{name}` is {value}, expected {expected}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// What it was.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A number of a body or a material is out of its range.
    #[error("{what} is {value}, expected {expected}")]
    Value {
        /// Which number.
        what: &'static str,
        /// What it was.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A shape or material id that this world never gave.
    #[error("unknown {what} {index}")]
    Unknown {
        /// "shape" or "material".
        what: &'static str,
        /// The id.
        index: u32,
    },
    /// No body has this id.
    #[error("no body {}", .0.0)]
    NoBody(BodyId),
    /// Two bodies with one id.
    #[error("body {} exists already", .0.0)]
    Duplicate(BodyId),
    /// A shape makes no sense.
    #[error(transparent)]
    Shape(#[from] rockfall_shape::ShapeError),
    /// A surface without an inside can't move.
    #[error("a {shape} can't be dynamic, only static or kinematic")]
    Immovable {
        /// The kind of shape.
        shape: &'static str,
    },
    /// The threads could not be started.
    #[error("could not start {threads} threads: {reason}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}
