//! A run without a simulation: values that a formula gives, so that any reader can check every one of them.

use rockfall::{BodyId, StepReport};
use rockfall_cache::{
    BodyTable, Column, Contacts, Contents, Error, Event, EventKind, FORMAT, Frame, NumberType, Precision,
    RunFolder, RunWriter, Status, Summary, VERSION, Values, Velocities, WantedContacts, WantedEvents,
    Written,
};
use rockfall_math::{DVec3, Pose, Quat};
use std::ops::Range;
use std::path::Path;

/// Where the bodies start from.
pub(crate) const ORIGIN: DVec3 = DVec3::new(4.0e6, -2.0e6, 100.0);

/// Ids are odd numbers; every third body has a name.
pub(crate) fn table(bodies: usize) -> BodyTable {
    BodyTable {
        ids: (0..bodies as u64).map(|row| 2 * row + 1).collect(),
        names: (0..bodies)
            .map(|row| if row % 3 == 0 { format!("Körper {row}") } else { String::new() })
            .collect(),
        shapes: (0..bodies as u32).map(|row| row % 7).collect(),
        scales: (0..bodies).map(|row| 0.5 + row as f32 / 4.0).collect(),
    }
}

/// The bodies that are there at a frame: one of five comes at frame 1. All values are exact in single precision.
pub(crate) fn state(bodies: usize, frame: u64) -> (Vec<BodyId>, Vec<Pose>) {
    (0..bodies)
        .filter(|row| frame > 0 || row % 5 != 4)
        .map(|row| {
            let offset = DVec3::new(row as f64, frame as f64 * 0.25, -(row as f64) / 8.0);
            let turn = frame as f32 / 128.0;
            let rotation = Quat::from_xyzw(turn, 0.5, -0.25, row as f32 / 1024.0);
            (BodyId(2 * row as u64 + 1), Pose { position: ORIGIN + offset, rotation })
        })
        .unzip()
}

/// Unit quaternions and positions that no step hits, and velocities.
pub(crate) fn rolling(bodies: usize, frame: u64) -> (Vec<BodyId>, Vec<Pose>, Velocities) {
    let (ids, mut poses) = state(bodies, frame);
    for (pose, id) in poses.iter_mut().zip(&ids) {
        let (phase, t) = (id.0 as f64 * 0.1, time(frame));
        pose.position = ORIGIN + DVec3::new(phase.sin() * 300.0 + t, phase.cos() * 20.0, -4.9 * t * t);
        let axis = DVec3::new(phase.cos(), 0.6 * phase.sin(), 0.8 * phase.sin());
        let (sin, cos) = (0.5 * (phase + 3.0 * t)).sin_cos();
        let [x, y, z] = (axis * sin).to_array();
        pose.rotation = Quat::from_xyzw(x as f32, y as f32, z as f32, cos as f32);
    }
    let mut velocities = Velocities::default();
    let there: Vec<u64> = ids.iter().map(|id| id.0).collect();
    for id in table(bodies).ids {
        let there = there.binary_search(&id).is_ok();
        let number = if there { id as f32 + frame as f32 } else { f32::NAN };
        velocities.linear.extend([number, -number, 0.5 * number]);
        velocities.angular.extend([0.0 * number, 0.0 * number, 3.0 + 0.0 * number]);
    }
    (ids, poses, velocities)
}

/// Within a tenth of a millimetre and a tenth of a degree, with velocities.
pub(crate) fn bounded() -> Contents {
    let precision = Precision { position: Some(1e-4), rotation: Some(0.1_f64.to_radians()) };
    let (scene, rockfall) = ("seed = 1\n".into(), "0.1.0".into());
    Contents { origin: ORIGIN, precision, velocities: true, scene, rockfall, ..Contents::default() }
}

/// The same with contacts, events and columns.
pub(crate) fn everything() -> Contents {
    let column = |name: &str, numbers, units: &str| Column {
        name: name.into(),
        numbers,
        units: units.into(),
        description: format!("{name} of a body"),
    };
    Contents {
        contacts: Some(WantedContacts { every: 1, force: 2.5, friction: true }),
        events: Some(WantedEvents { sensors: true, touches: true, hits: Some(4.5) }),
        columns: vec![
            column("heat", NumberType::F32, "K"),
            column("work", NumberType::F64, "J"),
            column("touched", NumberType::U32, "1"),
        ],
        ..bounded()
    }
}

/// Contacts of [`everything`]: none in every third frame.
pub(crate) fn contacts(bodies: usize, frame: u64) -> Contacts {
    let mut found = Contacts::default();
    for k in (0..bodies as u64).filter(|_| !frame.is_multiple_of(3)) {
        let x = k as f32 + frame as f32 / 8.0;
        found.a.push(2 * k + 1);
        found.b.push(2 * k + 3 + frame);
        found.positions.push([x, -x, 0.5]);
        found.normals.push([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]][k as usize % 2]);
        found.distances.push(-x / 1024.0);
        found.forces.push(2.5 + x);
        found.frictions.push([0.0, 0.25, -x]);
    }
    found
}

