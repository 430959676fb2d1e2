//! What a scene can begin with, and what it can ask for: runs of runs, contacts, events and columns.

#[path = "../common/mod.rs"]
mod common;

mod extras;
mod start;
