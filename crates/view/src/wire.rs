//! What goes over the WebSocket.
//!
//! Text is JSON: from the page a command (`command.rs`), to the page an object whose `is` says what it is. Binary messages to the page start with a byte that says which
//! of the tables below it is. All numbers have their lowest byte first; offsets are in bytes.
//!
//! **1, a moment.** Bodies have no ids on the wire: their rows in the table of bodies name them. Only rows are sent that differ from what this viewer was sent last, so
//! what sleeps costs nothing; rows that were never sent are absent.
//!
//! | offset | type | what |
//! |---|---|---|
//! | 0 | u8 | 1 |
//! | 1 | u8 | 1: forget all records that were sent before |
//! | 4 | u32 | number of the message, which the page sends back as 4 bytes when it has read it; with two on their way a viewer is sent no more |
//! | 8 | u32 | frame |
//! | 12 | f32 | step of the grid, metres |
//! | 16 | f64 | simulated seconds |
//! | 24 | u32 | records |
//! | 28 | u32 | n, bytes of runs |
//! | 32 | n | runs of rows: how many are skipped, how many follow; each number seven bits a byte, lowest first, with the eighth bit set in all but the last |
//! | 32 + n to a multiple of 4 | 12 each | records |
//!
//! A record is three words, one for each axis: bits 0 to 19 are the position, in steps of the grid from its origin, plus 2¹⁹. Bits 20 to 30 are three of the four
//! numbers of the rotation, in their order, those but the largest in size: 2047 steps from -1/√2 to 1/√2; the largest is positive. Bits 31 of the first two words tell which one it is, and that
//! of the third one whether the body sleeps. A body that is not there has bits 0 to 19 of the first word set.
//!
//! A record is 12 bytes, and a run takes 4 at most below two million bodies: **at most 16 bytes for a body that moves**, beside the 32 of the message. A position is off by at most half a step on each axis,
//! which is a 2²⁰-th of the width of what was there at first, or less; a rotation by at most 0.0025 rad.
//!
//! **2, colours.** 4: u32 records, 8: u32 n, 12: runs as above, then 3 bytes each: red, green, blue in sRGB. Rows that were never sent are grey, 150 each.
//!
//! **3, meshes.** 4: u32 number of the first one, 8: u32 count. For each: u32 kind (0 flat faces, 1 ball, 2 plane, 3 smooth), u32 corners, u32 triangles, f32 radius; then corners (3 f32), and where it is smooth
//! their normals (3 f32), then triangles (3 u32).
//!
//! **4, bodies.** 4: u32 first row, 8: u32 count, 12: u32 1 to forget all former rows, meshes and records. For each: u32 mesh, 3 f32 scale, u32 bits: 1 it can move, 2 it is nothing to look at, 4 it is seen from inside as well.
//!
//! **5, lines of overlays.** 4: u32 count. For each: 2 × 3 f32 ends from the origin, metres, u32 colour in sRGB, lowest byte red, and in the highest byte 1 where both ends are one point.

mod colors;
mod lines;
mod moment;
mod record;
mod runs;
mod stage;

pub use colors::{Colors, SentColors, UNPAINTED};
pub use lines::{Line, lines};
pub use moment::{HEAD, Moment, Sent};
pub use record::{ABSENT, Grid, ROTATION_ERROR, Record};
pub use stage::{Body, Mesh, MeshKind, bodies, meshes};

/// The first byte of a binary message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Where bodies are.
    Moment = 1,
    /// What colour they have.
    Colors = 2,
    /// What they look like.
    Meshes = 3,
    /// Which there are.
    Bodies = 4,
    /// What is drawn over them.
    Lines = 5,
}

/// The first four bytes of a message.
fn begin(kind: Kind, flags: u8, room: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(room + 8);
    out.extend_from_slice(&[kind as u8, flags, 0, 0]);
    out
}

fn put(out: &mut Vec<u8>, number: u32) {
    out.extend_from_slice(&number.to_le_bytes());
}

fn put_f32(out: &mut Vec<u8>, numbers: &[f32]) {
    numbers.iter().for_each(|number| out.extend_from_slice(&number.to_le_bytes()));
}

/// Zeros up to a multiple of four bytes.
fn pad(out: &mut Vec<u8>) {
    out.resize(out.len().next_multiple_of(4), 0);
}
