//! Very many bodies: heaps, silos, hoppers, drums. Lengths of balls are in diameters of 1 m, so that contacts, which give by a length that does not know sizes, are
//! hard beside them.

mod boxes;
mod crater;
mod drum;
mod heap;
mod hopper;
mod janssen;
mod line;
mod nut;
mod packing;
mod pressure;
mod repose;

use crate::case::Case;

pub(super) const CASES: [Case; 9] = [
    boxes::CASE,
    pressure::CASE,
    janssen::CASE,
    hopper::CASE,
    packing::CASE,
    repose::CASE,
    drum::CASE,
    crater::CASE,
    nut::CASE,
];

/// Name of the group.
const GROUP: &str = "grains";
