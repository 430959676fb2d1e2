//! `events`: who begins to touch and ceases, who is hit hard, and who comes into sensors and leaves them, in a run that writes it.

use crate::ragged::{Column, Kind};
use crate::sheet::NumberType;
use rockfall::{BodyId, Events};
use serde_json::{Value, json};

const ROW: &[&str] = &["event"];

pub(crate) static EVENTS: Kind = Kind {
    name: "events",
    columns: &[
        Column {
            name: "kind",
            numbers: NumberType::U8,
            dimensions: ROW,
            units: None,
            description: "0 entered, 1 left, 2 begun, 3 ended, 4 hit",
        },
        Column {
            name: "a",
            numbers: NumberType::U64,
            dimensions: ROW,
            units: None,
            description: "id of the sensor, or of a body that touches, the smaller one of the two",
        },
        Column {
            name: "b",
            numbers: NumberType::U64,
            dimensions: ROW,
            units: None,
            description: "id of the body in the sensor, or of the other one that touches",
        },
        Column {
            name: "impulse",
            numbers: NumberType::F32,
            dimensions: ROW,
            units: Some("N s"),
            description: "of a hit: sum of the normal impulses over the step; 0 of other events",
        },
    ],
    // Impulses are there where hits are.
    always: 3,
};

/// Which events a run writes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WantedEvents {
    /// Who comes into sensors and leaves them.
    pub sensors: bool,
    /// Who begins to touch and ceases.
    pub touches: bool,
    /// Who presses each other by more than this in a step, N s.
    pub hits: Option<f32>,
}

/// What happened to two bodies in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EventKind {
    /// `b` came into the sensor `a`.
    Entered,
    /// `b` left the sensor `a`.
    Left,
    /// `a` and `b` began to touch.
    Begun,
    /// `a` and `b` ceased to touch.
    Ended,
    /// `a` and `b` pressed each other hard.
    Hit,
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// Id of the sensor, or of the body with the smaller one.
    pub a: u64,
    /// Id of the other body.
    pub b: u64,
    /// Of a hit, the sum of the normal impulses of all contact points over the step, N s; 0 of other events.
    pub impulse: f32,
}

impl EventKind {
    /// All of them, by the numbers that they have on disk.
    pub const ALL: [EventKind; 5] =
        [EventKind::Entered, EventKind::Left, EventKind::Begun, EventKind::Ended, EventKind::Hit];
}

impl WantedEvents {
    /// Those of a world's last step, by kind and ids. The world tells of touches and hits if it [watches](rockfall::World::watch) them.
    pub fn gather(self, events: &Events) -> Vec<Event> {
        let event = |kind, a: BodyId, b: BodyId| Event { kind, a: a.0, b: b.0, impulse: 0.0 };
        let sensors = [(EventKind::Entered, &events.entered), (EventKind::Left, &events.left)];
        let sensors = sensors
            .into_iter()
            .filter(|_| self.sensors)
            .flat_map(|(kind, list)| list.iter().map(move |told| event(kind, told.sensor, told.body)));
        let pairs = [(EventKind::Begun, &events.begun), (EventKind::Ended, &events.ended)];
        let pairs = pairs
            .into_iter()
            .filter(|_| self.touches)
            .flat_map(|(kind, list)| list.iter().map(move |pair| event(kind, pair.a, pair.b)));
        let hits = events.hits.iter().filter(|_| self.hits.is_some());
        let hits =
            hits.map(|hit| Event { impulse: hit.impulse, ..event(EventKind::Hit, hit.pair.a, hit.pair.b) });
        sensors.chain(pairs).chain(hits).collect()
    }

    /// The attributes of the trajectory and of the group that tell of it.
    pub(crate) fn about(self) -> [(&'static str, Value); 2] {
        let word = match (self.touches, self.sensors) {
            (true, _) => "all",
            (false, true) => "sensors",
            (false, false) => "none",
        };
        [("events", json!(word)), ("hits_N_s", json!(self.hits))]
    }
}

/// The bytes of each column.
pub(crate) fn to_bytes(events: &[Event]) -> Vec<Vec<u8>> {
    let ids = |id: fn(&Event) -> u64| events.iter().map(id).flat_map(u64::to_le_bytes).collect();
    vec![
        events.iter().map(|event| event.kind as u8).collect(),
        ids(|event| event.a),
        ids(|event| event.b),
        events.iter().flat_map(|event| event.impulse.to_le_bytes()).collect(),
    ]
}

/// From the bytes of each column; `None` where there are not as many of each, or a kind that there is not.
pub(crate) fn of_bytes(columns: &[Vec<u8>]) -> Option<Vec<Event>> {
    let [kinds, a, b, impulses @ ..] = columns else { return None };
    let ids =
        |bytes: &[u8]| -> Vec<u64> { bytes.as_chunks().0.iter().map(|&id| u64::from_le_bytes(id)).collect() };
    let (a, b) = (ids(a), ids(b));
    let impulses: Vec<f32> = match impulses.first() {
        Some(bytes) => bytes.as_chunks().0.iter().map(|&x| f32::from_le_bytes(x)).collect(),
        None => vec![0.0; kinds.len()],
    };
    if [a.len(), b.len(), impulses.len()] != [kinds.len(); 3] {
        return None;
    }
    let event = |(((&kind, &a), &b), &impulse): (((&u8, &u64), &u64), &f32)| {
        Some(Event { kind: *EventKind::ALL.get(usize::from(kind))?, a, b, impulse })
    };
    kinds.iter().zip(&a).zip(&b).zip(&impulses).map(event).collect()
}
