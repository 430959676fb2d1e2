//! Balls in space, and whether there is room for another.

use rockfall_math::{DVec3, hash};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Balls in a grid of cells; each cell knows the balls that reach into it. The map is only ever asked for a key, so
/// that its order is of no account.
pub(crate) struct Crowd {
    cell: f64,
    balls: Vec<(DVec3, f64)>,
    cells: HashMap<[i64; 3], Vec<u32>, BuildHasherDefault<Mixer>>,
}

impl Crowd {
    /// A grid with cells of about `diameter`, but not so fine that a ball of radius `largest` would fill very many.
    pub(crate) fn new(diameter: f64, largest: f64) -> Self {
        Crowd { cell: diameter.max(0.25 * largest), balls: Vec::new(), cells: HashMap::default() }
    }

    /// Whether a ball would not overlap any.
    pub(crate) fn is_free(&self, centre: DVec3, radius: f64) -> bool {
        self.reach(centre, radius).all(|key| {
            self.cells.get(&key).is_none_or(|list| {
                list.iter().all(|&i| {
                    let (other, r) = self.balls[i as usize];
                    (other - centre).length_squared() >= (r + radius) * (r + radius)
                })
            })
        })
    }

    pub(crate) fn add(&mut self, centre: DVec3, radius: f64) {
        let index = self.balls.len() as u32;
        self.balls.push((centre, radius));
        for key in self.reach(centre, radius) {
            self.cells.entry(key).or_default().push(index);
        }
    }

    /// Cells that the box around a ball meets.
    fn reach(&self, centre: DVec3, radius: f64) -> impl Iterator<Item = [i64; 3]> + use<> {
        let cell = |p: DVec3| (p / self.cell).floor().to_array().map(|x| x as i64);
        let (low, high) = (cell(centre - DVec3::splat(radius)), cell(centre + DVec3::splat(radius)));
        (low[2]..=high[2]).flat_map(move |z| {
            (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z]))
        })
    }
}

/// Hashes three integers.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.0 = hash::combine(self.0, u64::from_le_bytes(word));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn agrees_with_looking_at_every_ball() {
        let mut random = Random::new(1, "crowd");
        let mut crowd = Crowd::new(0.2, 1.0);
        let (mut free, mut taken) = (0, 0);
        for _ in 0..2000 {
            let centre = random.point(DVec3::splat(-5.0), DVec3::splat(5.0));
            let radius = random.within(0.02, 1.0);
            let clear = crowd.balls.iter().all(|(p, r)| (*p - centre).length() >= r + radius);
            assert_eq!(crowd.is_free(centre, radius), clear);
            if clear {
                crowd.add(centre, radius);
                free += 1;
            } else {
                taken += 1;
            }
        }
        assert!(free > 50 && taken > 50);
    }
}
