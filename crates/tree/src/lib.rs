//! Broad phase: which boxes overlap which.

/// A bounding-volume hierarchy over boxes.
#[derive(Clone, Debug, Default)]
pub struct Tree {}
