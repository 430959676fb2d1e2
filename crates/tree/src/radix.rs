//! Sorts whole numbers by a range of their bits, in parallel.
//!
//! Least significant digit first. In each pass every thread counts the digits of its share, which says where the share's numbers of each
//! digit go; the room is cut into these places, so that all threads write at once and none writes where another does.

use rayon::prelude::*;
use rockfall_math::share::{self, Share};
use std::ops::Range;
use std::slice::IterMut;

/// Bits per digit: as many places as lines fit the first cache. 11 bits, with three passes for 32 bits instead of four, take as long.
const DIGIT: u32 = 8;

/// Numbers in a share at least.
const GRAIN: usize = 1 << 14;

/// Sorts by `bits` alone, ascending; numbers that are equal there keep their order.
pub(crate) fn radix_sort(numbers: &mut Vec<u64>, bits: Range<u32>) {
    let passes = bits.len().div_ceil(DIGIT as usize).max(1) as u32;
    let digit = (bits.len() as u32).div_ceil(passes);
    let mut room = vec![0; numbers.len()];
    for first in bits.clone().step_by(digit.max(1) as usize) {
        pass(numbers, &mut room, first, digit.min(bits.end - first));
        std::mem::swap(numbers, &mut room);
    }
}

fn pass(from: &[u64], to: &mut [u64], first: u32, digit: u32) {
    let share = from.len().div_ceil(share::threads()).max(GRAIN);
    let (mask, digits) = ((1_u64 << digit) - 1, 1_usize << digit);
    let digit_of = |number: u64| (number >> first & mask) as usize;
    let counts: Vec<Vec<u32>> = from
        .par_chunks(share)
        .shared()
        .map(|numbers| {
            let mut counts = vec![0_u32; digits];
            numbers.iter().for_each(|&number| counts[digit_of(number)] += 1);
            counts
        })
        .collect();

    let mut places: Vec<Vec<IterMut<'_, u64>>> = counts.iter().map(|_| Vec::with_capacity(digits)).collect();
    let mut rest = to;
    for digit in 0..digits {
        for (places, counts) in places.iter_mut().zip(&counts) {
            let (here, after) = std::mem::take(&mut rest).split_at_mut(counts[digit] as usize);
            places.push(here.iter_mut());
            rest = after;
        }
    }
    from.par_chunks(share).zip(&mut places).shared().for_each(|(numbers, places)| {
        for &number in numbers {
            if let Some(place) = places[digit_of(number)].next() {
                *place = number;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    #[test]
    fn any_range_of_bits_sorts_as_a_stable_sort_does_for_any_number_of_threads() {
        for count in [0, 1, 100, 100_000] {
            let numbers: Vec<u64> = (0..count).map(mix).collect();
            for bits in [0..0, 0..1, 32..40, 5..38, 32..64, 0..64] {
                let mut expected = numbers.clone();
                let len = bits.len() as u32;
                expected
                    .sort_by_key(|x| x >> bits.start & 1_u64.checked_shl(len).unwrap_or(0).wrapping_sub(1));
                for threads in [1, 2, 3] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                    let mut sorted = numbers.clone();
                    pool.install(|| radix_sort(&mut sorted, bits.clone()));
                    assert!(sorted == expected, "{count} numbers, bits {bits:?}, {threads} threads");
                }
            }
        }
    }
}
