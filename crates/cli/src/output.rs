//! The output of a run: the world's state, frame by frame, into a run's folder.

use crate::args::{Every, RunArgs};
use crate::exit::Failure;
use crate::extras::Extras;
use crate::open;
use crate::summary::Tally;
use rockfall::math::DVec3;
use rockfall::math::hash::combine;
use rockfall::snapshot;
use rockfall::{StepReport, World};
use rockfall_cache::{
    BodyTable, Checkpoint, Contents, Frame, Precision, RunFolder, RunReader, RunWriter, START, Summary,
    Written,
};
use rockfall_scene::{Running, Scene};
use std::path::Path;
use std::time::Instant;

/// Where runs go when nobody says where.
const RUNS: &str = "runs";

/// Bodies within this distance of the world's origin, in metres and along each axis, keep it as theirs: single
/// precision resolves a tenth of a millimetre there.
const NEAR: f64 = 1000.0;

/// A run's folder that is being filled.
#[derive(Debug)]
pub(crate) struct Output {
    writer: RunWriter,
    table: BodyTable,
    origin: DVec3,
    /// Whether velocities are written.
    velocities: bool,
    extras: Extras,
    /// Hash of the scene as it was run, by which checkpoints are known.
    scene: u64,
    every: Every,
    /// When there was a checkpoint last, and of which frame.
    last: (Instant, u64),
}

impl Output {
    /// Whether there may be output where the options want it. Said before a scene is built, which can take a while.
    pub(crate) fn check(args: &RunArgs) -> Result<(), Failure> {
        match &args.out {
            Some(path) => Ok(RunFolder::check(path, args.overwrite)?),
            None => Ok(()),
        }
    }

    /// Starts the folder and writes the state at the start.
    pub(crate) fn start(
        args: &RunArgs,
        path: &Path,
        scene: &Scene,
        running: &Running,
        summary: &Summary,
    ) -> Result<Self, Failure> {
        let folder = match &args.out {
            Some(path) => RunFolder::at(path, args.overwrite)?,
            None => RunFolder::numbered(Path::new(RUNS), &open::name(path))?,
        };
        Self::start_in(&folder, args, scene, running, summary)
    }

    /// The same in a folder that there is.
    pub(crate) fn start_in(
        folder: &RunFolder,
        args: &RunArgs,
        scene: &Scene,
        running: &Running,
        summary: &Summary,
    ) -> Result<Self, Failure> {
        let table = table(running);
        let origin = origin(running.world.poses().iter().map(|pose| pose.position));
        let text = scene.to_toml_filled();
        let hash = hash(&text);
        let (wanted, extras) = (&scene.output, Extras::of(scene, running));
        let contents = Contents {
            origin,
            precision: Precision {
                position: wanted.position_error,
                rotation: wanted.rotation_error.map(f64::to_radians),
            },
            velocities: wanted.velocities,
            scene: text.clone(),
            rockfall: summary.rockfall.clone(),
            ..Contents::default()
        };
        let mut writer = RunWriter::create(folder, &text, summary, &table, extras.within(contents))?;
        writer.encode_on(running.world.threads())?;
        if let Some(start) = scene.start() {
            start.write(&folder.path().join(START))?;
        }
        let (every, last) = (args.checkpoint_every, (Instant::now(), 0));
        let velocities = wanted.velocities;
        let mut output = Output { writer, table, origin, velocities, extras, scene: hash, every, last };
        output.push(&running.world, None)?;
        Ok(output)
    }

    /// Goes on in the folder of a run, whose state is that after the frame `frame`.
    pub(crate) fn resume(
        folder: &RunFolder,
        args: &RunArgs,
        scene: &Scene,
        running: &Running,
        summary: &Summary,
        frame: u64,
    ) -> Result<Self, Failure> {
        let table = table(running);
        let origin = RunReader::open(folder.path())?.origin()?;
        let mut writer = RunWriter::resume(folder, summary, &table, frame, running.world.hash())?;
        writer.encode_on(running.world.threads())?;
        Ok(Output {
            writer,
            table,
            origin,
            velocities: scene.output.velocities,
            extras: Extras::of(scene, running),
            scene: hash(&scene.to_toml_filled()),
            every: args.checkpoint_every,
            last: (Instant::now(), frame),
        })
    }