/// Events of the same.
pub(crate) fn events(frame: u64) -> Vec<Event> {
    let kinds = EventKind::ALL.into_iter().cycle();
    let event = |(kind, k): (EventKind, u64)| {
        let impulse = if kind == EventKind::Hit { 4.75 + frame as f32 } else { 0.0 };
        Event { kind, a: 2 * k + 1, b: 2 * frame + 1, impulse }
    };
    kinds.zip(0..frame % 7).map(event).collect()
}

/// Columns of the same.
pub(crate) fn columns(bodies: usize, frame: u64) -> Vec<Values> {
    let (table, ids) = (table(bodies), state(bodies, frame).0);
    let of = |id: &BodyId| (id.0 + 3 * frame) as f64 / 16.0;
    let heat: Vec<f32> = ids.iter().map(|id| of(id) as f32).collect();
    let work: Vec<f64> = ids.iter().map(|id| of(id) / 3.0).collect();
    let touched: Vec<u32> = ids.iter().map(|id| (id.0 ^ frame) as u32).collect();
    vec![
        Values::gather(&table, &ids, &heat).unwrap(),
        Values::gather(&table, &ids, &work).unwrap(),
        Values::gather(&table, &ids, &touched).unwrap(),
    ]
}

/// A frame of [`everything`].
pub(crate) fn full_frame(writer: &RunWriter, bodies: usize, index: u64) -> Frame {
    Frame {
        contacts: contacts(bodies, index),
        events: events(index),
        columns: columns(bodies, index),
        ..rolling_frame(writer, bodies, index)
    }
}

/// Writes a whole run of [`everything`].
pub(crate) fn write_everything(path: &Path, bodies: usize, frames: u64) -> Result<Written, Error> {
    fill(start_with(path, bodies, everything())?, path, bodies, 0..frames, full_frame)
}

/// A frame of [`rolling`].
pub(crate) fn rolling_frame(writer: &RunWriter, bodies: usize, index: u64) -> Frame {
    let (ids, poses, velocities) = rolling(bodies, index);
    let mut buffer = writer.buffer();
    buffer.gather(&table(bodies), ORIGIN, &ids, &poses).unwrap();
    Frame { poses: buffer, velocities, ..frame(writer, bodies, index) }
}

/// Simulated time of a frame, seconds.
pub(crate) fn time(frame: u64) -> f64 {
    frame as f64 / 64.0
}

/// A summary of a run that goes on.
pub(crate) fn summary() -> Summary {
    Summary { format: FORMAT.into(), format_version: VERSION, frames_per_second: 64.0, ..Summary::default() }
}

/// The frame `frame` of a run of `bodies`.
pub(crate) fn frame(writer: &RunWriter, bodies: usize, frame: u64) -> Frame {
    let (ids, poses) = state(bodies, frame);
    let mut buffer = writer.buffer();
    buffer.gather(&table(bodies), ORIGIN, &ids, &poses).unwrap();
    let report = StepReport { step: frame, awake: ids.len(), ..StepReport::default() };
    let report = (frame > 0).then_some(report);
    Frame { time: time(frame), poses: buffer, report, hash: Some(frame), ..Frame::default() }
}

/// Starts a run in `path`.
pub(crate) fn start(path: &Path, bodies: usize) -> Result<RunWriter, Error> {
    start_with(path, bodies, Contents::from(ORIGIN))
}

/// The same with other contents.
pub(crate) fn start_with(path: &Path, bodies: usize, contents: Contents) -> Result<RunWriter, Error> {
    RunWriter::create(&RunFolder::at(path, false)?, "seed = 1\n", &summary(), &table(bodies), contents)
}

/// Writes a whole run.
pub(crate) fn write(path: &Path, bodies: usize, frames: u64) -> Result<Written, Error> {
    fill(start(path, bodies)?, path, bodies, 0..frames, frame)
}

/// Writes a whole run of [`rolling`] bodies.
pub(crate) fn write_bounded(path: &Path, bodies: usize, frames: u64) -> Result<Written, Error> {
    fill(start_with(path, bodies, bounded())?, path, bodies, 0..frames, rolling_frame)
}

/// Writes frames, and ends the run.
pub(crate) fn fill(
    mut writer: RunWriter,
    path: &Path,
    bodies: usize,
    frames: Range<u64>,
    frame: fn(&RunWriter, usize, u64) -> Frame,
) -> Result<Written, Error> {
    for index in frames {
        let frame = frame(&writer, bodies, index);
        writer.push(frame)?;
    }
    let written = writer.finish()?;
    Summary { status: Status::Finished, ..summary() }.write(&path.join(rockfall_cache::SUMMARY))?;
    Ok(written)
}
