//! The tree against brute force.

use rayon::iter::ParallelIterator;
use rockfall_math::{Aabb, Vec3, hash};
use rockfall_tree::Tree;

/// A stream of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (hash::mix(self.0) >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn point(&mut self, side: f32) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * side
    }
}

/// Boxes in a cube of the given side, half extents from `smallest` to `smallest * ratio`, small ones more often.
fn boxes(count: usize, side: f32, smallest: f32, ratio: f32, seed: u64) -> Vec<Aabb> {
    let mut random = Random(seed);
    (0..count)
        .map(|_| {
            let centre = random.point(side);
            let share = random.next();
            let half = Vec3::splat(smallest) * (1.0 + (ratio - 1.0) * share * share * share * share);
            Aabb::new(centre - half, centre + half)
        })
        .collect()
}

fn found(tree: &Tree, area: &Aabb) -> Vec<u32> {
    let mut items = Vec::new();
    tree.query(area, |item| items.push(item));
    items.sort_unstable();
    items
}

fn expected(boxes: &[Aabb], area: &Aabb) -> Vec<u32> {
    (0..boxes.len() as u32).filter(|&i| boxes[i as usize].overlaps(area)).collect()
}

fn check(tree: &Tree, boxes: &[Aabb], queries: &[Aabb]) {
    let mut hits = 0;
    for area in queries {
        let items = found(tree, area);
        hits += items.len();
        assert_eq!(items, expected(boxes, area));
    }
    assert!(hits > 0, "a test that finds nothing tests nothing");
}

#[test]
fn a_query_finds_what_brute_force_finds() {
    for (count, ratio) in
        [(1, 1.0), (2, 1.0), (8, 1.0), (9, 1.0), (64, 1.0), (65, 1.0), (3000, 1.0), (3000, 100.0)]
    {
        let boxes = boxes(count, 10.0, 0.05, ratio, 7);
        let tree = Tree::build(&boxes);
        assert_eq!(tree.len(), count);
        check(&tree, &boxes, &boxes[..count.min(500)]);
        check(&tree, &boxes, &[Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY)]);
    }
}

#[test]
fn a_query_after_a_refit_finds_what_brute_force_finds() {
    let mut random = Random(3);
    let mut boxes = boxes(3000, 10.0, 0.05, 100.0, 11);
    let mut tree = Tree::build(&boxes);
    for round in 0..4 {
        for area in &mut boxes {
            let push = random.point(2.0) - Vec3::ONE;
            *area = Aabb::new(area.min + push, area.max + push);
        }
        boxes[17 + round] = Aabb::EMPTY;
        tree.refit(|item| boxes[item]);
        check(&tree, &boxes, &boxes[..500]);
    }
}

#[test]
fn a_ray_meets_what_brute_force_meets() {
    let boxes = boxes(3000, 10.0, 0.05, 100.0, 13);
    let tree = Tree::build(&boxes);
    let mut random = Random(17);
    let meets = |area: &Aabb, origin: Vec3, direction: Vec3, slack: f32| {
        let area = area.grown(slack);
        let (mut near, mut far) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (o, d) = (f64::from(origin[axis]), f64::from(direction[axis]));
            let ends = [area.min, area.max].map(|side| f64::from(side[axis]) - o);
            if d == 0.0 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return false;
                }
            } else {
                near = near.max((ends[0] / d).min(ends[1] / d));
                far = far.min((ends[0] / d).max(ends[1] / d));
            }
        }
        near <= far
    };
    let mut total = 0;
    for i in 0..500 {
        let origin = random.point(14.0) - Vec3::splat(2.0);
        let mut direction = random.point(20.0) - Vec3::splat(10.0);
        if i % 5 == 0 {
            direction[i % 3] = 0.0;
        }
        let mut items = Vec::new();
        tree.cast_ray(origin, direction, 1.0, |item, max| {
            items.push(item);
            max
        });
        items.sort_unstable();
        total += items.len();
        for item in 0..boxes.len() as u32 {
            let reported = items.binary_search(&item).is_ok();
            let area = &boxes[item as usize];
            if meets(area, origin, direction, 0.0) {
                assert!(reported, "ray {i} lost item {item}");
            } else if reported {
                assert!(meets(area, origin, direction, 1e-5), "ray {i} has nothing to do with item {item}");
            }
        }
        assert!(items.windows(2).all(|pair| pair[0] < pair[1]), "an item came twice");
    }
    assert!(total > 1000);
}

