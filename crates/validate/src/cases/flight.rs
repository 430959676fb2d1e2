//! Bodies that nothing touches: flight and tops.

mod gazebo;
mod gyroscope;
mod projectile;
mod top;

use crate::case::Case;

pub(super) const CASES: [Case; 7] = [
    projectile::CASE,
    top::CASE,
    gazebo::CASES[0],
    gazebo::CASES[1],
    gyroscope::CASES[0],
    gyroscope::CASES[1],
    gyroscope::CASES[2],
];

/// Name of the group.
const GROUP: &str = "flight";
