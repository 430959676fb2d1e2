//! The state of a world to a snapshot and back.
//!
//! Columns are written as they are, contacts and what pairs remember included, so that every later step gives the same bits as it would have
//! without. Trees are built anew: they answer the same queries. Settings, shapes and materials are not written; a fingerprint tells that they
//! are the same. Whatever is read as a place in a column is checked before it is used.

use super::World;
use crate::bodies::{Bodies, State};
use crate::index::Index;
use crate::slots::Slots;
use crate::touches::Touches;
use crate::{BodyId, Events, Kind, Pair, Presence, Settings, StepReport};
use rockfall_math::snapshot::{Error, Reader, Writer};
use rockfall_solve::Contacts;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::{self, Write};
use xxhash_rust::xxh3::Xxh3;

/// The version of the engine that writes the state, and the only one that reads it.
const ENGINE: &str = env!("CARGO_PKG_VERSION");

impl World {
    /// Writes the whole state: what [`World::load`] makes of it goes on step by step with the same bits.
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose};
    /// use rockfall::snapshot::{Reader, Writer};
    /// use rockfall::{Body, Material, Settings, Shape, World};
    ///
    /// let scene = || -> Result<World, rockfall::Error> {
    ///     let mut world = World::new(Settings::default())?;
    ///     let rock = world.add_material(Material::default())?;
    ///     let ball = world.add_shape(Shape::Sphere { radius: 0.5 })?;
    ///     world.spawn(Body::new(ball, rock, Pose::at(DVec3::Z)))?;
    ///     Ok(world)
    /// };
    /// let mut world = scene()?;
    /// world.step();
    /// let mut file = Vec::new();
    /// let mut writer = Writer::new(&mut file)?;
    /// world.save(&mut writer)?;
    /// writer.finish()?;
    ///
    /// let mut other = scene()?;
    /// let mut bytes = &file[..];
    /// let mut reader = Reader::new(&mut bytes)?;
    /// other.load(&mut reader)?;
    /// reader.finish()?;
    /// world.step();
    /// other.step();
    /// assert_eq!(other.hash(), world.hash());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn save(&self, to: &mut Writer<'_>) -> Result<(), Error> {
        #[rustfmt::skip]
        let World {
            bodies, vacant, names, next_id, fresh, stirred, handled, touches, contacts, report, sensors, events,
            // The fingerprint speaks for them.
            settings: _, shapes: _, masses: _, materials: _, fingerprint: _,
            // What is asked for, by the one who asks.
            watch: _,
            // They follow from the rest.
            slots: _, rows: _, sorted: _, index: _, drifted: _, late: _,
            // Of the machine, or of the step at hand, and there is none.
            width: _, pool: _, islands: _, moved: _, starts: _, sums: _, rooms: _,
        } = self;
        to.text("engine", ENGINE)?;
        to.one("fingerprint", self.fingerprint())?;
        bodies.save(to)?;
        to.column("vacant", vacant)?;
        to.one("next_id", *next_id)?;
        to.one("fresh", *fresh as u64)?;
        to.one("handled", u64::from(*handled))?;
        to.column("stirred", &stirred.iter().copied().collect::<Vec<u32>>())?;
        save_names(names, to)?;
        touches.save(to)?;
        contacts.save(to)?;
        to.column("sensors.ids", &sensors.keys().copied().collect::<Vec<u64>>())?;
        to.column("sensors.masks", &sensors.values().copied().collect::<Vec<u32>>())?;
        save_events(events, to)?;
        save_report(report, to)
    }

    /// Takes the state that [`World::save`] wrote, in place of all bodies that are there. The world has to have the same settings but for
    /// threads and lanes, the same shapes, and the same materials. It goes on watching what it watched ([`World::watch`]); of the last step's
    /// events it knows who touched and who was in a sensor.
    ///
    /// # Errors
    /// The world is left as it was. [`Error::Version`], [`Error::OtherWorld`], and those of the reader; [`Error::Invalid`] where a state
    /// contradicts itself.
    pub fn load(&mut self, from: &mut Reader<'_>) -> Result<(), Error> {
        let engine = from.text("engine")?;
        if engine != ENGINE {
            return Err(Error::Version { found: engine, expected: ENGINE.into() });
        }
        if from.one::<u64>("fingerprint")? != self.fingerprint() {
            return Err(Error::OtherWorld("settings, shapes or materials"));
        }
        let bodies = Bodies::load(from, self.shapes.len(), self.materials.len())?;
        let rows = bodies.rows();
        let vacant: Vec<u32> = from.column("vacant")?;
        let (slots, places) = find_slots(&bodies, &vacant)?;
        let next_id = from.one("next_id")?;
        let fresh = from.one::<u64>("fresh")?;
        let fresh = usize::try_from(fresh).ok().filter(|&fresh| fresh < rows);
        let fresh = fresh.ok_or_else(|| Error::invalid("fresh", "more rows than there are"))?;
        let handled = from.one::<u64>("handled")? != 0;
        let stirred: BTreeSet<u32> = from.column("stirred")?.into_iter().collect();
        let there = stirred.iter().all(|&row| (row as usize) < rows);
        Error::unless(there, "stirred", "a row that is not there")?;
        let names = load_names(from, &slots)?;
        let touches = Touches::load(from, &bodies)?;
        let moves = |row: usize| bodies.kinds[row] == Kind::Dynamic;
        let contacts = Contacts::load(from, rows - fresh, &moves)?;
        touches.check_contacts(&contacts)?;
        let ids: Vec<u64> = from.column("sensors.ids")?;
        let sensors: BTreeMap<u64, u32> =
            ids.iter().copied().zip(from.column_of("sensors.masks", ids.len())?).collect();
        let known = sensors.keys().all(|&id| slots.get(id).is_some());
        Error::unless(known, "sensors.ids", "no body has this id")?;
        let events = load_events(from)?;
        let report = load_report(from)?;

        let pool = std::sync::Arc::clone(&self.pool);
        self.index = pool.install(|| Index::new(&bodies, rows - fresh));
        (self.bodies, self.slots, self.rows, self.vacant) = (bodies, slots, places, vacant);
        (self.names, self.next_id, self.fresh, self.stirred) = (names, next_id, fresh, stirred);
        (self.touches, self.contacts, self.report, self.handled) = (touches, contacts, report, handled);
        (self.sensors, self.events) = (sensors, events);
        self.contacts.keep_totals(self.watch.impulse.is_some());
        self.sorted.take();
        self.late.take();
        self.drifted.take();
        Ok(())
    }

    /// A hash of settings, shapes and materials. What they print as says each number to the last bit, of whatever kinds of shapes there are.
    fn fingerprint(&self) -> u64 {
        *self.fingerprint.get_or_init(|| {
            let mut hash = Print(Xxh3::new());
            let settings = Settings { threads: 0, lanes: 0, ..self.settings };
            // Hashing can't fail.
            let _ = write!(hash, "{settings:?} {:?} {:?}", self.materials, self.shapes);
            hash.0.digest()
        })
    }
}

