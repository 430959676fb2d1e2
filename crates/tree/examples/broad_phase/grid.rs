//! The challenger: a grid of several levels, sorted.
//!
//! A box belongs to the level with the smallest cells that are at least as wide as the box; cells of the widest level are as wide as the
//! widest box, those of each further level a quarter. An entry lies in the cell of its box's centre. Keys, a level's first
//! key plus the Morton code of the cell, are dense and fit 32 bits; sorted by them, the entries of a cell, and of every aligned
//! cube of 2ᵏ cells a side, lie side by side, and their boxes lie eight to a block, as the tree's do. A table of the leading bits of the keys,
//! up to four per entry, leads to a cell.
//!
//! With `slack` an entry stays where it is until its centre has left the cell by that share of a cell, and queries look
//! farther by so much.

use crate::radix::radix_sort;
use glam::Vec4;
use rayon::prelude::*;
use rockfall_math::{Aabb, Vec3};

/// Levels at most: boxes that are smaller than the largest by more are all in the last.
const LEVELS: usize = 16;
/// By how many octaves the cells of a level are smaller than those of the one before.
const OCTAVES: usize = 2;
/// Entries that one task works on.
const GRAIN: usize = 2048;

/// Eight boxes side by side; lanes without a box hold NaN.
#[repr(align(64))]
#[derive(Clone, Copy)]
struct Eight([[f32; 8]; 6]);

impl Eight {
    fn set(&mut self, lane: usize, area: &Aabb) {
        let sides = area.min.to_array().into_iter().chain(area.max.to_array());
        self.0.iter_mut().zip(sides).for_each(|(column, side)| column[lane] = side);
    }

    fn overlaps(&self, area: &Aabb) -> u32 {
        let (low, high) = (area.min.to_array(), area.max.to_array());
        let half = |first: usize| {
            let lanes = |side: usize| Vec4::from_slice(&self.0[side][first..first + 4]);
            let begins = |axis: usize| lanes(axis).cmple(Vec4::splat(high[axis]));
            let ends = |axis: usize| lanes(axis + 3).cmpge(Vec4::splat(low[axis]));
            (begins(0) & ends(0) & begins(1) & ends(1) & begins(2) & ends(2)).bitmask()
        };
        half(0) | half(4) << 4
    }
}

/// The cells of one size.
#[derive(Clone, Copy, Default)]
struct Level {
    /// Width of a cell, and its inverse.
    cell: f32,
    inverse: f32,
    /// The last cell of each axis.
    last: [u32; 3],
    /// The first key.
    base: u32,
    /// Entries.
    count: usize,
    /// Where its part of the table begins, and how many bits of a code the table leaves out.
    table: usize,
    shift: u32,
}

/// See the head of this file.
pub(crate) struct Grid {
    /// Cubes of cells that a query looks at, per axis and level, at most: the cubes grow until so many cover its box. One of three, and
    /// levels an octave apart, were slower.
    span: u32,
    slack: f32,
    origin: Vec3,
    levels: [Level; LEVELS],
    keys: Vec<u32>,
    items: Vec<u32>,
    /// Where each item lies.
    places: Vec<u32>,
    boxes: Vec<Eight>,
    table: Vec<u32>,
}

