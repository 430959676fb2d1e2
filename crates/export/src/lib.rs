//! Runs of Rockfall as files that other programs open.
//!
//! [`export`] writes a [`Run`] in a [`Format`]. A format is one file of this crate: it says what it makes, a file or a folder, and writes it from a
//! [`Job`], which hands it the moments of the run in order while threads prepare those that follow. `docs/export.md` describes every format for people.
//!
//! | format | file |
//! |---|---|
//! | [`Vtp`] | ParaView: one file per frame, and a list of all |
//! | [`Usd`] | OpenUSD: one file, or value clips |
//! | [`Csv`] | one row per body and frame |
//! | [`Parquet`] | the same in columns |
//! | [`Glb`] | glTF: a still with instances, or an animation |
//!
//! What formats have in common: [`Run`] knows the bodies, frames and times; [`Inventory`] what bodies look like; [`prototypes`] turns shapes into
//! triangles; a [`Moment`] is where the bodies are at a frame and how they move; `target` puts the result in place, whole or not at all.
//!
//! The bytes of every file depend on the run and the options alone, not on the number of threads.
#![forbid(unsafe_code)]

mod color;
mod columns;
mod csv;
mod error;
mod export;
mod format;
mod glb;
mod inventory;
mod job;
mod moment;
mod parquet;
pub mod prototypes;
mod run;
mod select;
mod surface;
mod target;
mod usd;
mod vtp;

pub use crate::csv::Csv;
pub use crate::parquet::Parquet;
pub use color::{color, linear};
pub use error::Error;
pub use export::{Done, Options, export};
pub use format::{Format, Makes};
pub use glb::{Glb, MOST_ANIMATED};
pub use inventory::Inventory;
pub use job::{Detail, Job, Watch};
pub use moment::Moment;
pub use run::Run;
pub use select::{Frames, Ids};
pub use surface::{CHORDAL_ERROR, Surface};
pub use usd::Usd;
pub use vtp::Vtp;
