//! Runs of Rockfall on disk.
//!
//! A run is a folder with these parts; `docs/run.md` describes them for people who read them with other programs.
//!
//! | part | what |
//! |---|---|
//! | `scene.toml` | the scene as it was run, every default filled in |
//! | `summary.json` | [`Summary`]: what was run, how it ended, figures of the whole run |
//! | `frames.csv` | one row per step: [`csv`] |
//! | `trajectory.zarr` | the pose of every body at every frame: [`trajectory`] |
//! | `state.zarr` | where the bodies are at the end and how fast, to the bit: [`State`] |
//! | `start.zarr` | what the run began with, where that was a frame of another run: [`Start`] |
//! | `checkpoints` | the whole state at some frames, of a run that is not finished: [`Checkpoint`] |
//!
//! [`RunWriter`] writes one from a thread of its own while the simulation goes on, or goes on with one that has ended early; [`RunReader`] reads one. Whenever
//! a run ends, by itself, by a key or by a power cut, what it had written so far can be read.
#![forbid(unsafe_code)]

mod checkpoint;
mod columns;
mod contacts;
pub mod csv;
mod error;
mod events;
mod extras;
mod folder;
mod frame;
mod group;
mod lock;
mod motion;
mod moving;
mod precision;
mod ragged;
mod reader;
mod seal;
mod sheet;
mod start;
mod state;
mod store;
mod summary;
pub mod trajectory;
mod writer;

pub use checkpoint::Checkpoint;
pub use columns::{Column, Number, Values};
pub use contacts::{Contacts, WantedContacts};
pub use error::Error;
pub use events::{Event, EventKind, WantedEvents};
pub use extras::{ColumnReader, ContactsReader, EventsReader};
pub use folder::{CHECKPOINTS, FRAMES, LOCK, RunFolder, SCENE, START, STATE, SUMMARY, TRAJECTORY};
pub use frame::{BodyTable, Frame, Poses, Velocities};
pub use motion::mean_velocities;
pub use precision::Precision;
pub use reader::{Part, RunReader};
pub use seal::checksum;
pub use sheet::NumberType;
pub use start::Start;
pub use state::{State, VelocityOf};
pub use summary::{Breach, FORMAT, Final, Status, Summary, VERSION, Whole};
pub use trajectory::Contents;
pub use writer::{RunWriter, Written};
