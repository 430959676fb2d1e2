//! Stage 8, **prepare**: manifolds to batches.
//!
//! Reads manifolds, memories, colours, masses and velocities; writes blocks of sixteen, sorted into buckets by side, colour,
//! number of points, and whether they need the cold half. Contacts between two bodies that move come first, those with
//! immovable bodies last, so that the ground has the last word.

use crate::block::{Block, Cold, LANES};
use crate::fill::Fill;
use crate::line::Line;
use crate::manifold::Chunk;
use rockfall_math::DVec3;
use rockfall_math::room::make_room;

/// How two surfaces rub and bounce.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    /// Coulomb's coefficient.
    pub friction: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
    /// Coefficient of rolling friction, m.
    pub rolling: f32,
    /// Coefficient of twisting friction, m.
    pub twisting: f32,
}

impl Surface {
    /// Whether a contact of so many points needs the cold half of a block.
    pub(crate) fn is_cold(&self, points: u32) -> bool {
        self.restitution > 0.0 || self.rolling > 0.0 || (self.twisting > 0.0 && points == 1)
    }
}

/// Where a lane of a block comes from and its impulses go to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin {
    pub(crate) chunk: u32,
    pub(crate) row: u32,
    pub(crate) in_use: bool,
}

/// How many points the blocks of a class have room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    One,
    Two,
    Four,
}

pub(crate) const CLASSES: [Class; 3] = [Class::One, Class::Two, Class::Four];

impl Class {
    pub(crate) fn of(points: u32) -> Self {
        match points {
            0 | 1 => Class::One,
            2 => Class::Two,
            _ => Class::Four,
        }
    }
}

/// Blocks `from..to` of one class, of one colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub(crate) class: Class,
    pub(crate) one_sided: bool,
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// The cold half of block `from`.
    pub(crate) cold: Option<usize>,
}

/// The blocks of one class with their origins.
#[derive(Clone, Debug)]
pub(crate) struct Shelf<const P: usize, const T: usize> {
    pub(crate) blocks: Vec<Block<P, T>>,
    /// [`LANES`] a block.
    pub(crate) origins: Vec<Origin>,
}

impl<const P: usize, const T: usize> Default for Shelf<P, T> {
    fn default() -> Self {
        Shelf { blocks: Vec::new(), origins: Vec::new() }
    }
}

impl<const P: usize, const T: usize> Shelf<P, T> {
    pub(crate) fn resize(&mut self, blocks: usize) {
        self.blocks.truncate(blocks);
        make_room(&mut self.blocks, blocks);
        self.blocks.resize(blocks, Block::IDLE);
        self.origins.truncate(blocks * LANES);
        make_room(&mut self.origins, blocks * LANES);
        self.origins.resize(blocks * LANES, Origin::default());
    }

    fn memory(&self) -> usize {
        self.blocks.capacity() * size_of::<Block<P, T>>() + self.origins.capacity() * size_of::<Origin>()
    }
}

/// Spans whose contacts don't share a body that moves, or that are solved one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) spans: std::ops::Range<usize>,
    /// The overflow: contact after contact, in order.
    pub(crate) serial: bool,
    /// Blocks in all spans.
    pub(crate) blocks: usize,
}

/// All contacts of a step, ready to be swept.
#[derive(Clone, Debug, Default)]
pub struct Batches {
    pub(crate) one: Shelf<1, 0>,
    pub(crate) two: Shelf<2, 1>,
    pub(crate) four: Shelf<4, 1>,
    pub(crate) colds: Vec<Cold>,
    pub(crate) spans: Vec<Span>,
    pub(crate) layers: Vec<Layer>,
    /// Bucket of every manifold; see [`crate::shelve`].
    pub(crate) codes: Vec<Vec<u16>>,
}

/// What [`Batches::prepare`] reads of the bodies.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    /// Masses and velocities.
    pub lines: &'a [Line],
    /// Centres of mass, metres.
    pub positions: &'a [DVec3],
}

impl Batches {
    /// Number of layers that hold contacts: colours of both sides.
    pub fn colors(&self) -> usize {
        self.layers.len()
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.one.memory()
            + self.two.memory()
            + self.four.memory()
            + self.colds.capacity() * size_of::<Cold>()
            + self.spans.capacity() * size_of::<Span>()
            + self.codes.iter().map(|codes| codes.capacity() * size_of::<u16>()).sum::<usize>()
    }

    /// Bytes that one sweep over all blocks reads.
    pub fn swept_bytes(&self) -> usize {
        size_of_val(&self.one.blocks[..])
            + size_of_val(&self.two.blocks[..])
            + size_of_val(&self.four.blocks[..])
    }

    /// Fills the batches with the contacts of `chunks`, painted before. `active` tells by row whether a body moves in this
    /// step; contacts without one are left out. `surface` mixes the materials of two rows.
    pub fn prepare(
        &mut self,
        chunks: &[Chunk],
        bodies: Bodies<'_>,
        active: impl Fn(usize) -> bool + Sync,
        surface: impl Fn(usize, usize) -> Surface + Sync,
    ) {
        let places = self.shelve(chunks, &active, &surface);
        Fill { chunks, bodies, surface: &surface }.all(self, &places);
    }
}
