//! Scenes of other programs, read.

mod damage;
mod gltf;
mod python;
mod reach;
mod usd;
