//! What is drawn over bodies.

use super::{Kind, begin, put, put_f32};

/// A line, or a dot where both ends are one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Metres from the origin.
    pub from: [f32; 3],
    /// Metres from the origin.
    pub to: [f32; 3],
    /// sRGB.
    pub color: [u8; 3],
}

/// The message of all lines.
pub fn lines(lines: &[Line]) -> Vec<u8> {
    let mut out = begin(Kind::Lines, 0, 8 + 28 * lines.len());
    put(&mut out, lines.len() as u32);
    for line in lines {
        put_f32(&mut out, &line.from);
        put_f32(&mut out, &line.to);
        let [r, g, b] = line.color;
        out.extend_from_slice(&[r, g, b, u8::from(line.from == line.to)]);
    }
    out
}
