//! Scene files of Rockfall: TOML, meshes, generators.
//!
//! [`Scene::load`] reads a file and checks all of it; [`Scene::build`] cooks the shapes, lays out the bodies and gives
//! a [`Running`] world. `docs/scene.md` describes every key; [`schema`] is the same for editors.
//!
//! The way through the crate: `load` reads files and merges what they include; `check` turns TOML into a tree of
//! values by the tables of keys that stand at the head of each shape's and each generator's file; `import` brings in scenes of
//! other programs; `start` reads the run that a scene begins with; `plan` cooks and places; `running` fills a world and pours into it.

#![forbid(unsafe_code)]

mod body;
mod cameras;
mod check;
mod crowd;
mod error;
mod generators;
mod import;
mod inside;
mod load;
mod manual;
mod memory;
pub use rockfall_import::mesh_file;
mod nesting;
mod node;
mod noise;
mod plan;
mod random;
mod region;
mod root;
mod rotation;
mod running;
mod scene;
mod schema;
mod shapes;
mod sizes;
mod source;
mod spec;
mod start;
mod tables;
mod terrain;
mod visual;
mod write;

pub use cameras::{Course, SceneCamera};
pub use error::{Place, Problem, SceneError};
pub use manual::keys as manual;
pub use memory::Estimate;
pub use plan::{BodyRow, Cut};
pub use rockfall_decompose::Misfit;
pub use root::Output;
pub use running::Running;
pub use scene::{Inventory, Scene};
pub use schema::schema;
pub use tables::{material_table, world_table};
pub use visual::{Color, Look};
