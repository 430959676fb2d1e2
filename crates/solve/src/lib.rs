//! Contact solvers. They see rows of bodies, manifolds and memories, and know no shapes.
//!
//! A step paints the manifolds ([`paint`]) so that no body stands twice in a colour, cuts each colour into blocks of 16
//! contacts ([`batch`]), and sweeps over the blocks. Within a colour the order of the contacts does not matter, so that
//! neither the number of threads nor the number of lanes can change a bit of the result.

pub mod batch;
pub mod block;
pub mod bounce;
pub mod drift;
mod effective;
mod fill;
pub mod impulse;
pub mod iterate;
pub mod line;
pub mod manifold;
pub mod paint;
pub mod push;
pub mod reflect;
pub mod respond;
mod shelve;
pub mod soft;
pub mod store;
mod sweep;
pub mod warm;

pub use batch::{Batches, Surface};
pub use line::{Columns, Drift, Line};
pub use manifold::{Chunk, FIXED, Manifold, Memory, NO_COLOR, row_of};
pub use soft::{Softness, SubStep};
