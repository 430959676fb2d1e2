//! Contacts read and written one by one, by many threads at once.
//!
//! Threads that bring manifolds up to date have lanes of their own, but these lie between one another's; hence `words.rs`.

use crate::block::Cold;
use crate::manifold::{Manifold, Memory, row_of};
use crate::paint::{OVERFLOW, Painter};
use crate::shelf::{Class, Cut, HOT, Key, Lane, Phase, Shelf, TILE};
use crate::single::{ColdSingle, Single, Surface};
use crate::words::Words;
use rockfall_math::Vec3;
use std::sync::atomic::Ordering::Relaxed;

/// How far the bodies of a contact may go relative to each other while it only follows them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Leash {
    /// Way, metres.
    pub length: f32,
    /// Distance from the contact within which the two surfaces may come near each other, metres: a turn of one body against the
    /// other counts as a way of so many times its angle. Two balls may turn as they like.
    pub lever: f32,
    /// Of a round body against a flat one, the radius of the round one about the point, the middle of a ball or on the axis of a capsule, that is nearest to
    /// the other, metres: the contact follows that point and does not turn with the body. Negative where b is the round one, 0 between flat ones.
    pub skin: f32,
}

/// A contact that was found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// What was found; where it has a colour, with the rows of [`Desk::read`].
    pub manifold: Manifold,
    /// What was known of it.
    pub memory: Memory,
    /// How its two surfaces rub and bounce.
    pub surface: Surface,
    /// From the centre of mass of a to that of b, metres.
    pub offset: Vec3,
    /// Whether contacts move one of its bodies in this step.
    pub active: bool,
    /// Distinct for the manifolds of one pair.
    pub ordinal: u32,
    /// Whether both bodies are balls about their centres of mass.
    pub balls: bool,
    /// For how long it may follow its bodies.
    pub leash: Leash,
    /// Where it is; [`Lane::NONE`] until it has a place.
    pub lane: Lane,
}

impl Found {
    /// Where it belongs, having a colour.
    pub(crate) fn key(&self, cut: Cut) -> Key {
        let m = &self.manifold;
        let color = self.memory.color;
        let (phase, tile) = place_of(m, color, self.active, cut);
        Key::new(phase, tile, color, Class::of(m.count, self.balls), self.surface.is_cold(m.count))
    }
}

/// When a manifold has its turn, and in which tile.
pub(crate) fn place_of(m: &Manifold, color: u32, active: bool, cut: Cut) -> (Phase, u32) {
    let tile = |row: u32| if cut.tiled { (row_of(row) / TILE) as u32 } else { 0 };
    let copied = m.a >= cut.bodies || row_of(m.b) >= cut.bodies as usize;
    let outer = if m.is_one_sided() { Phase::Ground } else { Phase::Between };
    match (active, m.is_one_sided()) {
        (false, false) => (Phase::Parked, 0),
        (false, true) => (Phase::ParkedGround, 0),
        (true, _) if color == OVERFLOW => (outer, Key::NO_TILE),
        (true, _) if copied => (outer, Key::COPIES),
        (true, true) => (Phase::Ground, tile(m.a)),
        (true, false) if cut.tiled && tile(m.a) == tile(m.b) => (Phase::Inner, tile(m.a)),
        (true, false) => (Phase::Between, 0),
    }
}

/// A shelf, open for many threads.
struct Open<'a, const P: usize, const T: usize> {
    blocks: Words<'a>,
    names: Words<'a>,
    slacks: Words<'a>,
    follows: &'a [u16],
    keys: &'a [Key],
    colds: &'a [u32],
}

impl<'a, const P: usize, const T: usize> Open<'a, P, T> {
    fn new(shelf: &'a mut Shelf<P, T>) -> Self {
        let Shelf { blocks, names, slacks, follows, keys, colds } = shelf;
        let (blocks, names, slacks) = (Words::new(blocks), Words::new(names), Words::new(slacks));
        Open { blocks, names, slacks, follows, keys, colds }
    }

    fn get(&self, at: Lane) -> Single<P, T> {
        let (row, lane) = (self.blocks.row(at.block()), at.lane());
        let mut single = Single::IDLE;
        [single.a, single.b] = [0, 1].map(|word: usize| row[word][lane].load(Relaxed));
        let mut words = row[2..].iter();
        single.each(|x| *x = words.next().map_or(0.0, |word| f32::from_bits(word[lane].load(Relaxed))));
        single
    }

