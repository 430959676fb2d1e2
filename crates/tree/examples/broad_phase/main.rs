//! Measures the tree against a sorted grid of several levels, and prints a Markdown table. Both must find the same pairs.
//!
//!     cargo run --release -p rockfall-tree --example broad_phase [LARGEST [equal|mixed|sort|parts]]
//!
//! LARGEST is the number of boxes in the largest case, 1,000,000 unless given; the second word picks one table for that number
//! alone. Times are medians of rounds in which all contenders take turns.

#![forbid(unsafe_code)]

mod cases;
mod grid;
#[path = "../../src/order.rs"]
mod order;
#[path = "../../src/radix.rs"]
mod radix;
mod turns;

use cases::{bed, mixed, move_some, pile, strewn};
use grid::Grid;
use rayon::prelude::*;
use rockfall_math::{Aabb, Vec3};
use rockfall_tree::{Tree, hilbert, morton};
use turns::{Turns, with_threads};

/// Items whose pairs one task finds, as the world does it.
const ROWS: usize = 256;
/// Cubes of cells per axis that a query of the grid looks at.
const SPAN: u32 = 2;
/// Share of a cell by which a box may leave it.
const SLACK: f32 = 0.25;

fn main() {
    let largest = std::env::args().nth(1).and_then(|arg| arg.parse().ok()).unwrap_or(1_000_000);
    agree();
    match std::env::args().nth(2).as_deref() {
        None => {}
        Some("equal") => return moving("equal", &pile(largest)),
        Some("mixed") => return moving("1:100", &mixed(largest)),
        Some("sort") => return sorting("equal", &pile(largest)),
        Some("parts") => return parts("equal", &pile(largest)),
        Some(other) => return eprintln!("no table is called `{other}`"),
    }
    let counts: Vec<usize> = [10_000, 100_000, 1_000_000].into_iter().filter(|&n| n <= largest).collect();
    println!("| case | threads | work | tree, ms | grid | grid with slack |\n|---|--:|---|--:|--:|--:|");
    for &count in &counts {
        moving(&format!("equal, {count}"), &pile(count));
    }
    for &count in &counts {
        moving(&format!("1:100, {count}"), &mixed(count));
    }
    for count in [1000, 10_000] {
        fixed(count, &bed(largest));
    }
    println!("\n| case | threads | work | first, ms | second | third |\n|---|--:|---|--:|--:|--:|");
    for &count in &counts {
        sorting(&format!("equal, {count}"), &pile(count));
        sorting(&format!("1:100, {count}"), &mixed(count));
    }
    for &count in counts.iter().filter(|&&count| count > 10_000) {
        parts(&format!("equal, {count}"), &pile(count));
    }
}

/// Pairs of the items in `moved`, found by the tree.
#[inline(never)]
fn tree_pairs(tree: &Tree, boxes: &[Aabb], moved: &[bool]) -> Vec<Vec<u64>> {
    by_rows(moved, |item, keys| {
        tree.query(&boxes[item as usize], |other| {
            if other != item && !(moved[other as usize] && other < item) {
                keys.push(u64::from(item.min(other)) << 32 | u64::from(item.max(other)));
            }
        });
    })
}

#[inline(never)]
fn grid_pairs(grid: &Grid, boxes: &[Aabb], moved: &[bool]) -> Vec<Vec<u64>> {
    let all = moved.iter().all(|&moved| moved);
    by_rows(moved, |item, keys| grid.pairs_of(item, &boxes[item as usize], moved, all, keys))
}

/// What `search` finds for each moved item, in parallel.
fn by_rows(moved: &[bool], search: impl Fn(u32, &mut Vec<u64>) + Sync) -> Vec<Vec<u64>> {
    let rows = moved.par_chunks(ROWS).enumerate().map(|(chunk, moved)| {
        let mut keys = Vec::new();
        for (i, _) in moved.iter().enumerate().filter(|(_, moved)| **moved) {
            search((chunk * ROWS + i) as u32, &mut keys);
        }
        keys
    });
    rows.collect()
}

/// All keys, sorted.
fn sorted(keys: Vec<Vec<u64>>) -> Vec<u64> {
    let mut keys: Vec<u64> = keys.concat();
    keys.par_sort_unstable();
    keys
}

/// Few boxes against brute force.
fn agree() {
    for (name, boxes) in [("equal", pile(2000)), ("1:100", mixed(2000)), ("bed", bed(2000))] {
        for one_in in [1, 7] {
            let (after, moved) = move_some(&boxes, one_in, 5);
            let mut expected = Vec::new();
            for a in 0..after.len() {
                for b in a + 1..after.len() {
                    if (moved[a] || moved[b]) && after[a].overlaps(&after[b]) {
                        expected.push((a as u64) << 32 | b as u64);
                    }
                }
            }
            let mut tree = Tree::build(&boxes);
            tree.refit_moved(&moved, |item| after[item]);
            assert!(sorted(tree_pairs(&tree, &after, &moved)) == expected, "tree, {name}");
            for (span, slack) in [(2, 0.0), (3, 0.0), (2, SLACK), (3, SLACK)] {
                let mut grid = Grid::build(&boxes, span, slack);
                if !grid.update(&after, &moved) {
                    assert!(slack == 0.0, "a tenth of a size leaves no loose cell");
                    grid = Grid::build(&after, span, slack);
                }
                assert!(
                    sorted(grid_pairs(&grid, &after, &moved)) == expected,
                    "grid, {name}, {span}, {slack}"
                );
            }
        }
    }
}

