//! What a run writes beside poses and velocities, as its scene wants it: contacts, events, columns.

use crate::exit::Failure;
use rockfall::math::DVec3;
use rockfall::{BodyId, Watch, World};
use rockfall_cache::{
    BodyTable, Column, Contacts, Contents, Error, Event, NumberType, Values, WantedContacts, WantedEvents,
};
use rockfall_scene::{Running, Scene};

/// A column that a scene can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BuiltIn {
    Speed,
    KineticEnergy,
    ContactCount,
    ContactForce,
    Asleep,
}

/// What is written.
#[derive(Clone, Debug)]
pub(crate) struct Extras {
    contacts: Option<WantedContacts>,
    events: Option<WantedEvents>,
    columns: Vec<BuiltIn>,
}

/// Has the world watch what the scene wants to be told of; before its first step, and before it goes on from a checkpoint.
pub(crate) fn watch(scene: &Scene, running: &mut Running) -> Result<(), Failure> {
    let impulse = scene.output.hits.map(|least| least as f32);
    let watch = Watch { contacts: scene.output.touches, impulse, ..Watch::default() };
    running.world.watch(watch).map_err(|error| Failure::Run(error.to_string()))
}

impl Extras {
    /// What the scene wants.
    pub(crate) fn of(scene: &Scene, running: &Running) -> Self {
        let wanted = &scene.output;
        let sensors = wanted.sensors && running.body_table().iter().any(|row| row.sensor);
        Extras {
            contacts: wanted.contacts.map(|(every, force)| WantedContacts { every, force, friction: true }),
            events: Some(WantedEvents {
                sensors: sensors || wanted.touches,
                touches: wanted.touches,
                hits: wanted.hits.map(|least| least as f32),
            })
            .filter(|wanted| *wanted != WantedEvents::default()),
            columns: wanted.columns.iter().filter_map(|word| BuiltIn::of(word)).collect(),
        }
    }

    /// The contents of a trajectory with it.
    pub(crate) fn within(&self, contents: Contents) -> Contents {
        let columns = self.columns.iter().map(|column| column.about()).collect();
        Contents { contacts: self.contacts, events: self.events, columns, ..contents }
    }

    /// That of the world, whose bodies are `ids`, after the frame `frame`.
    pub(crate) fn gather(
        &self,
        world: &World,
        ids: &[BodyId],
        table: &BodyTable,
        origin: DVec3,
        frame: u64,
    ) -> Result<(Contacts, Vec<Event>, Vec<Values>), Failure> {
        let contacts = self.contacts.map(|wanted| wanted.gather(world, origin, frame));
        let events = self.events.map(|wanted| wanted.gather(world.events()));
        let counts = [BuiltIn::ContactCount, BuiltIn::ContactForce].iter().any(|c| self.columns.contains(c));
        let all = if counts { WantedContacts::ALL.gather(world, origin, frame) } else { Contacts::default() };
        let columns = self.columns.iter().map(|column| column.values(world, table, ids, &all));
        let columns = columns.collect::<Result<_, Error>>()?;
        Ok((contacts.unwrap_or_default(), events.unwrap_or_default(), columns))
    }
}

impl BuiltIn {
    /// By the word in scene files, which is also the name of the column.
    fn of(word: &str) -> Option<Self> {
        let all = [
            BuiltIn::Speed,
            BuiltIn::KineticEnergy,
            BuiltIn::ContactCount,
            BuiltIn::ContactForce,
            BuiltIn::Asleep,
        ];
        all.into_iter().find(|column| column.about().name == word)
    }

    fn about(self) -> Column {
        let (name, numbers, units, description) = match self {
            BuiltIn::Speed => ("speed", NumberType::F32, "m s-1", "of the centre of mass"),
            BuiltIn::KineticEnergy => {
                ("kinetic_energy", NumberType::F32, "J", "0 of bodies that are not dynamic")
            }
            BuiltIn::ContactCount => {
                ("contact_count", NumberType::U32, "1", "points at which the body touches others")
            }
            BuiltIn::ContactForce => {
                ("contact_force", NumberType::F32, "N", "sum of the normal forces on the body")
            }
            BuiltIn::Asleep => ("asleep", NumberType::U8, "1", "1 of a body that is asleep, else 0"),
        };
        Column { name: name.into(), numbers, units: units.into(), description: description.into() }
    }

    fn values(
        self,
        world: &World,
        table: &BodyTable,
        ids: &[BodyId],
        all: &Contacts,
    ) -> Result<Values, Error> {
        match self {
            BuiltIn::Speed => {
                let speeds: Vec<f32> = world.velocities().iter().map(|(v, _)| v.length()).collect();
                Values::gather(table, ids, &speeds)
            }
            BuiltIn::KineticEnergy => {
                let energies: Vec<f32> =
                    world.kinetic_energies().iter().map(|&energy| energy as f32).collect();
                Values::gather(table, ids, &energies)
            }
            BuiltIn::ContactCount => {
                Values::gather(table, ids, &of_bodies(ids, all, |count: &mut u32, _| *count += 1))
            }
            BuiltIn::ContactForce => {
                let sums = of_bodies(ids, all, |sum: &mut f64, force| *sum += f64::from(force));
                Values::gather(table, ids, &sums.iter().map(|&sum| sum as f32).collect::<Vec<f32>>())
            }
            BuiltIn::Asleep => {
                let asleep: Vec<u8> = world.sleeping().iter().map(|&asleep| u8::from(asleep)).collect();
                Values::gather(table, ids, &asleep)
            }
        }
    }
}

/// Something of each body, to which each of its contacts adds by its force. Contacts come in the order of ids, so sums don't depend on anything else.
fn of_bodies<T: Copy + Default>(ids: &[BodyId], contacts: &Contacts, add: impl Fn(&mut T, f32)) -> Vec<T> {
    let mut all = vec![T::default(); ids.len()];
    for ((&a, &b), &force) in contacts.a.iter().zip(&contacts.b).zip(&contacts.forces) {
        for id in [a, b] {
            if let Ok(row) = ids.binary_search(&BodyId(id)) {
                add(&mut all[row], force);
            }
        }
    }
    all
}
