//! Runs on disk, written from several sides and read from several others.

mod bounded;
mod corrupt;
mod extras;
mod promises;
mod python;
mod resume;
mod synthetic;
