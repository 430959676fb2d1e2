//! The promises of the convex pair functions.

mod brute_force;
#[path = "../common/mod.rs"]
mod common;
mod known_depths;
mod manifolds;
mod opinion;
mod pairs;
mod peers;
mod smooth;
mod thin_boxes;