#[test]
fn a_ray_along_a_side_meets_the_box() {
    let tree = Tree::build(&[Aabb::new(Vec3::ZERO, Vec3::ONE)]);
    let mut hits = 0;
    tree.cast_ray(Vec3::new(-1.0, 0.0, 1.0), Vec3::X, 10.0, |_, max| {
        hits += 1;
        max
    });
    assert_eq!(hits, 1);
}

#[test]
fn a_shortened_ray_stops() {
    let row: Vec<Aabb> = (0..1000)
        .map(|i| Aabb::new(Vec3::new(i as f32, 0.0, 0.0), Vec3::new(i as f32 + 0.5, 1.0, 1.0)))
        .collect();
    let tree = Tree::build(&row);
    let (mut calls, mut first) = (0, f32::INFINITY);
    tree.cast_ray(Vec3::new(-1.0, 0.5, 0.5), Vec3::X, f32::INFINITY, |item, max| {
        calls += 1;
        first = max.min(item as f32 + 1.0);
        first
    });
    assert_eq!(first, 1.0);
    assert!(calls < 10, "{calls} calls for the nearest of a row");
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let before = boxes(30_000, 10.0, 0.05, 100.0, 19);
    let after = boxes(30_000, 10.0, 0.05, 100.0, 23);
    let trees: Vec<(Tree, Tree)> = [1, 2, 3, 8]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| {
                let built = Tree::build(&before);
                let mut moved = built.clone();
                moved.refit(|item| after[item]);
                (built, moved)
            })
        })
        .collect();
    assert!(trees[0].0 != trees[0].1);
    assert!(trees.iter().all(|tree| *tree == trees[0]));
}

#[test]
fn ten_thousand_boxes_at_one_point_are_all_found() {
    let boxes = vec![Aabb::new(Vec3::ONE, Vec3::splat(2.0)); 10_000];
    let tree = Tree::build(&boxes);
    assert_eq!(found(&tree, &boxes[0]).len(), 10_000);
    assert!(tree.order().iter().enumerate().all(|(place, &item)| place == item as usize));
}

/// Promise: blocks are passed over only where none of their items is wanted, and the root knows about all items.
#[test]
fn a_query_with_a_condition_finds_what_brute_force_finds() {
    for count in [0, 1, 8, 9, 65, 3000] {
        let boxes = boxes(count, 10.0, 0.05, 10.0, 3);
        let tree = Tree::build(&boxes);
        let value = |item: u32| hash::mix(u64::from(item)) as u32 >> 8;
        let largest = tree.fold(0, value, u32::max);
        assert_eq!(largest.all, (0..count as u32).map(value).max().unwrap_or(0));
        for area in [Aabb::new(Vec3::ZERO, Vec3::splat(6.0)), Aabb::new(Vec3::splat(4.0), Vec3::splat(5.0))] {
            let (asked, wanted) = (std::cell::Cell::new(0), 0x00ff_0000);
            let mut items = Vec::new();
            let keep = |largest: &u32, _: &Aabb| {
                asked.set(asked.get() + 1);
                *largest >= wanted
            };
            tree.query_where(&area, &largest, keep, |item| items.push(item));
            items.sort_unstable();
            let all = expected(&boxes, &area);
            let some: Vec<u32> = all.iter().copied().filter(|&item| value(item) >= wanted).collect();
            assert_eq!(items, some);
            assert!(count < 3000 || asked.get() < all.len().max(100), "{} questions", asked.get());
        }
    }
}

#[test]
fn nothing_is_found_in_nothing() {
    let everywhere = Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let tree = Tree::build(&[]);
    assert!(tree.is_empty() && found(&tree, &everywhere).is_empty() && tree.bounds() == Aabb::EMPTY);
    tree.cast_ray(Vec3::ZERO, Vec3::X, 1.0, |_, _| unreachable!("no item to meet"));

    let tree = Tree::build(&[Aabb::EMPTY; 20]);
    assert!(tree.len() == 20 && found(&tree, &everywhere).is_empty() && tree.bounds() == Aabb::EMPTY);
    tree.cast_ray(Vec3::ZERO, Vec3::X, f32::INFINITY, |_, _| unreachable!("no item to meet"));
}

