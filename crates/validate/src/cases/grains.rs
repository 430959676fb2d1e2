//! Very many bodies: heaps, silos, hoppers. Lengths of balls are in diameters of 1 m, so that contacts, which give by a length that does not know sizes, are
//! hard beside them.

mod boxes;
mod heap;
mod hopper;
mod janssen;
mod packing;
mod pressure;

use crate::case::Case;

pub(super) const CASES: [Case; 5] = [boxes::CASE, pressure::CASE, janssen::CASE, hopper::CASE, packing::CASE];

/// Name of the group.
const GROUP: &str = "grains";
