//! Who hangs together: bodies that contacts join, but not through what nobody moves.

use crate::Sight;
use rockfall::Kind;
use rockfall_cache::Contacts;

/// The number of each body's island, counted from 0 in the order of the smallest ids in them; none of a body that touches no other one that moves.
pub(super) fn islands(sight: &Sight, contacts: &Contacts) -> Vec<Option<u32>> {
    let mut above: Vec<usize> = (0..sight.bodies.len()).collect();
    let mut touches = vec![false; above.len()];
    let moves = |row: &usize| sight.bodies[*row].kind == Kind::Dynamic;
    for (&a, &b) in contacts.a.iter().zip(&contacts.b) {
        let row = |id: u64| sight.row(id).filter(moves);
        if let (Some(a), Some(b)) = (row(a), row(b)) {
            (touches[a], touches[b]) = (true, true);
            let (a, b) = (top(&mut above, a), top(&mut above, b));
            // The smallest is on top, so that the order of contacts does not matter.
            above[a.max(b)] = a.min(b);
        }
    }
    let mut numbers = vec![None; above.len()];
    let mut count = 0;
    for row in 0..above.len() {
        if touches[row] {
            let first = top(&mut above, row);
            if numbers[first].is_none() {
                numbers[first] = Some(count);
                count += 1;
            }
            numbers[row] = numbers[first];
        }
    }
    numbers
}

/// The uppermost above a row, with all on the way hung directly below what was two above.
fn top(above: &mut [usize], mut row: usize) -> usize {
    while above[row] != row {
        above[row] = above[above[row]];
        row = above[row];
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sight::Seen;
    use rockfall_math::{DVec3, Pose, Vec3};

    #[test]
    fn bodies_that_touch_are_one_island_and_the_ground_joins_nobody() {
        let body = |id: u64, kind| Seen {
            id,
            shape: 0,
            shown: 0,
            color: None,
            material: 0,
            kind,
            pose: Pose::default(),
            center: DVec3::ZERO,
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
        };
        let mut bodies: Vec<Seen> = (1..=7).map(|id| body(id, Kind::Dynamic)).collect();
        bodies[0].kind = Kind::Static;
        let sight = Sight { bodies, ..Sight::default() };
        let contacts = Contacts { a: vec![1, 1, 5, 3, 2], b: vec![2, 3, 7, 6, 4], ..Contacts::default() };
        let found = islands(&sight, &contacts);
        assert_eq!(found, [None, Some(0), Some(1), Some(0), Some(2), Some(1), Some(2)]);
    }
}
