//! What the pairs of parts of two compounds remember, in the room of one.
//!
//! | bits | for each of two pairs of parts, the first in their order that touch |
//! |---|---|
//! | 0–12 | the cache of two boxes; 0 for any other, which a cache makes only faster |
//! | 13–15 | which parts they are: see [`tag`] |
//!
//! Without it, boxes that are parts chose the corners by which they lie on each other anew in every step, and of 480 such blocks in a deep pile some rattled for ever.

use crate::Cache;

/// Bits of a cache.
const BITS: u32 = 13;

/// Names a pair of parts: different for each two of two parts, and for few of more.
pub(super) fn tag(outer: u32, part: u32) -> u32 {
    (2 * outer + part) & 7
}

/// Two slots as they were, and as they will be.
pub(super) struct Memory {
    before: [u16; 2],
    after: [u16; 2],
    kept: usize,
}

impl Memory {
    pub(super) fn new(word: u32) -> Self {
        Memory { before: [word as u16, (word >> 16) as u16], after: [0; 2], kept: 0 }
    }

    pub(super) fn word(&self) -> u32 {
        u32::from(self.after[0]) | u32::from(self.after[1]) << 16
    }

    /// What a pair of parts knows; of two that have one name the first is told what the first knew.
    pub(super) fn recall(&mut self, tag: u32) -> Cache {
        let of_tag = |slot: &&mut u16| **slot != 0 && u32::from(**slot) >> BITS == tag;
        let word = self.before.iter_mut().find(of_tag).map_or(0, std::mem::take);
        Cache { word: u32::from(word) & ((1 << BITS) - 1), ..Cache::default() }
    }

    /// Keeps what a pair of parts that touches knows now, if there is room.
    pub(super) fn keep(&mut self, tag: u32, cache: Cache) {
        if cache.word != 0 && cache.word < 1 << BITS && self.kept < self.after.len() {
            self.after[self.kept] = (cache.word | tag << BITS) as u16;
            self.kept += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_of_parts_gets_its_own_back() {
        let cache = |word| Cache { word, ..Cache::default() };
        let tags = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| tag(tag(0, i), j));
        let mut memory = Memory::new(0);
        assert_eq!(memory.recall(tags[1]), Cache::default());
        memory.keep(tags[1], cache(0x1abc));
        memory.keep(tags[2], cache(0x0123));
        // There is no room for a third, nor for what is longer.
        memory.keep(tags[3], cache(0x0042));
        let mut again = Memory::new(memory.word());
        assert_eq!(again.recall(tags[3]), Cache::default());
        assert_eq!(again.recall(tags[2]), cache(0x0123));
        assert_eq!(again.recall(tags[1]), cache(0x1abc));
        assert_eq!(again.recall(tags[1]), Cache::default());
        again.keep(tags[0], cache(1 << BITS));
        assert_eq!(again.word(), 0);
    }
}
