//! The promises of the convex pair functions.

mod brute_force;
mod manifolds;
mod opinion;
mod pairs;
mod smooth;
