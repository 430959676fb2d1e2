//! Collisions: what bounces, and how high.

mod bounce;
mod bullets;
mod cradle;
mod experiment;
mod head_on;
mod walton;

use crate::case::Case;

pub(super) const CASES: [Case; 6] =
    [bounce::CASE, head_on::CASE, cradle::CASE, walton::CASE, experiment::CASE, bullets::CASE];

/// Name of the group.
const GROUP: &str = "impact";