/// Cases in which any box may move.
fn moving(case: &str, boxes: &[Aabb]) {
    let size = (Tree::build(boxes).memory(), Grid::build(boxes, SPAN, 0.0).memory());
    let per_box = |bytes: usize| bytes as f64 / boxes.len() as f64;
    println!(
        "| {case} | | bytes per box | {:.1} | {:.1} | {:.1} |",
        per_box(size.0),
        per_box(size.1),
        per_box(size.1)
    );
    for threads in [1, 2] {
        let (mut tree, mut tight, mut loose) =
            (Tree::build(boxes), Grid::build(boxes, SPAN, 0.0), Grid::build(boxes, SPAN, SLACK));
        with_threads(threads, || {
            let mut turns = Turns::new(case, threads, boxes.len());
            turns.take(
                "build",
                &mut [
                    &mut || tree = Tree::build(boxes),
                    &mut || tight = Grid::build(boxes, SPAN, 0.0),
                    &mut || loose = Grid::build(boxes, SPAN, SLACK),
                ],
            );
            for (share, one_in) in [("1 %", 100), ("10 %", 10), ("100 %", 1)] {
                let (after, moved) = move_some(boxes, one_in, 6);
                let update = turns.take(
                    &format!("{share} move: update"),
                    &mut [
                        &mut || tree.refit_moved(&moved, |item| after[item]),
                        &mut || tight = Grid::build(&after, SPAN, 0.0),
                        &mut || assert!(loose.update(&after, &moved)),
                    ],
                );
                let mut found = [Vec::new(), Vec::new(), Vec::new()];
                let [a, b, c] = &mut found;
                let pairs = turns.take(
                    &format!("{share} move: pairs"),
                    &mut [
                        &mut || *a = tree_pairs(&tree, &after, &moved),
                        &mut || *b = grid_pairs(&tight, &after, &moved),
                        &mut || *c = grid_pairs(&loose, &after, &moved),
                    ],
                );
                turns.sum(&format!("{share} move: both"), &[update, pairs]);
                let found = found.map(sorted);
                assert!(found[0] == found[1] && found[0] == found[2], "{case}, {share}");
                if threads == 1 && one_in == 1 {
                    let mean = 2.0 * found[0].len() as f64 / boxes.len() as f64;
                    println!("| {case} | | neighbours per box | {mean:.1} | {mean:.1} | {mean:.1} |");
                }
                // Back to where they were, so that slack does not add up.
                tree.refit_moved(&moved, |item| boxes[item]);
                assert!(loose.update(boxes, &moved));
            }
        });
    }
}

/// Few bodies on very many fixed ones: each contender has one structure for either.
fn fixed(count: usize, bed: &[Aabb]) {
    let case = format!("{} fixed, {count} move", bed.len());
    let boxes = strewn(count, bed);
    let (after, moved) = move_some(&boxes, 1, 7);
    let still = vec![false; bed.len()];
    for threads in [1, 2] {
        with_threads(threads, || {
            let mut turns = Turns::new(&case, threads, bed.len());
            let (mut tree, mut grid) = (Tree::default(), Grid::build(&[], SPAN, 0.0));
            turns.take(
                "build of the fixed",
                &mut [&mut || tree = Tree::build(bed), &mut || grid = Grid::build(bed, SPAN, 0.0)],
            );
            let mut few = (Tree::build(&boxes), Grid::build(&boxes, SPAN, 0.0));
            let mut turns = Turns::new(&case, threads, count);
            let update = turns.take(
                "all move: update",
                &mut [&mut || few.0.refit_moved(&moved, |item| after[item]), &mut || {
                    few.1 = Grid::build(&after, SPAN, 0.0)
                }],
            );
            let mut found = [Vec::new(), Vec::new()];
            let [a, b] = &mut found;
            let pairs = turns.take(
                "all move: pairs",
                &mut [
                    &mut || {
                        *a = tree_pairs(&few.0, &after, &moved);
                        a.extend(by_rows(&moved, |item, keys| {
                            tree.query(&after[item as usize], |other| {
                                keys.push(u64::from(item) << 32 | 1 << 31 | u64::from(other))
                            });
                        }));
                    },
                    &mut || {
                        *b = grid_pairs(&few.1, &after, &moved);
                        b.extend(by_rows(&moved, |item, keys| {
                            grid.query_all(&after[item as usize], |other| {
                                keys.push(u64::from(item) << 32 | 1 << 31 | u64::from(other))
                            });
                        }));
                    },
                ],
            );
            turns.sum("all move: both", &[update, pairs]);
            let found = found.map(sorted);
            assert!(found[0] == found[1], "{case}");

            // As the world has it: the movers' tree has places for fixed bodies, too, whose boxes are empty.
            let rows: Vec<Aabb> = boxes.iter().copied().chain(bed.iter().map(|_| Aabb::EMPTY)).collect();
            let renewed: Vec<bool> = moved.iter().chain(&still).copied().collect();
            let mut full = Tree::build(&rows);
            let mut some = full.clone();
            let area = |item: usize| after.get(item).copied().unwrap_or(Aabb::EMPTY);
            let mut turns = Turns::new(&case, threads, bed.len());
            turns.take(
                "one tree for all rows: `refit`, `refit_moved`",
                &mut [&mut || full.refit(area), &mut || some.refit_moved(&renewed, area)],
            );
            assert!(full == some);
        });
    }
}

