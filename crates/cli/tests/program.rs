//! What the program promises to those who call it: files, exit codes, output.

mod common;

use common::{Place, error, expect, out, signal, wait_for};
use rockfall_cache::{RunReader, SUMMARY, Status, Summary, TRAJECTORY};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Two balls and a crate fall on the ground; a third ball is poured later.
const SCENE: &str = r#"
[world]
frames = 30

[shapes.floor]
kind = "half-space"
[shapes.ball]
kind = "sphere"
radius = 0.5
[shapes.crate]
kind = "box"
size = [1, 1, 1]

[[bodies]]
name = "floor"
shape = "floor"
[[bodies]]
name = "left"
shape = "ball"
position = [-0.2, 0, 1]
[[bodies]]
name = "right"
shape = "ball"
position = [0.3, 0.1, 2]
[[bodies]]
name = "crate"
shape = "crate"
position = [0, 0, 4]
rotation = [10, 20, 30]
"#;

fn place() -> Place {
    Place::with("small.toml", SCENE)
}

/// A run that does not end by itself, with piped streams.
fn endless(place: &Place, arguments: &str) -> Child {
    let mut command = place.command(&format!("run small.toml --frames 1000000000 {arguments}"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn a_run_leaves_its_four_parts_and_says_so() {
    let place = place();
    let run = place.rockfall("run small.toml --out result");
    expect(&run, 0);
    assert!(out(&run).contains("finished after 30 of 30 frames"), "{}", out(&run));
    let reader = RunReader::open(&place.path("result")).unwrap();
    assert_eq!(reader.frames().unwrap(), 31);
    assert_eq!(reader.bodies().unwrap().names, ["floor", "left", "right", "crate"]);
    assert!(reader.parts().unwrap().iter().all(|part| part.files > 0));
    let summary = reader.summary();
    assert_eq!((summary.status, summary.frames, summary.bodies), (Status::Finished, 30, 4));

    let start = reader.poses(0).unwrap();
    assert_eq!(start.positions[3..6], [-0.2, 0.0, 1.0]);
    let end = reader.poses(30).unwrap();
    assert!(end.positions.iter().chain(&end.orientations).all(|x| x.is_finite()));
    assert!(end.positions[11] < 3.0, "the crate has not fallen: {:?}", end.positions);

    let rows = fs::read_to_string(place.path("result/frames.csv")).unwrap();
    let last = rows.lines().last().unwrap();
    assert!(last.starts_with("30,0.5,") && last.contains(&format!(",{},", summary.hash)), "{last}");

    let info = place.rockfall("info result");
    expect(&info, 0);
    assert!(out(&info).contains("31 of 31, the start included"), "{}", out(&info));
}

/// A crate that stands half in the ground is lifted out of it: that is energy from nowhere, and the run says so. One that stands on it is none.
#[test]
fn a_run_tells_which_invariants_it_broke() {
    let place = place();
    for (height, broken) in [("0", true), ("0.5", false)] {
        let scene = SCENE.replace("[0, 0, 4]\nrotation = [10, 20, 30]", &format!("[5, 0, {height}]"));
        fs::write(place.path("crate.toml"), scene).unwrap();
        let run = place.rockfall("run crate.toml --out crate --overwrite");
        expect(&run, 0);
        assert_eq!(out(&run).contains("energy broken"), broken, "{}", out(&run));
        let breaches = Summary::read(&place.path("crate").join(SUMMARY)).unwrap().broken;
        let told: Vec<&str> = breaches.iter().map(|breach| breach.invariant.as_str()).collect();
        assert_eq!(told, if broken { vec!["energy"] } else { vec![] });
        assert!(breaches.iter().all(|breach| breach.first >= 1 && breach.frames >= 1 && breach.worst > 0.0));
    }
}

#[test]
fn json_is_the_summary_on_disk() {
    let place = place();
    let run = place.rockfall("run small.toml --out result --json --quiet");
    expect(&run, 0);
    assert_eq!(error(&run), "");
    let mut printed: serde_json::Value = serde_json::from_str(&out(&run)).unwrap();
    let stored = fs::read_to_string(place.path("result").join(SUMMARY)).unwrap();
    assert_eq!(printed, serde_json::from_str::<serde_json::Value>(&stored).unwrap());
    assert_eq!(printed["format"], "rockfall-run");
    assert_eq!(printed["frames"], 30);

    let info = place.rockfall("info result --json");
    let info: serde_json::Value = serde_json::from_str(&out(&info)).unwrap();
    // The checksum is the file's own.
    assert!(printed.as_object_mut().unwrap().remove("checksum").is_some());
    assert_eq!(info["summary"], printed);
    assert_eq!(info["trajectory_frames"], 31);
}

#[test]
fn the_hash_does_not_depend_on_how_it_was_computed() {
    let place = place();
    let hash = |arguments: &str| {
        let run = place.rockfall(&format!("run {arguments} --hash --quiet"));
        expect(&run, 0);
        out(&run)
    };
    let first = hash("small.toml --out result");
    assert_eq!(first.trim().len(), 16);
    for other in [
        "small.toml --no-output --threads 1",
        "small.toml --no-output --threads 3",
        "small.toml --no-output --lanes 1",
        "small.toml --no-output --lanes 8",
        // The scene as it was run is the same scene.
        "result/scene.toml --no-output",
    ] {
        assert_eq!(hash(other), first, "{other}");
    }
    assert_ne!(hash("small.toml --no-output --frames 29"), first);
    assert_ne!(hash("small.toml --no-output --substeps 5"), first);
    assert_ne!(hash("small.toml --no-output --solver impulse"), first);
    let overridden = hash("small.toml --solver reflect --substeps 3 --frames 7 --seed 9 --out other");
    assert_eq!(hash("other/scene.toml --no-output"), overridden);
}

#[test]
fn another_hash_than_expected_is_exit_code_4() {
    let place = place();
    let run = place.rockfall("run small.toml --no-output --hash --expect-hash 0123456789abcdef");
    expect(&run, 4);
    let hash = out(&run);
    assert!(error(&run).contains(&format!("the hash is {}, expected 0123456789abcdef", hash.trim())));
    expect(&place.rockfall(&format!("run small.toml --no-output --expect-hash {hash}")), 0);
}

#[test]
fn a_dry_run_counts_and_touches_nothing() {
    let place = place();
    let dry = place.rockfall("run small.toml --dry-run --frames 1000");
    expect(&dry, 0);
    assert!(out(&dry).contains("bodies   4") && out(&dry).contains("frames   1,000"), "{}", out(&dry));
    let json = place.rockfall("run small.toml --dry-run --json --out result");
    let json: serde_json::Value = serde_json::from_str(&out(&json)).unwrap();
    assert_eq!((&json["bodies"], &json["frames"]), (&4.into(), &30.into()));
    assert!(json["memory_bytes"].as_u64() > Some(0));
    // 31 frames of 4 poses of 28 bytes, and something for the rest.
    assert!((31 * 4 * 28..50_000).contains(&json["disk_bytes"].as_u64().unwrap()), "{json}");
    assert_eq!(fs::read_dir(place.folder.path()).unwrap().count(), 1);

    // `info` says the same of the scene.
    let info = place.rockfall("info small.toml --json");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&out(&info)).unwrap(), json);
}

#[test]
fn every_scene_that_ships_is_read() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut count = 0;
    for entry in fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let info = Command::new(env!("CARGO_BIN_EXE_rockfall")).arg("info").arg(&path).output().unwrap();
            expect(&info, 0);
            count += 1;
        }
    }
    assert!(count >= 10, "{count} scenes");
}

