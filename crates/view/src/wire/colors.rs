//! What colour bodies have.

use super::runs::changed;
use super::{Kind, begin, pad, put};
use std::sync::Arc;

/// Of each row of the table: red, green, blue in sRGB; and what explains them, as JSON.
#[derive(Clone, Debug)]
pub struct Colors {
    /// By rows.
    pub colors: Vec<[u8; 3]>,
    /// The legend.
    pub legend: Arc<str>,
}

/// What a body has that nobody has painted.
pub const UNPAINTED: [u8; 3] = [150; 3];

/// What a viewer has been sent.
#[derive(Debug, Default)]
pub struct SentColors {
    colors: Vec<[u8; 3]>,
    /// The legend.
    pub legend: Option<Arc<str>>,
}

impl Colors {
    /// The message for a viewer; `None` where it knows all of it.
    pub fn message(&self, sent: &mut SentColors) -> Option<Vec<u8>> {
        let mut values = Vec::new();
        let (runs, count) =
            changed(&self.colors, &mut sent.colors, UNPAINTED, |color| values.extend_from_slice(&color));
        if count == 0 {
            return None;
        }
        let mut out = begin(Kind::Colors, 0, 16 + runs.len() + values.len());
        put(&mut out, count);
        put(&mut out, runs.len() as u32);
        out.extend_from_slice(&runs);
        pad(&mut out);
        out.extend_from_slice(&values);
        Some(out)
    }
}
