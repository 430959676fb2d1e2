//! Contacts to a snapshot and back.
//!
//! Blocks are written as they are. Which of their lanes are idle, the buckets, the order of the sweeps, and which colours are taken at each
//! body follow from them. What is read is checked wherever a sweep relies on it: rows and cold halves are there, every contact is
//! where it belongs, and within a colour no body that moves stands twice.

use crate::block::{Block, Cold, Column, LANES};
use crate::contacts::Contacts;
use crate::copies::Copies;
use crate::desk::place_of;
use crate::line::{Drift, Line, Role};
use crate::manifold::{FIXED, Manifold};
use crate::paint::{OVERFLOW, Painter};
use crate::plan::Plan;
use crate::shelf::{CLASSES, Class, Cut, HOT, Key, Lane, Names, Phase, Shelf, Slack};
use bytemuck::{cast_slice, cast_slice_mut};
use rockfall_math::snapshot::{Error, Get, Put, Reader, Stored, Writer, get_each, put_each};
use rockfall_math::{stored_byte, stored_plain};

stored_plain! {
    Line: "line",
    Drift: "drift",
    Lane: "lane",
    Key: "key",
    Slack: "slack",
    Cold: "cold",
}

stored_byte!(Role: "role", Role::Still = 0, Role::Driven = 1, Role::Free = 2);

/// The most blocks of a class whose lanes have numbers.
const BLOCKS: usize = (1 << Lane::BITS) / LANES;

impl<const P: usize, const T: usize> Block<P, T> {
    /// Its columns as bytes, in the order of the fields.
    fn each(&mut self, mut visit: impl FnMut(&mut [u8])) {
        let Block {
            a,
            b,
            normal,
            offset,
            arms,
            distances,
            masses,
            impulses,
            tangent_mass,
            tangent_impulse,
            friction,
            twist_mass,
            twist_impulse,
            twist_limit,
        } = self;
        visit(cast_slice_mut(a));
        visit(cast_slice_mut(b));
        let mut number = |column: &mut Column| visit(cast_slice_mut(column));
        normal.iter_mut().chain(offset).chain(arms.iter_mut().flatten()).for_each(&mut number);
        distances.iter_mut().chain(masses).chain(impulses).chain(tangent_mass).for_each(&mut number);
        tangent_impulse.iter_mut().chain([friction]).for_each(&mut number);
        twist_mass.iter_mut().chain(twist_impulse).chain(twist_limit).for_each(number);
    }
}

impl<const P: usize, const T: usize> Stored for Block<P, T> {
    const TYPE: &'static str = "block";

    fn put(column: &[Self], put: Put<'_>) -> Result<(), Error> {
        put_each(column, put, |block, bytes| {
            let mut block = *block;
            block.each(|column| bytes.extend_from_slice(column));
        })
    }

    fn get(count: u64, get: Get<'_>) -> Result<Option<Vec<Self>>, Error> {
        get_each(count, Self::SIZE, get, |bytes| {
            let (mut block, mut rest) = (Block::IDLE, bytes);
            block.each(|column| {
                let here;
                (here, rest) = rest.split_at(column.len());
                column.copy_from_slice(here);
            });
            // A field that `each` leaves out would be lost.
            debug_assert!(rest.is_empty());
            Some(block)
        })
    }
}

impl<const P: usize> Stored for Names<P> {
    const TYPE: &'static str = "names";

    fn put(column: &[Self], put: Put<'_>) -> Result<(), Error> {
        put_each(column, put, |Names { features, counts }, bytes| {
            features.iter().chain([counts]).for_each(|column| bytes.extend_from_slice(cast_slice(column)));
        })
    }

    fn get(count: u64, get: Get<'_>) -> Result<Option<Vec<Self>>, Error> {
        get_each(count, Self::SIZE, get, |bytes| {
            let mut names = Names::IDLE;
            let columns = names.features.iter_mut().chain([&mut names.counts]);
            for (column, bytes) in columns.zip(bytes.chunks_exact(size_of::<Column>())) {
                cast_slice_mut(column).copy_from_slice(bytes);
            }
            Some(names)
        })
    }
}

