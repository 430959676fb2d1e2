//! The promises of the convex pair functions.

mod brute_force;
mod manifolds;
mod pairs;
