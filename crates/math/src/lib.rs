//! The ground floor of Rockfall: vectors, poses, boxes, lanes, deterministic trigonometry, hashes and
//! disjoint rows.
//!
//! Everything here gives the same bits on every machine: no fused multiply-add, no platform trigonometry,
//! no order of operations that depends on the width of a register.

pub mod aabb;
pub mod disjoint;
pub mod hash;
pub mod isometry;
pub mod lanes;
pub mod pose;
pub mod room;
pub mod rotation;
pub mod share;
pub mod snapshot;
pub mod trig;

pub use aabb::Aabb;
pub use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec2, Vec3};
pub use isometry::Isometry;
pub use pose::Pose;
