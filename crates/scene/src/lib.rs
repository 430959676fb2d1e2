//! Scene files of Rockfall: TOML, meshes, generators.
