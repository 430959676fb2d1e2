//! Where contacts are kept: blocks of one class, and the names of places in them.

use crate::block::{Block, Cold, Column, LANES, get3};
use crate::manifold::{Manifold, Memory};
use crate::paint::OVERFLOW;
use crate::plan::cold_of;
use crate::single::Single;
use bytemuck::{Pod, Zeroable};
use rockfall_math::room::make_room;

/// How many points the blocks of a class have room for, and how their contacts follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// One point between two balls.
    Ball,
    One,
    Two,
    Four,
}

pub(crate) const CLASSES: [Class; 4] = [Class::Ball, Class::One, Class::Two, Class::Four];

impl Class {
    pub(crate) fn of(points: u32, balls: bool) -> Self {
        match points {
            _ if balls => Class::Ball,
            0 | 1 => Class::One,
            2 => Class::Two,
            _ => Class::Four,
        }
    }
}

/// The place of one contact: a lane of a block. It holds until the contact is moved or the blocks are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct Lane(u32);

impl Default for Lane {
    fn default() -> Self {
        Lane::NONE
    }
}

impl Lane {
    /// No place yet.
    pub const NONE: Lane = Lane(u32::MAX);

    /// Bits of the number of a lane within its class.
    pub(crate) const BITS: u32 = 29;

    /// # Panics
    /// Beyond 2²⁹ contacts of a class, whose blocks would take 40 GiB and more.
    pub(crate) fn new(class: Class, parked: bool, index: usize) -> Self {
        assert!(index < 1 << Self::BITS, "more than 2^29 contacts of a class");
        Lane((class as u32) << (Self::BITS + 1) | u32::from(parked) << Self::BITS | index as u32)
    }

    pub(crate) fn class(self) -> Class {
        CLASSES[(self.0 >> (Self::BITS + 1)) as usize]
    }

    /// Whether the contact takes no part, since neither of its bodies does.
    pub fn is_parked(self) -> bool {
        self.0 >> Self::BITS & 1 == 1
    }

    /// Number within the class.
    pub(crate) fn index(self) -> usize {
        (self.0 & ((1 << Self::BITS) - 1)) as usize
    }

    pub(crate) fn block(self) -> usize {
        self.index() / LANES
    }

    pub(crate) fn lane(self) -> usize {
        self.index() % LANES
    }
}

/// When in a sweep a contact has its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Phase {
    /// Between two bodies of one tile.
    Inner,
    /// Between bodies of two tiles.
    Between,
    /// With a body that contacts can't move: these have the last word.
    Ground,
    /// Never: neither body takes part. Between two bodies that contacts move.
    Parked,
    /// Likewise, with a body that contacts can't move.
    ParkedGround,
}

const PHASES: [Phase; 5] = [Phase::Inner, Phase::Between, Phase::Ground, Phase::Parked, Phase::ParkedGround];

/// Rows of a tile. Bodies and drifts of so many take 384 KiB: they stay in a second-level cache of 1 MiB while their
/// contacts are swept, colour after colour.
pub(crate) const TILE: usize = 4096;

/// Worlds with fewer rows of bodies that move are not worth tiles: all of them stay in the caches anyway, and tiles too few would not
/// keep all threads busy.
pub const WORTH_TILES: usize = 16 * TILE;

/// How rows are cut into parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cut {
    /// Whether into tiles.
    pub(crate) tiled: bool,
    /// Rows of bodies; behind them stand copies (see [`crate::copies`]).
    pub(crate) bodies: u32,
}

/// What the contacts of a block have in common: phase, tile, colour, class, and whether they have a cold half, in the order in
/// which contacts are swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Key(u32);

impl Key {
    const TILES: u32 = 19;
    /// The tile of contacts that belong to none; behind all others.
    pub(crate) const NO_TILE: u32 = (1 << Self::TILES) - 1;
    /// The tile of contacts of copies, which belong to no tile either.
    pub(crate) const COPIES: u32 = Self::NO_TILE - 1;

    pub(crate) fn new(phase: Phase, tile: u32, color: u32, class: Class, cold: bool) -> Self {
        debug_assert!(tile <= Self::NO_TILE && color <= OVERFLOW);
        let place = (phase as u32) << Self::TILES | tile;
        Key(place << 10 | color << 3 | (class as u32) << 1 | u32::from(cold))
    }

    /// Whether it is one that [`Key::new`] makes.
    pub(crate) fn is_sound(self) -> bool {
        ((self.0 >> (Self::TILES + 10)) as usize) < PHASES.len() && self.color() <= OVERFLOW
    }

    pub(crate) fn phase(self) -> Phase {
        PHASES[(self.0 >> (Self::TILES + 10)) as usize]
    }

    pub(crate) fn tile(self) -> u32 {
        self.0 >> 10 & Self::NO_TILE
    }

    pub(crate) fn color(self) -> u32 {
        self.0 >> 3 & 127
    }

    pub(crate) fn class(self) -> Class {
        CLASSES[(self.0 >> 1 & 3) as usize]
    }

    pub(crate) fn is_cold(self) -> bool {
        self.0 & 1 == 1
    }

    /// Whether one of the bodies of its contacts is split.
    pub(crate) fn is_of_copies(self) -> bool {
        self.tile() == Self::COPIES
    }

    pub(crate) fn is_parked(self) -> bool {
        matches!(self.phase(), Phase::Parked | Phase::ParkedGround)
    }

