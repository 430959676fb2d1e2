//! All contacts into new blocks: when rows have been sorted, or bodies split.
//!
//! Reads what the lanes hold; writes new blocks. Within a key contacts stand in the order of their pairs, so that neighbours in space are
//! neighbours in memory. The tables are sorted column by column, so that no more than one number of each contact is there twice.

use crate::block::{Block, Cold, LANES};
use crate::contacts::{Bucket, Contacts};
use crate::copies::Copies;
use crate::desk::place_of;
use crate::manifold::{FIXED, Manifold};
use crate::paint::{Blank, OVERFLOW};
use crate::plan::Plan;
use crate::shelf::{CLASSES, Class, HOT, Key, Lane, Names, Shelf, Slack};
use crate::words::Words;
use rayon::prelude::*;
use rockfall_math::room::make_room;
use rockfall_math::share::{Share, ShareSort};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

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

/// New blocks of one class.
#[derive(Default)]
struct Layout {
    /// Of each block.
    keys: Vec<Key>,
    /// For every lane, which one its contact comes from, or [`NOBODY`].
    sources: Vec<u32>,
    /// For every lane, the rows of its bodies, without the mark.
    rows: Vec<[u32; 2]>,
}

/// A lane without a contact.
const NOBODY: u32 = u32::MAX;

impl Layout {
    /// Adds the blocks of a key. Returns the number of their first lane.
    fn add<'a>(&mut self, key: Key, contacts: impl Iterator<Item = &'a Entry>) -> usize {
        let first = self.sources.len();
        for entry in contacts {
            self.sources.push(entry.lane.index() as u32);
            self.rows.push([entry.a, entry.b & !FIXED]);
        }
        let len = self.sources.len().next_multiple_of(LANES);
        self.sources.resize(len, NOBODY);
        self.rows.resize(len, [0; 2]);
        self.keys.resize(len / LANES, key);
        first
    }

    /// The bucket of the blocks added last, whose lanes `from..` are idle.
    fn bucket(&self, first: usize, from: usize) -> Bucket {
        let end = self.sources.len();
        let blocks = first as u32 / LANES as u32..end as u32 / LANES as u32;
        Bucket { blocks: blocks.collect(), free: (from as u32..end as u32).rev().collect() }
    }
}

impl<const P: usize, const T: usize> Shelf<P, T> {
    /// Puts contacts where `layout` says. To `colds` is added, for every lane of the new cold halves, which one it comes from.
    fn arrange(&mut self, layout: Layout, colds: &mut Vec<u32>) {
        let Layout { keys, sources, rows } = layout;
        let lanes = LANES as u32;
        let old = |source: u32| self.colds[(source / lanes) as usize] * lanes + source % lanes;
        let mut numbers = vec![HOT; keys.len()];
        for (block, _) in keys.iter().enumerate().filter(|(_, key)| key.is_cold()) {
            numbers[block] = (colds.len() / LANES) as u32;
            let here = &sources[block * LANES..(block + 1) * LANES];
            colds.extend(here.iter().map(|&source| if source == NOBODY { NOBODY } else { old(source) }));
        }
        regroup(&mut self.blocks, Block::IDLE, &sources);
        regroup(&mut self.names, Names::IDLE, &sources);
        regroup(&mut self.slacks, Slack::IDLE, &sources);
        let here = self.blocks.par_iter_mut().zip(rows.par_chunks_exact(LANES)).with_min_len(256).shared();
        here.for_each(|(block, rows)| {
            for (lane, &[a, b]) in rows.iter().enumerate() {
                (block.a[lane], block.b[lane]) = (a, b);
            }
        });
        self.follows = vec![0; keys.len()];
        (self.keys, self.colds) = (keys, numbers);
    }
}

/// Lane i of a table becomes what lane `sources[i]` was.
fn regroup<B: Copy>(table: &mut Vec<B>, idle: B, sources: &[u32]) {
    let blocks = sources.len() / LANES;
    let most = blocks.max(table.len());
    make_room(table, most);
    table.resize(most, idle);
    let mut idle = [idle];
    let (words, idle) = (Words::new(table), Words::new(&mut idle));
    let mut column = Vec::new();
    for (c, idle) in idle.row(0).iter().enumerate() {
        let read = |&source: &u32| match source as usize {
            _ if source == NOBODY => idle[0].load(Relaxed),
            source => words.row(source / LANES)[c][source % LANES].load(Relaxed),
        };
        sources.par_iter().with_min_len(4096).shared().map(read).collect_into_vec(&mut column);
        column.par_chunks_exact(LANES).enumerate().with_min_len(256).shared().for_each(|(block, column)| {
            words.row(block)[c].iter().zip(column).for_each(|(word, &x)| word.store(x, Relaxed));
        });
    }
    table.truncate(blocks);
    table.shrink_to_fit();
}

impl Contacts {
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
        self.buckets.clear();
        let mut lanes = vec![Lane::NONE; entries.len()];
        let mut colds = Vec::new();
        for class in CLASSES {
            let places = self.places(class, &entries, &painted);
            let mut layout = Layout::default();
            for group in places.chunk_by(|a, b| a.0 == b.0) {
                let key = group[0].0;
                let first = layout.add(key, group.iter().map(|&(_, i)| &entries[i as usize]));
                group.iter().zip(first..).for_each(|(&(_, i), index)| lanes[i as usize] = key.lane(index));
                self.buckets.insert(key, layout.bucket(first, first + group.len()));
            }
            drop(places);
            match class {
                Class::Ball => self.ball.arrange(layout, &mut colds),
                Class::One => self.one.arrange(layout, &mut colds),
                Class::Two => self.two.arrange(layout, &mut colds),
                Class::Four => self.four.arrange(layout, &mut colds),
            }
        }
        regroup(&mut self.colds, Cold::IDLE, &colds);
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
            .shared()
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
        let blanks: Vec<Blank> = blank.par_iter().shared().map(of).collect();
        blank.into_iter().zip(painter.paint(&blanks)).collect()
    }

    pub(crate) fn rows_at(&self, at: Lane) -> (u32, u32) {
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
            .shared()
            .filter(|(entry, _)| entry.lane.class() == class)
            .map(|(&Entry { lane, a, b }, i)| {
                let old = keys[lane.block()];
                let color = painted(i).unwrap_or(old.color());
                let manifold = Manifold { a, b, ..Manifold::default() };
                let (phase, tile) = place_of(&manifold, color, !old.is_parked(), cut);
                (Key::new(phase, tile, color, class, old.is_cold()), i)
            })
            .collect();
        places.sort_shared();
        places
    }
}

/// Contacts of each of so many bodies: with bodies that contacts move, and with others.
fn degrees(entries: &[Entry], rows: usize) -> Vec<[u32; 2]> {
    let counts: Vec<[AtomicU32; 2]> =
        (0..rows).into_par_iter().shared().map(|_| Default::default()).collect();
    entries.par_iter().with_min_len(4096).shared().for_each(|&Entry { a, b, .. }| {
        let side = usize::from(b & FIXED != 0);
        counts[a as usize][side].fetch_add(1, Relaxed);
        if side == 0 {
            counts[b as usize][side].fetch_add(1, Relaxed);
        }
    });
    counts.into_par_iter().shared().map(|count| count.map(AtomicU32::into_inner)).collect()
}
