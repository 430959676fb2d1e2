//! How fast this machine reads memory, measured: the roof under which whatever goes through memory stays.

use crate::Error;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::hint::black_box;
use std::time::Instant;

/// Passes over the buffer; the middle one counts.
const PASSES: usize = 7;

/// Of the buffer, bytes: at least, and at most, and by the size of the last-level cache, of which little may be left in it from
/// one pass to the next.
const LEAST: usize = 256 << 20;
const MOST: usize = 4 << 30;
const CACHES: usize = 8;

/// Numbers that are summed side by side, so that a thread waits for memory and not for an addition.
const ABREAST: usize = 32;

/// Streaming reads with so many threads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Bandwidth {
    pub(crate) threads: usize,
    /// 10⁹ bytes a second, all threads together.
    pub(crate) gigabytes_per_second: f64,
}

/// With one thread, and with each of these numbers of them.
pub(crate) fn measure(threads: &[usize]) -> Result<Vec<Bandwidth>, Error> {
    let bytes = buffer(last_level_cache());
    let mut numbers: Vec<usize> = threads.iter().copied().chain([1]).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let one = |threads| Ok(Bandwidth { threads, gigabytes_per_second: read(bytes, threads)? });
    numbers.into_iter().map(one).collect()
}

/// Bytes to read, for a machine with such a cache.
fn buffer(cache: usize) -> usize {
    (CACHES * cache).clamp(LEAST, MOST)
}

/// Of the first processor, bytes; nothing where the system does not tell.
fn last_level_cache() -> usize {
    let size = |index: usize| {
        let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/size");
        parse_size(&fs::read_to_string(path).ok()?)
    };
    (0..8).filter_map(size).max().unwrap_or(0)
}

/// A size as Linux writes it: `32768K`.
fn parse_size(text: &str) -> Option<usize> {
    let text = text.trim();
    let (digits, unit) = match text.strip_suffix('M') {
        Some(digits) => (digits, 1 << 20),
        None => (text.strip_suffix('K')?, 1 << 10),
    };
    digits.parse::<usize>().ok()?.checked_mul(unit)
}

/// Billions of bytes a second, the median of some passes.
fn read(bytes: usize, threads: usize) -> Result<f64, Error> {
    let refused = |e: rayon::ThreadPoolBuildError| Error::Io(std::io::Error::other(e));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(refused)?;
    let words = bytes / size_of::<u64>();
    let share = words.div_ceil(threads);
    pool.install(|| {
        // Every page is written before it is read, or all of them would be the same page of zeros.
        let buffer: Vec<u64> = (0..words as u64).into_par_iter().collect();
        let pass = |_| {
            let start = Instant::now();
            let sum = buffer.par_chunks(share).with_max_len(1).map(sum).reduce(|| 0, u64::wrapping_add);
            black_box(sum);
            1e-9 * (words * size_of::<u64>()) as f64 / start.elapsed().as_secs_f64()
        };
        let mut rates: Vec<f64> = (0..PASSES).map(pass).collect();
        rates.sort_unstable_by(f64::total_cmp);
        Ok(rates[PASSES / 2])
    })
}

/// Of all words, modulo 2⁶⁴.
fn sum(words: &[u64]) -> u64 {
    let (rows, rest) = words.as_chunks::<ABREAST>();
    let mut sums = [0u64; ABREAST];
    for row in rows {
        for (sum, word) in sums.iter_mut().zip(row) {
            *sum = sum.wrapping_add(*word);
        }
    }
    sums.iter().chain(rest).fold(0, |a, &b| a.wrapping_add(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_is_read_once() {
        for count in [0u64, 1, 31, 32, 33, 1000] {
            let words: Vec<u64> = (1..=count).collect();
            assert_eq!(sum(&words), count * (count + 1) / 2);
        }
    }

    #[test]
    fn the_buffer_is_far_larger_than_the_cache() {
        assert_eq!(buffer(0), LEAST);
        assert_eq!(buffer(64 << 20), 512 << 20);
        assert_eq!(buffer(2 << 30), MOST);
        assert_eq!(parse_size("32768K\n"), Some(32 << 20));
        assert_eq!(parse_size("96M"), Some(96 << 20));
        assert_eq!(parse_size("?"), None);
    }

    #[test]
    fn each_number_of_threads_has_a_rate() {
        let rates: Vec<f64> = [1, 2].map(|threads| read(32 << 20, threads).expect("a rate")).to_vec();
        // From a slow card to the cache of the fastest processor.
        assert!(rates.iter().all(|rate| (0.1..1e4).contains(rate)), "{rates:?}");
    }
}
