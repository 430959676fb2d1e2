//! In which order a sweep goes over the blocks.
//!
//! Contacts between bodies of one tile first: a thread takes a tile and goes through all of its colours, while its
//! bodies stay in the cache. Then contacts between tiles, and those with immovable bodies, which have the last word. Within a
//! colour threads share the work; between two colours of the whole world they wait for each other.

use crate::block::LANES;
use crate::contacts::Contacts;
use crate::paint::OVERFLOW;
use crate::shelf::{Class, HOT, Key, Phase};
use std::ops::Range;

/// Blocks in a span. Results don't depend on it.
const SPAN: usize = 8;

/// Blocks `from..to` of one class, of one colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub(crate) class: Class,
    pub(crate) one_sided: bool,
    pub(crate) cold: bool,
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// The only lane, of contacts that are solved one by one.
    pub(crate) only: Option<u8>,
}

impl Span {
    /// The block that is visited `count` blocks after block `i` of this span, where that is in this span or in the one `after` it.
    #[inline(always)]
    pub(crate) fn ahead(&self, i: usize, count: usize, after: Option<&Span>) -> Option<usize> {
        let (block, end) = (i + count, self.to as usize);
        if block < end {
            return Some(block);
        }
        let Span { from, to, .. } = after?;
        Some(*from as usize + block - end).filter(|block| *block < *to as usize)
    }

    /// Whether all contacts are those that [`crate::balls`] is for.
    #[inline(always)]
    pub(crate) fn is_of_plain_balls(&self) -> bool {
        self.class == Class::Ball && !self.cold
    }
}

/// Spans that belong together in the order of a sweep.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// The spans of each tile, colour after colour. Tiles share no body that moves.
    Tiles(Vec<Range<usize>>),
    /// The spans of one colour, with so many blocks.
    Layer(Range<usize>, usize),
    /// Contact after contact.
    Serial(Vec<Span>),
}

/// The order of a sweep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// All blocks.
    pub(crate) spans: Vec<Span>,
    /// What comes first: the spans of the contacts within each tile, colour after colour. Empty where rows are not cut.
    pub(crate) inner: Vec<Range<usize>>,
    /// What comes then.
    pub(crate) parts: Vec<Part>,
    /// Colours that hold contacts, of both sides.
    pub(crate) colors: usize,
}

impl Plan {
    /// The order of the blocks that `contacts` has now.
    pub(crate) fn new(contacts: &Contacts) -> Self {
        let mut plan = Plan::default();
        let mut colors = [0_u128; 2];
        for key in contacts.buckets.keys().filter(|key| !key.is_parked()) {
            colors[usize::from(key.is_one_sided())] |= 1 << key.color();
        }
        plan.colors = colors.iter().map(|colors| colors.count_ones() as usize).sum();
        let of = |phase: Phase| -> Vec<Key> {
            contacts.buckets.keys().filter(|key| key.phase() == phase).copied().collect()
        };
        if contacts.is_tiled() {
            plan.inner = vec![0..0; contacts.tiles()];
            for keys in of(Phase::Inner).chunk_by(|a, b| a.tile() == b.tile()) {
                plan.inner[keys[0].tile() as usize] = plan.add(contacts, keys);
            }
        }
        for phase in [Phase::Between, Phase::Ground] {
            let keys = of(phase);
            let tiles = if contacts.is_tiled() && phase == Phase::Ground { Key::COPIES } else { 0 };
            let (tiled, rest) = keys.split_at(keys.partition_point(|key| key.tile() < tiles));
            let (layered, last) = rest.split_at(rest.partition_point(|key| key.color() < OVERFLOW));
            if !tiled.is_empty() {
                let tiles = tiled.chunk_by(|a, b| a.tile() == b.tile());
                let tiles = tiles.map(|keys| plan.add(contacts, keys)).collect();
                plan.parts.push(Part::Tiles(tiles));
            }
            for keys in layered.chunk_by(|a, b| (a.tile(), a.color()) == (b.tile(), b.color())) {
                let spans = plan.add(contacts, keys);
                let blocks = plan.spans[spans.clone()].iter().map(|s| (s.to - s.from) as usize).sum();
                plan.parts.push(Part::Layer(spans, blocks));
            }
            if !last.is_empty() {
                plan.add(contacts, last);
                plan.parts.push(Part::Serial(one_by_one(contacts, last)));
            }
        }
        plan
    }

    /// Contacts that are solved one by one. Where there are any, their order has to be found anew when one of them comes or goes.
    pub(crate) fn serial(&self) -> usize {
        let one_by_one = |part: &Part| if let Part::Serial(spans) = part { spans.len() } else { 0 };
        self.parts.iter().map(one_by_one).sum()
    }

    pub(crate) fn memory(&self) -> usize {
        self.spans.capacity() * size_of::<Span>()
    }

    /// Adds the blocks of some keys.
    fn add(&mut self, contacts: &Contacts, keys: &[Key]) -> Range<usize> {
        let first = self.spans.len();
        for key in keys {
            let start = self.spans.len();
            for &block in &contacts.buckets[key].blocks {
                match self.spans[start..].last_mut() {
                    Some(last) if last.to == block && ((last.to - last.from) as usize) < SPAN => last.to += 1,
                    _ => self.spans.push(span(*key, block)),
                }
            }
        }
        first..self.spans.len()
    }
}

/// The contacts of some keys, in the order of their rows.
fn one_by_one(contacts: &Contacts, keys: &[Key]) -> Vec<Span> {
    let mut lanes = Vec::new();
    for key in keys {
        for &block in &contacts.buckets[key].blocks {
            for lane in 0..LANES {
                let (m, memory) = contacts.read(key.lane(block as usize * LANES + lane));
                if m.count > 0 {
                    let span = Span { only: Some(lane as u8), ..span(*key, block) };
                    lanes.push(((m.a, m.b, memory.features), span));
                }
            }
        }
    }
    lanes.sort_unstable_by_key(|(order, _)| *order);
    lanes.into_iter().map(|(_, span)| span).collect()
}

fn span(key: Key, block: u32) -> Span {
    Span {
        class: key.class(),
        one_sided: key.is_one_sided(),
        cold: key.is_cold(),
        from: block,
        to: block + 1,
        only: None,
    }
}

/// The cold half of a block, where it has one.
pub(crate) fn cold_of(colds: &[u32], block: usize) -> Option<usize> {
    Some(colds[block]).filter(|&cold| cold != HOT).map(|cold| cold as usize)
}