    /// Saves the whole state after frame `frame`, where it is time to, or somebody asks for it `now`.
    pub(crate) fn save(
        &mut self,
        running: &Running,
        tally: &Tally,
        frame: u64,
        now: bool,
    ) -> Result<(), Failure> {
        let (time, before) = self.last;
        let due = match self.every {
            Every::Frames(frames) => now || frame - before >= frames,
            Every::Time(every) => now || time.elapsed() >= every,
            Every::Never => false,
        };
        if !due || frame == before {
            return Ok(());
        }
        // A checkpoint is of no use without the frames before it.
        self.writer.sync()?;
        let (scene, waited) = (self.scene, self.writer.waited());
        Checkpoint::write(self.writer.path(), frame, |to| {
            to.one("scene", scene)?;
            tally.save(waited, to)?;
            running.save(to)
        })?;
        self.last = (Instant::now(), frame);
        Ok(())
    }

    /// Hands the state of the world over to be written.
    pub(crate) fn push(&mut self, world: &World, report: Option<&StepReport>) -> Result<(), Failure> {
        let (mut poses, mut velocities) = self.writer.buffers();
        let ids = world.ids();
        poses.take(world, &ids, &self.table, self.origin)?;
        if self.velocities {
            velocities.gather(&self.table, &ids, &world.velocities())?;
        }
        let time = report.map_or(0.0, |report| report.time);
        let hash = Some(world.hash());
        let frame = report.map_or(0, |report| report.step);
        let (contacts, events, columns) = self.extras.gather(world, &ids, &self.table, self.origin, frame)?;
        let (report, memory) = (report.cloned(), world.memory() as u64);
        self.writer.push(Frame {
            time,
            poses,
            velocities,
            report,
            hash,
            memory,
            contacts,
            events,
            columns,
        })?;
        Ok(())
    }

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        self.writer.path()
    }

    /// Waits for what is still to be written, and says what was, and how long the simulation had to wait for the disk.
    pub(crate) fn finish(self) -> Result<Written, Failure> {
        Ok(self.writer.finish()?)
    }
}

/// Reads a checkpoint of this scene into `running`. Returns the figures so far.
pub(crate) fn load(checkpoint: &Checkpoint, scene: &Scene, running: &mut Running) -> Result<Tally, Failure> {
    let expected = hash(&scene.to_toml_filled());
    let mut tally = checkpoint.read(|from| {
        if from.one::<u64>("scene")? != expected {
            return Err(snapshot::Error::OtherWorld("scene.toml"));
        }
        let tally = Tally::load(from)?;
        running.load(from)?;
        Ok(tally)
    })?;
    tally.resume(running.world.report());
    Ok(tally)
}

/// A hash of the text of a scene.
fn hash(text: &str) -> u64 {
    text.bytes().fold(text.len() as u64, |hash, byte| combine(hash, u64::from(byte)))
}

/// The bodies by ascending id.
fn table(running: &Running) -> BodyTable {
    let mut rows: Vec<_> = running.body_table().iter().collect();
    rows.sort_by_key(|row| row.id);
    BodyTable {
        ids: rows.iter().map(|row| row.id).collect(),
        names: rows.iter().map(|row| row.name.clone().unwrap_or_default()).collect(),
        shapes: rows.iter().map(|row| row.shape as u32).collect(),
        scales: rows.iter().map(|row| row.scale).collect(),
    }
}

/// The world's origin where all bodies are near it, else the middle of the bodies, in whole metres.
fn origin(positions: impl Iterator<Item = DVec3>) -> DVec3 {
    let bounds = positions.fold(None, |bounds: Option<(DVec3, DVec3)>, p| {
        Some(bounds.map_or((p, p), |(low, high)| (low.min(p), high.max(p))))
    });
    match bounds {
        Some((low, high)) if low.abs().max(high.abs()).max_element() > NEAR => (0.5 * (low + high)).round(),
        _ => DVec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_near_the_origin_keep_it_and_others_get_their_own() {
        assert_eq!(origin([].into_iter()), DVec3::ZERO);
        assert_eq!(
            origin([DVec3::new(-900.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 999.0)].into_iter()),
            DVec3::ZERO
        );
        let far = [DVec3::new(5.0e6, 0.0, 0.25), DVec3::new(5.0e6 + 3.0, 0.0, 0.0)];
        assert_eq!(origin(far.into_iter()), DVec3::new(5.0e6 + 2.0, 0.0, 0.0));
    }
}
