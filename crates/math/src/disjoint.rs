//! Rows of one table written by many threads, no row by two.

use core::cell::UnsafeCell;
use core::marker::PhantomData;

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// A slice whose rows several threads read and write at once, under the promise that no row that one of them writes is
/// touched by another. Colours of the solver keep that promise: no body stands twice in a colour.
#[derive(Debug)]
pub struct DisjointRows<'a, T> {
    rows: *const UnsafeCell<T>,
    len: usize,
    borrowed: PhantomData<&'a mut [T]>,
}

// SAFETY: the pointer comes from an exclusive borrow that lasts for 'a; access to one row from two threads is excluded
// by the contract of `get` and `set`, so that sharing amounts to sending each row to one thread.
unsafe impl<T: Send> Sync for DisjointRows<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Send> Send for DisjointRows<'_, T> {}

impl<'a, T> DisjointRows<'a, T> {
    /// Borrows `rows` for shared writing.
    pub fn new(rows: &'a mut [T]) -> Self {
        DisjointRows {
            rows: rows.as_mut_ptr() as *const UnsafeCell<T>,
            len: rows.len(),
            borrowed: PhantomData,
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Reads row `i`.
    ///
    /// # Panics
    /// When there is no row `i`.
    ///
    /// # Safety
    /// No other thread writes row `i` while the reference lives, and this thread does not write it either.
    #[inline(always)]
    pub unsafe fn get(&self, i: usize) -> &T {
        assert!(i < self.len);
        // SAFETY: `i` is in bounds; that nobody writes the row is the caller's promise.
        unsafe { &*(*self.rows.add(i)).get() }
    }

    /// [`DisjointRows::get`] of a row that is known to be there, as after [`DisjointRows::has`].
    ///
    /// # Safety
    /// `i` is smaller than [`DisjointRows::len`], and the promise of [`DisjointRows::get`].
    #[inline(always)]
    pub unsafe fn get_unchecked(&self, i: usize) -> &T {
        debug_assert!(i < self.len);
        // SAFETY: both are the caller's promise.
        unsafe { &*(*self.rows.add(i)).get() }
    }

    /// [`DisjointRows::row`] of a row that is known to be there, as after [`DisjointRows::has`].
    ///
    /// # Safety
    /// `i` is smaller than [`DisjointRows::len`], and the promise of [`DisjointRows::row`].
    #[inline(always)]
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn row_unchecked(&self, i: usize) -> &mut T {
        debug_assert!(i < self.len);
        // SAFETY: both are the caller's promise.
        unsafe { &mut *(*self.rows.add(i)).get() }
    }

    /// Asks once for many rows, which costs a few instructions for all of them together.
    ///
    /// # Panics
    /// When one of them is not there.
    #[inline(always)]
    pub fn has(&self, rows: &[u32]) {
        let last = rows.iter().fold(0, |last, &row| if row > last { row } else { last });
        assert!((last as usize) < self.len);
    }

    /// Asks the processor to bring a row to the nearest cache, since it is needed soon. Does nothing that a program could see, whether or not
    /// there is such a row, and nothing at all where the processor is not an x86.
    #[inline(always)]
    pub fn fetch(&self, i: usize) {
        #[cfg(target_arch = "x86_64")]
        for line in 0..size_of::<T>().div_ceil(LINE) {
            use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let address = self.rows.wrapping_add(i).cast::<i8>().wrapping_add(line * LINE);
            // SAFETY: the instruction faults at no address and reads nothing, whatever other threads write.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(address) };
        }
    }

    /// A row to write to.
    ///
    /// # Panics
    /// When there is no row `i`.
    ///
    /// # Safety
    /// No other reference to row `i` is alive, in this thread or in another.
    #[inline(always)]
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn row(&self, i: usize) -> &mut T {
        assert!(i < self.len);
        // SAFETY: `i` is in bounds; that the reference is the only one is the caller's promise.
        unsafe { &mut *(*self.rows.add(i)).get() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_write_their_own_rows() {
        let mut table = vec![0_usize; 1000];
        let rows = DisjointRows::new(&mut table);
        std::thread::scope(|scope| {
            for t in 0..4 {
                let rows = &rows;
                scope.spawn(move || {
                    for i in (t..rows.len()).step_by(4) {
                        // SAFETY: thread t is the only one to touch rows congruent to t.
                        unsafe { *rows.row(i) = i + t };
                    }
                });
            }
        });
        assert!(table.iter().enumerate().all(|(i, &x)| x == i + i % 4));
    }

    #[test]
    #[should_panic(expected = "self.len")]
    fn a_row_that_is_not_among_many_is_caught() {
        let mut table = [0.0_f32; 3];
        let rows = DisjointRows::new(&mut table);
        rows.has(&[2, 0, 1]);
        rows.has(&[2, 3, 1]);
    }

    #[test]
    #[should_panic(expected = "i < self.len")]
    fn out_of_bounds_is_caught() {
        let mut table = [0.0_f32; 2];
        let rows = DisjointRows::new(&mut table);
        // SAFETY: nothing else refers to the table; the row does not exist.
        unsafe { *rows.row(2) = 1.0 };
    }
}
