//! Scene files of Rockfall: TOML, meshes, generators.

pub mod mesh_file;
