//! `rockfall run`: a scene, from its file to a folder of results.

use crate::args::RunArgs;
use crate::exit::Failure;
use crate::film::Recording;
use crate::output::{self, Output};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::stop::Stop;
use crate::summary::{self, Tally};
use crate::{extras, open, say, units};
use rockfall_cache::{Checkpoint, RunFolder, SCENE, STATE, SUMMARY, State, Status, Summary, Written};
use rockfall_scene::Running;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Runs a scene as the options want it, or goes on with a run.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let start = Instant::now();
    if let Some(folder) = &args.resume {
        return resume(args, folder, start);
    }
    // One or the other is there.
    let path = args.scene.as_deref().unwrap_or(Path::new(""));
    let scene = open::open(path, args)?;
    if args.dry_run {
        let plan = Plan::new(path, &scene);
        say::out(&if args.json { plan.to_json() } else { plan.to_string() });
        return Ok(());
    }
    Output::check(args)?;
    scene.notes().iter().for_each(|text| note(args, &format!("Note: {text}")));
    let summary = summary::head(path, &scene);
    note(args, &format!("{}: building {} bodies", summary.scene, units::count(summary.bodies as u64)));
    let mut running = scene.build()?;
    if !args.no_output {
        extras::watch(&scene, &mut running)?;
    }
    let tally = Tally::new(start.elapsed());

    // Until here Ctrl-C ends the program in the ordinary way: there is nothing to save.
    let stop = Stop::listen("this step")?;
    let film = args.film.as_deref().map(|path| Recording::start(path, &scene)).transpose()?;
    let output =
        if args.no_output { None } else { Some(Output::start(args, path, &scene, &running, &summary)?) };
    Job { running, tally, output, summary, done: 0, frames: scene.frames, film }.finish(args, &stop)
}

/// Goes on with the run in a folder: from its last checkpoint, from the one before it where that can't be used, or from the start where there
/// was none yet.
fn resume(args: &RunArgs, path: &Path, start: Instant) -> Result<(), Failure> {
    let folder = RunFolder::of_run(path)?;
    let former = Summary::read(&path.join(SUMMARY))?;
    if former.status == Status::Finished {
        note(args, &format!("{} is finished: there is nothing to go on with", path.display()));
        show(args, &former, Some(path.to_owned()));
        return ended(args, Status::Finished, &former.hash);
    }
    let scene_path = path.join(SCENE);
    let scene = open::open(&scene_path, args)?;
    let summary = Summary { scene: former.scene, ..summary::head(&scene_path, &scene) };
    note(args, &format!("{}: building {} bodies", summary.scene, units::count(summary.bodies as u64)));
    let mut running = scene.build()?;
    extras::watch(&scene, &mut running)?;
    let stop = Stop::listen("this step")?;
    let checkpoints = Checkpoint::all(path)?;
    for checkpoint in &checkpoints {
        let frame = checkpoint.frame;
        let resumed = output::load(checkpoint, &scene, &mut running).and_then(|tally| {
            let output = Output::resume(&folder, args, &scene, &running, &summary, frame)?;
            Ok((tally, output))
        });
        match resumed {
            Ok((tally, output)) => {
                note(args, &format!("going on after frame {}", units::count(frame)));
                let output = Some(output);
                return Job {
                    running,
                    tally,
                    output,
                    summary,
                    done: frame,
                    frames: scene.frames,
                    film: None,
                }
                .finish(args, &stop);
            }
            // Told also where only errors are: it costs the frames since the checkpoint before.
            Err(Failure::Run(reason)) => say::error(&format!("Warning: {reason}")),
            Err(other) => return Err(other),
        }
    }
    if !checkpoints.is_empty() {
        return Err(rockfall_cache::Error::NoCheckpoint { path: path.to_owned() }.into());
    }
    if !former.scene_checksum.is_empty() && former.scene_checksum != summary.scene_checksum {
        return Err(Failure::Run(format!("{} is not the scene that was run", scene_path.display())));
    }
    note(args, "there is no checkpoint yet: starting again");
    folder.clear()?;
    let tally = Tally::new(start.elapsed());
    let output = Some(Output::start_in(&folder, args, &scene, &running, &summary)?);
    Job { running, tally, output, summary, done: 0, frames: scene.frames, film: None }.finish(args, &stop)
}

/// A run that is ready to go.
struct Job<'a> {
    running: Running,
    tally: Tally,
    output: Option<Output>,
    summary: Summary,
    /// Steps that were done before.
    done: u64,
    /// Steps of the whole run.
    frames: u64,
    film: Option<Recording<'a>>,
}

