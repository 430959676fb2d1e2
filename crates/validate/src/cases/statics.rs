//! What stands, leans and rests.

mod balls;
mod belt;
mod cards;
mod column;
mod cylinders;
mod ladder;
mod overhang;
mod pyramid;
mod tipping;
mod tower;

use crate::case::Case;

pub(super) const CASES: [Case; 11] = [
    overhang::CASE,
    cylinders::CASE,
    ladder::CASE,
    cards::CASE,
    tipping::CASE,
    tower::CASE,
    column::CASES[0],
    column::CASES[1],
    pyramid::CASE,
    balls::CASE,
    belt::CASE,
];

/// Name of the group.
const GROUP: &str = "statics";
