//! One frame: bodies that look alike as instances of one node.

use super::document::{Component, Document, Look, look};
use crate::prototypes::Prototypes;
use crate::{Detail, Error, Job, Moment};
use serde_json::json;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Writes the bodies `rows` at the only frame of the job.
pub(super) fn write(job: &Job<'_>, rows: &[u32], to: &Path) -> Result<(), Error> {
    let (run, inventory) = (job.run(), job.inventory()?);
    let prototypes = Prototypes::of(run, rows, &inventory.shown_of)?;
    job.stream(rows, Detail::Poses, Ok, |moment: Moment| {
        let mut alike: BTreeMap<Look, Vec<usize>> = BTreeMap::new();
        for (k, &row) in moment.rows.iter().enumerate() {
            alike.entry(look(inventory, row)).or_default().push(k);
        }
        let mut document = Document::default();
        for (look, bodies) in alike {
            let Some(surface) = prototypes.get(look.shown) else { continue };
            let mesh = document.mesh(look, inventory, surface);
            let positions: Vec<[f32; 3]> = bodies.iter().map(|&k| moment.positions[k]).collect();
            let rotations: Vec<[f32; 4]> = bodies.iter().map(|&k| moment.rotations[k]).collect();
            let mut attributes = json!({
                "TRANSLATION": document.numbers(Component::F32, "VEC3", &positions),
                "ROTATION": document.numbers(Component::F32, "VEC4", &rotations),
            });
            let ids = bodies.iter().map(|&k| run.bodies().ids[moment.rows[k] as usize]);
            // Ids beyond 32 bits can't be told.
            if let Ok(ids) = ids.map(u32::try_from).collect::<Result<Vec<u32>, _>>() {
                attributes["_ID"] = json!(document.numbers(Component::U32, "SCALAR", &ids));
            }
            let name =
                format!("shape {} of {}", look.shown, inventory.materials[look.paint.material as usize]);
            document.node(json!({
                "name": name, "mesh": mesh, "extensions": { INSTANCING: { "attributes": attributes } },
            }));
            document.require(INSTANCING);
        }
        document.write(run, to, io::empty())
    })
}
