//! Which rows changed.

/// Rows of `now` that differ from those of `sent`, as runs; the values are put behind each other with `put`, and `sent` becomes `now`. Rows that `sent` lacks count as `none`. Returns the runs and the number of values.
pub(super) fn changed<T: Copy + PartialEq>(
    now: &[T],
    sent: &mut Vec<T>,
    none: T,
    mut put: impl FnMut(T),
) -> (Vec<u8>, u32) {
    sent.resize(now.len(), none);
    let (mut runs, mut count, mut row, mut done) = (Vec::new(), 0, 0, 0);
    while row < now.len() {
        if now[row] == sent[row] {
            row += 1;
            continue;
        }
        let first = row;
        while row < now.len() && now[row] != sent[row] {
            put(now[row]);
            row += 1;
        }
        number(&mut runs, first - done);
        number(&mut runs, row - first);
        count += (row - first) as u32;
        done = row;
    }
    sent.copy_from_slice(now);
    (runs, count)
}

/// Seven bits a byte.
fn number(out: &mut Vec<u8>, mut number: usize) {
    while number > 0x7f {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_differs_is_told_and_every_row_is_found_again() {
        let mut sent = vec![0_u8; 300];
        let mut now = sent.clone();
        (now[0], now[1], now[299]) = (1, 2, 3);
        now.push(4);
        let mut values = Vec::new();
        let (runs, count) = changed(&now, &mut sent, 9, |value| values.push(value));
        // 300 - 2 - 1 = 297 = 41 + 2 · 128.
        assert_eq!((runs, count, values), (vec![0, 2, 0x80 | 41, 2, 2], 4, vec![1, 2, 3, 4]));
        assert_eq!(sent, now);
        assert_eq!(changed(&now, &mut sent, 9, |_| unreachable!()), (vec![], 0));
    }
}