/// Hashes what is printed.
struct Print(Xxh3);

impl Write for Print {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

/// Slots by id and rows by slot; every slot is one body's, or vacant.
fn find_slots(bodies: &Bodies, vacant: &[u32]) -> Result<(Slots, Vec<u32>), Error> {
    let alive = || (1..bodies.rows()).filter(|&row| bodies.states[row] != State::Dead);
    let mut places = vec![u32::MAX; alive().count() + vacant.len()];
    let mut slots = Slots::default();
    let mut take = |slot: u32, row: u32, column: &str| match places.get_mut(slot as usize) {
        Some(place) if *place == u32::MAX => {
            *place = row;
            Ok(())
        }
        _ => Err(Error::invalid(column, "a slot that is not there, or another's")),
    };
    for row in alive() {
        take(bodies.slots[row], row as u32, "slots")?;
        let id = bodies.ids[row];
        let new = id != u64::MAX && slots.get(id).is_none();
        Error::unless(new, "ids", "an id that no body may have, or another one has")?;
        slots.insert(id, bodies.slots[row]);
    }
    vacant.iter().try_for_each(|&slot| take(slot, 0, "vacant"))?;
    Ok((slots, places))
}

fn save_names(names: &HashMap<u64, String>, to: &mut Writer<'_>) -> Result<(), Error> {
    let mut sorted: Vec<(u64, &str)> = names.iter().map(|(&id, name)| (id, name.as_str())).collect();
    sorted.sort_unstable();
    to.column("names.ids", &sorted.iter().map(|(id, _)| *id).collect::<Vec<u64>>())?;
    to.column("names.lengths", &sorted.iter().map(|(_, name)| name.len() as u64).collect::<Vec<u64>>())?;
    to.text("names.text", &sorted.iter().map(|(_, name)| *name).collect::<String>())
}

fn load_names(from: &mut Reader<'_>, slots: &Slots) -> Result<HashMap<u64, String>, Error> {
    let ids: Vec<u64> = from.column("names.ids")?;
    let lengths: Vec<u64> = from.column_of("names.lengths", ids.len())?;
    let text = from.text("names.text")?;
    let mut rest = text.as_str();
    let mut names = HashMap::with_capacity(ids.len());
    for (id, length) in ids.into_iter().zip(lengths) {
        let cut = usize::try_from(length).ok().and_then(|at| rest.split_at_checked(at));
        let (name, behind) = cut.ok_or_else(|| Error::invalid("names.lengths", "longer than the text"))?;
        rest = behind;
        Error::unless(slots.get(id).is_some(), "names.ids", "no body has this id")?;
        names.insert(id, name.to_owned());
    }
    Ok(names)
}

/// Who touches and who is in a sensor: the next step compares with it. All else is told anew.
fn save_events(events: &Events, to: &mut Writer<'_>) -> Result<(), Error> {
    let Events { begun, persisting, present, ended: _, entered: _, left: _, hits: _, forces: _ } = events;
    let mut touching: Vec<Pair> = begun.iter().chain(persisting).copied().collect();
    touching.sort_unstable();
    to.column("events.touching.a", &touching.iter().map(|pair| pair.a.0).collect::<Vec<u64>>())?;
    to.column("events.touching.b", &touching.iter().map(|pair| pair.b.0).collect::<Vec<u64>>())?;
    to.column("events.present.sensors", &present.iter().map(|p| p.sensor.0).collect::<Vec<u64>>())?;
    to.column("events.present.bodies", &present.iter().map(|p| p.body.0).collect::<Vec<u64>>())
}

fn load_events(from: &mut Reader<'_>) -> Result<Events, Error> {
    let mut ids = |names: [&str; 2]| -> Result<Vec<(BodyId, BodyId)>, Error> {
        let first: Vec<u64> = from.column(names[0])?;
        let second: Vec<u64> = from.column_of(names[1], first.len())?;
        let both: Vec<_> = first.into_iter().map(BodyId).zip(second.into_iter().map(BodyId)).collect();
        Error::unless(both.is_sorted(), names[0], "not in ascending order")?;
        Ok(both)
    };
    let touching = ids(["events.touching.a", "events.touching.b"])?;
    let present = ids(["events.present.sensors", "events.present.bodies"])?;
    Ok(Events {
        persisting: touching.into_iter().map(|(a, b)| Pair { a, b }).collect(),
        present: present.into_iter().map(|(sensor, body)| Presence { sensor, body }).collect(),
        ..Events::default()
    })
}

/// Times are not part of the state.
fn save_report(report: &StepReport, to: &mut Writer<'_>) -> Result<(), Error> {
    #[rustfmt::skip]
    let &StepReport {
        step, time, bodies, awake, pairs, touching, manifolds, contacts, colors, split, serial, swept_bytes,
        deepest_penetration, mean_penetration, p99_penetration, kinetic_energy, potential_energy, momentum, angular_momentum, frozen,
        support, weight, momentum_error, energy_gain, friction_use, times: _,
    } = report;
    let counts =
        [bodies, awake, pairs, touching, manifolds, contacts, colors, split, serial, swept_bytes, frozen];
    to.one("report.step", step)?;
    to.column("report.counts", &counts.map(|count| count as u64))?;
    to.column("report.depths", &[deepest_penetration, mean_penetration, p99_penetration])?;
    let ([x, y, z], [u, v, w]) = (momentum, angular_momentum);
    to.column("report.sums", &[time, kinetic_energy, potential_energy, x, y, z, u, v, w])?;
    let ([x, y, z], [u, v, w]) = (support, weight);
    to.column("report.balance", &[x, y, z, u, v, w, momentum_error, energy_gain, friction_use])
}

fn load_report(from: &mut Reader<'_>) -> Result<StepReport, Error> {
    let step = from.one("report.step")?;
    Error::unless(step < u64::MAX / 2, "report.step", "more steps than anybody can have done")?;
    let counts: Vec<u64> = from.column("report.counts")?;
    let depths: Vec<f32> = from.column("report.depths")?;
    let sums: Vec<f64> = from.column("report.sums")?;
    let balance: Vec<f64> = from.column("report.balance")?;
    let counts: Vec<usize> = counts.into_iter().map(|count| count as usize).collect();
    #[rustfmt::skip]
    let (
        &[bodies, awake, pairs, touching, manifolds, contacts, colors, split, serial, swept_bytes, frozen],
        &[deepest_penetration, mean_penetration, p99_penetration],
        &[time, kinetic_energy, potential_energy, x, y, z, u, v, w],
        &[support_x, support_y, support_z, weight_x, weight_y, weight_z, momentum_error, energy_gain, friction_use],
    ) = (&counts[..], &depths[..], &sums[..], &balance[..]) else {
        return Err(Error::invalid("report", "another number of figures"));
    };
    Error::unless(frozen <= usize::MAX / 2, "report.counts", "more bodies than there can be")?;
    #[rustfmt::skip]
    let report = StepReport {
        step, time, bodies, awake, pairs, touching, manifolds, contacts, colors, split, serial, swept_bytes,
        deepest_penetration, mean_penetration, p99_penetration, kinetic_energy, potential_energy, frozen,
        momentum: [x, y, z], angular_momentum: [u, v, w], support: [support_x, support_y, support_z],
        weight: [weight_x, weight_y, weight_z], momentum_error, energy_gain, friction_use, times: Default::default(),
    };
    Ok(report)
}
