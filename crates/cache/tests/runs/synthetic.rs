//! A run without a simulation: values that a formula gives, so that any reader can check every one of them.

use rockfall::{BodyId, StepReport};
use rockfall_cache::{
    BodyTable, Error, FORMAT, Frame, RunFolder, RunWriter, Status, Summary, VERSION, Written,
};
use rockfall_math::{DVec3, Pose, Quat};
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
    Frame { time: time(frame), poses: buffer, report: (frame > 0).then_some(report), hash: Some(frame) }
}

/// Starts a run in `path`.
pub(crate) fn start(path: &Path, bodies: usize) -> Result<RunWriter, Error> {
    RunWriter::create(&RunFolder::at(path, false)?, "seed = 1\n", &summary(), &table(bodies), ORIGIN)
}

/// Writes a whole run.
pub(crate) fn write(path: &Path, bodies: usize, frames: u64) -> Result<Written, Error> {
    let mut writer = start(path, bodies)?;
    for index in 0..frames {
        let frame = frame(&writer, bodies, index);
        writer.push(frame)?;
    }
    let written = writer.finish()?;
    Summary { status: Status::Finished, ..summary() }.write(&path.join(rockfall_cache::SUMMARY))?;
    Ok(written)
}
