//! All contacts of a world, in blocks of sixteen, from the step in which they are found to the one in which they end.
//!
//! A contact is in one place only: the lane that the solver sweeps over. Nothing is copied before a step or after it; a manifold that
//! only follows its bodies changes where it is ([`crate::follow`]), and impulses are found there by the next step. Blocks hold
//! contacts of one key: phase, tile, colour, class. Which lane of a key's blocks a contact has does not matter to any bit of
//! the result, because within a colour no body that moves stands twice.

use crate::block::{Cold, LANES};
use crate::copies::Copies;
use crate::desk::{Desk, Found, place_of};
use crate::line::Line;
use crate::manifold::{FIXED, Manifold, Memory, NO_COLOR};
use crate::paint::{Blank, OVERFLOW, Painter};
use crate::plan::Plan;
use crate::shelf::{CLASSES, Class, Cut, HOT, Key, Lane, Shelf, TILE};
use rayon::prelude::*;
use rockfall_math::room::make_room;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

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
    pub(crate) copies: Copies,
    painter: Painter,
    /// Whether rows are cut into tiles.
    tiled: bool,
    /// Whether a contact that came in this step found no colour.
    crowded: bool,
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
            + self.copies.memory()
            + self.painter.memory()
    }

    /// Whether rows are cut into tiles.
    pub fn is_tiled(&self) -> bool {
        self.tiled
    }

    /// Contacts that found no colour and are solved one after the other.
    pub fn serial(&self) -> usize {
        self.plan.serial()
    }

    /// Number of bodies that are split. If there are any, contacts have to be sorted also when bodies come behind all others.
    pub fn split_bodies(&self) -> usize {
        self.copies.len()
    }

    fn cut(&self) -> Cut {
        Cut { tiled: self.tiled, bodies: self.copies.first() }
    }

    /// Number of tiles, if rows are cut.
    pub(crate) fn tiles(&self) -> usize {
        (self.copies.first() as usize).div_ceil(TILE)
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
        self.copies.resize(rows);
        let cut = self.cut();
        let Contacts { ball, one, two, four, colds, copies, painter, .. } = self;
        painter.resize(copies.rows());
        Desk::new((ball, one, two, four), colds, painter, cut)
    }

    /// What a lane holds: position, normal and signed distances, and impulses; of a body that is split, the row of a copy.
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

    /// Gives a colour to every contact that has none yet, and the rows of copies where bodies are split; `rows` is the number of
    /// bodies.
    pub fn paint(&mut self, arrivals: &mut [Vec<Found>], rows: usize) {
        self.copies.resize(rows);
        self.painter.resize(self.copies.rows());
        let copies = &self.copies;
        let blank = |arrival: &&mut Found| arrival.memory.color == NO_COLOR;
        let mut found: Vec<&mut Found> =
            arrivals.par_iter_mut().flat_map_iter(|group| group.iter_mut().filter(blank)).collect();
        let blanks: Vec<Blank> = found
            .par_iter_mut()
            .map(|arrival| {
                let m = &mut arrival.manifold;
                (m.a, m.b) = copies.place(m.a, m.b, arrival.ordinal.into());
                Blank::new(m.a, m.b, arrival.ordinal)
            })
            .collect();
        let colors = self.painter.paint(&blanks);
        self.crowded = colors.par_iter().any(|&color| color == OVERFLOW);
        found.into_par_iter().zip(colors).for_each(|(arrival, color)| arrival.memory.color = color);
    }

    /// Whether contacts came in this step that found no colour, so that [`Contacts::split`] may help.
    pub fn is_crowded(&self) -> bool {
        self.crowded
    }

    /// Gives every contact a lane and writes it there.
    pub fn place(&mut self, arrivals: &mut [Vec<Found>]) {
        let cut = self.cut();
        let mut places: Vec<(Key, u32, u32)> = arrivals
            .par_iter()
            .enumerate()
            .flat_map_iter(|(group, arrivals)| {
                arrivals.iter().zip(0..).map(move |(arrival, i)| (arrival.key(cut), group as u32, i))
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
        let desk = Desk::new((ball, one, two, four), colds, painter, cut);
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
        // Bodies that came behind all others may have begun another tile.
        let more = self.tiled && self.plan.inner.len() != self.tiles();
        if self.grown || more || self.plan.serial() > 0 {
            self.plan = Plan::new(self);
            self.grown = false;
        }
        self.weigh();
        self.refresh(lines);
    }

    /// Sorts all contacts of a world, whose rows have changed, into new blocks: within a bucket in the order of `entries`. Contacts that
    /// are not among these are gone. `tiled` says whether rows are cut into tiles from now on, `rows` is their number, and `new_rows`
    /// tells what became of each old one, `u32::MAX` where it is gone. Returns the new places.
    pub fn sort(&mut self, entries: Vec<Entry>, tiled: bool, rows: usize, new_rows: &[u32]) -> Vec<Lane> {
        let next = self.copies.next(&degrees(&entries, rows), |row| new_rows[row as usize]);
        self.tiled = tiled;
        self.arrange(entries, next)
    }

    /// Splits the bodies that have more contacts than there are colours. Nothing if they are split already; otherwise the
    /// new places of all contacts, `entries`.
    pub fn split(&mut self, entries: Vec<Entry>) -> Option<Vec<Lane>> {
        let bodies = self.copies.first() as usize;
        let next = self.copies.next(&degrees(&entries, bodies), |row| row);
        (!next.is_like(&self.copies)).then(|| self.arrange(entries, next))
    }

    /// Puts all contacts into new blocks, with the rows that they have among `copies`.
    fn arrange(&mut self, mut entries: Vec<Entry>, copies: Copies) -> Vec<Lane> {
        let from = std::mem::replace(&mut self.copies, copies);
        let painted = self.repaint(&mut entries, &from);
        let cut = self.cut();
        self.buckets.clear();
        let mut lanes = vec![Lane::NONE; entries.len()];
        let mut old = std::mem::take(&mut self.colds);
        let mut colds = 0;
        for class in CLASSES {
            let places = self.places(class, &entries, &painted);
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
            let from = Desk::new((ball, one, two, four), &mut old, painter, cut);
            let Contacts { ball, one, two, four, .. } = &mut fresh;
            let to = Desk::new((ball, one, two, four), &mut self.colds, painter, cut);
            places.par_iter().with_min_len(256).for_each(|&(_, i)| {
                let Entry { lane, a, b } = entries[i as usize];
                from.copy(lane, &to, lanes[i as usize], [a, b & !FIXED]);
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

    /// Gives each contact the rows of copies where bodies are split now, `from` being the copies until now. Takes the colours
    /// of those that keep theirs, and gives others to the rest: these, by their place among `entries`, are returned.
    fn repaint(&mut self, entries: &mut [Entry], from: &Copies) -> Vec<(u32, u32)> {
        self.painter.clear(self.copies.rows());
        let Contacts { copies, painter, .. } = &*self;
        let blank: Vec<u32> = entries
            .par_iter_mut()
            .enumerate()
            .filter_map(|(i, entry)| {
                let color = self.keys(entry.lane.class())[entry.lane.block()].color();
                let old = self.rows_at(entry.lane);
                let same;
                (entry.a, entry.b, same) = copies.keep((entry.a, entry.b), from, old, i as u64);
                if same && color < OVERFLOW {
                    painter.take(color, entry.a, (entry.b & FIXED == 0).then_some(entry.b));
                    return None;
                }
                Some(i as u32)
            })
            .collect();
        let of = |&i: &u32| Blank::new(entries[i as usize].a, entries[i as usize].b, i);
        let blanks: Vec<Blank> = blank.par_iter().map(of).collect();
        blank.into_iter().zip(painter.paint(&blanks)).collect()
    }

    fn rows_at(&self, at: Lane) -> (u32, u32) {
        let (block, lane) = (at.block(), at.lane());
        match at.class() {
            Class::Ball => self.ball.rows(block, lane),
            Class::One => self.one.rows(block, lane),
            Class::Two => self.two.rows(block, lane),
            Class::Four => self.four.rows(block, lane),
        }
    }

    /// The entries of a class with their new keys, in order; `painted` has the colours of those that lost theirs.
    fn places(&self, class: Class, entries: &[Entry], painted: &[(u32, u32)]) -> Vec<(Key, u32)> {
        let (keys, cut) = (self.keys(class), self.cut());
        let painted = |i: u32| painted.binary_search_by_key(&i, |&(i, _)| i).map(|at| painted[at].1);
        let mut places: Vec<(Key, u32)> = (entries, 0..entries.len() as u32)
            .into_par_iter()
            .filter(|(entry, _)| entry.lane.class() == class)
            .map(|(&Entry { lane, a, b }, i)| {
                let old = keys[lane.block()];
                let color = painted(i).unwrap_or(old.color());
                let manifold = Manifold { a, b, ..Manifold::default() };
                let (phase, tile) = place_of(&manifold, color, !old.is_parked(), cut);
                (Key::new(phase, tile, color, class, old.is_cold()), i)
            })
            .collect();
        places.par_sort_unstable();
        places
    }
}

/// Contacts of each of so many bodies: with bodies that contacts move, and with others.
fn degrees(entries: &[Entry], rows: usize) -> Vec<[u32; 2]> {
    let counts: Vec<[AtomicU32; 2]> = (0..rows).into_par_iter().map(|_| Default::default()).collect();
    entries.par_iter().with_min_len(4096).for_each(|&Entry { a, b, .. }| {
        let side = usize::from(b & FIXED != 0);
        counts[a as usize][side].fetch_add(1, Relaxed);
        if side == 0 {
            counts[b as usize][side].fetch_add(1, Relaxed);
        }
    });
    counts.into_par_iter().map(|count| count.map(AtomicU32::into_inner)).collect()
}
