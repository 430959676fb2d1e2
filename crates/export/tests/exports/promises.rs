//! What holds for every format.

use crate::sample::{Counter, FRAMES, Sample};
use rockfall_export::{Csv, Error, Format, Frames, Glb, Options, Parquet, Usd, Vtp, export};
use rockfall_math::Vec3;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

fn formats() -> Vec<Box<dyn Format>> {
    let (clips, more) =
        (Usd { clip: Some(4), ..Usd::default() }, Usd { velocities: true, precise: true, clip: None });
    vec![
        Box::new(Vtp { meshes: false }),
        Box::new(Vtp { meshes: true }),
        Box::new(Csv::default()),
        Box::new(Usd::default()),
        Box::new(more),
        Box::new(clips),
    ]
}

/// The bytes of an output by the names of its files.
fn content(path: &Path) -> BTreeMap<String, Vec<u8>> {
    if path.is_file() {
        return [(String::new(), fs::read(path).unwrap())].into();
    }
    let file =
        |entry: fs::DirEntry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap());
    fs::read_dir(path).unwrap().map(|entry| file(entry.unwrap())).collect()
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let sample = Sample::new(0.0, FRAMES);
    for (k, format) in formats().iter().enumerate() {
        let mut first = None;
        for threads in [1, 2, 7] {
            let to = sample.path(&format!("{k}-{threads}"));
            let options = Options { to: Some(to.clone()), threads: Some(threads), ..Options::default() };
            let counter = Counter::default();
            let done = export(&sample.run(), format.as_ref(), &options, &counter).unwrap();
            let content = content(&to);
            let bytes = content.values().map(|file| file.len() as u64).sum::<u64>();
            assert_eq!((done.files, done.bytes, done.frames), (content.len() as u64, bytes, FRAMES));
            assert_eq!(counter.seen.into_inner(), FRAMES);
            assert_eq!(first.get_or_insert(content.clone()), &content, "{} with {threads}", format.name());
        }
    }
}

/// Promise: a run that has velocities is exported with them, at the origin of the shape, and not with means over a step.
#[test]
fn stored_velocities_are_used_where_there_are_any() {
    for away in [0.0, 4.0e6] {
        let sample = Sample::with_motion(away);
        sample.export(&Csv::default(), "", "out.csv").unwrap();
        let text = fs::read_to_string(sample.path("out.csv")).unwrap();
        let mut rows = text.lines();
        let names: Vec<&str> = rows.next().unwrap().split(',').collect();
        let first = names.iter().position(|name| *name == "vx_m_s").unwrap();
        let (mut compared, mut fastest) = (0, 0.0_f32);
        for row in rows {
            // One name has a comma in quotes; the numbers are counted from the end.
            let cells: Vec<&str> = row.split(',').collect();
            let number = |k: usize| cells[cells.len() - names.len() + k].parse::<f32>().unwrap();
            let found =
                [0, 3].map(|k| Vec3::new(number(first + k), number(first + k + 1), number(first + k + 2)));
            let (frame, id): (usize, u64) = (cells[0].parse().unwrap(), cells[2].parse().unwrap());
            let (velocity, spin) = sample.motion[frame][&id];
            assert!((found[0] - velocity).length() < 1e-5 * (1.0 + velocity.length()), "{row}");
            assert_eq!(found[1], spin);
            (compared, fastest) = (compared + 1, fastest.max(velocity.length()));
        }
        assert!(compared > 500 && fastest > 5.0, "{compared} {fastest}");
        let few = sample.export(&Usd { velocities: true, ..Usd::default() }, "3..5", "out.usdc").unwrap();
        assert_eq!(few.frames, 3);
    }
}

#[test]
fn a_run_that_was_killed_gives_the_frames_that_are_there() {
    let sample = Sample::new(0.0, 7);
    for format in formats() {
        let done = sample.export(format.as_ref(), "", &format!("{}-all", format.name())).unwrap();
        assert_eq!(done.frames, 7);
        let refused = sample.export(format.as_ref(), "3..7", "more").unwrap_err();
        assert_eq!(refused.to_string(), "frame 7 is not in the run, which has frames 0 to 6");
        fs::remove_dir_all(&done.path).or_else(|_| fs::remove_file(&done.path)).unwrap();
    }
    assert!(!sample.path("more").exists());
}

#[test]
fn what_is_stopped_or_fails_leaves_nothing() {
    let sample = Sample::new(0.0, FRAMES);
    for format in formats() {
        let to = sample.path("out");
        let options = Options { to: Some(to), threads: Some(1), ..Options::default() };
        let counter = Counter { stop_at: 1, ..Counter::default() };
        let stopped = export(&sample.run(), format.as_ref(), &options, &counter);
        assert!(matches!(stopped, Err(Error::Stopped)));
        assert_eq!(fs::read_dir(sample.folder.path()).unwrap().count(), 1, "more is there than the run");
    }
}

#[test]
fn outputs_lie_beside_the_run_and_are_replaced_only_on_demand() {
    let sample = Sample::new(0.0, 3);
    for (format, name) in [
        (&Vtp::default() as &dyn Format, "run-vtp"),
        (&Csv::default(), "run.csv"),
        (&Parquet::default(), "run.parquet"),
        (&Parquet { per_frame: true, bodies: None }, "run-parquet"),
        (&Glb::default(), "run.glb"),
        (&Usd::default(), "run.usdc"),
    ] {
        let options = |overwrite| Options { overwrite, ..Options::default() };
        let export = |overwrite| export(&sample.run(), format, &options(overwrite), &Counter::default());
        assert_eq!(export(false).unwrap().path, sample.path(name));
        let before = content(&sample.path(name));
        let refused = export(false).unwrap_err();
        assert!(matches!(refused, Error::Exists(_)), "{refused}");
        export(true).unwrap();
        assert_eq!(content(&sample.path(name)), before);
    }
}

#[test]
fn a_scene_that_was_changed_since_is_refused() {
    let sample = Sample::new(0.0, 3);
    let path = sample.path("run/scene.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("count = 60", "count = 59")).unwrap();
    let refused = sample.export(&Vtp::default(), "", "out").unwrap_err();
    assert!(
        refused.to_string().ends_with("expected 65 bodies, found 64; was it changed since?"),
        "{refused}"
    );
    fs::write(&path, text.replace("shape = \"crate\"", "shape = \"pill\"")).unwrap();
    let refused = sample.export(&Vtp::default(), "", "out").unwrap_err();
    assert!(matches!(refused, Error::OtherScene { .. }), "{refused}");
    // Rows of numbers need no shapes.
    sample.export(&Csv::default(), "", "out.csv").unwrap();
}

#[test]
fn frames_are_chosen_by_their_numbers() {
    let sample = Sample::new(0.0, FRAMES);
    let frames = Frames { every: 5, ..("3..19".parse().unwrap()) };
    let options = Options { frames, to: Some(sample.path("out")), ..Options::default() };
    export(&sample.run(), &Vtp::default(), &options, &Counter::default()).unwrap();
    let names = content(&sample.path("out")).into_keys().filter(|name| name.starts_with("frame"));
    assert_eq!(
        names.collect::<Vec<_>>(),
        ["frame-000003.vtp", "frame-000008.vtp", "frame-000013.vtp", "frame-000018.vtp"]
    );
}