impl Grid {
    /// A query looks at no more than `span` cubes of cells per axis and level; `slack` is in cells.
    pub(crate) fn build(boxes: &[Aabb], span: u32, slack: f32) -> Grid {
        let extent = |area: &Aabb| (area.max - area.min).max_element();
        let (min, max, widest) = boxes
            .par_iter()
            .with_min_len(GRAIN)
            .map(|area| (area.center(), area.center(), extent(area)))
            .reduce(
                || (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0),
                |a, b| (a.0.min(b.0), a.1.max(b.1), a.2.max(b.2)),
            );
        let mut grid = Grid {
            span,
            slack,
            origin: min,
            levels: [Level::default(); LEVELS],
            keys: Vec::new(),
            items: Vec::new(),
            places: Vec::new(),
            boxes: Vec::new(),
            table: Vec::new(),
        };
        for (i, level) in grid.levels.iter_mut().enumerate() {
            level.cell = widest / (1_u64 << (i * OCTAVES)) as f32;
            level.inverse = 1.0 / level.cell;
            level.last = ((max - min) * level.inverse).to_array().map(|x| x as u32);
        }
        grid.count(boxes);
        let mut packed: Vec<u64> = boxes
            .par_iter()
            .zip(0..boxes.len() as u32)
            .with_min_len(GRAIN)
            .map(|(area, item)| u64::from(grid.key(area)) << 32 | u64::from(item))
            .collect();
        let used = grid.levels.iter().filter(|level| level.count > 0);
        let top = used.map(|level| u64::from(level.base) + level.codes()).max().unwrap_or(0);
        radix_sort(&mut packed, 32..32 + (u64::BITS - top.leading_zeros()));

        grid.keys = packed.par_iter().with_min_len(GRAIN).map(|&p| (p >> 32) as u32).collect();
        grid.items = packed.par_iter().with_min_len(GRAIN).map(|&p| p as u32).collect();
        let places: Vec<_> = (0..boxes.len()).map(|_| std::sync::atomic::AtomicU32::new(0)).collect();
        grid.items.par_iter().zip(0..boxes.len() as u32).with_min_len(GRAIN).for_each(|(&item, place)| {
            places[item as usize].store(place, std::sync::atomic::Ordering::Relaxed);
        });
        grid.places = places.into_iter().map(std::sync::atomic::AtomicU32::into_inner).collect();
        grid.boxes = grid
            .items
            .par_chunks(8)
            .with_min_len(GRAIN / 8)
            .map(|items| {
                let mut eight = Eight([[f32::NAN; 8]; 6]);
                items.iter().enumerate().for_each(|(k, &item)| eight.set(k, &boxes[item as usize]));
                eight
            })
            .collect();
        grid.tabulate();
        grid
    }

    pub(crate) fn memory(&self) -> usize {
        4 * (self.keys.capacity() + self.items.capacity() + self.places.capacity() + self.table.capacity())
            + self.boxes.capacity() * size_of::<Eight>()
    }

    /// Takes over the new boxes of the items marked in `moved`, where each can stay in its cell; `false` where one can't, and then
    /// only a new grid is right.
    pub(crate) fn update(&mut self, boxes: &[Aabb], moved: &[bool]) -> bool {
        let count = moved.par_iter().with_min_len(1 << 16).filter(|&&moved| moved).count();
        if count > moved.len() / 8 {
            return self.update_all(boxes);
        }
        let mut stale: Vec<u32> = Vec::new();
        for (chunk, marks) in moved.chunks(64).enumerate() {
            if !<&[bool; 64]>::try_from(marks).is_ok_and(|marks| *marks == [false; 64]) {
                let items = marks.iter().zip(chunk * 64..).filter(|(moved, _)| **moved);
                stale.extend(items.map(|(_, item)| self.places[item]));
            }
        }
        stale.par_sort_unstable();
        let stays = stale.par_iter().with_min_len(GRAIN).all(|&place| {
            let place = place as usize;
            self.stays(self.keys[place], &boxes[self.items[place] as usize])
        });
        if stays {
            set_some(&mut self.boxes, 0, &stale, &self.items, boxes);
        }
        stays
    }

    /// The same with every box.
    fn update_all(&mut self, boxes: &[Aabb]) -> bool {
        let mut blocks = std::mem::take(&mut self.boxes);
        let entries = self.keys.par_chunks(8).zip(self.items.par_chunks(8));
        let stay =
            blocks.par_iter_mut().zip(entries).with_min_len(GRAIN / 8).all(|(eight, (keys, items))| {
                keys.iter().zip(items).enumerate().all(|(lane, (&key, &item))| {
                    let area = &boxes[item as usize];
                    eight.set(lane, area);
                    self.stays(key, area)
                })
            });
        self.boxes = blocks;
        stay
    }

    /// Whether a box is within reach of its cell.
    fn stays(&self, key: u32, area: &Aabb) -> bool {
        let level = &self.levels[self.level_of_key(key)];
        let code = key - level.base;
        let cell = Vec3::from([code, code >> 1, code >> 2].map(|c| gather(c) as f32));
        let at = (area.center() - self.origin) * level.inverse - cell - 0.5;
        (area.max - area.min).max_element() <= level.cell * 1.0001
            && at.abs().max_element() <= 0.5 + self.slack
    }

