//! Several frames: a node for each body, moved by a sampler for its position and one for its rotation. One that is not there has no size.

use super::MOST_ANIMATED;
use super::document::{Component, Document, look, too_large};
use super::tracks::{POSITION, ROTATION, Track, Tracks};
use crate::prototypes::Prototypes;
use crate::{Detail, Error, Inventory, Job, Run};
use rockfall::Kind;
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// Writes the bodies `rows` at all frames of the job.
pub(super) fn write(job: &Job<'_>, rows: &[u32], to: &Path) -> Result<(), Error> {
    let (run, inventory) = (job.run(), job.inventory()?);
    let (fixed, moving): (Vec<u32>, Vec<u32>) =
        rows.iter().partition(|&&row| inventory.kinds[row as usize] == Kind::Static);
    let frames = job.frames().len();
    check(moving.len(), frames)?;
    let prototypes = Prototypes::of(run, rows, &inventory.shown_of)?;
    let failed = |error: io::Error| Error::io("write", to, &error);
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut tracks = Tracks::new(folder, &moving, frames).map_err(failed)?;
    job.stream(&moving, Detail::Poses, Ok, |moment| tracks.add(moment).map_err(failed))?;
    let places: Vec<(u64, u64)> = (0..moving.len()).map(|body| tracks.places(body)).collect();
    let (tracks, file) = tracks.finish().map_err(failed)?;

    let mut document = Document::default();
    let still = job.at(job.frames()[0], &fixed)?;
    for ((&row, position), rotation) in still.rows.iter().zip(&still.positions).zip(&still.rotations) {
        place(&mut document, run, inventory, &prototypes, row, (position, rotation));
    }
    let start = run.times()[job.frames()[0] as usize];
    let times: Vec<f32> =
        job.frames().iter().map(|&frame| (run.times()[frame as usize] - start) as f32).collect();
    let mut animation = Animation { channels: Vec::new(), samplers: Vec::new() };
    let mut nodes = Vec::new();
    for (body, (&row, track)) in moving.iter().zip(&tracks).enumerate() {
        let Some((position, rotation)) = &track.first else { continue };
        let node = place(&mut document, run, inventory, &prototypes, row, (position, rotation));
        let Some(node) = node else { continue };
        if track.changes != [(0, true)] {
            presence(&mut document, &mut animation, node, track, &times);
        }
        nodes.push((body, node));
    }
    if nodes.is_empty() {
        // Nothing moves, and an animation must have something to move.
        return document.write(run, to, io::empty());
    }
    let input = document.times(&times);
    let tail = document.tail((POSITION + ROTATION) * (moving.len() * frames) as u64);
    for (body, node) in nodes {
        let (positions, rotations) = places[body];
        let output = document.accessor(tail, positions, Component::F32, "VEC3", frames);
        animation.add(node, "translation", input, output, "LINEAR");
        let output = document.accessor(tail, rotations, Component::F32, "VEC4", frames);
        animation.add(node, "rotation", input, output, "LINEAR");
    }
    document.animate(animation.channels, animation.samplers);
    document.write(run, to, file)
}

/// Whether so many bodies and frames are within the limits, before the run is read.
fn check(bodies: usize, frames: usize) -> Result<(), Error> {
    if bodies > MOST_ANIMATED {
        return Err(Error::Limit(format!(
            "{bodies} bodies can move, and an animation in glTF may have {MOST_ANIMATED} here, since few programs bear a node for each; choose one \
             frame with --frames for a still, some bodies with --bodies, or a format for many, such as vtp"
        )));
    }
    let bytes = (POSITION + ROTATION) * (bodies * frames) as u64;
    if u32::try_from(bytes).is_err() { Err(too_large(bytes)) } else { Ok(()) }
}

/// Adds the node of a body.
fn place(
    document: &mut Document,
    run: &Run,
    inventory: &Inventory,
    prototypes: &Prototypes,
    row: u32,
    (position, rotation): (&[f32; 3], &[f32; 4]),
) -> Option<usize> {
    let look = look(inventory, row);
    let mesh = document.mesh(look, inventory, prototypes.get(look.shown)?);
    let (id, name) = (run.bodies().ids[row as usize], &run.bodies().names[row as usize]);
    let name = if name.is_empty() { format!("body {id}") } else { name.clone() };
    Some(document.node(json!({
        "name": name, "mesh": mesh, "translation": position, "rotation": unit(rotation), "extras": { "id": id },
    })))
}

/// The rotation with a length of one in double precision, which is what JSON has.
fn unit(rotation: &[f32; 4]) -> [f64; 4] {
    let q = rotation.map(f64::from);
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / length)
}

/// Lets a body come and go: its size jumps between nothing and one.
fn presence(document: &mut Document, animation: &mut Animation, node: usize, track: &Track, times: &[f32]) {
    let mut keys = track.changes.clone();
    if keys.first().is_none_or(|&(frame, _)| frame > 0) {
        keys.insert(0, (0, false));
        document.scale(node, 0.0);
    }
    let input = document.times(&keys.iter().map(|&(frame, _)| times[frame]).collect::<Vec<f32>>());
    let sizes: Vec<[f32; 3]> = keys.iter().map(|&(_, there)| [f32::from(u8::from(there)); 3]).collect();
    let output = document.numbers(Component::F32, "VEC3", &sizes);
    animation.add(node, "scale", input, output, "STEP");
}

/// An animation that grows.
struct Animation {
    channels: Vec<Value>,
    samplers: Vec<Value>,
}

impl Animation {
    fn add(&mut self, node: usize, path: &str, input: usize, output: usize, interpolation: &str) {
        let sampler = self.samplers.len();
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
        self.channels.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }
}
