//! Very many balls: heaps, silos, hoppers. Lengths are in diameters of 1 m, so that contacts, which give by a length that does not know sizes, are
//! hard beside them.

mod heap;
mod hopper;
mod janssen;
mod packing;
mod pressure;

use crate::case::Case;

pub(super) const CASES: [Case; 4] = [pressure::CASE, janssen::CASE, hopper::CASE, packing::CASE];

/// Name of the group.
const GROUP: &str = "grains";
