//! `rockfall report`: one page that shows a run: pictures, figures and curves, and needs nothing else.

mod curves;
mod table;

use crate::args::{LookArgs, ReportArgs, Size};
use crate::exit::Failure;
use crate::film::{Pace, Reel};
use crate::progress::Progress;
use crate::shots::{self, Shots};
use crate::{say, summary, units};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rockfall_cache::SCENE;
use rockfall_export::Run;
use rockfall_picture::{Recorded, Sight, sheet};
use rockfall_plot::{FOOT, escape, head};
use rockfall_scene::Scene;
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::time::Instant;
use table::Table;

/// Columns and rows of the contact sheet, and pixels of its pictures and of a film.
const GRID: [u64; 2] = [4, 3];
const SMALL: Size = Size { width: 320, height: 180 };
const FILM: Size = Size { width: 640, height: 360 };

/// What the page has of its own.
const STYLE: &str = "h2 { margin-top: 2.5rem }
figure { width: min(100%, 37rem) }
nav a { margin-right: 1rem }
video, .sheet { width: 100%; max-width: 80rem; border-radius: 4px; background: #18181c }
summary { cursor: pointer; color: light-dark(#555, #aaa) }
.rows { max-height: 24rem; overflow: auto }
.rows th { position: sticky; top: 0; background: light-dark(#fff, #1b1b1b) }
.facts td { text-align: left; white-space: normal }
";

/// Writes the page.
pub(crate) fn report(args: &ReportArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let run = Run::open(&args.run)?;
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.html", name(&args.run))));
    let failed = |error: std::io::Error| Failure::Run(format!("cannot write {}: {error}", output.display()));
    // Whether it can be written is found out before the work begins, and what is there stays until there is a page.
    let fresh = !output.exists();
    OpenOptions::new().append(true).create(true).open(&output).map_err(failed)?;
    let made = page(args, &run, &output)
        .and_then(|page| fs::write(&output, &page).map_err(failed).map(|()| page.len()));
    let bytes = made.inspect_err(|_| {
        if fresh {
            // An empty page is worth nothing; what went wrong is said anyway.
            let _ = fs::remove_file(&output);
        }
    })?;
    if !args.quiet {
        let (size, time) = (units::bytes(bytes as u64), units::time(start.elapsed()));
        say::out(&format!("{}: {size}, in {time}", output.display()));
    }
    Ok(())
}

/// The folder's name.
fn name(run: &Path) -> String {
    let whole = run.canonicalize().unwrap_or_else(|_| run.to_owned());
    whole.file_name().map_or_else(|| "report".into(), |name| name.to_string_lossy().into_owned())
}

fn page(args: &ReportArgs, run: &Run, output: &Path) -> Result<String, Failure> {
    let table = Table::read(&args.run)?;
    let sections = curves::sections(&table);
    let mut text = head(&format!("Run {}", name(&args.run)), STYLE);
    let (sentence, facts) = summary::facts(run.summary());
    text += &format!(
        "<p>{}</p>\n<nav aria-label=\"Sections\"><a href=\"#seen\">Pictures</a><a href=\"#figures\">Figures</a>",
        escape(&sentence)
    );
    text +=
        "<a href=\"#curves\">Curves</a><a href=\"#scene\">Scene</a></nav>\n<h2 id=\"seen\">Pictures</h2>\n";
    text += &match &args.film {
        Some(film) => moving(args, run, film.as_deref(), output)?,
        None => moments(args, run)?,
    };
    text += "<h2 id=\"figures\">Figures</h2>\n<div class=\"wide\"><table class=\"facts\">\n";
    for (fact, value) in facts {
        text += &format!(
            "<tr><th class=\"text\" scope=\"row\">{}</th><td>{}</td></tr>\n",
            escape(&fact),
            escape(&value)
        );
    }
    text += "</table></div>\n<h2 id=\"curves\">Curves</h2>\n";
    sections.iter().for_each(|section| text += section);
    let scene = fs::read_to_string(args.run.join(SCENE)).unwrap_or_default();
    text += &format!(
        "<h2 id=\"scene\">Scene</h2>\n<details><summary>The scene file</summary><pre class=\"wide\">{}</pre></details>\n",
        escape(&scene)
    );
    Ok(text + FOOT)
}

/// A picture of many moments.
fn moments(args: &ReportArgs, run: &Run) -> Result<String, Failure> {
    let count = (GRID[0] * GRID[1]).min(run.frames());
    let last = run.frames().saturating_sub(1);
    let frames: Vec<u64> = (0..count).map(|k| (k * last).checked_div(count - 1).unwrap_or(0)).collect();
    let mut pictures = Vec::new();
    shoot(args, run, SMALL, &frames, |picture| {
        pictures.push(picture);
        Ok(())
    })?;
    let png = sheet(&pictures, GRID[0] as u32).to_png()?;
    let listed = frames.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    Ok(format!(
        "<img class=\"sheet\" alt=\"The run at frames {listed}\" src=\"data:image/png;base64,{}\">\n",
        BASE64_STANDARD.encode(png)
    ))
}

/// A film: one that is there, or one that is made.
fn moving(args: &ReportArgs, run: &Run, film: Option<&Path>, output: &Path) -> Result<String, Failure> {
    let cannot =
        |path: &Path, error: std::io::Error| Failure::Run(format!("cannot read {}: {error}", path.display()));
    let bytes = if let Some(path) = film {
        let bytes = fs::read(path).map_err(|error| cannot(path, error))?;
        if bytes.get(4..8) != Some(b"ftyp") {
            return Err(Failure::Usage(format!("{} is not a film, expected NAME.mp4", path.display())));
        }
        bytes
    } else {
        let path = output.with_extension("html.mp4");
        let Pace { every, rate } = Pace::new(run.summary().frames_per_second, None, None);
        let frames: Vec<u64> = (0..run.frames()).step_by(every as usize).collect();
        let mut reel = Reel::start(&path, FILM, rate, frames.len() as u64, args.quality)?;
        let made =
            shoot(args, run, FILM, &frames, |picture| reel.push(picture)).and_then(|()| reel.finish(true));
        let bytes = made.and_then(|()| fs::read(&path).map_err(|error| cannot(&path, error)));
        // It is in the page.
        let _ = fs::remove_file(&path);
        bytes?
    };
    let data = BASE64_STANDARD.encode(bytes);
    Ok(format!("<video controls loop muted playsinline src=\"data:video/mp4;base64,{data}\"></video>\n"))
}

/// Takes the pictures of some frames.
fn shoot(
    args: &ReportArgs,
    run: &Run,
    size: Size,
    frames: &[u64],
    mut keep: impl FnMut(rockfall_picture::Picture) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let recorded = Recorded::new(run)?;
    let chosen = shots::chosen(None, Scene::load(args.run.join(SCENE))?.cameras())?;
    let look = LookArgs { quality: args.quality, caption: true, ..LookArgs::default() };
    let mut shots = Shots::new(&look, size, chosen);
    let ends = [frames.first(), frames.last()].into_iter().flatten();
    shots.prepare(&ends.map(|&frame| recorded.at(frame)).collect::<Result<Vec<Sight>, _>>()?)?;
    let mut progress = Progress::new(frames.len() as u64, 0, args.quiet);
    for &frame in frames {
        keep(shots.take(recorded.at(frame)?)?.1)?;
        progress.frames(1);
    }
    progress.finish();
    Ok(())
}
