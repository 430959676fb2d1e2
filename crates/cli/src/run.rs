//! `rockfall run`: a scene, from its file to a folder of results.

use crate::args::RunArgs;
use crate::exit::Failure;
use crate::output::Output;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::stop::Stop;
use crate::summary::{self, Tally};
use crate::{open, say, units};
use rockfall_cache::{SUMMARY, Status, Summary};
use rockfall_scene::Running;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Runs a scene as the options want it.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let scene = open::open(args)?;
    if args.dry_run {
        let plan = Plan::new(&args.scene, &scene);
        say::out(&if args.json { plan.to_json() } else { plan.to_string() });
        return Ok(());
    }
    Output::check(args)?;
    let mut summary = summary::head(&args.scene, &scene);
    note(args, &format!("{}: building {} bodies", summary.scene, units::count(summary.bodies as u64)));
    let mut running = scene.build()?;
    let mut tally = Tally::new(start.elapsed());

    // Until here Ctrl-C ends the program in the ordinary way: there is nothing to save.
    let stop = Stop::listen()?;
    let mut output =
        if args.no_output { None } else { Some(Output::start(args, &scene, &running, &summary)?) };
    let folder = output.as_ref().map(|output| output.path().to_owned());
    note(args, &started(&summary, folder.as_deref()));
    let mut progress = Progress::new(scene.frames, args.quiet);
    let ended = simulate(&mut running, scene.frames, output.as_mut(), &stop, |report, time| {
        tally.step(report, time);
        progress.step(report, time);
    });
    progress.finish();

    let written = output.map_or(Ok(Duration::ZERO), Output::finish);
    let complete = ended.as_ref().ok().filter(|_| written.is_ok());
    summary.status = complete.copied().unwrap_or(Status::Failed);
    let hash = running.world.hash();
    summary.hash = format!("{hash:016x}");
    tally.fill(&mut summary, *written.as_ref().unwrap_or(&Duration::ZERO), running.world.memory());
    // Even a disk that refused poses may take the few bytes that say so.
    let told = folder.as_ref().map_or(Ok(()), |path| summary.write(&path.join(SUMMARY)));
    let status = ended?;
    written?;
    told?;
    show(args, &summary, folder);
    match args.expect_hash {
        _ if status == Status::Interrupted => Err(Failure::Interrupted),
        Some(expected) if expected != hash => Err(Failure::Hash { expected, found: hash }),
        _ => Ok(()),
    }
}

/// Steps until the end, or until somebody wants it to stop.
fn simulate(
    running: &mut Running,
    frames: u64,
    mut output: Option<&mut Output>,
    stop: &Stop,
    mut watch: impl FnMut(&rockfall::StepReport, Duration),
) -> Result<Status, Failure> {
    for frame in 0..frames {
        if stop.asked() {
            return Ok(Status::Interrupted);
        }
        running.before_step(frame).map_err(|error| Failure::Run(format!("at frame {frame}: {error}")))?;
        let start = Instant::now();
        running.world.step();
        let time = start.elapsed();
        let report = running.world.report();
        watch(report, time);
        if let Some(output) = &mut output {
            output.push(&running.world, Some(report))?;
        }
    }
    Ok(Status::Finished)
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