/// Sorts along the curve: comparison of whole keys, and digits of their leading halves.
fn sorting(case: &str, boxes: &[Aabb]) {
    let bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
    let cells = morton::Grid::new(&bounds);
    let codes: Vec<u64> = boxes.iter().map(|area| hilbert(cells.morton(area.center()))).collect();
    let stirred: Vec<u64> = {
        let mut order: Vec<u64> = (0..codes.len() as u64).collect();
        order.sort_unstable_by_key(|&i| rockfall_math::hash::mix(i));
        order.into_iter().map(|i| codes[i as usize]).collect()
    };
    // Rows that were sorted a while ago: each body has gone by about its size.
    let (gone, _) = move_some(&boxes.iter().map(|b| b.grown(2.0)).collect::<Vec<_>>(), 1, 8);
    let worn: Vec<u64> = gone.iter().map(|area| hilbert(cells.morton(area.center()))).collect();
    for threads in [1, 2] {
        with_threads(threads, || {
            let mut turns = Turns::new(case, threads, boxes.len());
            for (name, codes) in [("rows that moved", &worn), ("rows in any order", &stirred)] {
                let mut found = [Vec::new(), Vec::new()];
                let [a, b] = &mut found;
                turns.take(
                    &format!("sort, {name}: by comparison, by digits"),
                    &mut [
                        &mut || {
                            let mut keys: Vec<u128> = codes
                                .par_iter()
                                .enumerate()
                                .with_min_len(2048)
                                .map(|(item, &code)| u128::from(code) << 32 | item as u128)
                                .collect();
                            keys.par_sort_unstable();
                            *a = keys
                                .par_iter()
                                .with_min_len(2048)
                                .map(|&key| key as u32)
                                .collect::<Vec<u32>>();
                        },
                        &mut || *b = order::order(codes),
                    ],
                );
                assert!(found[0] == found[1], "{case}, {name}");
            }
        });
    }
}

/// The tree's own parts: refits and wide queries.
fn parts(case: &str, boxes: &[Aabb]) {
    let bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
    for threads in [1, 2] {
        with_threads(threads, || {
            let mut turns = Turns::new(case, threads, boxes.len());
            let mut full = Tree::build(boxes);
            let mut some = full.clone();
            for one_in in [10_000, 1000, 100, 40, 20] {
                let (after, moved) = move_some(boxes, one_in, 9);
                turns.take(
                    &format!("1 in {one_in} moves: `refit`, `refit_moved`"),
                    &mut [&mut || full.refit(|item| after[item]), &mut || {
                        some.refit_moved(&moved, |item| after[item])
                    }],
                );
                assert!(full == some);
                full.refit(|item| boxes[item]);
                some.refit(|item| boxes[item]);
            }
            let tree = full;
            for share in [0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 1.0] {
                // A slab over that share of the area.
                let size = bounds.max - bounds.min;
                let side = size.x * f32::sqrt(share);
                let middle = bounds.center();
                let half = Vec3::new(0.5 * side, 0.5 * side, if share < 1.0 { 0.5 } else { 4.0 });
                let slab = Aabb::new(middle - half, middle + half);
                let mut found = [Vec::new(), Vec::new()];
                let [a, b] = &mut found;
                let mut hits = 0;
                tree.query(&slab, |_| hits += 1);
                let wide = if tree.is_wide(&slab) { "wide" } else { "not wide" };
                turns.take(
                    &format!("slab, {hits} hits, {wide}: `query`, `par_query`, `is_wide`"),
                    &mut [
                        &mut || {
                            *a = Vec::new();
                            tree.query(&slab, |item| a.push(item));
                        },
                        &mut || *b = tree.par_query(&slab).collect(),
                        &mut || assert!(tree.is_wide(&slab) == (wide == "wide")),
                    ],
                );
                assert!(found[0] == found[1]);
            }
            let all = vec![true; boxes.len()];
            turns.take(
                "pairs of all: without, with `is_wide`",
                &mut [&mut || drop(tree_pairs(&tree, boxes, &all)), &mut || {
                    drop(by_rows(&all, |item, keys| {
                        let area = &boxes[item as usize];
                        assert!(!tree.is_wide(area));
                        tree.query(area, |other| {
                            if other != item && !(all[other as usize] && other < item) {
                                keys.push(u64::from(item.min(other)) << 32 | u64::from(item.max(other)));
                            }
                        });
                    }))
                }],
            );
        });
    }
}
