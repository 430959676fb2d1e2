//! Contact solvers. They see rows of bodies, manifolds and memories, and know no shapes.
//!
//! Contacts live in blocks of sixteen ([`contacts`]) from the step in which they are found. A step colours the new ones ([`paint`]), so
//! that no body stands twice in a colour, and sweeps over the blocks colour after colour. Within a colour the order of the
//! contacts does not matter, so that neither the number of threads nor the number of lanes can change a bit of the result.

pub mod advance;
mod arrange;
mod balls;
pub mod block;
pub mod bounce;
mod cold;
pub mod contacts;
mod copies;
pub mod desk;
pub mod drift;
mod effective;
pub mod follow;
pub mod forces;
pub mod impulse;
pub mod iterate;
pub mod line;
pub mod manifold;
pub mod paint;
mod plan;
pub mod push;
pub mod reflect;
pub mod respond;
mod retrace;
mod shelf;
mod single;
pub mod slender;
mod snapshot;
pub mod soft;
mod sweep;
pub mod tally;
mod total;
pub mod warm;
mod words;

pub use arrange::Entry;
pub use contacts::Contacts;
pub use desk::{Desk, Found, Leash};
pub use line::{Columns, Drift, Line};
pub use manifold::{FIXED, Manifold, Memory, NO_COLOR, row_of};
pub use shelf::{Lane, WORTH_TILES};
pub use single::Surface;
pub use soft::{Softness, SubStep};