    fn put(&self, at: Lane, mut single: Single<P, T>) {
        let (row, lane) = (self.blocks.row(at.block()), at.lane());
        row[0][lane].store(single.a, Relaxed);
        row[1][lane].store(single.b, Relaxed);
        let mut words = row[2..].iter();
        single.each(|x| words.next().into_iter().for_each(|word| word[lane].store(x.to_bits(), Relaxed)));
    }

    fn put_names(&self, at: Lane, features: &[u32; 4], count: u32) {
        let names = features[..P].iter().chain([&count]);
        let row = self.names.row(at.block());
        row.iter().zip(names).for_each(|(word, &x)| word[at.lane()].store(x, Relaxed));
    }

    fn put_leash(&self, at: Lane, Leash { length, lever, skin }: Leash) {
        let row = self.slacks.row(at.block());
        row.iter()
            .zip([length, lever, skin])
            .for_each(|(word, x)| word[at.lane()].store(x.to_bits(), Relaxed));
    }

    fn may_follow(&self, at: Lane) -> bool {
        self.follows[at.block()] >> at.lane() & 1 == 1
    }
}

/// Of each class.
type Shelves<'a> = (&'a mut Shelf<1, 0>, &'a mut Shelf<1, 0>, &'a mut Shelf<2, 1>, &'a mut Shelf<4, 1>);

/// All lanes, open for many threads that have each their own.
pub struct Desk<'a> {
    ball: Open<'a, 1, 0>,
    one: Open<'a, 1, 0>,
    two: Open<'a, 2, 1>,
    four: Open<'a, 4, 1>,
    colds: Words<'a>,
    painter: &'a Painter,
    cut: Cut,
}

impl<'a> Desk<'a> {
    pub(crate) fn new(
        (ball, one, two, four): Shelves<'a>,
        colds: &'a mut [Cold],
        painter: &'a Painter,
        cut: Cut,
    ) -> Self {
        let colds = Words::new(colds);
        Desk {
            ball: Open::new(ball),
            one: Open::new(one),
            two: Open::new(two),
            four: Open::new(four),
            colds,
            painter,
            cut,
        }
    }

    pub(crate) fn key(&self, at: Lane) -> Key {
        let keys = match at.class() {
            Class::Ball => self.ball.keys,
            Class::One => self.one.keys,
            Class::Two => self.two.keys,
            Class::Four => self.four.keys,
        };
        keys[at.block()]
    }

    /// What a lane holds; of a body that is split, the row of a copy.
    pub fn read(&self, at: Lane) -> (Manifold, Memory) {
        match at.class() {
            Class::Ball => self.take(&self.ball, at),
            Class::One => self.take(&self.one, at),
            Class::Two => self.take(&self.two, at),
            Class::Four => self.take(&self.four, at),
        }
    }

    fn take<const P: usize, const T: usize>(&self, shelf: &Open<'_, P, T>, at: Lane) -> (Manifold, Memory) {
        let mut names = [0; 5];
        let row = shelf.names.row(at.block());
        names.iter_mut().zip(row).for_each(|(x, word)| *x = word[at.lane()].load(Relaxed));
        let key = shelf.keys[at.block()];
        let (manifold, mut memory) = shelf.get(at).manifold(names[P] as usize, key.is_one_sided());
        memory.features[..P].copy_from_slice(&names[..P]);
        memory.color = key.color();
        if key.is_cold() {
            let mut cold = ColdSingle::default();
            let mut words = self.colds.row(shelf.colds[at.block()] as usize).iter();
            let mut next = || words.next().map_or(0, |word| word[at.lane()].load(Relaxed));
            cold.each(|x| *x = f32::from_bits(next()));
            memory.rolling = Vec3::from_array(cold.rolling_impulse);
            memory.twist += cold.twist_impulse;
        }
        (manifold, memory)
    }

    /// Whether a contact that takes part has only to follow its bodies still.
    pub fn may_follow(&self, at: Lane) -> bool {
        match at.class() {
            Class::Ball => self.ball.may_follow(at),
            Class::One => self.one.may_follow(at),
            Class::Two => self.two.may_follow(at),
            Class::Four => self.four.may_follow(at),
        }
    }

    /// Has a contact found anew, since one of its bodies was put somewhere else.
    pub fn unleash(&self, at: Lane) {
        match at.class() {
            Class::Ball => self.ball.put_leash(at, Leash::default()),
            Class::One => self.one.put_leash(at, Leash::default()),
            Class::Two => self.two.put_leash(at, Leash::default()),
            Class::Four => self.four.put_leash(at, Leash::default()),
        }
    }

    /// Writes a contact to its lane if it belongs there; otherwise tells so.
    pub fn rewrite(&self, contact: &Found) -> bool {
        let stays = self.key(contact.lane) == contact.key(self.cut);
        if stays {
            self.write(contact);
        }
        stays
    }