#[test]
fn runs_without_a_folder_are_numbered() {
    let place = place();
    for number in 1..=2 {
        let run = place.rockfall("run small.toml --frames 2");
        expect(&run, 0);
        let folder = Path::new("runs").join(format!("small-{number}"));
        assert!(out(&run).contains(&folder.display().to_string()), "{}", out(&run));
        assert!(RunReader::is_run(&place.folder.path().join(folder)));
    }
}

#[test]
fn a_folder_in_use_is_exit_code_1_and_stays_as_it_was() {
    let place = place();
    expect(&place.rockfall("run small.toml --out result"), 0);
    place.refuses("run small.toml --out result --frames 2", 1, "result holds a run already");
    assert_eq!(RunReader::open(&place.path("result")).unwrap().frames().unwrap(), 31);
    expect(&place.rockfall("run small.toml --out result --frames 2 --overwrite"), 0);
    assert_eq!(RunReader::open(&place.path("result")).unwrap().frames().unwrap(), 3);

    // The folder of the scene itself.
    place.refuses("run small.toml --out . --overwrite", 1, "is neither empty nor a run");
    assert_eq!(fs::read_to_string(place.path("small.toml")).unwrap(), SCENE);
    expect(&place.rockfall("info result/frames.csv"), 3);
    expect(&place.rockfall("info runs-that-never-were"), 3);
    expect(&place.rockfall("info ."), 1);
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let place = place();
    for arguments in [
        "",
        "walk small.toml",
        "run",
        "run small.toml --threads 0",
        "run small.toml --lanes 3",
        "run small.toml --frames 0",
        "run small.toml --solver magic",
        "run small.toml --expect-hash 12",
        "run small.toml --overwrite",
        "run small.toml --out a --no-output",
    ] {
        expect(&place.rockfall(arguments), 2);
    }
    assert_eq!(fs::read_dir(place.folder.path()).unwrap().count(), 1);
}

#[test]
fn a_wrong_scene_is_exit_code_3_with_its_place() {
    let place = place();
    fs::write(place.path("wrong.toml"), SCENE.replace("radius", "radus")).unwrap();
    for arguments in ["run wrong.toml", "run wrong.toml --dry-run", "info wrong.toml"] {
        let run = place.rockfall(arguments);
        expect(&run, 3);
        let text = error(&run);
        assert!(text.contains("wrong.toml:9:1") && text.contains("radus"), "{text}");
    }
    place.refuses("run missing.toml", 3, "missing.toml does not exist");
    assert!(!place.path("runs").exists());
}

