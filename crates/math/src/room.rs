//! Memory that follows the size of its content both ways.

/// Capacities between two powers of two. Few sizes, so that what one vector gives back fits the next.
const CLASSES: usize = 8;

/// Gives `v` room for `len` items and up to an eighth more. A vector that grows by pushing keeps up to twice of what it
/// ever held; of one vector per run of pairs that would be a third of all memory.
pub fn make_room<T>(v: &mut Vec<T>, len: usize) {
    if v.capacity() < len {
        v.reserve_exact(class(len) - v.len().min(len));
    } else if v.capacity() > class(len + len / 4) {
        v.shrink_to(class(len));
    }
}

/// The smallest capacity in use that holds `len` items.
fn class(len: usize) -> usize {
    let step = (len.next_power_of_two() / (2 * CLASSES)).max(1);
    len.next_multiple_of(step)
}

/// Asks the C library's allocator to map every block of 128 KiB and more on its own, and to give it back when it is freed;
/// for programs, before their first world. Without, GNU's allocator takes the size of the first large block that it frees for a sign
/// that such blocks come and go, and keeps them in heaps that fray: a pile of 10,000 boxes then needs a third more memory. Does
/// nothing where that library is not in use.
pub fn map_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: sets a number under the allocator's own lock; both arguments are documented values.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 128 << 10);
    }
}

/// Gives memory that was freed but not yet given back to the system, between blocks that are in use too. Takes milliseconds; for
/// when much was freed that will not be needed again soon. Does nothing where GNU's C library is not in use.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: frees nothing that is in use, under the allocator's own locks.
    unsafe {
        libc::malloc_trim(0);
    }
}

#[cfg(test)]
mod tests {
    use super::make_room;

    #[test]
    fn follows_up_and_down() {
        let mut v: Vec<u64> = Vec::new();
        make_room(&mut v, 1000);
        assert!((1000..1130).contains(&v.capacity()));
        v.resize(1000, 7);
        make_room(&mut v, 1010);
        assert!((1010..1130).contains(&v.capacity()));
        v.truncate(100);
        make_room(&mut v, 100);
        assert!((100..130).contains(&v.capacity()) && v.len() == 100);
    }
}
