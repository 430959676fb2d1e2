//! What an engine says of itself: how its solution changes with its step, and with what nobody could have measured.

mod convergence;
mod spread;

use crate::case::Case;

pub(super) const CASES: [Case; 2] = [convergence::CASE, spread::CASE];

/// Name of the group.
const GROUP: &str = "consistency";
