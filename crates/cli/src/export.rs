//! `rockfall export`: a run, from its folder to files that other programs open.

use crate::args::{ExportArgs, FormatName};
use crate::exit::Failure;
use crate::progress::Progress;
use crate::stop::Stop;
use crate::{say, units};
use rockfall_export::{Csv, Done, Format, Frames, Glb, Options, Parquet, Run, Usd, Vtp, Watch};
use std::sync::{Mutex, PoisonError};

/// Writes the frames that the options want in the format that they want.
pub(crate) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let run = Run::open(&args.run)?;
    let frames = Frames { every: args.every, ..args.frames.unwrap_or_default() };
    let options = Options {
        frames,
        to: args.output.clone(),
        overwrite: args.overwrite,
        threads: args.threads.map(usize::from),
    };
    let count = frames.among(run.frames())?.len() as u64;
    let format = format(args, run.bodies().len() as u64, count)?;
    let stop = Stop::listen("these frames")?;
    let watcher = Watcher { progress: Mutex::new(Progress::new(count, 0, args.quiet)), stop };
    let done = rockfall_export::export(&run, format.as_ref(), &options, &watcher);
    watcher.progress.lock().unwrap_or_else(PoisonError::into_inner).finish();
    let Done { path, frames, files, bytes } = done?;
    if !args.quiet {
        say::out(&format!(
            "{}: {} frames of {} bodies, {} in {} files",
            path.display(),
            units::count(frames),
            units::count(run.bodies().len() as u64),
            units::bytes(bytes),
            units::count(files),
        ));
    }
    Ok(())
}

/// The format with its options, for so many bodies and frames; options of another one are refused.
fn format(args: &ExportArgs, bodies: u64, frames: u64) -> Result<Box<dyn Format>, Failure> {
    let (format, known): (Box<dyn Format>, &[&str]) = match args.to {
        FormatName::Usd => {
            let usd = Usd { velocities: args.velocities, precise: args.precise, clip: None };
            let usd = match args.clips {
                None => usd.sized(bodies, frames),
                Some(clip) => Usd { clip: (clip > 0).then_some(clip), ..usd },
            };
            (Box::new(usd), &["--velocities", "--precise", "--clips"])
        }
        FormatName::Vtp => (Box::new(Vtp { meshes: args.meshes }), &["--meshes"]),
        FormatName::Csv => (Box::new(Csv { bodies: args.bodies.clone() }), &["--bodies"]),
        FormatName::Parquet => {
            let parquet = Parquet { bodies: args.bodies.clone(), per_frame: args.per_frame };
            (Box::new(parquet), &["--bodies", "--per-frame"])
        }
        FormatName::Glb => (Box::new(Glb { bodies: args.bodies.clone() }), &["--bodies"]),
    };
    let given = [
        ("--velocities", args.velocities),
        ("--precise", args.precise),
        ("--clips", args.clips.is_some()),
        ("--meshes", args.meshes),
        ("--per-frame", args.per_frame),
        ("--bodies", args.bodies.is_some()),
    ];
    match given.iter().find(|(option, given)| *given && !known.contains(option)) {
        Some((option, _)) => Err(Failure::Usage(format!("--to {} does not know {option}", format.name()))),
        None => Ok(format),
    }
}

/// Passes on between the export and the person.
struct Watcher {
    progress: Mutex<Progress>,
    stop: Stop,
}

impl Watch for Watcher {
    fn wrote(&self, frames: u64) {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner).frames(frames);
    }

    fn stopped(&self) -> bool {
        self.stop.asked()
    }
}
