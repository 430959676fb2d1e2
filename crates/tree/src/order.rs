//! Brings items into the order of their places on a curve.

use crate::radix::radix_sort;
use rayon::prelude::*;
use rockfall_math::share::{Share, ShareSort};

/// Items that one task packs, and the shortest stretch of equals that is sorted by many.
const GRAIN: usize = 2048;

/// Fewer items are sorted by comparison.
const FEW: usize = 1 << 14;

/// The indices of `codes` in ascending order of code, then of index.
pub(crate) fn order(codes: &[u64]) -> Vec<u32> {
    if codes.len() < FEW {
        let mut keys: Vec<(u64, u32)> = codes.iter().copied().zip(0..).collect();
        keys.sort_unstable();
        return keys.into_iter().map(|(_, item)| item).collect();
    }
    // The 32 leading bits of what is in use, besides the item: half the memory, and half the passes, of whole codes. `u64::MAX`
    // means no place at all and must not make all others equal.
    let largest = codes.par_iter().with_min_len(GRAIN).shared().filter(|&&code| code != u64::MAX).max();
    let shift = 32_u32.saturating_sub(largest.map_or(64, |code| code.leading_zeros()));
    let mut packed: Vec<u64> = codes
        .par_iter()
        .zip(0..codes.len() as u32)
        .with_min_len(GRAIN)
        .shared()
        .map(|(&code, item)| (code >> shift).min(u64::from(u32::MAX)) << 32 | u64::from(item))
        .collect();
    radix_sort(&mut packed, 32..64);
    resolve(&mut packed, codes);
    packed.par_iter().with_min_len(GRAIN).shared().map(|&key| key as u32).collect()
}

/// Sorts stretches that are equal in their upper half by whole codes.
fn resolve(packed: &mut [u64], codes: &[u64]) {
    let same = |a: &u64, b: &u64| a >> 32 == b >> 32;
    let mut stretches = Vec::with_capacity(packed.len() / GRAIN + 1);
    let mut rest = packed;
    while !rest.is_empty() {
        // A cut falls where the upper half changes.
        let start = rest.len().min(GRAIN);
        let cut = rest[start - 1..].windows(2).position(|two| !same(&two[0], &two[1]));
        let (here, after) = rest.split_at_mut(cut.map_or(rest.len(), |more| start + more));
        stretches.push(here);
        rest = after;
    }
    stretches.into_par_iter().shared().for_each(|stretch| {
        for equals in stretch.chunk_by_mut(same) {
            let code = |key: &u64| (codes[*key as u32 as usize], *key as u32);
            if equals.len() > 1 && !equals.is_sorted_by_key(code) {
                equals.sort_shared_by_key(code);
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    #[test]
    fn the_order_is_that_of_codes_and_then_of_items() {
        let spread = |i: u64| mix(i) >> 1;
        let patterns: [(&str, &dyn Fn(u64) -> u64); 7] = [
            ("spread", &spread),
            ("equal", &|_| 7),
            ("nothing", &|_| u64::MAX),
            ("some nothing", &|i| if i % 3 == 0 { u64::MAX } else { spread(i) }),
            ("small", &|i| mix(i) % 1000),
            ("equal in the leading bits", &|i| (1 << 62) | (mix(i) % 5000)),
            ("two clusters", &|i| ((i % 2) << 62) | (mix(i) % 100_000)),
        ];
        for (name, code) in patterns {
            for count in [0, 1, 1000, 50_000] {
                let codes: Vec<u64> = (0..count).map(code).collect();
                let mut expected: Vec<u32> = (0..count as u32).collect();
                expected.sort_by_key(|&item| codes[item as usize]);
                assert!(order(&codes) == expected, "{name}, {count} items");
            }
        }
    }
}
