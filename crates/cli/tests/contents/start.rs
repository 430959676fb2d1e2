//! Runs that begin with the end of a run.

use crate::common::{Place, error, expect, out, wait_for};
use rockfall_cache::{RunReader, START, STATE, State, TRAJECTORY};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Balls fall into a container; a box stands in the middle as a gate.
const FILL: &str = r#"
[world]
frames = 30

[shapes.ball]
kind = "sphere"
radius = 0.2
[shapes.gate]
kind = "box"
size = [0.2, 4, 2]

[[bodies]]
name = "gate"
shape = "gate"
kind = "static"
position = [0, 0, 1]
[[generators]]
kind = "container"
name = "bin"
size = [4, 4, 2]
[[generators]]
kind = "grid"
shape = "ball"
count = [4, 8, 4]
spacing = [0.42, 0.45, 0.45]
position = [1.05, 0, 1]
"#;

/// The gate is gone, what pulls pulls aslant, and a ball falls from above.
const OPEN: &str = r#"
[world]
frames = 400
gravity = [-4, 0, -9]
[start]
run = "fill"
without = ["gate"]
[output]
velocities = true
[shapes.ball]
kind = "sphere"
radius = 0.3
[[bodies]]
name = "new"
shape = "ball"
position = [-1, 0, 3]
"#;

/// All files at and below a folder, by their paths from there.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(below, content)| (name.join(below), content)));
        } else {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

fn place() -> Place {
    let place = Place::with("fill.toml", FILL);
    fs::write(place.path("open.toml"), OPEN).unwrap();
    expect(&place.rockfall("run fill.toml --out fill --quiet"), 0);
    place
}

#[test]
fn a_container_is_filled_and_then_opened() {
    let place = place();
    let run = place.rockfall("run open.toml --out open --hash --quiet");
    expect(&run, 0);
    let (before, after) =
        (RunReader::open(&place.path("fill")).unwrap(), RunReader::open(&place.path("open")).unwrap());
    let (former, bodies) = (before.bodies().unwrap(), after.bodies().unwrap());
    assert_eq!((former.len(), bodies.len()), (1 + 5 + 128, 5 + 128 + 1));
    let walls = ["floor", "left", "front", "right", "back"].map(|wall| format!("bin.{wall}"));
    assert_eq!(former.names[1..6], walls);
    assert_eq!(bodies.ids[..133], former.ids[1..]);
    assert_eq!((bodies.ids[133], bodies.names[133].as_str()), (135, "new"));
    let (end, start) = (before.poses(30).unwrap(), after.poses(0).unwrap());
    assert_eq!(end.positions[3..], start.positions[..3 * 133]);
    assert_eq!(end.orientations[4..], start.orientations[..4 * 133]);
    // To the bit as fast as they were, though the run before has no velocities.
    let state = State::read(&place.path("fill").join(STATE)).unwrap().unwrap();
    let velocities = after.velocities(0).unwrap().unwrap();
    assert!((1..134).all(|row| velocities.at(row - 1) == Some(state.velocities[row])));
    assert!(state.velocities.iter().any(|(v, _)| v.length() > 0.0));
    // Through where the gate was.
    let left = |run: &RunReader, frame, rows: std::ops::Range<usize>| {
        let poses = run.poses(frame).unwrap();
        rows.filter(|&row| poses.at(row).unwrap().0.x < 0.0).count()
    };
    assert_eq!(left(&before, 30, 6..134), 0);
    assert!(left(&after, 400, 5..133) > 20);
    for name in ["fill", "open"] {
        expect(&place.rockfall(&format!("verify {name}")), 0);
    }
    assert!(out(&place.rockfall("info open")).contains("start.zarr"));

    // When the run before is gone, this one runs again, is exported, and begins a third.
    fs::rename(place.path("fill"), place.path("elsewhere")).unwrap();
    let again = place.rockfall("run open/scene.toml --out again --hash --quiet --threads 1");
    expect(&again, 0);
    assert_eq!(out(&again), out(&run));
    expect(&place.rockfall("export open --to vtp --frames 400 --quiet"), 0);
    let third = "[world]\nframes = 2\n[start]\nrun = \"open\"\nframe = 30\nkinds = [\"dynamic\"]\n";
    fs::write(place.path("third.toml"), third).unwrap();
    expect(&place.rockfall("run third.toml --out third --quiet"), 0);
    let third = RunReader::open(&place.path("third")).unwrap();
    assert_eq!(third.bodies().unwrap().ids[..], bodies.ids[5..]);
    assert_eq!(third.poses(0).unwrap().positions[..], after.poses(30).unwrap().positions[15..]);
    let missing = place.rockfall("run open.toml --out other");
    expect(&missing, 3);
    assert!(
        error(&missing).contains("open.toml:6") && error(&missing).contains("fill is not a run"),
        "{}",
        error(&missing)
    );
}

#[test]
fn a_run_that_began_with_a_run_goes_on_without_it() {
    let place = place();
    let more =
        "contacts = true\ncontacts_every = 3\nevents = \"all\"\ncolumns = [\"speed\", \"contact_count\"]\n";
    let long =
        OPEN.replace("frames = 400", "frames = 1500").replace("[output]\n", &format!("[output]\n{more}"));
    fs::write(place.path("open.toml"), long).unwrap();
    let whole = place.rockfall("run open.toml --out whole --hash --quiet");
    expect(&whole, 0);
    for (every, frames) in [("never", 20), ("40", 100)] {
        let _ = fs::remove_dir_all(place.path("part"));
        let arguments = format!("run open.toml --out part --quiet --checkpoint-every {every}");
        let mut child = place.command(&arguments).stdout(Stdio::null()).spawn().unwrap();
        let path = place.path("part");
        wait_for("frame", || RunReader::open(&path).and_then(|run| run.frames()).is_ok_and(|n| n > frames));
        child.kill().unwrap();
        child.wait().unwrap();
        let away = place.path("elsewhere");
        fs::rename(place.path("fill"), &away).unwrap();
        let resumed = place.rockfall("run --resume part --hash --quiet");
        expect(&resumed, 0);
        assert_eq!(out(&resumed), out(&whole));
        // All that there is beside poses, to the byte.
        for name in ["contacts", "events", "speed", "contact_count"] {
            let [a, b] = ["whole", "part"].map(|run| files(&place.path(run).join(TRAJECTORY).join(name)));
            assert!(a.len() > 1 && a == b, "{name}");
        }
        fs::rename(away, place.path("fill")).unwrap();
    }
    expect(&place.rockfall("diff whole part"), 0);
    // The copy is part of the run: it goes with it, and is checked.
    let chunk = place.path("part").join(START).join("position/c.0.0");
    let mut bytes = fs::read(&chunk).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 16;
    fs::write(&chunk, bytes).unwrap();
    let verify = place.rockfall("verify part");
    expect(&verify, 1);
    assert!(error(&verify).contains("start.zarr"), "{}", error(&verify));
    expect(&place.rockfall("run fill.toml --out part --overwrite --quiet"), 0);
    assert!(!place.path("part").join(START).exists());
}