#[test]
fn strange_boxes_do_no_harm() {
    let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
    let everywhere = Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let below = Aabb::new(Vec3::NEG_INFINITY, Vec3::new(f32::INFINITY, f32::INFINITY, 0.5));
    let half_known = Aabb::new(Vec3::new(0.0, f32::NAN, 0.0), Vec3::ONE);
    let inverted = Aabb::new(Vec3::ONE, Vec3::ZERO);
    let huge = Aabb::new(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX));
    let far = Aabb::new(Vec3::splat(1e38), Vec3::splat(2e38));
    let mut list = vec![unit, everywhere, below, half_known, inverted, huge, far, Aabb::EMPTY];
    list.extend(boxes(1000, 1.0, 0.001, 1.0, 29));
    let tree = Tree::build(&list);
    let items = found(&tree, &unit);
    assert_eq!(items, (0..1008).filter(|i| ![3, 4, 6, 7].contains(i)).collect::<Vec<u32>>());
    let high = Aabb::new(Vec3::splat(2.0), Vec3::splat(3.0));
    assert_eq!(found(&tree, &high), [1, 5]);
    let mut met = Vec::new();
    tree.cast_ray(Vec3::new(5.0, 5.0, 5.0), Vec3::NEG_Z, f32::INFINITY, |item, max| {
        met.push(item);
        max
    });
    met.sort_unstable();
    assert_eq!(met, [1, 2, 5]);
    for bad in [Vec3::NAN, Vec3::INFINITY] {
        tree.cast_ray(bad, Vec3::X, 1.0, |_, _| unreachable!("a ray from nowhere"));
        tree.cast_ray(Vec3::ZERO, bad, 1.0, |_, _| unreachable!("a ray to nowhere"));
        let _ = found(&tree, &Aabb::new(bad, bad));
    }
}

#[test]
fn a_runaway_body_does_not_slow_the_rest() {
    // Work of a query, counted in boxes that f sees plus the blocks' order: neighbours on the curve stay near.
    let mut list = boxes(4096, 1.0, 0.01, 1.0, 31);
    list.push(Aabb::new(Vec3::splat(1e30), Vec3::splat(1.1e30)));
    let tree = Tree::build(&list);
    let step: f32 = tree
        .order()
        .windows(2)
        .map(|pair| list[pair[0] as usize].center().distance(list[pair[1] as usize].center()))
        .filter(|d| *d < 1e3)
        .sum::<f32>()
        / 4096.0;
    assert!(step < 0.2, "neighbours on the curve lie {step} apart on average, at random it is 0.66");
}

#[test]
fn memory_is_within_forty_bytes_per_item() {
    let tree = Tree::build(&boxes(100_000, 10.0, 0.01, 1.0, 37));
    assert!(tree.memory() < 40 * tree.len());
    assert!(tree.memory() > 24 * tree.len());
}

/// Boxes along the curve, as rows of bodies are, of which those that `moves` names have moved a little.
fn moved(before: &[Aabb], moves: impl Fn(usize) -> bool) -> (Vec<bool>, Vec<Aabb>) {
    let mut random = Random(41);
    let marks: Vec<bool> = (0..before.len()).map(moves).collect();
    let step = |(area, &moved): (&Aabb, &bool)| {
        let push = random.point(0.1);
        if moved { Aabb::new(area.min + push, area.max + push) } else { *area }
    };
    let after = before.iter().zip(&marks).map(step).collect();
    (marks, after)
}

