//! The scene that all frames have in common.

use super::crowd::{Crowd, attributes};
use super::look::{self, Looks};
use super::{fixed, mesh};
use crate::prototypes::Prototypes;
use crate::{Error, Job};
use rockfall_math::DVec3;
use rockfall_usd::{Array, Attribute, Dictionary, Layer, ListOp, Metadata, Prim, Relationship, Value};
use std::collections::BTreeMap;

/// The PointInstancer of all bodies that move.
pub(super) const BODIES: &str = "/World/Bodies";

/// Where materials are.
pub(super) const LOOKS: &str = "/World/Looks";

/// Everything but the frames.
pub(super) struct Stage {
    metadata: Metadata,
    bodies: Prim,
    fixed: Prim,
    looks: Prim,
    origin: DVec3,
}

impl Stage {
    /// That of a job whose moving bodies are in `rows` and have these surfaces.
    pub(super) fn of(
        job: &Job<'_>,
        rows: &[u32],
        surfaces: &Prototypes,
        crowd: &Crowd,
    ) -> Result<Self, Error> {
        let inventory = job.inventory()?;
        let looks = Looks::of(inventory);

        // A prototype for each shape in each look, in the order of the shapes.
        let key = |row: &u32| (inventory.shown_of[*row as usize], look::of(inventory, *row));
        let mut numbers: BTreeMap<(u32, look::Key), i32> = rows.iter().map(|row| (key(row), 0)).collect();
        (0..).zip(numbers.values_mut()).for_each(|(k, number)| *number = k);
        let mut prototypes = Prim::def("Scope", "Prototypes");
        for &(shape, look) in numbers.keys() {
            let Some(surface) = surfaces.get(shape) else { continue };
            let name = look::prototype(shape, look);
            prototypes = prototypes.child(looks.dress(mesh::of(name, surface), look));
        }
        let targets = prototypes.children.iter().map(|p| format!("{BODIES}/Prototypes/{}", p.name)).collect();
        let indices = rows.iter().map(|row| numbers[&key(row)]).collect();
        let mut bodies = Prim::def("PointInstancer", "Bodies")
            .with(Relationship::new("prototypes", targets))
            .with(Attribute::new("int64[]", "ids", Value::Array(Array::Int64(crowd.ids().to_vec()))))
            .with(Attribute::new("int[]", "protoIndices", Value::Array(Array::Int(indices))))
            .child(prototypes);
        bodies.properties.extend(attributes(&crowd.declared()).map(Into::into));

        Ok(Stage {
            metadata: metadata(job),
            bodies,
            fixed: fixed::of(job, &looks)?,
            looks: looks.scope(),
            origin: job.run().origin(),
        })
    }

    /// The layer, with the metadata `clips` where the frames are in clips.
    pub(super) fn layer(mut self, clips: Option<Value>) -> Layer {
        self.bodies.metadata.extend(clips.map(|clips| ("clips", clips)));
        let place = (self.origin != DVec3::ZERO).then(|| self.origin.to_array());
        let world = placed(Prim::def("Xform", "World"), place, None)
            .meta("kind", Value::Token("assembly".into()))
            .child(self.bodies)
            .child(self.fixed)
            .child(self.looks);
        Layer { metadata: self.metadata, prims: vec![world] }
    }
}

/// A list of schemas that are applied to a prim.
pub(super) fn schemas(names: &[&str]) -> Value {
    Value::Tokens(ListOp::Prepend(names.iter().map(|&name| name.to_owned()).collect()))
}

fn metadata(job: &Job<'_>) -> Metadata {
    let (frames, summary) = (job.frames(), job.run().summary());
    let rate = Value::Double(summary.frames_per_second);
    let about =
        [("generator", format!("Rockfall {}", env!("CARGO_PKG_VERSION"))), ("scene", summary.scene.clone())];
    let about: Dictionary = about.map(|(key, text)| (key.to_owned(), Value::String(text))).into();
    vec![
        ("defaultPrim", Value::Token("World".into())),
        ("metersPerUnit", Value::Double(1.0)),
        ("upAxis", Value::Token("Z".into())),
        ("startTimeCode", Value::Double(frames[0] as f64)),
        ("endTimeCode", Value::Double(frames[frames.len() - 1] as f64)),
        ("timeCodesPerSecond", rate.clone()),
        ("framesPerSecond", rate),
        (
            "customLayerData",
            Value::Dictionary(Dictionary::from([("rockfall".to_owned(), Value::Dictionary(about))])),
        ),
    ]
}

/// Moves a prim: a place, metres, and a quaternion x, y, z, w.
pub(super) fn placed(mut prim: Prim, place: Option<[f64; 3]>, rotation: Option<[f32; 4]>) -> Prim {
    let mut order = Vec::new();
    if let Some(place) = place {
        prim = prim.with(Attribute::new("double3", "xformOp:translate", Value::Double3(place)));
        order.push("xformOp:translate".to_owned());
    }
    if let Some(rotation) = rotation {
        prim = prim.with(Attribute::new("quatf", "xformOp:orient", Value::Quatf(rotation)));
        order.push("xformOp:orient".to_owned());
    }
    match order.is_empty() {
        true => prim,
        false => prim.with(Attribute::uniform("token[]", "xformOpOrder", Value::Array(Array::Token(order)))),
    }
}
