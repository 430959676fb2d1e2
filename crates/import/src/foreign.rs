//! Calls into the readers that other people wrote: should one of them panic on a file, that is the file's error and not ours.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static AT_WORK: Cell<bool> = const { Cell::new(false) };
}

/// What a reader makes of a file; `None` where it panics. What it was given is not to be used then.
pub(crate) fn foreign<T>(read: impl FnOnce() -> T) -> Option<T> {
    let before = AT_WORK.replace(true);
    let read = catch_unwind(AssertUnwindSafe(read));
    AT_WORK.set(before);
    read.ok()
}

/// Whether this thread is in the reader of a file, whose panics become errors. A program that has a panic hook asks here whether there is anything to tell
/// people; this library installs none, since a hook is there for all threads.
pub fn is_reading() -> bool {
    AT_WORK.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_nothing_and_the_thread_reads_no_more() {
        assert!(!is_reading());
        assert_eq!(foreign(|| (is_reading(), foreign(is_reading))), Some((true, Some(true))));
        assert_eq!(
            foreign(|| (foreign(|| panic!("a reader gives up")).map(|(): ()| 1), is_reading())),
            Some((None, true))
        );
        assert!(!is_reading());
    }
}
