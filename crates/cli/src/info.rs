//! `rockfall info`: what is in a scene file or in the output of a run.

use crate::args::InfoArgs;
use crate::exit::Failure;
use crate::plan::Plan;
use crate::{say, summary, units};
use rockfall_cache::{Part, RunReader, Status, Summary};
use rockfall_scene::Scene;
use serde::Serialize;

/// Says what is at a path.
pub(crate) fn info(args: &InfoArgs) -> Result<(), Failure> {
    if args.path.is_dir() { run(args) } else { scene(args) }
}

fn scene(args: &InfoArgs) -> Result<(), Failure> {
    let scene = Scene::load(&args.path)?;
    let plan = Plan::new(&args.path, &scene).with_cuts(scene.cuts()?);
    say::out(&if args.json { plan.to_json() } else { plan.to_string() });
    Ok(())
}

/// What `info --json` says of a run.
#[derive(Serialize)]
struct Run<'a> {
    /// Complete frames in the trajectory, the start included.
    trajectory_frames: u64,
    /// Bytes and number of files of each part.
    parts: Vec<PartSize>,
    /// Of all frames; none in a run that does not write them.
    contacts: Option<u64>,
    events: Option<u64>,
    /// Columns beside poses.
    columns: Vec<String>,
    summary: &'a Summary,
}

#[derive(Serialize)]
struct PartSize {
    name: &'static str,
    bytes: u64,
    files: u64,
}

fn run(args: &InfoArgs) -> Result<(), Failure> {
    let reader = RunReader::open(&args.path)?;
    let (frames, parts, summary) = (reader.frames()?, reader.parts()?, reader.summary());
    let contacts = reader.contacts()?.map(|contacts| contacts.total());
    let events = reader.events()?.map(|events| events.total());
    let columns: Vec<String> = reader.columns()?.into_iter().map(|column| column.name).collect();
    if args.json {
        let size = |part: &Part| PartSize { name: part.name, bytes: part.bytes, files: part.files };
        let parts = parts.iter().map(size).collect();
        let run = Run { trajectory_frames: frames, parts, contacts, events, columns, summary };
        // Only maps with keys that are not text can fail to become JSON, and there is none.
        say::out(&serde_json::to_string_pretty(&run).unwrap_or_default());
        return Ok(());
    }
    let mut lines = vec![if summary.status == Status::Running {
        format!(
            "{} is not finished: it goes on, or the program was killed\n  {:<20} {}",
            summary.scene,
            "bodies",
            units::count(summary.bodies as u64)
        )
    } else {
        summary::table(summary)
    }];
    let complete = format!("{} of {}", units::count(frames), units::count(summary.frames_planned + 1));
    lines.push(format!("  {:<20} {complete}, the start included", "frames on disk"));
    for (name, rows) in [("contacts on disk", contacts), ("events on disk", events)] {
        lines.extend(rows.map(|rows| format!("  {name:<20} {}", units::count(rows))));
    }
    if !columns.is_empty() {
        lines.push(format!("  {:<20} {}", "columns", columns.join(", ")));
    }
    lines.extend(parts.iter().map(|part| {
        format!("  {:<20} {:>12} in {} files", part.name, units::bytes(part.bytes), units::count(part.files))
    }));
    say::out(&lines.join("\n"));
    Ok(())
}
