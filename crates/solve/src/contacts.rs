//! All contacts of a world, in blocks of sixteen, from the step in which they are found to the one in which they end.
//!
//! A contact is in one place only: the lane that the solver sweeps over. Nothing is copied before a step or after it; a manifold that
//! only follows its bodies changes where it is ([`crate::follow`]), and impulses are found there by the next step. Blocks hold
//! contacts of one key: phase, tile, colour, class. Which lane of a key's blocks a contact has does not matter to any bit of
//! the result, because within a colour no body that moves stands twice.

use crate::block::{Cold, LANES};
use crate::copies::Copies;
use crate::desk::{Desk, Found};
use crate::line::Line;
use crate::manifold::{Manifold, Memory, NO_COLOR};
use crate::paint::{Blank, OVERFLOW, Painter};
use crate::plan::Plan;
use crate::shelf::{Class, Cut, HOT, Key, Lane, Shelf, TILE};
use crate::total::Totals;
use rayon::prelude::*;
use rockfall_math::room::make_room;
use rockfall_math::share::{Share, ShareSort};
use std::collections::BTreeMap;

/// One idle lane in so many is too much.
const SPARSE: usize = 12;

/// The blocks of a key.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bucket {
    /// Numbers of its blocks within their class, ascending.
    pub(crate) blocks: Vec<u32>,
    /// Lanes without a contact; the last is taken first.
    pub(crate) free: Vec<u32>,
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
    pub(crate) painter: Painter,
    /// Where somebody asks.
    pub(crate) totals: Option<Totals>,
    /// Whether rows are cut into tiles.
    pub(crate) tiled: bool,
    /// Whether a contact that came in this step found no colour.
    pub(crate) crowded: bool,
    /// Whether blocks have come since the plan was made.
    pub(crate) grown: bool,
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
            + self.totals.as_ref().map_or(0, Totals::memory)
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

    pub(crate) fn cut(&self) -> Cut {
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

    pub(crate) fn keys(&self, class: Class) -> &[Key] {
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
            arrivals.par_iter_mut().shared().flat_map_iter(|group| group.iter_mut().filter(blank)).collect();
        let blanks: Vec<Blank> = found
            .par_iter_mut()
            .shared()
            .map(|arrival| {
                let m = &mut arrival.manifold;
                (m.a, m.b) = copies.place(m.a, m.b, arrival.ordinal.into());
                Blank::new(m.a, m.b, arrival.ordinal)
            })
            .collect();
        let colors = self.painter.paint(&blanks);
        self.crowded = colors.par_iter().shared().any(|&color| color == OVERFLOW);
        found.into_par_iter().zip(colors).shared().for_each(|(arrival, color)| arrival.memory.color = color);
    }

    /// Whether so many lanes are idle, since contacts have ended, that sorting all contacts into new blocks is worth it.
    pub fn is_sparse(&self) -> bool {
        let idle: usize = self.buckets.values().map(|bucket| bucket.free.len()).sum();
        let blocks: usize = self.buckets.values().map(|bucket| bucket.blocks.len()).sum();
        // Half a block of every key stays idle anyway.
        let spare = idle.saturating_sub(self.buckets.len() * LANES / 2);
        spare * SPARSE > blocks * LANES
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
            .shared()
            .flat_map_iter(|(group, arrivals)| {
                arrivals.iter().zip(0..).map(move |(arrival, i)| (arrival.key(cut), group as u32, i))
            })
            .collect();
        places.sort_shared();
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
        arrivals
            .par_iter()
            .shared()
            .for_each(|arrivals| arrivals.iter().for_each(|arrival| desk.write(arrival)));
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
        if self.grown || self.crowded || more || self.plan.serial() > 0 {
            self.plan = Plan::new(self);
            self.grown = false;
        }
        self.weigh();
        self.refresh(lines);
    }
}