    /// Keys of the pairs of an item that has moved, the smaller item in the upper half; each pair of two such is reported by one.
    pub(crate) fn pairs_of(&self, item: u32, area: &Aabb, moved: &[bool], all: bool, keys: &mut Vec<u64>) {
        let own = self.level(area);
        let mut push = |other: u32| keys.push(u64::from(item.min(other)) << 32 | u64::from(item.max(other)));
        for i in (0..own).filter(|&i| self.levels[i].count > 0) {
            self.query(i, area, &mut push);
        }
        self.query(own, area, |other| {
            if other != item && !(moved[other as usize] && other < item) {
                push(other);
            }
        });
        if all {
            return;
        }
        for i in (own + 1..LEVELS).filter(|&i| self.levels[i].count > 0) {
            self.query(i, area, |other| {
                if !moved[other as usize] {
                    push(other);
                }
            });
        }
    }

    /// Items of all levels whose boxes meet `area`.
    pub(crate) fn query_all(&self, area: &Aabb, mut f: impl FnMut(u32)) {
        (0..LEVELS).filter(|&i| self.levels[i].count > 0).for_each(|i| self.query(i, area, &mut f));
    }

    /// Items of a level whose boxes meet `area`.
    #[inline]
    fn query(&self, level: usize, area: &Aabb, mut f: impl FnMut(u32)) {
        let level = &self.levels[level];
        // Rounding of a place in cells: some 2⁻²³ of up to 2¹² cells, thrice.
        const ROUNDING: f32 = 2e-3;
        let reach = 0.5 + self.slack + ROUNDING;
        let (low, high) = (
            (area.min - self.origin) * level.inverse - reach,
            (area.max - self.origin) * level.inverse + reach,
        );
        let (low, high) = (low.to_array(), high.to_array());
        let (mut first, mut last, mut k) = ([0_u32; 3], [0_u32; 3], 0);
        for axis in 0..3 {
            if high[axis] < 0.0 || low[axis] >= (level.last[axis] + 1) as f32 {
                return;
            }
            first[axis] = low[axis] as u32;
            last[axis] = (high[axis] as u32).min(level.last[axis]);
            while (last[axis] >> k) - (first[axis] >> k) >= self.span {
                k += 1;
            }
        }
        for z in first[2] >> k..=last[2] >> k {
            let code_z = spread(z) << 2;
            for y in first[1] >> k..=last[1] >> k {
                let code_y = code_z | spread(y) << 1;
                for x in first[0] >> k..=last[0] >> k {
                    let code = code_y | spread(x);
                    let (from, to) =
                        (self.find(level, code << (3 * k)), self.find(level, (code + 1) << (3 * k)));
                    self.scan(from, to, area, &mut f);
                }
            }
        }
    }

    /// Entries `from..to` whose boxes meet `area`.
    #[inline]
    fn scan(&self, from: usize, to: usize, area: &Aabb, f: &mut impl FnMut(u32)) {
        let mut at = from;
        while at < to {
            let start = at & !7;
            let mask = (0xff << (at - start)) & (0xff_u32 >> (start + 8).saturating_sub(to));
            let mut hits = self.boxes[start / 8].overlaps(area) & mask;
            while hits != 0 {
                f(self.items[start + hits.trailing_zeros() as usize]);
                hits &= hits - 1;
            }
            at = start + 8;
        }
    }

    /// The first entry of a level whose code is at least `code`.
    #[inline]
    fn find(&self, level: &Level, code: u64) -> usize {
        let slot = level.table + (code >> level.shift) as usize;
        let from = self.table[slot] as usize;
        if level.shift == 0 || code & ((1 << level.shift) - 1) == 0 {
            return from;
        }
        let to = self.table[slot + 1] as usize;
        from + self.keys[from..to].partition_point(|&key| u64::from(key - level.base) < code)
    }

    /// Level of a box.
    #[inline]
    fn level(&self, area: &Aabb) -> usize {
        let extent = (area.max - area.min).max_element();
        let ratio = self.levels[0].cell / extent;
        // The exponent is the whole part of the binary logarithm.
        let whole = (((ratio.to_bits() >> 23) as usize).saturating_sub(127) / OCTAVES).min(LEVELS - 1);
        if self.levels[whole].cell < extent { whole.saturating_sub(1) } else { whole }
    }

