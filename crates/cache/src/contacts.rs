//! `contacts`: what touches, frame by frame, in a run that writes it.

use crate::ragged::{Column, Kind};
use crate::sheet::NumberType;
use crate::trajectory::attributes;
use rockfall::{BodyId, Contact, World};
use rockfall_math::DVec3;
use serde_json::{Map, Value, json};

const ROW: &[&str] = &["contact"];
const VECTOR: &[&str] = &["contact", "xyz"];

pub(crate) static CONTACTS: Kind = Kind {
    name: "contacts",
    columns: &[
        column("a", NumberType::U64, ROW, None, "id of a body, the smaller one of the two"),
        column("b", NumberType::U64, ROW, None, "id of the other body"),
        column(
            "position",
            NumberType::F32,
            VECTOR,
            Some("m"),
            "from the origin of the trajectory, half-way between the surfaces at the start of the step",
        ),
        column("normal", NumberType::F32, VECTOR, Some("1"), "unit vector from a to b"),
        column(
            "distance",
            NumberType::F32,
            ROW,
            Some("m"),
            "signed distance at the start of the step, negative where the bodies overlapped",
        ),
        column("force", NumberType::F32, ROW, Some("N"), "along the normal, at the end of the step"),
        column(
            "friction",
            NumberType::F32,
            VECTOR,
            Some("N"),
            "force of friction on b, in the world's axes, at the end of the step",
        ),
    ],
    // Runs of older versions have no friction.
    always: 6,
};

const fn column(
    name: &'static str,
    numbers: NumberType,
    dimensions: &'static [&'static str],
    units: Option<&'static str>,
    description: &'static str,
) -> Column {
    Column { name, numbers, dimensions, units, description }
}

/// Which contacts a run writes: points at which the surfaces touch or overlap, or which carry a load; not those that are only near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WantedContacts {
    /// Those of every so many frames; at least 1.
    pub every: u64,
    /// Only those that press at least this much, N; 0 for all.
    pub force: f64,
    /// Whether the forces of friction are written.
    pub friction: bool,
}

/// The contacts of a frame, by the ids of their bodies; those of a pair in the order of the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Id of a body, the smaller one of the two.
    pub a: Vec<u64>,
    /// Id of the other body.
    pub b: Vec<u64>,
    /// Metres from the run's origin, half-way between the surfaces at the start of the step.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors from `a` to `b`.
    pub normals: Vec<[f32; 3]>,
    /// Signed distances at the start of the step, metres; negative where the bodies overlapped.
    pub distances: Vec<f32>,
    /// Along the normals at the end of the step, N: on `b`, and the opposite on `a`.
    pub forces: Vec<f32>,
    /// Friction on `b`, the opposite on `a`, in the world's axes at the end of the step, N; empty in a run without.
    pub frictions: Vec<[f32; 3]>,
}

impl WantedContacts {
    /// All contacts of every frame, without friction.
    pub const ALL: Self = WantedContacts { every: 1, force: 0.0, friction: false };

    /// Those of the world's last step, which led to the frame `frame`. The solvers `impulse` and `reflect` keep no impulses: forces are zero there.
    pub fn gather(&self, world: &World, origin: DVec3, frame: u64) -> Contacts {
        let mut found = Contacts::default();
        if frame == 0 || !frame.is_multiple_of(self.every.max(1)) {
            return found;
        }
        let rate = world.settings().rate * world.settings().substeps as f32;
        let touches = |contact: &Contact| contact.distance <= 0.0 || contact.impulse > 0.0;
        let presses = |contact: &Contact| f64::from(contact.impulse * rate) >= self.force;
        let mut contacts: Vec<Contact> =
            world.contacts().filter(|contact| touches(contact) && presses(contact)).collect();
        let pair =
            |contact: &Contact| -> (BodyId, BodyId) { (contact.a.min(contact.b), contact.a.max(contact.b)) };
        contacts.sort_by_key(pair);
        for contact in contacts {
            let (a, b) = pair(&contact);
            let side = if contact.a == a { 1.0 } else { -1.0 };
            found.a.push(a.0);
            found.b.push(b.0);
            found.positions.push((contact.position - origin).as_vec3().to_array());
            found.normals.push((contact.normal * side).to_array());
            found.distances.push(contact.distance);
            found.forces.push(contact.impulse * rate);
            if self.friction {
                found.frictions.push((contact.friction * (side * rate)).to_array());
            }
        }
        found
    }

    /// The attributes of the group.
    pub(crate) fn about(&self) -> Map<String, Value> {
        attributes([
            ("every", json!(self.every)),
            ("least_force_N", json!(self.force)),
            ("friction", json!(self.friction)),
            (
                "description",
                json!("points of contact; those of frame f are the rows offset[f] to offset[f] + count[f]"),
            ),
        ])
    }

    /// What the attributes say.
    pub(crate) fn of(about: &Map<String, Value>) -> Option<Self> {
        let (every, force) = (about.get("every")?.as_u64()?, about.get("least_force_N")?.as_f64()?);
        let friction = about.get("friction").and_then(Value::as_bool).unwrap_or_default();
        Some(WantedContacts { every, force, friction })
    }
}

impl Contacts {
    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.a.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.a.is_empty()
    }

    /// The bytes of each column.
    pub(crate) fn to_bytes(&self) -> Vec<Vec<u8>> {
        let ids = |ids: &[u64]| ids.iter().flat_map(|id| id.to_le_bytes()).collect();
        let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect();
        vec![
            ids(&self.a),
            ids(&self.b),
            floats(self.positions.as_flattened()),
            floats(self.normals.as_flattened()),
            floats(&self.distances),
            floats(&self.forces),
            floats(self.frictions.as_flattened()),
        ]
    }

    /// From the bytes of each column; `None` where there are not as many of each.
    pub(crate) fn of_bytes(columns: &[Vec<u8>]) -> Option<Self> {
        let [a, b, positions, normals, distances, forces, frictions @ ..] = columns else { return None };
        let ids = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|&id| u64::from_le_bytes(id)).collect();
        let floats = |bytes: &[u8]| -> Vec<f32> {
            bytes.as_chunks().0.iter().map(|&x| f32::from_le_bytes(x)).collect()
        };
        let vectors = |bytes: &[u8]| floats(bytes).as_chunks().0.to_vec();
        let found = Contacts {
            a: ids(a),
            b: ids(b),
            positions: vectors(positions),
            normals: vectors(normals),
            distances: floats(distances),
            forces: floats(forces),
            frictions: frictions.first().map(|bytes| vectors(bytes)).unwrap_or_default(),
        };
        let n = found.len();
        let friction = found.frictions.len() == if frictions.is_empty() { 0 } else { n };
        let lengths = [found.b.len(), found.positions.len(), found.normals.len(), found.distances.len()];
        (lengths == [n; 4] && found.forces.len() == n && friction).then_some(found)
    }
}