    pub(crate) fn is_one_sided(self) -> bool {
        matches!(self.phase(), Phase::Ground | Phase::ParkedGround)
    }

    /// The lane of that number under this key.
    pub(crate) fn lane(self, index: usize) -> Lane {
        Lane::new(self.class(), self.is_parked(), index)
    }
}

/// What a contact is remembered by, lane by lane; read only when its manifold is found anew.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<const P: usize> {
    /// Names of the points.
    pub(crate) features: [[u32; LANES]; P],
    /// Points in use; 0 in lanes that are not.
    pub(crate) counts: [u32; LANES],
}

impl<const P: usize> Names<P> {
    pub(crate) const IDLE: Self = Names { features: [[0; LANES]; P], counts: [0; LANES] };
}

/// For how long contacts may follow their bodies, lane by lane.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Slack {
    /// Way that the two bodies may still go relative to each other, metres.
    pub(crate) left: Column,
    /// How far from the contact the surfaces may come near each other, metres: what a turn of one against the other is multiplied by.
    pub(crate) levers: Column,
    /// See [`crate::Leash`].
    pub(crate) skins: Column,
}

impl Slack {
    pub(crate) const IDLE: Self = Slack { left: [0.0; LANES], levers: [0.0; LANES], skins: [0.0; LANES] };
}

/// A block has no cold half.
pub(crate) const HOT: u32 = u32::MAX;

/// The blocks of one class.
#[derive(Clone, Debug)]
pub(crate) struct Shelf<const P: usize, const T: usize> {
    pub(crate) blocks: Vec<Block<P, T>>,
    pub(crate) names: Vec<Names<P>>,
    pub(crate) slacks: Vec<Slack>,
    /// Which contacts of each block may go on following their bodies, a bit each, when they have followed them into this step. By pair they are
    /// asked for in no order of memory; two bytes a block stay in a cache, its slack does not.
    pub(crate) follows: Vec<u16>,
    pub(crate) keys: Vec<Key>,
    /// Number of each block's cold half, or [`HOT`].
    pub(crate) colds: Vec<u32>,
}

impl<const P: usize, const T: usize> Default for Shelf<P, T> {
    fn default() -> Self {
        Shelf {
            blocks: Vec::new(),
            names: Vec::new(),
            slacks: Vec::new(),
            follows: Vec::new(),
            keys: Vec::new(),
            colds: Vec::new(),
        }
    }
}

impl<const P: usize, const T: usize> Shelf<P, T> {
    /// What a lane holds.
    pub(crate) fn read(&self, at: Lane, colds: &[Cold]) -> (Manifold, Memory) {
        let (block, lane) = (at.block(), at.lane());
        let (key, names) = (self.keys[block], &self.names[block]);
        let count = names.counts[lane] as usize;
        let (manifold, mut memory) =
            Single::of(&self.blocks[block], lane).manifold(count, key.is_one_sided());
        for (feature, column) in memory.features.iter_mut().zip(&names.features) {
            *feature = column[lane];
        }
        memory.color = key.color();
        if let Some(cold) = cold_of(&self.colds, block) {
            memory.rolling = get3(&colds[cold].rolling_impulse, lane);
            memory.twist += colds[cold].twist_impulse[lane];
        }
        (manifold, memory)
    }

    /// The two rows of a lane.
    pub(crate) fn rows(&self, block: usize, lane: usize) -> (u32, u32) {
        (self.blocks[block].a[lane], self.blocks[block].b[lane])
    }

    /// Adds an idle block and returns its number.
    pub(crate) fn add(&mut self, key: Key, cold: u32) -> u32 {
        let len = self.blocks.len() + 1;
        make_room(&mut self.blocks, len);
        make_room(&mut self.names, len);
        make_room(&mut self.slacks, len);
        self.blocks.push(Block::IDLE);
        self.names.push(Names::IDLE);
        self.slacks.push(Slack::IDLE);
        self.follows.push(0);
        self.keys.push(key);
        self.colds.push(cold);
        len as u32 - 1
    }

    pub(crate) fn memory(&self) -> usize {
        self.blocks.capacity() * size_of::<Block<P, T>>()
            + self.names.capacity() * size_of::<Names<P>>()
            + self.slacks.capacity() * size_of::<Slack>()
            + self.follows.capacity() * size_of::<u16>()
            + self.keys.capacity() * size_of::<Key>()
            + self.colds.capacity() * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hold_what_they_are_made_of() {
        for phase in PHASES {
            for class in CLASSES {
                for (tile, color, cold) in [(0, 0, false), (Key::NO_TILE, OVERFLOW, true), (77, 13, true)] {
                    let key = Key::new(phase, tile, color, class, cold);
                    assert_eq!((key.phase(), key.tile(), key.color()), (phase, tile, color));
                    assert_eq!((key.class(), key.is_cold()), (class, cold));
                    let lane = key.lane(123_456_789);
                    assert_eq!((lane.class(), lane.index()), (class, 123_456_789));
                    assert_eq!(lane.is_parked(), key.is_parked());
                }
            }
        }
        let order = [
            Key::new(Phase::Inner, 3, 9, Class::Four, false),
            Key::new(Phase::Inner, 4, 0, Class::One, false),
            Key::new(Phase::Between, 0, 0, Class::One, false),
            Key::new(Phase::Between, 0, 0, Class::One, true),
            Key::new(Phase::Between, 0, 0, Class::Two, false),
            Key::new(Phase::Between, 0, 1, Class::One, false),
        ];
        assert!(order.is_sorted());
    }
}
