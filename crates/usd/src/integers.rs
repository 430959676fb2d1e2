//! Integers as the format packs them.
//!
//! Each is replaced by its difference from the one before, the first by itself. Then follow: the difference that is most frequent; two bits for
//! each, four to a byte from the low end; and, for those that are not the most frequent, the difference in a quarter, a half or all of the width. What
//! comes out is compressed once more, by LZ4.
//!
//! | bits | difference |
//! |---|---|
//! | 0 | the most frequent one, nothing follows |
//! | 1 | a quarter of the width: 1 byte of 4, 2 of 8 |
//! | 2 | half of the width |
//! | 3 | all of it |

use crate::lz4;

/// Bytes of an integer before it is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    Four,
    Eight,
}

/// Packs integers, each within `width`: the compressed form and its length before it, as every list of integers in a file is written.
pub(crate) fn put(values: &[i64], width: Width, to: &mut Vec<u8>) {
    let packed = lz4::compress(&encode(values, width));
    to.extend((packed.len() as u64).to_le_bytes());
    to.extend(packed);
}

fn encode(values: &[i64], width: Width) -> Vec<u8> {
    if values.is_empty() {
        return Vec::new();
    }
    let bytes = match width {
        Width::Four => 4,
        Width::Eight => 8,
    };
    let steps: Vec<i64> = (0..values.len())
        .map(|k| {
            let step = values[k].wrapping_sub(if k == 0 { 0 } else { values[k - 1] });
            // A reader adds with 32 bits, so a difference may wrap around.
            if width == Width::Four { i64::from(step as i32) } else { step }
        })
        .collect();
    let common = most_frequent(&steps);

    let mut codes = vec![0u8; steps.len().div_ceil(4)];
    let mut rest: Vec<u8> = Vec::new();
    for (k, &step) in steps.iter().enumerate() {
        if step == common {
            continue;
        }
        let (code, size) = [(1u8, bytes / 4), (2, bytes / 2)]
            .into_iter()
            .find(|&(_, size)| fits(step, size))
            .unwrap_or((3, bytes));
        codes[k / 4] |= code << (2 * (k % 4));
        rest.extend(&step.to_le_bytes()[..size]);
    }
    let mut out = common.to_le_bytes()[..bytes].to_vec();
    out.extend(codes);
    out.extend(rest);
    out
}

/// Whether a signed integer of `size` bytes holds `value`.
fn fits(value: i64, size: usize) -> bool {
    let unused = 64 - 8 * size as u32;
    (value << unused) >> unused == value
}

/// The value that is there most often; of several the largest, because it takes most room where it is written out.
fn most_frequent(values: &[i64]) -> i64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    let runs = sorted.chunk_by(|a, b| a == b);
    runs.max_by_key(|run| run.len()).and_then(|run| run.first()).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse, written from the description.
    fn decode(data: &[u8], count: usize, width: Width) -> Vec<i64> {
        let bytes = if width == Width::Four { 4 } else { 8 };
        let int = |at: usize, size: usize| {
            let mut wide = [if data[at + size - 1] < 128 { 0 } else { 255 }; 8];
            wide[..size].copy_from_slice(&data[at..at + size]);
            i64::from_le_bytes(wide)
        };
        let common = int(0, bytes);
        let mut at = bytes + count.div_ceil(4);
        let mut value = 0i64;
        let out = (0..count)
            .map(|k| {
                let code = data[bytes + k / 4] >> (2 * (k % 4)) & 3;
                let size = [0, bytes / 4, bytes / 2, bytes][usize::from(code)];
                value = value.wrapping_add(if code == 0 { common } else { int(at, size) });
                at += size;
                if width == Width::Four {
                    value = i64::from(value as i32);
                }
                value
            })
            .collect();
        assert_eq!(at, data.len(), "nothing is left over");
        out
    }

    #[test]
    fn the_example_of_the_formats_description_comes_out_to_the_byte() {
        let packed = encode(&[123, 124, 125, 100_125, 100_125, 100_126, 100_126], Width::Four);
        // Differences 123, 1, 1, 100000, 0, 1, 0, of which 1 is the most frequent.
        let codes = [0b11_00_00_01, 0b01_00_01];
        let rest = [123, 0xa0, 0x86, 0x01, 0x00, 0, 0];
        assert_eq!(packed, [&[1, 0, 0, 0][..], &codes, &rest].concat());
    }

    #[test]
    fn all_widths_come_back() {
        let (low, high) = (i64::from(i32::MIN), i64::from(i32::MAX));
        let narrow = [0, 127, -1, 128, -129, 32767, -1, 32768, low, high, low, 0, 0, 0, 5];
        for count in 1..=narrow.len() {
            let values = &narrow[..count];
            assert_eq!(decode(&encode(values, Width::Four), count, Width::Four), values);
        }
        let wide = [0, 1 << 15, 1 << 31, -(1 << 31), 1 << 40, i64::MIN, i64::MAX, 7, 8, 9];
        for count in 1..=wide.len() {
            let values = &wide[..count];
            assert_eq!(decode(&encode(values, Width::Eight), count, Width::Eight), values);
        }
    }

    #[test]
    fn numbers_in_a_row_take_two_bits_each() {
        let ids: Vec<i64> = (1..=1000).collect();
        assert_eq!(encode(&ids, Width::Eight).len(), 8 + 250);
        assert!(encode(&[], Width::Four).is_empty());
    }

    #[test]
    fn of_equally_frequent_differences_the_largest_is_left_out() {
        let packed = encode(&[1, 301], Width::Four);
        assert_eq!(packed, [44, 1, 0, 0, 1, 1]);
    }
}
