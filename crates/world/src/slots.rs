//! Which slot belongs to which id.
//!
//! Ids are most often given one after the other, so a plain table serves nearly all of them in four bytes each; those that are far beyond all
//! others go to a map.

use std::collections::HashMap;

/// In the table, an id that nobody has.
const NONE: u32 = u32::MAX;

/// An id goes to the table if that has then at most so many entries for every id in use, whatever the ids are: 16 bytes.
const PER_ID: usize = 4;

/// Ids to slots.
#[derive(Debug, Default)]
pub(crate) struct Slots {
    table: Vec<u32>,
    map: HashMap<u64, u32>,
    len: usize,
}

impl Slots {
    /// Number of ids.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The slot of an id.
    pub(crate) fn get(&self, id: u64) -> Option<u32> {
        let in_table =
            usize::try_from(id).ok().and_then(|id| self.table.get(id)).filter(|&&slot| slot != NONE);
        in_table.or_else(|| self.map.get(&id)).copied()
    }

    /// Gives a new id its slot, which is below `u32::MAX`.
    pub(crate) fn insert(&mut self, id: u64, slot: u32) {
        match usize::try_from(id) {
            Ok(index) if index < PER_ID * (self.len + 1) || index < self.table.len() => {
                if index >= self.table.len() {
                    self.table.resize(index + 1, NONE);
                }
                self.table[index] = slot;
            }
            _ => {
                self.map.insert(id, slot);
            }
        }
        self.len += 1;
    }

    /// Forgets an id and returns its slot.
    pub(crate) fn remove(&mut self, id: u64) -> Option<u32> {
        let entry =
            usize::try_from(id).ok().and_then(|id| self.table.get_mut(id)).filter(|slot| **slot != NONE);
        let slot = entry.map(|slot| std::mem::replace(slot, NONE)).or_else(|| self.map.remove(&id));
        self.len -= usize::from(slot.is_some());
        slot
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.table.capacity() * size_of::<u32>() + self.map.capacity() * (size_of::<(u64, u32)>() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ids that grow faster than their number, none of which is far beyond the one before.
    #[test]
    fn the_table_is_no_longer_than_its_ids_are_worth() {
        let mut slots = Slots::default();
        for k in 0..2000 {
            slots.insert(k * k, k as u32);
            assert!(slots.table.len() <= PER_ID * slots.len());
        }
        assert!((0..2000).all(|k| slots.get(k * k) == Some(k as u32)));
        // As emitters give them, from wherever on.
        let mut slots = Slots::default();
        (100..5000).for_each(|id| slots.insert(id, id as u32));
        assert!(slots.map.len() < 50);
    }

    #[test]
    fn ids_near_and_far_are_found_until_they_are_removed() {
        let mut slots = Slots::default();
        let ids = [0, 1, 2, 7, 5_000_000_000, 3, u64::MAX - 1, 40, 1_000_000, 8, 9];
        for (slot, &id) in ids.iter().enumerate() {
            assert_eq!(slots.get(id), None);
            slots.insert(id, slot as u32);
        }
        assert_eq!(slots.len(), ids.len());
        assert!(slots.table.len() < 100, "a far id does not make the table long");
        for (slot, &id) in ids.iter().enumerate() {
            assert_eq!(slots.get(id), Some(slot as u32));
        }
        for (slot, &id) in ids.iter().enumerate() {
            assert_eq!(slots.remove(id), Some(slot as u32));
            assert_eq!((slots.get(id), slots.remove(id)), (None, None));
        }
        assert_eq!(slots.len(), 0);
    }
}