#[test]
fn refitting_what_moved_is_refitting_everything() {
    type Moves = fn(usize) -> bool;
    let patterns: [(&str, Moves); 9] = [
        ("none", |_| false),
        ("one", |i| i == 77),
        ("last", |i| i % 30_011 == 30_010),
        ("few", |i| hash::mix(i as u64).is_multiple_of(1000)),
        ("one in forty", |i| hash::mix(i as u64).is_multiple_of(40)),
        ("a stretch", |i| (5000..5500).contains(&i)),
        ("one in a block", |i| i % 9 == 0),
        ("a quarter", |i| hash::mix(i as u64).is_multiple_of(4)),
        ("all", |_| true),
    ];
    for count in [0, 1, 7, 8, 9, 64, 100, 513, 30_011] {
        let before = boxes(count, 10.0, 0.05, 100.0, 43);
        for (name, moves) in patterns {
            let (marks, after) = moved(&before, moves);
            let built = Tree::build(&before);
            let mut all = built.clone();
            all.refit(|item| after[item]);
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                let mut some = built.clone();
                pool.install(|| some.refit_moved(&marks, |item| after[item]));
                assert!(some == all, "{name} of {count}, {threads} threads");
            }
        }
    }
}

#[test]
fn refitting_few_looks_at_few_boxes() {
    let before = boxes(30_000, 10.0, 0.05, 1.0, 47);
    let (marks, after) = moved(&before, |item| item == 5000 || item == 20_000);
    let mut tree = Tree::build(&before);
    let looks = std::sync::atomic::AtomicUsize::new(0);
    tree.refit_moved(&marks, |item| {
        looks.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        after[item]
    });
    assert_eq!(looks.into_inner(), 2);
    let mut all = Tree::build(&before);
    all.refit(|item| after[item]);
    assert!(tree == all);
}

#[test]
fn marks_may_be_fewer_or_more_than_items() {
    let before = boxes(300, 10.0, 0.05, 1.0, 53);
    let built = Tree::build(&before);
    let mut all = built.clone();
    all.refit(|item| if item == 3 { Aabb::EMPTY } else { before[item] });
    for len in [4, 300, 1000] {
        let marks: Vec<bool> = (0..len).map(|item| item == 3).collect();
        let mut some = built.clone();
        some.refit_moved(&marks, |item| if item == 3 { Aabb::EMPTY } else { before[item] });
        assert!(some == all);
    }
}

#[test]
fn a_query_by_many_threads_finds_the_same_in_the_same_order() {
    let everywhere = Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let slab = Aabb::new(Vec3::new(-1.0, -1.0, 3.0), Vec3::new(11.0, 11.0, 3.2));
    let far = Aabb::new(Vec3::splat(90.0), Vec3::splat(91.0));
    for count in [0, 1, 8, 9, 64, 65, 4097, 60_000] {
        let boxes = boxes(count, 10.0, 0.02, 4.0, 59);
        let tree = Tree::build(&boxes);
        let areas = boxes.iter().step_by(997).copied().chain([everywhere, slab, far, Aabb::EMPTY]);
        for area in areas {
            let mut expected = Vec::new();
            tree.query(&area, |item| expected.push(item));
            for threads in [1, 2, 8] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                let found: Vec<u32> = pool.install(|| tree.par_query(&area).collect());
                assert!(found == expected, "{count} boxes, {threads} threads, {area:?}");
                let first = pool.install(|| tree.par_query(&area).find_first(|_| true));
                assert_eq!(first, expected.first().copied());
            }
        }
    }
}

#[test]
fn wide_is_what_meets_tens_of_thousands() {
    let boxes = boxes(60_000, 10.0, 0.02, 4.0, 61);
    let tree = Tree::build(&boxes);
    assert!(tree.is_wide(&Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY)));
    assert!(tree.is_wide(&Aabb::new(Vec3::new(-1.0, -1.0, 3.0), Vec3::new(11.0, 11.0, 9.0))));
    assert!(!boxes.iter().any(|area| tree.is_wide(area)));
    assert!(!tree.is_wide(&Aabb::EMPTY));
    let few = Tree::build(&boxes[..1000]);
    assert!(!few.is_wide(&Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY)));
    assert!(!Tree::default().is_wide(&Aabb::new(Vec3::ZERO, Vec3::ONE)));
}