    /// Writes a contact to its lane.
    pub(crate) fn write(&self, contact: &Found) {
        match contact.lane.class() {
            Class::Ball => self.enter(&self.ball, contact),
            Class::One => self.enter(&self.one, contact),
            Class::Two => self.enter(&self.two, contact),
            Class::Four => self.enter(&self.four, contact),
        }
    }

    fn enter<const P: usize, const T: usize>(&self, shelf: &Open<'_, P, T>, contact: &Found) {
        let Found { manifold, memory, surface, offset, lane: at, leash, .. } = contact;
        shelf.put(*at, Single::new(manifold, memory, surface, *offset));
        shelf.put_names(*at, &memory.features, manifold.count);
        shelf.put_leash(*at, *leash);
        self.put_cold(shelf.colds[at.block()], *at, ColdSingle::new(memory, surface, manifold.count));
    }

    fn put_cold(&self, number: u32, at: Lane, mut cold: ColdSingle) {
        if number != HOT {
            let mut words = self.colds.row(number as usize).iter();
            cold.each(|x| {
                words.next().into_iter().for_each(|word| word[at.lane()].store(x.to_bits(), Relaxed))
            });
        }
    }

    /// Empties a lane; the caller hands it in with [`crate::Contacts::free`]. `ends` tells that the contact does not go on elsewhere
    /// with its colour.
    pub fn clear(&self, at: Lane, ends: bool) {
        let key = self.key(at);
        let [a, b] = match at.class() {
            Class::Ball => self.leave(&self.ball, at),
            Class::One => self.leave(&self.one, at),
            Class::Two => self.leave(&self.two, at),
            Class::Four => self.leave(&self.four, at),
        };
        if ends {
            self.painter.free(key.color(), a, (!key.is_one_sided()).then_some(b));
        }
    }

