//! Everything that is known of one body.

use crate::scenery::Scenery;
use crate::source::{Kind, Source};
use crate::wire::{Grid, Moment};
use rockfall::BodyId;
use rockfall_math::DVec3;
use rockfall_picture::Sight;
use serde_json::{Value, json};

/// Contacts that are listed, those that press most; the others are counted.
const MOST_CONTACTS: usize = 40;

/// What there is to say of the body in a row, where `sight` has it.
pub(crate) fn told(source: &Source, sight: &Sight, scenery: &Scenery, row: u32) -> Value {
    let gone = || json!({"is": "picked", "row": row, "gone": true});
    let Some(&id) = scenery.ids.get(row as usize) else { return gone() };
    let Ok(k) = sight.bodies.binary_search_by_key(&id, |body| body.id) else { return gone() };
    let body = &sight.bodies[k];
    let name = |id: u64| sight.names.iter().find(|(_, of)| **of == id).map(|(name, _)| name.as_str());
    let shape = sight.shapes.get(body.shape as usize);
    let mass = match &source.0 {
        Kind::Live(live) => live.running.world.mass(BodyId(id)).ok().filter(|mass| mass.is_finite()),
        Kind::Recorded(_) => None,
    };
    let kind = match body.kind {
        rockfall::Kind::Dynamic => "dynamic",
        rockfall::Kind::Kinematic => "kinematic",
        rockfall::Kind::Static => "static",
    };
    let mut value = json!({
        "is": "picked",
        "row": row,
        // Numbers of JavaScript are not wide enough for all of them.
        "id": id.to_string(),
        "name": name(id),
        "kind": kind,
        "shape": shape.map(rockfall::Shape::name),
        "material": sight.materials.get(body.material as usize),
        "mass": mass,
        "size": shape.map(|shape| rockfall_export::prototypes::size(shape).to_array()),
        "position": body.pose.position.to_array(),
        "rotation": body.pose.rotation.to_array(),
        "center": body.center.to_array(),
        "velocity": body.velocity.to_array(),
        "spin": body.spin.to_array(),
        "asleep": sight.asleep.as_ref().ok().map(|asleep| asleep[k]),
        "force": sight.forces.as_ref().ok().map(|forces| forces[k]),
    });
    match &sight.contacts {
        Err(why) => value["contacts_unknown"] = json!(why),
        Ok(contacts) => {
            let mut mine: Vec<usize> =
                (0..contacts.a.len()).filter(|&c| contacts.a[c] == id || contacts.b[c] == id).collect();
            mine.sort_by(|&a, &b| contacts.forces[b].total_cmp(&contacts.forces[a]));
            value["contact_count"] = json!(mine.len());
            let one = |&c: &usize| {
                let other = if contacts.a[c] == id { contacts.b[c] } else { contacts.a[c] };
                json!({
                    "with": other.to_string(),
                    "name": name(other),
                    "force": contacts.forces[c],
                    "distance": contacts.distances[c],
                    "normal": contacts.normals[c],
                })
            };
            value["contacts"] = mine.iter().take(MOST_CONTACTS).map(one).collect();
        }
    }
    value
}

/// What there is to say of the body in a row as it was at a moment that is past, of which places and who slept are kept; `newest` is what is known of the present, and tells what does not
/// change: name, shape, material and mass. What is not kept is null.
pub(crate) fn told_of_past(source: &Source, newest: &Sight, moment: &Moment, row: u32) -> Value {
    let Moment { scenery, frame, .. } = moment;
    let record = moment.records.get(row as usize).copied();
    let then = record.and_then(|record| Grid { step: moment.step }.pose(record));
    let Some((position, rotation, asleep)) = then else {
        return json!({"is": "picked", "row": row, "gone": true});
    };
    let mut value = told(source, newest, scenery, row);
    if value["gone"] == true {
        return value;
    }
    value["past"] = json!(frame);
    value["position"] = json!((scenery.origin + DVec3::from(position)).to_array());
    value["rotation"] = json!(rotation.to_array());
    value["asleep"] = json!(asleep);
    for key in ["center", "velocity", "spin", "force", "contact_count", "contacts"] {
        value[key] = Value::Null;
    }
    value
}
