//! Collisions: what bounces, and how high.

mod bounce;
mod bullets;
mod cradle;
mod experiment;
mod head_on;
mod pairings;
mod walton;

use crate::case::Case;

pub(super) const CASES: [Case; 7] = [
    bounce::CASE,
    head_on::CASE,
    pairings::CASE,
    cradle::CASE,
    walton::CASE,
    experiment::CASE,
    bullets::CASE,
];

/// Name of the group.
const GROUP: &str = "impact";
