//! `rockfall verify`: whether the output of a run is whole, and its parts say the same.

use crate::args::VerifyArgs;
use crate::exit::Failure;
use crate::{say, units};
use rockfall_cache::{
    Checkpoint, Contacts, Error, FRAMES, Poses, RunReader, SCENE, START, Start, Status, checksum, csv,
};
use rockfall_scene::Scene;
use std::fs;

/// How far a rotation may be from length 1, which single precision keeps to 1e-6.
const UNIT: f32 = 1e-4;

/// Goes through all parts, and tells everything that is wrong with them.
pub(crate) fn verify(args: &VerifyArgs) -> Result<(), Failure> {
    let run = &args.run;
    let reader = RunReader::open(run)?;
    let mut wrong: Vec<String> = Vec::new();
    if let Err(error) = Scene::load(run.join(SCENE)) {
        wrong.push(error.render(false));
    }
    let expected = &reader.summary().scene_checksum;
    if !expected.is_empty() && fs::read(run.join(SCENE)).is_ok_and(|text| checksum(&text) != *expected) {
        wrong.push(format!(
            "{} is not the scene that was run: its checksum is another one",
            run.join(SCENE).display()
        ));
    }
    let rows = csv::read(&run.join(FRAMES)).unwrap_or_else(|error| {
        wrong.push(error.to_string());
        Vec::new()
    });
    let frames = trajectory(&reader, &rows, &mut wrong).unwrap_or_else(|error| {
        wrong.push(error.to_string());
        0
    });
    let summary = reader.summary();
    if summary.status != Status::Running && summary.status != Status::Failed {
        let expected = summary.frames;
        if (rows.len() as u64, frames) != (expected, expected + 1) {
            let (rows, frames) = (rows.len(), frames.saturating_sub(1));
            wrong
                .push(format!("the summary has {expected} frames, {FRAMES} {rows}, the trajectory {frames}"));
        }
        let last = rows.last().and_then(|row| row.hash);
        if last.is_some_and(|hash| format!("{hash:016x}") != summary.hash) {
            wrong.push(format!("the summary has another hash than the last row of {FRAMES}"));
        }
    }
    wrong.extend(reader.end().err().map(|error| error.to_string()));
    wrong.extend(Start::read(&run.join(START)).err().map(|error| error.to_string()));
    let checkpoints = Checkpoint::all(run)?;
    wrong.extend(checkpoints.iter().filter_map(|checkpoint| Some(checkpoint.verify().err()?.to_string())));
    if wrong.is_empty() {
        let (frames, checkpoints) = (units::count(frames), checkpoints.len());
        say::out(&format!("{}: {frames} frames and {checkpoints} checkpoints are whole", run.display()));
        return Ok(());
    }
    Err(Failure::Run(format!("{} is damaged:\n  {}", run.display(), wrong.join("\n  "))))
}

/// Reads every frame. Returns how many there are.
fn trajectory(reader: &RunReader, rows: &[csv::Row], wrong: &mut Vec<String>) -> Result<u64, Error> {
    let (bodies, times, hashes) = (reader.bodies()?, reader.times()?, reader.hashes()?);
    if !bodies.ids.is_sorted_by(|a, b| a < b) {
        wrong.push("ids of the trajectory do not ascend".into());
    }
    for (frame, &time) in (0_u64..).zip(&times) {
        let expected = if frame == 0 { Some(0.0) } else { rows.get(frame as usize - 1).map(|row| row.time) };
        let said = (frame > 0).then(|| rows.get(frame as usize - 1)?.hash).flatten();
        if hashes.get(frame as usize).is_some_and(|&hash| said.is_some_and(|said| said != hash)) {
            wrong.push(format!("frame {frame} has one hash in the trajectory, and another one in {FRAMES}"));
        }
        if expected.is_some_and(|expected| expected != time) {
            wrong.push(format!(
                "frame {frame} is of {time} s in the trajectory, and of another time in {FRAMES}"
            ));
        }
        match reader.poses(frame).and_then(|poses| reader.velocities(frame).map(|_| poses)) {
            Ok(poses) if is_sound(&poses, bodies.len()) => {}
            Ok(_) => wrong.push(format!("frame {frame} of the trajectory has a pose that no body can have")),
            Err(error) => wrong.push(error.to_string()),
        }
    }
    wrong.extend(extras(reader, &bodies.ids, times.len() as u64)?);
    Ok(times.len() as u64)
}

/// Reads the contacts, the events and the columns of every frame. Returns what is wrong with them.
fn extras(reader: &RunReader, ids: &[u64], frames: u64) -> Result<Vec<String>, Error> {
    let (contacts, events) = (reader.contacts()?, reader.events()?);
    let columns = reader.columns()?;
    let columns = columns.iter().map(|column| reader.column(column)).collect::<Result<Vec<_>, Error>>()?;
    let known = |id: u64| ids.binary_search(&id).is_ok();
    let mut wrong = Vec::new();
    for frame in 0..frames {
        match contacts.as_ref().map(|contacts| contacts.at(frame)).transpose() {
            Ok(Some(found)) if !are_sound(&found) || !found.a.iter().chain(&found.b).all(|&id| known(id)) => {
                wrong.push(format!("frame {frame} has a contact that there can't be"));
            }
            Ok(_) => {}
            Err(error) => wrong.push(error.to_string()),
        }
        match events.as_ref().map(|events| events.at(frame)).transpose() {
            Ok(Some(found)) if !found.iter().all(|event| known(event.a) && known(event.b)) => {
                wrong.push(format!("frame {frame} has an event of a body that there is not"));
            }
            Ok(_) => {}
            Err(error) => wrong.push(error.to_string()),
        }
        wrong.extend(columns.iter().filter_map(|column| Some(column.at(frame).err()?.to_string())));
    }
    Ok(wrong)
}

/// Whether all normals have length 1, and all other numbers are some.
fn are_sound(contacts: &Contacts) -> bool {
    let unit = |n: &[f32; 3]| (n.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < UNIT;
    let numbers = contacts.distances.iter().chain(&contacts.forces);
    let numbers = numbers.chain(contacts.frictions.as_flattened());
    contacts.normals.iter().all(unit)
        && contacts.positions.as_flattened().iter().chain(numbers).all(|x| x.is_finite())
        && contacts.a.iter().zip(&contacts.b).all(|(a, b)| a < b)
}

/// Whether every body is either not there, or somewhere, and turned by a rotation.
fn is_sound(poses: &Poses, bodies: usize) -> bool {
    let (positions, _) = poses.positions.as_chunks::<3>();
    let (rotations, _) = poses.orientations.as_chunks::<4>();
    let sound = |(position, rotation): (&[f32; 3], &[f32; 4])| {
        let there = position.iter().chain(rotation).all(|x| x.is_finite());
        let length = rotation.iter().map(|x| x * x).sum::<f32>().sqrt();
        (there && (length - 1.0).abs() < UNIT) || position.iter().chain(rotation).all(|x| x.is_nan())
    };
    positions.len() == bodies && rotations.len() == bodies && positions.iter().zip(rotations).all(sound)
}
