//! What `rockfall export` promises to those who call it: files and exit codes. What is in the files is tested where they are made.

mod common;

use common::{Place, error, expect, out, signal, wait_for};
use std::fs;
use std::process::Stdio;

/// A ball falls on the ground.
const SCENE: &str = r#"
[world]
frames = 5

[shapes]
floor = { kind = "half-space" }
ball = { kind = "sphere", radius = 0.5 }

[[bodies]]
shape = "floor"
[[bodies]]
name = "ball"
shape = "ball"
position = [0, 0, 2]
"#;

fn place() -> Place {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    place
}

#[test]
fn every_format_makes_its_output_and_says_what_it_is() {
    let place = place();
    for (options, path, files) in [
        ("usd", "run.usdc", 1),
        ("usd --clips 3", "run-usd", 4),
        ("vtp", "run-vtp", 9),
        ("csv", "run.csv", 1),
        ("parquet", "run.parquet", 1),
        ("parquet --per-frame", "run-parquet", 6),
        ("glb", "run.glb", 1),
    ] {
        let export = place.rockfall(&format!("export run --to {options}"));
        expect(&export, 0);
        let said = out(&export);
        assert!(said.starts_with(&format!("{path}: 6 frames of 2 bodies, ")), "{said}");
        assert!(said.trim_end().ends_with(&format!("in {files} files")), "{said}");
        assert!(place.path(path).exists());
    }
    let quiet = place.rockfall("export run --to csv -o some.csv --frames 1..5 --every 2 --bodies 2 -q");
    expect(&quiet, 0);
    assert!(out(&quiet).is_empty() && error(&quiet).is_empty());
    let text = fs::read_to_string(place.path("some.csv")).unwrap();
    let starts: Vec<&str> = text.lines().filter_map(|line| line.split(',').next()).collect();
    assert_eq!(starts, ["frame", "1", "3", "5"]);
}

/// What is in the files is tested where they are made; here, that each option reaches them.
#[test]
fn every_option_of_usd_does_what_it_says() {
    let place = place();
    let size = |path: &str| fs::metadata(place.path(path)).unwrap().len();
    let names = |folder: &str| {
        let mut names: Vec<String> = fs::read_dir(place.path(folder))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort_unstable();
        names
    };
    expect(&place.rockfall("export run --to usd -q"), 0);
    assert!(place.path("run.usdc").is_file());
    // Of six frames of a body.
    for (option, bytes) in [("--velocities", 24), ("--precise", 16), ("--velocities --precise", 40)] {
        expect(&place.rockfall(&format!("export run --to usd {option} -o with.usdc --overwrite -q")), 0);
        assert!(size("with.usdc") > size("run.usdc") + 6 * bytes, "{option}");
    }
    expect(&place.rockfall("export run --to usd --clips 4 -o clips -q"), 0);
    assert_eq!(names("clips"), ["frames-0000.usdc", "frames-0001.usdc", "manifest.usdc", "scene.usdc"]);
    expect(
        &place.rockfall("export run --to usd --clips 1 --frames 1.. --every 2 -o clips --overwrite -q"),
        0,
    );
    let clips = ["frames-0000.usdc", "frames-0001.usdc", "frames-0002.usdc", "manifest.usdc", "scene.usdc"];
    assert_eq!(names("clips"), clips);
    // Nought is one file, however large.
    expect(&place.rockfall("export run --to usd --clips 0 -o one.usdc -q --threads 1"), 0);
    assert_eq!(fs::read(place.path("one.usdc")).unwrap(), fs::read(place.path("run.usdc")).unwrap());
    expect(&place.rockfall("export run --to usd --frames 2..4 -o some.usdc -q"), 0);
    assert!(size("some.usdc") < size("run.usdc"));
    for (arguments, code, text) in [
        ("--to usd --meshes", 2, "--to usd does not know --meshes"),
        ("--to usd --per-frame", 2, "--to usd does not know --per-frame"),
        ("--to usd --bodies 2", 2, "--to usd does not know --bodies"),
        ("--to usd --clips=-1", 2, "invalid value '-1'"),
        ("--to usd --clips many", 2, "invalid value 'many'"),
        ("--to vtp --clips 4", 2, "--to vtp does not know --clips"),
        ("--to csv --velocities", 2, "--to csv does not know --velocities"),
        ("--to glb --precise", 2, "--to glb does not know --precise"),
        ("--to usd -o run.usdc", 1, "run.usdc exists"),
        ("--to usd --clips 4 -o run.usdc --overwrite", 1, "run.usdc"),
    ] {
        place.refuses(&format!("export run {arguments}"), code, text);
    }
}

#[test]
fn exit_codes_tell_usage_from_what_is_in_the_way_and_from_the_scene() {
    let place = place();
    expect(&place.rockfall("export run --to csv -o out.csv"), 0);
    for (arguments, code, text) in [
        (
            "run --to csv -o out.csv",
            1,
            "out.csv exists; choose another path with -o, or replace it with --overwrite",
        ),
        ("run --to csv -o out.csv --overwrite", 0, ""),
        ("run --to csv -o run", 1, "run is a folder, which is never replaced"),
        ("run --to vtp -o run --overwrite", 1, "run is a folder that holds"),
        ("small.toml --to csv", 1, "small.toml is not a run"),
        ("run --to csv -o new.csv --frames 6", 2, "frame 6 is not in the run, which has frames 0 to 5"),
        ("run --to csv -o new.csv --bodies 3", 2, "the run has no body 3"),
        ("run --to csv -o new.csv --meshes", 2, "--to csv does not know --meshes"),
        ("run --to csv -o new.csv --frames 5..3", 2, "the first frame, 5, is behind the last, 3"),
        ("run --to usdx", 2, "invalid value 'usdx'"),
    ] {
        place.refuses(&format!("export {arguments}"), code, text);
    }
    assert!(!place.path("new.csv").exists());
    fs::write(place.path("run/scene.toml"), "[shapes.ball]\nkind = \"spere\"\n").unwrap();
    place.refuses("export run --to vtp", 3, "scene.toml:2");
}

#[test]
fn an_export_that_is_interrupted_leaves_nothing() {
    let place = place();
    expect(&place.rockfall("run small.toml --frames 4000 --out long --quiet"), 0);
    let before = entries(&place);
    let child = place.command("export long --to vtp").stderr(Stdio::piped()).spawn().unwrap();
    let hidden = format!(".long-vtp.{}.part", child.id());
    wait_for("frame", || place.path(&hidden).join("frame-000000.vtp").exists());
    signal(&child, "-INT");
    let export = child.wait_with_output().unwrap();
    expect(&export, 130);
    assert!(error(&export).contains("stopping after these frames"), "{}", error(&export));
    assert_eq!(entries(&place), before);
}

fn entries(place: &Place) -> Vec<String> {
    let names = fs::read_dir(place.folder.path()).unwrap();
    let mut names: Vec<String> =
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort_unstable();
    names
}
