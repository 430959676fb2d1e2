//! Coulomb's law: what slides, what rolls, what stays.

mod angular;
mod block;
mod directions;
mod edges;
mod painleve;
mod rolling;
mod round;
mod stand;
mod stiction;
mod travel;

use crate::case::Case;

pub(super) const CASES: [Case; 10] = [
    block::CASE,
    round::CASE,
    rolling::CASE,
    travel::CASE,
    directions::CASE,
    angular::CASE,
    stiction::CASE,
    stand::CASE,
    painleve::CASE,
    edges::CASE,
];

/// Name of the group.
const GROUP: &str = "friction";
