//! What a scene can begin with, and what it can ask for: runs of runs, contacts, events and columns.

#[path = "../common/mod.rs"]
#[expect(dead_code, reason = "nobody is stopped here")]
mod common;

mod extras;
mod start;