    /// Empties a lane and returns the two rows that it held.
    fn leave<const P: usize, const T: usize>(&self, shelf: &Open<'_, P, T>, at: Lane) -> [u32; 2] {
        let Single { a, b, .. } = shelf.get(at);
        shelf.put(at, Single::IDLE);
        shelf.put_names(at, &[0; 4], 0);
        shelf.put_leash(at, Leash::default());
        self.put_cold(shelf.colds[at.block()], at, ColdSingle::default());
        [a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrange::Entry;
    use crate::contacts::Contacts;
    use crate::manifold::FIXED;
    use std::collections::HashSet;

    /// A contact of `count` points with numbers that can be told apart.
    fn arrival(a: u32, b: u32, count: u32, color: u32, cold: bool) -> Found {
        let x = a as f32;
        let point = |p: usize| Vec3::new(x, p as f32, -x);
        let mut memory = Memory {
            friction: Vec3::new(x, 2.0, 0.0),
            twist: if count > 1 { x } else { 0.0 },
            color,
            ..Memory::default()
        };
        let mut manifold = Manifold { a, b, count, normal: Vec3::Z, ..Manifold::default() };
        for p in 0..count as usize {
            (manifold.arms[p], manifold.distances[p]) = (point(p), -x - p as f32);
            (memory.features[p], memory.normals[p]) = (a * 10 + p as u32, x + p as f32);
        }
        let rolling = if cold { 0.1 } else { 0.0 };
        memory.rolling = Vec3::splat(x * rolling);
        let surface = Surface { friction: 0.5, restitution: 0.0, rolling, twisting: 0.0 };
        let leash = Leash { length: x, lever: 1.0, skin: 0.0 };
        Found { manifold, memory, surface, offset: Vec3::ONE, active: true, leash, ..Found::default() }
    }

    fn all() -> Vec<Found> {
        let kind = |i: u32| (1 + i % 4, i % 3, i.is_multiple_of(5));
        (1..200)
            .map(|i| {
                let (count, color, cold) = kind(i);
                let fixed = if i.is_multiple_of(7) { FIXED } else { 0 };
                Found { active: !i.is_multiple_of(11), ..arrival(i, (i + 300) | fixed, count, color, cold) }
            })
            .collect()
    }

    #[test]
    fn what_is_written_is_read_by_all_readers() {
        let mut contacts = Contacts::default();
        let mut arrivals = vec![all()];
        contacts.place(&mut arrivals);
        let lanes: HashSet<Lane> = arrivals[0].iter().map(|arrival| arrival.lane).collect();
        assert_eq!(lanes.len(), arrivals[0].len());
        for contact in &arrivals[0] {
            let whole = (contact.manifold, contact.memory);
            assert_eq!(contacts.read(contact.lane), whole);
            assert_eq!(contacts.desk(600).read(contact.lane), whole);
            assert_eq!(contact.lane.is_parked(), !contact.active);
        }
        let tally = contacts.tally();
        assert_eq!((tally.manifolds, tally.touching), (199, 199));
        assert_eq!(tally.contacts, arrivals[0].iter().map(|a| a.manifold.count as usize).sum::<usize>());
        let distances = arrivals[0].iter().flat_map(|a| &a.manifold.distances[..a.manifold.count as usize]);
        let overlaps: Vec<f32> = distances.filter(|d| **d < 0.0).map(|d| -d).collect();
        let nanometres: f64 =
            overlaps.iter().map(|&overlap| (1e9 * f64::from(overlap)).round_ties_even()).sum();
        assert!(overlaps.len() > 199 && tally.overlapping == overlaps.len());
        assert_eq!(tally.overlap, nanometres as u64);
        assert_eq!(tally.deepest, overlaps.iter().copied().fold(0.0, f32::max));
    }

    #[test]
    fn a_contact_is_rewritten_only_where_it_belongs() {
        let mut contacts = Contacts::default();
        contacts.desk(4);
        let mut arrivals = vec![vec![arrival(1, 2, 3, 0, false)]];
        contacts.place(&mut arrivals);
        let old = arrivals[0][0];
        let mut new = Found { lane: old.lane, ..arrival(1, 2, 4, 0, false) };
        let desk = contacts.desk(4);
        assert!(desk.rewrite(&new));
        assert_eq!(desk.read(old.lane).0, new.manifold);
        for other in [arrival(1, 2, 2, 0, false), arrival(1, 2, 4, 1, false), arrival(1, 2, 4, 0, true)] {
            assert!(!desk.rewrite(&Found { lane: old.lane, ..other }));
        }
        new.active = false;
        assert!(!desk.rewrite(&new));
        assert_eq!(desk.read(old.lane).0, new.manifold);
        desk.clear(old.lane, true);
        contacts.free(&[old.lane]);
        assert_eq!(contacts.tally().manifolds, 0);
        let mut again = vec![vec![arrival(1, 3, 4, 0, false)]];
        contacts.place(&mut again);
        assert_eq!(again[0][0].lane, old.lane);
    }

    #[test]
    fn contacts_are_sparse_when_many_have_ended() {
        let mut contacts = Contacts::default();
        let mut arrivals =
            vec![(0..160).map(|i| arrival(1 + 2 * i, 2 + 2 * i, 1, 0, false)).collect::<Vec<_>>()];
        contacts.place(&mut arrivals);
        assert!(!contacts.is_sparse());
        // Half a block may be idle, and a twelfth of all beyond that: 8 and 13 of 160.
        let lanes: Vec<Lane> = arrivals[0].iter().map(|arrival| arrival.lane).collect();
        contacts.free(&lanes[..21]);
        assert!(!contacts.is_sparse());
        contacts.free(&lanes[21..22]);
        assert!(contacts.is_sparse());
    }

    #[test]
    fn sorting_keeps_contacts_and_gives_them_their_new_rows() {
        let mut contacts = Contacts::default();
        let mut arrivals = vec![all()];
        contacts.place(&mut arrivals);
        let kept: Vec<&Found> =
            arrivals[0].iter().filter(|a| !a.manifold.a.is_multiple_of(13)).rev().collect();
        let moved = |row: u32| row + 1000;
        let entries: Vec<Entry> = kept
            .iter()
            .map(|contact| Entry {
                lane: contact.lane,
                a: moved(contact.manifold.a),
                b: moved(contact.manifold.b),
            })
            .collect();
        let new_rows: Vec<u32> = (0..600).map(moved).collect();
        let lanes = contacts.sort(entries, true, 100_000, &new_rows);
        assert_eq!(contacts.tally().manifolds, kept.len());
        for (contact, &lane) in kept.iter().zip(&lanes) {
            let m = &contact.manifold;
            let manifold = Manifold { a: moved(m.a), b: moved(m.b), ..*m };
            assert_eq!(contacts.read(lane), (manifold, contact.memory));
        }
        let mut more = vec![vec![arrival(1, 5000, 4, 0, false), arrival(1, 3, 4, 0, false)]];
        contacts.place(&mut more);
        let desk = contacts.desk(100_000);
        assert_eq!(desk.key(more[0][0].lane).phase(), Phase::Between);
        assert_eq!(desk.key(more[0][1].lane).phase(), Phase::Inner);
    }
}
