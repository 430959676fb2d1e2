//! Vectors that follow the size of their content both ways.

/// Slack over what is needed, as a divisor: a sixteenth.
const SLACK: usize = 16;

/// Gives `v` room for `len` items and a little more. A vector that grows by pushing keeps up to twice of what it ever
/// held; of one vector per run of pairs that would be a third of all memory.
pub fn make_room<T>(v: &mut Vec<T>, len: usize) {
    let wanted = len + len / SLACK;
    if v.capacity() < len {
        v.reserve_exact(wanted - v.len().min(wanted));
    } else if v.capacity() > len + len / 4 {
        v.shrink_to(wanted);
    }
}

#[cfg(test)]
mod tests {
    use super::make_room;

    #[test]
    fn follows_up_and_down() {
        let mut v: Vec<u64> = Vec::new();
        make_room(&mut v, 1000);
        assert!((1000..1100).contains(&v.capacity()));
        v.resize(1000, 7);
        make_room(&mut v, 1010);
        assert!((1010..1100).contains(&v.capacity()));
        v.truncate(100);
        make_room(&mut v, 100);
        assert!((100..130).contains(&v.capacity()) && v.len() == 100);
    }
}
