//! What must not break, whatever bytes it is given.
//!
//! A target takes bytes, makes of them what a user or a file could bring, and panics if the library does something that it must
//! not: a panic of its own, a number that is no number, an answer out of its range. An error is a good answer.
//!
//! `fuzz/` at the root of the repository has the same targets for `cargo fuzz`, which needs a nightly compiler. `tests/driver.rs` feeds them from
//! a stream of random numbers, also with what is nearly right, and stops what does not end.

#![forbid(unsafe_code)]

mod bytes;
mod files;
mod hull;
mod mesh;
mod pair;
mod run;
mod scene;
mod state;

pub use bytes::Bytes;
pub use files::{IMPORTS, MESH_FILES, import, mesh_file};
pub use hull::hull;
pub use mesh::mesh;
pub use pair::pair;
pub use run::{GoodRun, run_file};
pub use scene::scene;
pub use state::{checkpoint, good_checkpoint};