impl<const P: usize, const T: usize> Shelf<P, T> {
    fn save(&self, class: &str, to: &mut Writer<'_>) -> Result<(), Error> {
        let Shelf { blocks, names, slacks, follows, keys, colds } = self;
        to.column(&format!("{class}.blocks"), blocks)?;
        to.column(&format!("{class}.names"), names)?;
        to.column(&format!("{class}.slacks"), slacks)?;
        to.column(&format!("{class}.follows"), follows)?;
        to.column(&format!("{class}.keys"), keys)?;
        to.column(&format!("{class}.colds"), colds)
    }

    fn load(class: &str, from: &mut Reader<'_>) -> Result<Self, Error> {
        let blocks = from.column(&format!("{class}.blocks"))?;
        let count = blocks.len();
        let many = format!("{class}.blocks");
        Error::unless(count <= BLOCKS, &many, "more blocks than lanes can be told apart")?;
        Ok(Shelf {
            blocks,
            names: from.column_of(&format!("{class}.names"), count)?,
            slacks: from.column_of(&format!("{class}.slacks"), count)?,
            follows: from.column_of(&format!("{class}.follows"), count)?,
            keys: from.column_of(&format!("{class}.keys"), count)?,
            colds: from.column_of(&format!("{class}.colds"), count)?,
        })
    }

    /// Checks all blocks, and takes the colours of their contacts.
    fn check(&self, class: Class, check: &mut Check<'_>) -> Result<(), &'static str> {
        for (i, (block, names)) in self.blocks.iter().zip(&self.names).enumerate() {
            let key = self.keys[i];
            check.key(key, class, self.colds[i])?;
            for lane in 0..LANES {
                let (a, b, count) = (block.a[lane], block.b[lane], names.counts[lane]);
                match count {
                    0 if (a, b) == (0, 0) => {}
                    0 => return Err("an idle lane with a body"),
                    _ if count as usize > P || Class::of(count, class == Class::Ball) != class => {
                        return Err("more or fewer points than the class has");
                    }
                    _ => check.contact(key, a, b)?,
                }
            }
        }
        Ok(())
    }
}

/// What the contacts of a snapshot are checked against.
struct Check<'a> {
    cut: Cut,
    tiles: usize,
    copies: &'a Copies,
    /// Whether contacts move the body of a row.
    moves: &'a dyn Fn(usize) -> bool,
    painter: Painter,
    /// Cold halves that have a block.
    colds: Vec<bool>,
}

impl Check<'_> {
    /// A block may have this key and cold half.
    fn key(&mut self, key: Key, class: Class, cold: u32) -> Result<(), &'static str> {
        if !key.is_sound() || key.class() != class {
            return Err("a key that there is not");
        }
        let (tile, overflow, tiled) = (key.tile(), key.color() == OVERFLOW, self.cut.tiled);
        let in_a_tile = (tile as usize) < self.tiles;
        let outer = match tile {
            Key::NO_TILE => overflow,
            Key::COPIES => !overflow,
            _ => false,
        };
        let sound = match key.phase() {
            Phase::Inner => tiled && in_a_tile && !overflow,
            Phase::Between => outer || (tile == 0 && !overflow),
            Phase::Ground => outer || (!overflow && if tiled { in_a_tile } else { tile == 0 }),
            Phase::Parked | Phase::ParkedGround => tile == 0,
        };
        if !sound {
            return Err("a place in the sweep that there is not");
        }
        match (key.is_cold(), self.colds.get_mut(cold as usize)) {
            (false, _) if cold == HOT => Ok(()),
            // Every cold half belongs to one block.
            (true, Some(taken)) if !*taken => {
                *taken = true;
                Ok(())
            }
            _ => Err("a cold half that is not there, or another block's"),
        }
    }

    /// A block with this key may hold a contact of these rows.
    fn contact(&mut self, key: Key, a: u32, b: u32) -> Result<(), &'static str> {
        let rows = self.copies.rows();
        if a as usize >= rows || b as usize >= rows {
            return Err("a row that is not there");
        }
        let one_sided = key.is_one_sided();
        let moves = |row: u32| (self.moves)(self.copies.body(row) as usize);
        if !moves(a) || moves(b) == one_sided || (one_sided && b >= self.cut.bodies) {
            return Err("a body that contacts move where there may be none, or the other way round");
        }
        let manifold = Manifold { a, b: if one_sided { b | FIXED } else { b }, ..Manifold::default() };
        if place_of(&manifold, key.color(), !key.is_parked(), self.cut) != (key.phase(), key.tile()) {
            return Err("a contact in another place of the sweep than its bodies");
        }
        let free = self.painter.take_if_free(key.color(), a, (!one_sided).then_some(b));
        if free { Ok(()) } else { Err("a body twice in a colour") }
    }
}

