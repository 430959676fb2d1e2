//! The live page of Rockfall: a scene that is simulated, or a run, in a browser.
//!
//! A [`Door`] is opened first, so that a port that is taken is known before a scene is built; [`Door::serve`] then shows a [`Source`]. There are these threads:
//!
//! | thread | file | what |
//! |---|---|---|
//! | stage | `director.rs` | owns the world or the run, obeys what viewers ask for, and shows one moment after the other |
//! | door | `door.rs` | takes connections; each is read once: `request.rs`, `gate.rs` |
//! | two for each viewer | `viewer.rs` | one listens, one sends what is newest: `outbox.rs` |
//!
//! What goes over the wire is in [`wire`]; the page is in the folder `page`, and embedded.
#![forbid(unsafe_code)]

mod command;
mod details;
mod director;
mod door;
mod error;
mod gate;
mod history;
mod live;
mod outbox;
mod page;
mod recorded;
mod request;
mod save;
mod scenery;
mod source;
mod told;
mod toys;
mod viewer;
pub mod wire;

pub use door::{Door, Options, Server};
pub use error::Error;
pub use source::Source;