#[test]
fn a_box_on_its_way_meets_what_brute_force_meets() {
    let boxes = boxes(2000, 10.0, 0.05, 100.0, 67);
    let tree = Tree::build(&boxes);
    let mut random = Random(71);
    let mut total = 0;
    for i in 0..300 {
        let start = random.point(14.0) - Vec3::splat(2.0);
        let area = Aabb::new(start, start + random.point(0.5));
        let mut way = random.point(20.0) - Vec3::splat(10.0);
        if i % 5 == 0 {
            way[i % 3] = 0.0;
        }
        let mut found = Vec::new();
        tree.cast_box(&area, way, 1.0, |item, max| {
            found.push(item);
            max
        });
        total += found.len();
        let meets = |other: &Aabb, slack: f64| {
            let (mut near, mut far) = (0.0_f64, 1.0_f64);
            for axis in 0..3 {
                let gap = |a: f32, b: f32| f64::from(a) - f64::from(b);
                let (low, high) = (
                    gap(other.min[axis], area.max[axis]) - slack,
                    gap(other.max[axis], area.min[axis]) + slack,
                );
                let step = f64::from(way[axis]);
                if step == 0.0 {
                    far = if low <= 0.0 && high >= 0.0 { far } else { -1.0 };
                } else {
                    near = near.max((low / step).min(high / step));
                    far = far.min((low / step).max(high / step));
                }
            }
            near <= far
        };
        for item in 0..boxes.len() as u32 {
            let other = &boxes[item as usize];
            let reported = found.contains(&item);
            assert!(reported || !meets(other, 0.0), "box {i} lost item {item}");
            assert!(!reported || meets(other, 1e-5), "box {i} has nothing to do with item {item}");
        }
    }
    assert!(total > 1000);
}

#[test]
fn boxes_that_begin_where_another_hit_ends_are_still_met() {
    // Many boxes with one side in common, which a slanting ray meets at a time that is no number of single precision.
    let row: Vec<Aabb> =
        (0..64).map(|i| Aabb::new(Vec3::new(0.1, -1.0, -1.0), Vec3::new(0.2 + i as f32, 1.0, 1.0))).collect();
    let tree = Tree::build(&row);
    let direction = Vec3::new(0.7, 0.003, -0.001);
    let hit = (f64::from(0.1_f32) / f64::from(0.7_f32)) as f32;
    let mut met = 0;
    tree.cast_ray(Vec3::ZERO, direction, f32::INFINITY, |_, _| {
        met += 1;
        hit
    });
    assert_eq!(met, 64);
}

#[test]
fn the_nearest_item_is_that_of_brute_force() {
    let boxes = boxes(3000, 10.0, 0.02, 20.0, 73);
    let tree = Tree::build(&boxes);
    let mut random = Random(79);
    let gap = |p: Vec3, area: &Aabb| p.distance(p.clamp(area.min, area.max));
    let mut looks = 0;
    for _ in 0..500 {
        let p = random.point(16.0) - Vec3::splat(3.0);
        let (mut best, mut item) = (f32::INFINITY, u32::MAX);
        tree.nearest(&Aabb::new(p, p), f32::INFINITY, |other, _| {
            looks += 1;
            let distance = gap(p, &boxes[other as usize]);
            if (distance, other) < (best, item) {
                (best, item) = (distance, other);
            }
            best
        });
        let brute =
            (0..3000).min_by(|&a, &b| gap(p, &boxes[a as usize]).total_cmp(&gap(p, &boxes[b as usize])));
        assert_eq!(Some(item), brute);
        let mut within = Vec::new();
        tree.nearest(&Aabb::new(p, p), 1.0, |other, max| {
            within.push(other);
            max
        });
        for other in 0..3000 {
            let distance = gap(p, &boxes[other as usize]);
            assert!(within.contains(&other) || distance > 1.0);
            assert!(!within.contains(&other) || distance < 1.000_01);
        }
    }
    assert!(looks < 500 * 60, "{looks} looks: the bound does not bound");
    tree.nearest(&Aabb::new(Vec3::NAN, Vec3::NAN), 1.0, |_, _| unreachable!("near nothing"));
    tree.nearest(&Aabb::EMPTY, 1.0, |_, _| unreachable!("near nothing"));
    tree.nearest(&Aabb::new(Vec3::ZERO, Vec3::ONE), -1.0, |_, _| unreachable!("no nearer than nothing"));
}
