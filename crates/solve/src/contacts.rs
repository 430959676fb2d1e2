//! All contacts of a world, in blocks of sixteen, from the step in which they are found to the one in which they end.
//!
//! A contact is in one place only: the lane that the solver sweeps over. Nothing is copied before a step or after it; a manifold that
//! only follows its bodies changes where it is ([`crate::follow`]), and impulses are found there by the next step. Blocks hold
//! contacts of one key: phase, tile, colour, class. Which lane of a key's blocks a contact has does not matter to any bit of
//! the result, because within a colour no body that moves stands twice.

use crate::block::{Cold, LANES};
use crate::desk::{Desk, Found, place_of};
use crate::line::Line;
use crate::manifold::{FIXED, Manifold, Memory};
use crate::paint::Painter;
use crate::plan::Plan;
use crate::shelf::{CLASSES, Class, HOT, Key, Lane, Shelf};
use rayon::prelude::*;
use rockfall_math::room::make_room;
use std::collections::BTreeMap;

/// The blocks of a key.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bucket {
    /// Numbers of its blocks within their class, ascending.
    pub(crate) blocks: Vec<u32>,
    /// Lanes without a contact; the last is taken first.
    free: Vec<u32>,
}

/// All contacts.
#[derive(Debug, Default)]
pub struct Contacts {
    pub(crate) ball: Shelf<1, 0>,
    pub(crate) one: Shelf<1, 0>,
    pub(crate) two: Shelf<2, 1>,
    pub(crate) four: Shelf<4, 1>,
    pub(crate) colds: Vec<Cold>,
    pub(crate) buckets: BTreeMap<Key, Bucket>,
    pub(crate) plan: Plan,
    painter: Painter,
    /// Whether rows are cut into tiles.
    tiled: bool,
    /// Whether blocks have come since the plan was made.
    grown: bool,
}

/// A contact when all are sorted: its place, and its two rows, the second marked where contacts can't move it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Where it is.
    pub lane: Lane,
    /// New row of body a.
    pub a: u32,
    /// New row of body b, with its mark.
    pub b: u32,
}

impl Contacts {
    /// Number of colours that hold contacts, of both sides.
    pub fn colors(&self) -> usize {
        self.plan.colors
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        let bucket = |b: &Bucket| (b.blocks.capacity() + b.free.capacity()) * size_of::<u32>();
        self.ball.memory()
            + self.one.memory()
            + self.two.memory()
            + self.four.memory()
            + self.colds.capacity() * size_of::<Cold>()
            + self.buckets.values().map(bucket).sum::<usize>()
            + self.buckets.len() * size_of::<(Key, Bucket)>()
            + self.plan.memory()
            + self.painter.memory()
    }

    /// Whether rows are cut into tiles.
    pub fn is_tiled(&self) -> bool {
        self.tiled
    }

    /// Bytes that one sweep over all blocks reads, those of bodies aside.
    pub fn swept_bytes(&self) -> usize {
        size_of_val(&self.ball.blocks[..])
            + size_of_val(&self.one.blocks[..])
            + size_of_val(&self.two.blocks[..])
            + size_of_val(&self.four.blocks[..])
    }

