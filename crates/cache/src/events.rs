//! `events`: who begins to touch and ceases, and who comes into sensors and leaves them, in a run that writes it.

use crate::ragged::{Column, Kind};
use crate::sheet::NumberType;
use rockfall::Events;

const ROW: &[&str] = &["event"];

pub(crate) static EVENTS: Kind = Kind {
    name: "events",
    columns: &[
        Column {
            name: "kind",
            numbers: NumberType::U8,
            dimensions: ROW,
            units: None,
            description: "0 entered, 1 left, 2 begun, 3 ended",
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
    ],
};

/// Which events a run writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WantedEvents {
    /// Who comes into sensors and leaves them.
    Sensors,
    /// Also who begins to touch and ceases.
    All,
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
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// Id of the sensor, or of the body with the smaller one.
    pub a: u64,
    /// Id of the other body.
    pub b: u64,
}

impl EventKind {
    /// All of them, by the numbers that they have on disk.
    pub const ALL: [EventKind; 4] = [EventKind::Entered, EventKind::Left, EventKind::Begun, EventKind::Ended];
}

impl WantedEvents {
    /// Those of a world's last step, by kind and ids.
    pub fn gather(self, events: &Events) -> Vec<Event> {
        let sensors = [(EventKind::Entered, &events.entered), (EventKind::Left, &events.left)];
        let sensors = sensors.into_iter().flat_map(|(kind, list)| {
            list.iter().map(move |told| Event { kind, a: told.sensor.0, b: told.body.0 })
        });
        let pairs = [(EventKind::Begun, &events.begun), (EventKind::Ended, &events.ended)];
        let pairs = pairs
            .into_iter()
            .flat_map(|(kind, list)| list.iter().map(move |pair| Event { kind, a: pair.a.0, b: pair.b.0 }));
        sensors.chain(pairs.filter(|_| self == WantedEvents::All)).collect()
    }

    /// The word for it in the attributes of the group.
    pub(crate) fn word(self) -> &'static str {
        match self {
            WantedEvents::Sensors => "sensors",
            WantedEvents::All => "all",
        }
    }
}

/// The bytes of each column.
pub(crate) fn to_bytes(events: &[Event]) -> Vec<Vec<u8>> {
    let ids = |id: fn(&Event) -> u64| events.iter().map(id).flat_map(u64::to_le_bytes).collect();
    vec![events.iter().map(|event| event.kind as u8).collect(), ids(|event| event.a), ids(|event| event.b)]
}

/// From the bytes of each column; `None` where there are not as many of each, or a kind that there is not.
pub(crate) fn of_bytes(columns: &[Vec<u8>]) -> Option<Vec<Event>> {
    let [kinds, a, b] = columns else { return None };
    let ids =
        |bytes: &[u8]| -> Vec<u64> { bytes.as_chunks().0.iter().map(|&id| u64::from_le_bytes(id)).collect() };
    let (a, b) = (ids(a), ids(b));
    if [a.len(), b.len()] != [kinds.len(); 2] {
        return None;
    }
    let event = |((&kind, &a), &b): ((&u8, &u64), &u64)| {
        Some(Event { kind: *EventKind::ALL.get(usize::from(kind))?, a, b })
    };
    kinds.iter().zip(&a).zip(&b).map(event).collect()
}