#[test]
fn interruption_leaves_a_readable_run_and_a_line_was_seen_before() {
    let place = place();
    let mut child = endless(&place, "--out result");
    // A plain line of progress comes every three seconds where there is no terminal.
    let lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let progress =
        lines.map_while(Result::ok).find(|line| line.contains("ms/step")).expect("a line of progress");
    assert!(progress.contains("/1000000000  ETA") && progress.contains("body·steps/s"), "{progress}");
    signal(&child, "-INT");
    let ended = child.wait_with_output().unwrap();
    expect(&ended, 130);
    assert!(out(&ended).contains("interrupted after"), "{}", out(&ended));
    let reader = RunReader::open(&place.path("result")).unwrap();
    let frames = reader.frames().unwrap();
    assert_eq!(reader.summary().status, Status::Interrupted);
    assert_eq!(reader.summary().frames + 1, frames);
    assert!(reader.poses(frames - 1).unwrap().positions.iter().all(|x| x.is_finite()));
    let rows = fs::read_to_string(place.path("result/frames.csv")).unwrap();
    assert_eq!(rows.lines().count() as u64, frames);
}

#[test]
fn a_killed_run_reads_up_to_its_last_complete_frame() {
    let place = place();
    let mut child = endless(&place, "--out result --quiet");
    let path = place.path("result");
    wait_for("frame", || {
        RunReader::open(&path).and_then(|run| run.frames()).is_ok_and(|frames| frames > 300)
    });
    child.kill().unwrap();
    child.wait().unwrap();
    let reader = RunReader::open(&path).unwrap();
    let frames = reader.frames().unwrap();
    assert_eq!(reader.summary().status, Status::Running);
    let times = reader.times().unwrap();
    assert!(times.iter().enumerate().all(|(frame, time)| (time - frame as f64 / 60.0).abs() < 1e-6));
    for frame in 0..frames {
        assert!(reader.poses(frame).unwrap().positions.iter().all(|x| x.is_finite()));
    }
    let info = place.rockfall("info result");
    expect(&info, 0);
    assert!(out(&info).contains("is not finished"), "{}", out(&info));
}

#[test]
fn a_folder_that_goes_away_is_exit_code_1_and_named() {
    let place = place();
    let child = endless(&place, "--out result --quiet");
    wait_for("trajectory", || place.path("result").join(TRAJECTORY).join("time").exists());
    fs::rename(place.path("result"), place.path("elsewhere")).unwrap();
    let ended = child.wait_with_output().unwrap();
    expect(&ended, 1);
    let text = error(&ended);
    assert!(text.contains("result") && text.contains("was the folder moved or removed?"), "{text}");
    assert!(RunReader::open(&place.path("elsewhere")).is_ok());
}

#[test]
fn nobody_listening_is_no_failure() {
    let place = place();
    for arguments in ["run small.toml --no-output", "run small.toml --no-output --json", "info small.toml"] {
        let mut child =
            place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        expect(&ended, 0);
        let mut child =
            place.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments}");
    }
}

#[test]
#[cfg(not(feature = "bench"))]
fn the_bench_tells_how_to_get_it() {
    let place = place();
    for arguments in ["bench", "bench --scene pyramid --threads=1,2", "bench --help"] {
        place.refuses(arguments, 2, "--features bench");
    }
}

#[test]
#[cfg(feature = "bench")]
fn the_bench_finds_its_children_behind_the_verb() {
    let place = place();
    let few = "bench --scene pyramid --bodies 10 --steps 4 --timed 2 --turn 2 --repeats 1 --threads 1 --engines rockfall";
    let ended = place.rockfall(&format!("{few} --out result"));
    expect(&ended, 0);
    assert!(out(&ended).contains("| pyramid | 10 | 4 | 1 | rockfall"), "{}", out(&ended));
    for name in ["bench.md", "bench.html", "bench.csv", "bench.json"] {
        assert!(place.path("result").join(name).is_file(), "{name}");
    }
}

#[test]
fn validation_tells_what_it_finds_and_fails_where_the_default_solver_does() {
    let place = place();
    let passed = place.rockfall("validate --only stiction --solver soft-step --report page.html");
    expect(&passed, 0);
    assert!(
        out(&passed).contains("normal force") && out(&passed).contains("1 of 1 cases pass"),
        "{}",
        out(&passed)
    );
    let page = std::fs::read_to_string(place.path("page.html")).expect("a page");
    assert!(page.contains("A box is pushed and stays"));
    let failed = place.rockfall("validate --only bullets,stiction --json");
    expect(&failed, 4);
    let report: serde_json::Value = serde_json::from_str(&out(&failed)).expect("JSON");
    assert_eq!(report["outcomes"].as_array().map(Vec::len), Some(4), "two cases, two solvers");
    place.refuses("validate --only nonsense", 2, "there is no case and no group `nonsense`");
    let list = place.rockfall("validate --list --only friction");
    expect(&list, 0);
    assert!(out(&list).starts_with("block-on-slope  A block on a slope\n"), "{}", out(&list));
}