    fn level_of_key(&self, key: u32) -> usize {
        // Bases ascend with the number of the level.
        let mut used =
            self.levels.iter().enumerate().filter(|(_, level)| level.count > 0 && level.base <= key);
        used.next_back().map_or(0, |(number, _)| number)
    }

    #[inline]
    fn key(&self, area: &Aabb) -> u32 {
        let level = &self.levels[self.level(area)];
        let cell = (area.center() - self.origin) * level.inverse;
        let [x, y, z] = [0, 1, 2].map(|axis| spread((cell[axis] as u32).min(level.last[axis])));
        level.base + (x | y << 1 | z << 2) as u32
    }

    /// Counts the entries of each level and deals out keys.
    fn count(&mut self, boxes: &[Aabb]) {
        let counts = boxes
            .par_chunks(GRAIN)
            .map(|boxes| {
                let mut counts = [0; LEVELS];
                boxes.iter().for_each(|area| counts[self.level(area)] += 1);
                counts
            })
            .reduce(|| [0; LEVELS], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        let mut next = 0_u64;
        for (level, count) in self.levels.iter_mut().zip(counts) {
            level.count = count;
            level.base = next as u32;
            next += if count > 0 { level.codes() } else { 0 };
        }
        assert!(next < 1 << 32, "more cells than keys of 32 bits tell apart");
    }

    /// Fills the table from the sorted keys.
    fn tabulate(&mut self) {
        let mut total = 0;
        for level in self.levels.iter_mut().filter(|level| level.count > 0) {
            level.table = total;
            level.shift = (0..32).find(|s| level.codes() >> s <= 4 * level.count as u64).unwrap_or(31);
            // Two more: the end of the last slot, and the code beyond the last.
            total += (level.codes() >> level.shift) as usize + 2;
        }
        self.table = vec![0; total];
        let mut rest = &mut self.table[..];
        for level in self.levels.iter().filter(|level| level.count > 0) {
            let (here, after) = rest.split_at_mut((level.codes() >> level.shift) as usize + 2);
            rest = after;
            here.par_chunks_mut(GRAIN).enumerate().for_each(|(chunk, slots)| {
                let code =
                    |slot: usize| u64::from(level.base) + (((chunk * GRAIN + slot) as u64) << level.shift);
                let mut at = self.keys.partition_point(|&key| u64::from(key) < code(0));
                for (i, slot) in slots.iter_mut().enumerate() {
                    while self.keys.get(at).is_some_and(|&key| u64::from(key) < code(i)) {
                        at += 1;
                    }
                    *slot = at as u32;
                }
            });
        }
    }
}

impl Level {
    /// Number of codes: as many as a cube has that holds the level.
    fn codes(&self) -> u64 {
        let longest = self.last.into_iter().max().unwrap_or(0);
        1 << (3 * (u32::BITS - longest.leading_zeros()))
    }
}

/// Sets the boxes of the entries `stale`, ascending; `first` is the number of the first block.
fn set_some(blocks: &mut [Eight], first: u32, stale: &[u32], items: &[u32], boxes: &[Aabb]) {
    let cut = stale.len() / 2;
    let middle = stale.get(cut).map_or(0, |place| place / 8);
    let left = stale.partition_point(|place| place / 8 < middle);
    if stale.len() <= GRAIN || left == 0 {
        for &place in stale {
            let lane = place as usize % 8;
            blocks[(place / 8 - first) as usize].set(lane, &boxes[items[place as usize] as usize]);
        }
        return;
    }
    let (low, high) = blocks.split_at_mut((middle - first) as usize);
    let (left, right) = stale.split_at(left);
    rayon::join(|| set_some(low, first, left, items, boxes), || set_some(high, middle, right, items, boxes));
}

/// Moves bit i to bit 3 i; 10 bits.
#[inline]
fn spread(x: u32) -> u64 {
    let x = u64::from(x);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Moves bit 3 i to bit i.
#[inline]
fn gather(x: u32) -> u32 {
    let x = x & 0x0924_9249;
    let x = (x | x >> 2) & 0x030c_30c3;
    let x = (x | x >> 4) & 0x0300_f00f;
    let x = (x | x >> 8) & 0x0300_00ff;
    (x | x >> 16) & 0x3ff
}
