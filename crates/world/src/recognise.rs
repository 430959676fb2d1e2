//! Which of a pair's new contacts are old ones: those go on with their impulses.
//!
//! Reads a manifold that was found and those that were there; writes what it remembers, and in whose place it goes on.
//!
//! A point takes the impulse of its namesake. Where two faces cover each other, as in a tower of equal boxes, rounding decides which corner or crossing of edges names a
//! point, and names change from step to step; so a point without a namesake takes the impulse of the nearest point that has none either.
//!
//! Letting points go from one manifold of a pair to another that pushes the same way, none taken twice, was tried: it let a bowl of hulls rock on, and rings that lie in each other.

use rockfall_solve::{Manifold, Memory};
use std::mem::take;

/// How far a point may have gone in a step to be taken for the same under a new name, as a share of its arm.
const SAME: f32 = 0.05;

/// Gives a new manifold, whose points are named, what is remembered of the old ones, and takes their impulses away from those. Returns which of them it is: the first that has a namesake, or the only one,
/// which goes on even where all of its points have new names, as that of a convex pair may.
pub(crate) fn recognise(
    manifold: &Manifold,
    memory: &mut Memory,
    olds: &mut [(Manifold, Memory)],
) -> Option<usize> {
    let count = manifold.count as usize;
    let namesake = |feature: u32, (manifold, memory): &(Manifold, Memory)| {
        memory.features[..manifold.count as usize].iter().position(|&f| f == feature)
    };
    let knows =
        |old: &(Manifold, Memory)| memory.features[..count].iter().any(|&f| namesake(f, old).is_some());
    let source = olds.iter().position(knows).or((olds.len() == 1).then_some(0))?;
    let namesakes = memory.features.map(|feature| namesake(feature, &olds[source]));
    let (before, old) = &mut olds[source];
    let (mut free_old, mut free_new) = ([true; 4], [true; 4]);
    for (p, free) in free_new.iter_mut().enumerate().take(count) {
        if let Some(q) = namesakes[p] {
            memory.normals[p] = take(&mut old.normals[q]);
            (free_old[q], *free) = (false, false);
        }
    }
    for p in (0..count).filter(|&p| free_new[p]) {
        let arm = manifold.arms[p];
        let mut nearest = (SAME * SAME * arm.length_squared(), None);
        for q in (0..before.count as usize).filter(|&q| free_old[q]) {
            let way = (before.arms[q] - arm).length_squared();
            if way < nearest.0 {
                nearest = (way, Some(q));
            }
        }
        if let Some(q) = nearest.1 {
            memory.normals[p] = take(&mut old.normals[q]);
            free_old[q] = false;
        }
    }
    (memory.friction, memory.twist, memory.rolling) = (old.friction, old.twist, old.rolling);
    Some(source)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::Vec3;

    /// Points on a line along y, of names and impulses.
    fn known(points: &[(f32, u32, f32)]) -> (Manifold, Memory) {
        let mut manifold = Manifold { normal: Vec3::Z, count: points.len() as u32, ..Manifold::default() };
        let mut memory = Memory::default();
        for (p, &(y, name, impulse)) in points.iter().enumerate() {
            manifold.arms[p] = Vec3::new(1.0, y, 0.0);
            (memory.features[p], memory.normals[p]) = (name, impulse);
        }
        memory.friction = Vec3::X * memory.normals.iter().sum::<f32>();
        (manifold, memory)
    }

    #[test]
    fn points_keep_their_impulse_by_name_and_else_by_nearness() {
        let old = known(&[(0.0, 1, 1.0), (1.0, 2, 2.0), (2.0, 3, 4.0)]);
        let (manifold, mut memory) = known(&[(0.0, 3, 0.0), (0.99, 9, 0.0), (5.0, 8, 0.0)]);
        assert_eq!(recognise(&manifold, &mut memory, &mut [old]), Some(0));
        assert_eq!(memory.normals, [4.0, 2.0, 0.0, 0.0]);
        assert_eq!(memory.friction, 7.0 * Vec3::X);
    }

    #[test]
    fn of_several_manifolds_the_one_with_a_namesake_goes_on() {
        let mut olds = [known(&[(0.0, 1, 1.0)]), known(&[(0.0, 2, 2.0)])];
        let mut of = |name: u32| {
            let (manifold, mut memory) = known(&[(0.0, name, 0.0)]);
            (recognise(&manifold, &mut memory, &mut olds), memory.normals[0])
        };
        // What was taken is not there a second time.
        assert_eq!([of(2), of(7), of(2)], [(Some(1), 2.0), (None, 0.0), (Some(1), 0.0)]);
    }
}
