//! Files of other programs: meshes, and scenes of OpenUSD and glTF.
//!
//! [`read`] gives a scene's bodies, shapes and materials in metres, kilograms, seconds and radians, with z up, and says what of the file it can't give:
//! see [`Content`]. [`mesh_file`] reads the triangles of a file and nothing else.

#![forbid(unsafe_code)]

mod affine;
mod build;
mod content;
mod foreign;
mod form;
mod gltf_scene;
pub mod mesh_file;
mod read;
mod usd;

pub use content::{Body, Content, Geometry, Kind, Mass, Material, Mix, Note, Part, Weight};
pub use foreign::is_reading;
pub use read::{ImportError, Place, is_scene, read};
