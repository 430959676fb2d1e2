//! Tables of blocks, word by word.
//!
//! Threads that read and write single lanes have lanes of their own, but these lie between one another's. So words are read and
//! written as atomics, in no order: that costs nothing, and a mistake would give a wrong contact, not undefined behaviour.

use crate::block::LANES;
use std::sync::atomic::AtomicU32;

/// Lane l of a row, word by word.
pub(crate) type Row = [[AtomicU32; LANES]];

/// A table of blocks as words: of each row `width` times [`LANES`].
pub(crate) struct Words<'a> {
    words: &'a Row,
    /// Words of a lane.
    width: usize,
}

impl<'a> Words<'a> {
    /// `table` has rows of columns of [`LANES`] numbers of 32 bits, and nothing else.
    pub(crate) fn new<B: Copy + 'a>(table: &'a mut [B]) -> Self {
        const { assert!(size_of::<B>().is_multiple_of(size_of::<[u32; LANES]>())) };
        let width = size_of::<B>() / size_of::<[u32; LANES]>();
        let len = table.len() * width;
        // SAFETY: an exclusive borrow of plain numbers of 32 bits, as many as `len` columns have, becomes a shared one of atomics of
        // the same size and alignment, for as long.
        let words = unsafe { std::slice::from_raw_parts(table.as_mut_ptr().cast(), len) };
        Words { words, width }
    }

    pub(crate) fn row(&self, block: usize) -> &Row {
        &self.words[block * self.width..(block + 1) * self.width]
    }
}
