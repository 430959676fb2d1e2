//! Loops that other threads share, unless this one is alone.
//!
//! A step of a few hundred bodies takes some ten microseconds. To wake a thread of a pool for it, and to be woken when it is done, costs a processor
//! as much again; so a thread that does a small step by itself says so ([`alone`]), and loops that end in [`Share::shared`] then
//! run where they are called: no pool is asked, woken or even made. They give the same either way.

use rayon::iter::plumbing::{Consumer, Folder, Producer, ProducerCallback, UnindexedConsumer};
use rayon::prelude::*;
use std::cell::Cell;

thread_local! {
    /// Whether this thread shares nothing.
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Does `work` on this thread alone.
pub fn alone<R>(work: impl FnOnce() -> R) -> R {
    /// Also where `work` panics.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            ALONE.set(self.0);
        }
    }
    let _before = Before(ALONE.replace(true));
    work()
}

/// Whether this thread does its work alone.
pub fn is_alone() -> bool {
    ALONE.get()
}

/// Threads that share a loop of this one.
pub fn threads() -> usize {
    if is_alone() { 1 } else { rayon::current_num_threads() }
}

/// Number of this thread among those that share a loop.
pub fn thread() -> usize {
    if is_alone() { 0 } else { rayon::current_thread_index().unwrap_or_default() }
}

/// Both, side by side where somebody shares.
pub fn both(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if is_alone() {
        a();
        b();
    } else {
        rayon::join(a, b);
    }
}

/// Of parallel iterators.
pub trait Share: IndexedParallelIterator {
    /// The same items in the same order, by this thread where it is [`alone`]. What comes after may filter and map, but not zip or
    /// count: the loop is run by the last iterator that knows its length.
    fn shared(self) -> Shared<Self> {
        Shared(self)
    }
}

impl<I: IndexedParallelIterator> Share for I {}

/// See [`Share::shared`].
#[derive(Clone, Debug)]
pub struct Shared<I>(I);

impl<I: IndexedParallelIterator> ParallelIterator for Shared<I> {
    type Item = I::Item;

    fn drive_unindexed<C: UnindexedConsumer<Self::Item>>(self, consumer: C) -> C::Result {
        self.drive(consumer)
    }

    fn opt_len(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

impl<I: IndexedParallelIterator> IndexedParallelIterator for Shared<I> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn drive<C: Consumer<Self::Item>>(self, consumer: C) -> C::Result {
        if is_alone() { self.0.with_producer(Here(consumer)) } else { self.0.drive(consumer) }
    }

    fn with_producer<B: ProducerCallback<Self::Item>>(self, callback: B) -> B::Output {
        self.0.with_producer(callback)
    }
}

/// Gives a consumer all items at once.
struct Here<C>(C);

impl<T, C: Consumer<T>> ProducerCallback<T> for Here<C> {
    type Output = C::Result;

    fn callback<P: Producer<Item = T>>(self, producer: P) -> C::Result {
        producer.fold_with(self.0.into_folder()).complete()
    }
}

/// Sorts by all threads that share, of slices.
pub trait ShareSort<T: Send> {
    /// Ascending; equal ones in any order.
    fn sort_shared(&mut self)
    where
        T: Ord;

    /// By a key, ascending; equal ones in any order.
    fn sort_shared_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync);

    /// By a key, ascending; equal ones in the order in which they are.
    fn sort_shared_stably_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync);
}

impl<T: Send> ShareSort<T> for [T] {
    fn sort_shared(&mut self)
    where
        T: Ord,
    {
        if is_alone() { self.sort_unstable() } else { self.par_sort_unstable() }
    }

    fn sort_shared_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync) {
        if is_alone() { self.sort_unstable_by_key(key) } else { self.par_sort_unstable_by_key(key) }
    }

    fn sort_shared_stably_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync) {
        if is_alone() { self.sort_by_key(key) } else { self.par_sort_by_key(key) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Gives = (Vec<usize>, Vec<usize>, usize, Option<usize>, Vec<(usize, u8)>, Vec<u64>);

    /// What each kind of loop that a step has gives.
    fn loops() -> Gives {
        let numbers: Vec<usize> = (0..10_000).collect();
        let mut sorted: Vec<u64> = (0..10_000).map(crate::hash::mix).collect();
        sorted.sort_shared();
        let rows = || numbers.par_iter().with_min_len(64).shared();
        (
            rows().map(|x| 2 * x).collect(),
            rows().copied().filter(|x| x % 3 == 0).collect(),
            rows().copied().fold(|| 0, |a, b| a + b).reduce(|| 0, |a, b| a + b),
            rows().copied().max(),
            rows().flat_map_iter(|&x| [(x, 0), (x, 1)]).collect(),
            sorted,
        )
    }

    #[test]
    fn a_loop_gives_the_same_alone() {
        assert_eq!(loops(), alone(loops));
    }

    #[test]
    fn a_thread_that_is_alone_stays_where_it_is_until_it_is_done() {
        let here = std::thread::current().id();
        alone(|| {
            (0..10_000).into_par_iter().shared().for_each(|_: usize| {
                assert_eq!(std::thread::current().id(), here);
            });
            assert_eq!((threads(), thread()), (1, 0));
        });
        assert!(!is_alone());
        let broken = std::panic::catch_unwind(|| alone(|| panic!("as it has to")));
        assert!(broken.is_err() && !is_alone());
    }
}
