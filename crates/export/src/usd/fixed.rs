//! The bodies that nobody moves.
//!
//! One by itself is a mesh, which programs can choose and hide. Many that look alike are instances, as those that move are: a prim for each takes
//! programs far longer to open.

use super::look::{self, Looks};
use super::mesh;
use super::names::Names;
use super::stage::placed;
use crate::prototypes::Prototypes;
use crate::{Error, Job, Moment};
use half::f16;
use rockfall_usd::{Array, Attribute, Prim, Relationship, Value};
use std::collections::BTreeMap;

/// So many bodies without a name that share a shape and a look become instances.
const ALIKE: usize = 16;

/// Where they are.
const STATIC: &str = "/World/Static";

/// The prim of the instances, beside the meshes.
const INSTANCES: &str = "Instances";

/// What bodies that look alike have in common.
type Key = (u32, look::Key);

/// The scope of all static bodies.
pub(super) fn of(job: &Job<'_>, looks: &Looks) -> Result<Prim, Error> {
    let (run, inventory) = (job.run(), job.inventory()?);
    let rows = inventory.fixed();
    let surfaces = Prototypes::of(run, &rows, &inventory.shown_of)?;
    let still = job.at(job.frames()[0], &rows)?;
    let key = |row: u32| (inventory.shown_of[row as usize], look::of(inventory, row));
    let name = |row: u32| &run.bodies().names[row as usize];
    let mut alike: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    for (k, &row) in still.rows.iter().enumerate().filter(|(_, row)| name(**row).is_empty()) {
        alike.entry(key(row)).or_default().push(k);
    }
    alike.retain(|_, bodies| bodies.len() >= ALIKE);

    let (mut scope, mut names) = (Prim::def("Scope", "Static"), Names::default());
    if !alike.is_empty() {
        let instances = names.choose(INSTANCES);
        scope = scope.child(instancer(instances, job, looks, &surfaces, &still, &alike));
    }
    for (k, &row) in still.rows.iter().enumerate() {
        let is_instance = name(row).is_empty() && alike.contains_key(&key(row));
        let Some(surface) = surfaces.get(inventory.shown_of[row as usize]).filter(|_| !is_instance) else {
            continue;
        };
        let id = run.bodies().ids[row as usize];
        let name = names.choose(&if name(row).is_empty() { format!("Body_{id}") } else { name(row).clone() });
        let mesh = looks.dress(mesh::of(name, surface), look::of(inventory, row));
        let (position, rotation) = (still.positions[k].map(f64::from), still.rotations[k]);
        scope = scope.child(placed(mesh, Some(position), Some(rotation)));
    }
    Ok(scope)
}

/// A PointInstancer of the bodies that look alike, those of one look behind those of another.
fn instancer(
    name: String,
    job: &Job<'_>,
    looks: &Looks,
    surfaces: &Prototypes,
    still: &Moment,
    alike: &BTreeMap<Key, Vec<usize>>,
) -> Prim {
    let ids = &job.run().bodies().ids;
    let path = format!("{STATIC}/{name}/Prototypes");
    let (mut prototypes, mut targets) = (Prim::def("Scope", "Prototypes"), Vec::new());
    let (mut indices, mut of_bodies) = (Vec::new(), Vec::new());
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (&(shape, look), bodies) in alike {
        let Some(surface) = surfaces.get(shape) else { continue };
        let index = targets.len() as i32;
        let prototype = look::prototype(shape, look);
        targets.push(format!("{path}/{prototype}"));
        prototypes = prototypes.child(looks.dress(mesh::of(prototype, surface), look));
        let reach = surface.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
        for &k in bodies {
            indices.push(index);
            of_bodies.push(k);
            for axis in 0..3 {
                low[axis] = low[axis].min(still.positions[k][axis] - reach);
                high[axis] = high[axis].max(still.positions[k][axis] + reach);
            }
        }
    }
    // Those beyond the signed numbers become negative, each another one.
    let ids = of_bodies.iter().map(|&k| ids[still.rows[k] as usize] as i64).collect();
    let positions = of_bodies.iter().map(|&k| still.positions[k]).collect();
    let precise: Vec<[f32; 4]> = of_bodies.iter().map(|&k| still.rotations[k]).collect();
    let orientations = precise.iter().map(|rotation| rotation.map(f16::from_f32)).collect();
    let array = |type_name, name, values| Attribute::new(type_name, name, Value::Array(values));
    Prim::def("PointInstancer", name)
        .with(Relationship::new("prototypes", targets))
        .with(array("int64[]", "ids", Array::Int64(ids)))
        .with(array("int[]", "protoIndices", Array::Int(indices)))
        .with(array("point3f[]", "positions", Array::Float3(positions)))
        .with(array("quath[]", "orientations", Array::Quath(orientations)))
        .with(array("quatf[]", "orientationsf", Array::Quatf(precise)))
        .with(array("float3[]", "extent", Array::Float3(vec![low, high])))
        .child(prototypes)
}