    /// Opens all lanes for many threads; `rows` is the number of bodies.
    pub fn desk(&mut self, rows: usize) -> Desk<'_> {
        let Contacts { ball, one, two, four, colds, painter, tiled, .. } = self;
        painter.resize(rows);
        Desk::new((ball, one, two, four), colds, painter, *tiled)
    }

    /// What a lane holds: position, normal and signed distances, and impulses.
    pub fn read(&self, at: Lane) -> (Manifold, Memory) {
        match at.class() {
            Class::Ball => self.ball.read(at, &self.colds),
            Class::One => self.one.read(at, &self.colds),
            Class::Two => self.two.read(at, &self.colds),
            Class::Four => self.four.read(at, &self.colds),
        }
    }

    fn keys(&self, class: Class) -> &[Key] {
        match class {
            Class::Ball => &self.ball.keys,
            Class::One => &self.one.keys,
            Class::Two => &self.two.keys,
            Class::Four => &self.four.keys,
        }
    }

    /// Takes lanes back that were cleared.
    pub fn free(&mut self, lanes: &[Lane]) {
        for lane in lanes {
            let key = self.keys(lane.class())[lane.block()];
            self.buckets.entry(key).or_default().free.push(lane.index() as u32);
        }
    }

    /// Gives a colour to every contact that has none yet; `rows` is the number of bodies.
    pub fn paint(&mut self, arrivals: &mut [Vec<Found>], rows: usize) {
        self.painter.resize(rows);
        self.painter.paint(arrivals);
    }

    /// Gives every contact a lane and writes it there.
    pub fn place(&mut self, arrivals: &mut [Vec<Found>]) {
        let tiled = self.tiled;
        let mut places: Vec<(Key, u32, u32)> = arrivals
            .par_iter()
            .enumerate()
            .flat_map_iter(|(group, arrivals)| {
                arrivals.iter().zip(0..).map(move |(arrival, i)| (arrival.key(tiled), group as u32, i))
            })
            .collect();
        places.par_sort_unstable();
        for group in places.chunk_by(|a, b| a.0 == b.0) {
            let key = group[0].0;
            let mut free = std::mem::take(&mut self.buckets.entry(key).or_default().free);
            for &(_, of, i) in group {
                let index = match free.pop() {
                    Some(index) => index,
                    None => self.grow(key, &mut free),
                };
                arrivals[of as usize][i as usize].lane = key.lane(index as usize);
            }
            self.buckets.entry(key).or_default().free = free;
        }
        let Contacts { ball, one, two, four, colds, painter, .. } = self;
        let desk = Desk::new((ball, one, two, four), colds, painter, tiled);
        arrivals.par_iter().for_each(|arrivals| arrivals.iter().for_each(|arrival| desk.write(arrival)));
    }

    /// Adds a block to a bucket. Returns its first lane, the others go to `free`.
    fn grow(&mut self, key: Key, free: &mut Vec<u32>) -> u32 {
        let cold = if key.is_cold() { self.colds.len() as u32 } else { HOT };
        if key.is_cold() {
            make_room(&mut self.colds, cold as usize + 1);
            self.colds.push(Cold::IDLE);
        }
        let block = match key.class() {
            Class::Ball => self.ball.add(key, cold),
            Class::One => self.one.add(key, cold),
            Class::Two => self.two.add(key, cold),
            Class::Four => self.four.add(key, cold),
        };
        self.buckets.entry(key).or_default().blocks.push(block);
        self.grown = true;
        let lanes = LANES as u32;
        free.extend((block * lanes + 1..(block + 1) * lanes).rev());
        block * lanes
    }

    /// Makes ready for a step: the order of the sweeps, and what cold halves need to know of the bodies.
    pub fn prepare(&mut self, lines: &[Line]) {
        if self.grown || self.plan.is_serial() {
            self.plan = Plan::new(self);
            self.grown = false;
        }
        self.refresh(lines);
    }

    /// Sorts all contacts of a world, whose rows have changed, into new blocks: within a bucket in the order of `entries`. Contacts that
    /// are not among these are gone. `tiled` says whether rows are cut into tiles from now on, `rows` is their number. Returns the new places.
    pub fn sort(&mut self, entries: &[Entry], tiled: bool, rows: usize) -> Vec<Lane> {
        self.tiled = tiled;
        self.painter.clear(rows);
        self.buckets.clear();
        let mut lanes = vec![Lane::NONE; entries.len()];
        let mut old = std::mem::take(&mut self.colds);
        let mut colds = 0;
        for class in CLASSES {
            let places = self.places(class, entries);
            let keys: Vec<Key> = places
                .chunk_by(|a, b| a.0 == b.0)
                .flat_map(|group| vec![group[0].0; group.len().div_ceil(LANES)])
                .collect();
            let mut next = 0;
            for group in places.chunk_by(|a, b| a.0 == b.0) {
                let (key, first) = (group[0].0, next);
                next += group.len().next_multiple_of(LANES) as u32;
                for (&(_, i), index) in group.iter().zip(first..) {
                    lanes[i as usize] = key.lane(index as usize);
                }
                let blocks = first / LANES as u32..next / LANES as u32;
                let free = (first + group.len() as u32..next).rev().collect();
                self.buckets.insert(key, Bucket { blocks: blocks.collect(), free });
            }
            // One class at a time is there twice.
            let mut fresh = Contacts::default();
            match class {
                Class::Ball => fresh.ball = Shelf::idle(keys, &mut colds),
                Class::One => fresh.one = Shelf::idle(keys, &mut colds),
                Class::Two => fresh.two = Shelf::idle(keys, &mut colds),
                Class::Four => fresh.four = Shelf::idle(keys, &mut colds),
            }
            self.colds.resize(colds as usize, Cold::IDLE);
            let Contacts { ball, one, two, four, painter, .. } = self;
            let from = Desk::new((ball, one, two, four), &mut old, painter, false);
            let Contacts { ball, one, two, four, .. } = &mut fresh;
            let to = Desk::new((ball, one, two, four), &mut self.colds, painter, false);
            places.par_iter().with_min_len(256).for_each(|&(key, i)| {
                let Entry { lane, a, b } = entries[i as usize];
                from.copy(lane, &to, lanes[i as usize], [a, b & !FIXED]);
                painter.take(key.color(), a, (!key.is_one_sided()).then_some(b));
            });
            match class {
                Class::Ball => self.ball = fresh.ball,
                Class::One => self.one = fresh.one,
                Class::Two => self.two = fresh.two,
                Class::Four => self.four = fresh.four,
            }
        }
        self.plan = Plan::new(self);
        self.grown = false;
        lanes
    }

    /// The entries of a class with their new keys, in order.
    fn places(&self, class: Class, entries: &[Entry]) -> Vec<(Key, u32)> {
        let keys = self.keys(class);
        let mut places: Vec<(Key, u32)> = (entries, 0..entries.len() as u32)
            .into_par_iter()
            .filter(|(entry, _)| entry.lane.class() == class)
            .map(|(&Entry { lane, a, b }, i)| {
                let old = keys[lane.block()];
                let manifold = Manifold { a, b, ..Manifold::default() };
                let (phase, tile) = place_of(&manifold, old.color(), !old.is_parked(), self.tiled);
                (Key::new(phase, tile, old.color(), class, old.is_cold()), i)
            })
            .collect();
        places.par_sort_unstable();
        places
    }
}
