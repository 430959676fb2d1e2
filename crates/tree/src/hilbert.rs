//! The Hilbert curve: like the Z-shaped curve of [`morton`](crate::morton()), but without jumps.
//!
//! Eight neighbours on a Z-shaped curve may lie on both sides of a jump across half of space, and their common box is then
//! mostly air. On the Hilbert curve each cell touches the next, and a query over a million boxes opens half as many
//! blocks. The price is a few table look-ups per box at build time.

/// How the curve enters a cube, and along which axis it leaves: 8 corners × 3 axes.
const STATES: usize = 24;

/// The place on the Hilbert curve of the cell that has this Morton code, 63 bits.
#[inline]
pub fn hilbert(morton: u64) -> u64 {
    let first = STEP[(morton >> 60) as usize & 7];
    let mut place = u64::from(first & 7);
    let mut state = first as usize >> 3;
    for level in (0..10).rev() {
        let cells = (morton >> (6 * level)) as usize & 63;
        let two = TWO_STEPS[state << 6 | cells];
        place = place << 6 | u64::from(two & 63);
        state = two as usize >> 6;
    }
    place
}

/// `STEP[state * 8 + octant]` is the next state, times 8, and the rank of the octant on the curve.
const STEP: [u8; STATES * 8] = {
    let mut table = [0; STATES * 8];
    let mut state = 0;
    while state < STATES {
        let mut octant = 0;
        while octant < 8 {
            table[state * 8 + octant] = step(state, octant as u32);
            octant += 1;
        }
        state += 1;
    }
    table
};

/// Two levels at a time: `TWO_STEPS[state * 64 + octants]` is the next state, times 64, and the rank.
static TWO_STEPS: [u16; STATES * 64] = {
    let mut table = [0; STATES * 64];
    let mut at = 0;
    while at < STATES * 64 {
        let outer = STEP[at >> 3];
        let inner = STEP[(outer & !7) as usize | at & 7];
        table[at] = (inner as u16 >> 3) << 6 | (outer as u16 & 7) << 3 | inner as u16 & 7;
        at += 1;
    }
    table
};

/// One level of Hamilton and Rau-Chaplin, "Compact Hilbert indices for multi-dimensional data" (2008), algorithm 1,
/// in three dimensions. A state is 8 × (axis along which the curve leaves) + (corner where it enters).
const fn step(state: usize, octant: u32) -> u8 {
    let (axis, corner) = (state as u32 / 8, state as u32 % 8);
    // Seen from the curve: the entry in the origin, the exit along the last axis.
    let gray = rotate(octant ^ corner, 3 - (axis + 1) % 3);
    let rank = gray ^ gray >> 1 ^ gray >> 2;
    // Where the sub-cube of this rank is entered, and along which axis it is left.
    let even = if rank == 0 { 0 } else { (rank - 1) & !1 };
    let entry = if rank == 0 { 0 } else { even ^ even >> 1 };
    let exit = if rank == 0 {
        0
    } else if rank & 1 == 0 {
        (rank - 1).trailing_ones() % 3
    } else {
        rank.trailing_ones() % 3
    };
    let corner = corner ^ rotate(entry, (axis + 1) % 3);
    let axis = (axis + exit + 1) % 3;
    ((axis * 8 + corner) * 8 + rank) as u8
}

/// The lowest three bits, rotated left.
const fn rotate(bits: u32, by: u32) -> u32 {
    (bits << (by % 3) | bits >> (3 - by % 3)) & 7
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morton;
    use rockfall_math::{Aabb, Vec3};

    /// Cells of a grid of 2ᵏ per axis in the order of the curve.
    fn walk(bits: u32) -> Vec<[i32; 3]> {
        let count = 1 << bits;
        let bounds = Aabb::new(Vec3::ZERO, Vec3::splat(count as f32));
        let mut cells = Vec::new();
        for x in 0..count {
            for y in 0..count {
                for z in 0..count {
                    let centre = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, z as f32 + 0.5);
                    cells.push((hilbert(morton(centre, &bounds)) >> (63 - 3 * bits), [x, y, z]));
                }
            }
        }
        cells.sort_unstable();
        assert!(cells.iter().enumerate().all(|(rank, cell)| cell.0 == rank as u64), "not one to one");
        cells.into_iter().map(|(_, cell)| cell).collect()
    }

    #[test]
    fn each_cell_touches_the_next() {
        for bits in [1, 2, 3, 4] {
            for pair in walk(bits).windows(2) {
                let apart: i32 = (0..3).map(|axis| (pair[0][axis] - pair[1][axis]).abs()).sum();
                assert_eq!(apart, 1, "{:?} and {:?}", pair[0], pair[1]);
            }
        }
    }

    #[test]
    fn the_last_bits_count() {
        let codes: std::collections::BTreeSet<u64> = (0..4096).map(hilbert).collect();
        assert_eq!(codes.len(), 4096);
        assert!(codes.iter().all(|code| code >> 12 == codes.first().expect("some") >> 12));
    }
}
