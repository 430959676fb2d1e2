//! Which boxes overlap, for the judge: bodies with bodies and with what is fixed, whatever their sizes.
//!
//! Boxes are sorted by size into levels, each twice as coarse as the one before, and hashed by the cell of their level in which
//! their centre is. No box is wider than a cell of its level, so one that overlaps it, and is not on a finer level, is found in
//! the same or a neighbouring cell of its own level.

use rayon::prelude::*;
use rockfall::math::Aabb;
use std::collections::{BTreeMap, HashMap};

/// Boxes of one level by their cells.
type Level = HashMap<[i64; 3], Vec<usize>>;

/// All pairs of boxes that overlap, each once and in no order. Numbers from `bodies.len()` on are those of `fixed`, of which no two
/// are a pair.
pub(crate) fn pairs(bodies: &[Aabb], fixed: &[Aabb]) -> Vec<(usize, usize)> {
    let of = |i: usize| bodies.get(i).unwrap_or_else(|| &fixed[i - bodies.len()]);
    let is_body = |i: usize| i < bodies.len();
    let mut levels: BTreeMap<i32, Level> = BTreeMap::new();
    for i in 0..bodies.len() + fixed.len() {
        levels.entry(level(of(i))).or_default().entry(cell(of(i), level(of(i)))).or_default().push(i);
    }
    // The finer of two looks for the coarser; what is fixed does so only where there are coarser bodies.
    let coarsest = bodies.iter().map(level).max().unwrap_or(i32::MIN);
    (0..bodies.len() + fixed.len())
        .into_par_iter()
        .filter(|&i| is_body(i) || level(of(i)) < coarsest)
        .flat_map_iter(|i| {
            let own = level(of(i));
            let others = levels.range(own..).flat_map(move |(&at, level)| {
                let [x, y, z] = cell(of(i), at);
                let cells = (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
                let found = cells.filter_map(|c| level.get(&c)).flatten().copied();
                // On one level both look: the body with the smaller number has the pair, and bodies have smaller ones than what is fixed.
                found.filter(move |&j| at > own || j > i)
            });
            let pair = move |j: &usize| (is_body(i) || is_body(*j)) && of(i).overlaps(of(*j));
            others.filter(pair).map(move |j| (i.min(j), i.max(j)))
        })
        .collect()
}

/// The level whose cells are as wide as the box, or wider by less than a factor of two.
fn level(b: &Aabb) -> i32 {
    // A hair more, so that no rounding of the logarithm makes a cell narrower than its box.
    ((2.0 * b.half_extents().max_element()).max(f32::MIN_POSITIVE).log2() + 1e-5).ceil() as i32
}

fn cell(b: &Aabb, level: i32) -> [i64; 3] {
    let width = f64::from(level).exp2();
    (b.center().as_dvec3() / width).floor().to_array().map(|x| x as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall::math::Vec3;
    use rockfall::math::hash::mix;

    #[test]
    fn boxes_of_all_sizes_are_found_once() {
        let mut state = 7;
        let mut next = || {
            state = mix(state + 1);
            (state >> 40) as f32 / (1u32 << 24) as f32
        };
        let mut boxes = |count: usize| -> Vec<Aabb> {
            let one = |_| {
                let half = Vec3::splat(10f32.powf(3.0 * next() - 2.0)) * Vec3::new(1.0, next(), 0.5);
                let center = Vec3::new(next(), next(), next()) * 20.0 - 10.0;
                Aabb::from_points([center - half, center + half])
            };
            (0..count).map(one).collect()
        };
        let (bodies, fixed) = (boxes(300), boxes(200));
        let mut found = pairs(&bodies, &fixed);
        found.sort_unstable();
        let all: Vec<&Aabb> = bodies.iter().chain(&fixed).collect();
        let expected: Vec<(usize, usize)> = (0..300)
            .flat_map(|i| (i + 1..500).map(move |j| (i, j)))
            .filter(|&(i, j)| all[i].overlaps(all[j]))
            .collect();
        assert!(expected.len() > 1000, "{}", expected.len());
        assert_eq!(found, expected);
    }

    #[test]
    fn a_box_is_never_wider_than_its_cells_and_more_than_half_as_wide() {
        for width in [1e-3f32, 0.5, 0.50001, 1.0, 3.0, 1e4] {
            let half = Vec3::splat(0.5 * width);
            let cells = f64::from(level(&Aabb::from_points([-half, half]))).exp2();
            assert!((0.5 * cells..=cells * (1.0 + 1e-6)).contains(&f64::from(width)), "{width} in {cells}");
        }
    }
}