impl Job<'_> {
    /// Does what is left, and says what came out.
    fn finish(mut self, args: &RunArgs, stop: &Stop) -> Result<(), Failure> {
        let folder = self.output.as_ref().map(|output| output.path().to_owned());
        note(args, &started(&self.summary, folder.as_deref()));
        let mut progress = Progress::new(self.frames, self.done, args.quiet);
        let simulated = self.simulate(stop, &mut progress);
        progress.finish();

        let Job { running, tally, output, mut summary, film, .. } = self;
        let written = output.map_or(Ok(Written::default()), Output::finish).and_then(|written| {
            if let (Ok(_), Some(path)) = (&simulated, &folder) {
                State::of(&running.world, running.world.report().step).write(&path.join(STATE))?;
            }
            Ok(written)
        });
        let complete = simulated.as_ref().ok().filter(|_| written.is_ok());
        summary.status = complete.copied().unwrap_or(Status::Failed);
        summary.hash = format!("{:016x}", running.world.hash());
        let waited = written.as_ref().map_or(Duration::ZERO, |written| written.waited);
        tally.fill(&mut summary, waited, running.world.memory());
        // Even a disk that refused poses may take the few bytes that say so.
        let told = folder.as_ref().map_or(Ok(()), |path| summary.write(&path.join(SUMMARY)));
        let status = simulated?;
        let too_far = written?.too_far;
        if too_far > 0 {
            say::error(&format!(
                "Warning: {} poses were too far from the origin for the bound on positions, and are absent on disk",
                units::count(too_far)
            ));
        }
        told?;
        if let (Status::Finished, Some(path)) = (status, &folder) {
            Checkpoint::remove_all(path)?;
        }
        show(args, &summary, folder);
        // The run is complete, whatever became of its film.
        let filmed = film.map_or(Ok(()), |film| film.finish(args.quiet || args.json || args.hash));
        ended(args, status, &summary.hash).and(filmed)
    }

    /// Steps until the end, or until somebody wants it to stop.
    fn simulate(&mut self, stop: &Stop, progress: &mut Progress) -> Result<Status, Failure> {
        let Job { running, tally, output, film, .. } = self;
        if let Some(film) = film {
            film.frame(running, 0);
        }
        for frame in self.done..self.frames {
            if stop.asked() {
                if let Some(output) = output {
                    output.save(running, tally, frame, true)?;
                }
                return Ok(Status::Interrupted);
            }
            running.before_step(frame).map_err(|error| Failure::Run(format!("at frame {frame}: {error}")))?;
            let start = Instant::now();
            running.world.step();
            let time = start.elapsed();
            let report = running.world.report();
            tally.step(report, time);
            progress.step(report, time);
            if let Some(output) = output {
                output.push(&running.world, Some(report))?;
                if frame + 1 < self.frames {
                    output.save(running, tally, frame + 1, false)?;
                }
            }
            if let Some(film) = film {
                film.frame(running, frame + 1);
            }
        }
        Ok(Status::Finished)
    }
}

/// What the exit code tells of a run that has ended, `hash` being the last state's.
fn ended(args: &RunArgs, status: Status, hash: &str) -> Result<(), Failure> {
    let found = u64::from_str_radix(hash, 16).unwrap_or_default();
    match args.expect_hash {
        _ if status == Status::Interrupted => Err(Failure::Interrupted),
        Some(expected) if expected != found => Err(Failure::Hash { expected, found }),
        _ => Ok(()),
    }
}

fn started(summary: &Summary, folder: Option<&Path>) -> String {
    format!(
        "{} frames, {} with {} sub-steps, seed {}, {} threads, {} lanes → {}",
        units::count(summary.frames_planned),
        summary.solver,
        summary.substeps,
        summary.seed,
        summary.threads,
        summary.lanes,
        folder.map_or_else(|| "no output".into(), |path| path.display().to_string()),
    )
}

/// The summary: on standard output, unless that is wanted for JSON or the hash alone.
fn show(args: &RunArgs, summary: &Summary, folder: Option<PathBuf>) {
    let table = || {
        let folder = folder.as_ref().map(|path| format!("\n  {:<20} {}", "output", path.display()));
        format!("{}{}", summary::table(summary), folder.unwrap_or_default())
    };
    if args.json {
        say::out(summary.to_json().trim_end());
    }
    if args.hash {
        say::out(&summary.hash);
    }
    match (args.quiet, args.json || args.hash) {
        (true, _) => {}
        (false, true) => say::error(&table()),
        (false, false) => say::out(&table()),
    }
}

/// A line on standard error, for those who want to know.
fn note(args: &RunArgs, text: &str) {
    if !args.quiet {
        say::error(text);
    }
}