impl Contacts {
    /// Writes all contacts.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn save(&self, to: &mut Writer<'_>) -> Result<(), Error> {
        #[rustfmt::skip]
        let Contacts {
            ball, one, two, four, colds, copies, tiled,
            // They follow from the blocks.
            buckets: _, plan: _, painter: _,
            // Of the step at hand, and there is none.
            crowded: _, grown: _, totals: _,
        } = self;
        to.one("contacts.tiled", *tiled)?;
        ball.save("ball", to)?;
        one.save("one", to)?;
        two.save("two", to)?;
        four.save("four", to)?;
        to.column("contacts.colds", colds)?;
        copies.save(to)
    }

    /// Reads the contacts of a world with so many `rows` of bodies, of which contacts move those that `moves` tells.
    ///
    /// # Errors
    /// Those of the reader; [`Error::Invalid`] where a sweep could not rely on what is there.
    pub fn load(
        from: &mut Reader<'_>,
        rows: usize,
        moves: &dyn Fn(usize) -> bool,
    ) -> Result<Contacts, Error> {
        let tiled = from.one("contacts.tiled")?;
        let (ball, one) = (Shelf::load("ball", from)?, Shelf::load("one", from)?);
        let (two, four) = (Shelf::load("two", from)?, Shelf::load("four", from)?);
        let colds: Vec<Cold> = from.column("contacts.colds")?;
        let mut contacts = Contacts { ball, one, two, four, colds, tiled, ..Contacts::default() };
        let blocks: usize = CLASSES.into_iter().map(|class| contacts.keys(class).len()).sum();
        // A copy has six contacts and more when it is made.
        contacts.copies = Copies::load(from, rows, blocks * LANES)?;
        contacts.painter.resize(contacts.copies.rows());
        let mut check = Check {
            cut: contacts.cut(),
            tiles: contacts.tiles(),
            copies: &contacts.copies,
            moves,
            painter: std::mem::take(&mut contacts.painter),
            colds: vec![false; contacts.colds.len()],
        };
        let Contacts { ball, one, two, four, .. } = &contacts;
        ball.check(Class::Ball, &mut check).map_err(|reason| Error::invalid("ball.blocks", reason))?;
        one.check(Class::One, &mut check).map_err(|reason| Error::invalid("one.blocks", reason))?;
        two.check(Class::Two, &mut check).map_err(|reason| Error::invalid("two.blocks", reason))?;
        four.check(Class::Four, &mut check).map_err(|reason| Error::invalid("four.blocks", reason))?;
        contacts.painter = check.painter;
        contacts.fill_buckets();
        contacts.plan = Plan::new(&contacts);
        Ok(contacts)
    }

    /// Finds which blocks have which key, and which lanes are idle.
    fn fill_buckets(&mut self) {
        for class in CLASSES {
            for (block, &key) in (0..).zip(self.keys(class).to_vec().iter()) {
                let idle = |lane: &u32| self.rows_at(key.lane(*lane as usize)).0 == 0;
                let lanes = block * LANES as u32..(block + 1) * LANES as u32;
                let free: Vec<u32> = lanes.rev().filter(idle).collect();
                let bucket = self.buckets.entry(key).or_default();
                bucket.blocks.push(block);
                bucket.free.extend(free);
            }
        }
    }

    /// Number of contacts.
    pub fn count(&self) -> usize {
        let lanes = self.buckets.values().map(|bucket| bucket.blocks.len() * LANES - bucket.free.len());
        lanes.sum()
    }

    /// Rows of the bodies of the contact in a lane, the second marked where contacts can't move it; nothing where there is no contact.
    pub fn bodies_at(&self, at: Lane) -> Option<(u32, u32)> {
        let key = *self.keys(at.class()).get(at.block())?;
        let (a, b) = self.rows_at(at);
        let mark = if key.is_one_sided() { FIXED } else { 0 };
        (a != 0 && key.lane(at.index()) == at).then(|| (self.copies.body(a), self.copies.body(b) | mark))
    }
}
