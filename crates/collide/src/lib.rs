//! Pure functions over pairs of shapes: contact manifolds, signed distance, casts.
//!
//! Every function sees shape B from the frame of shape A; nothing here knows bodies or the world. Normals are unit
//! vectors from A to B. A signed distance is negative where the shapes overlap.

mod closest;
mod feature;
mod gjk;
mod manifold;
mod poly;
mod reduce;
mod surface;

pub use closest::Distance;
pub use manifold::{Cache, ContactPoint, Manifold};
pub use surface::{convex_height_field, convex_mesh};
