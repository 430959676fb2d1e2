//! What `rockfall render` promises to those who call it. What is in the pictures is tested where they are made.

mod common;

use common::{Place, expect, out};
use std::fs;

/// A ball falls on a box on the ground.
const SCENE: &str = r#"
[world]
frames = 8

[output]
contacts = true
columns = ["asleep"]

[shapes]
floor = { kind = "half-space" }
ball = { kind = "sphere", radius = 0.5 }
box = { kind = "box", size = [2, 2, 1] }

[[bodies]]
shape = "floor"
[[bodies]]
name = "box"
shape = "box"
position = [0, 0, 0.5]
[[bodies]]
name = "ball"
shape = "ball"
position = [0, 0, 1.55]

[[cameras]]
name = "near"
position = [3, -4, 3]
target = [0, 0, 1]
[[cameras]]
name = "ball"
kind = "follow"
body = "ball"
"#;

/// Width and height that a PNG file says it has.
fn size(bytes: &[u8]) -> (u32, u32) {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn a_scene_and_its_run_give_the_same_pictures() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    for options in [
        "",
        "--camera auto --color-by size",
        "--camera ball --color-by speed",
        "--color-by material --overlay bounds,centres,paths",
        "--color-by force --overlay impulses",
        "--color-by sleep",
        "--color-by island --overlay contacts,normals",
        "--color-by penetration --caption",
    ] {
        // The run keeps single precision, from an origin of its own; so pictures may differ in a few pixels, but not in size.
        for (what, file) in [("run", "run.png"), ("small.toml", "scene.png")] {
            let command =
                format!("render {what} --frame 6 --size 96x64 --quality draft {options} -o {file} --quiet");
            expect(&place.rockfall(&command), 0);
        }
        let [run, scene] = ["run.png", "scene.png"].map(|name| fs::read(place.path(name)).unwrap());
        assert_eq!(size(&run), (96, 64));
        assert_eq!(size(&scene), (96, 64));
    }
}

#[test]
fn frames_are_numbered_and_threads_change_nothing() {
    let place = Place::with("small.toml", SCENE);
    let said =
        place.rockfall("render small.toml --frame 2..8 --every 3 --size 64x48 --quality draft --threads 1");
    expect(&said, 0);
    assert_eq!(out(&said).lines().count(), 3, "{}", out(&said));
    let names = ["small-000002.png", "small-000005.png", "small-000008.png"];
    assert!(names.iter().all(|name| place.path(name).is_file()));
    let one = fs::read(place.path("small-000005.png")).unwrap();
    expect(
        &place
            .rockfall("render small.toml --frame 5 --size 64x48 --quality draft --threads 3 -o three.png -q"),
        0,
    );
    // Not the automatic camera: the scene has one, and the picture of a frame is the same by itself.
    assert!(one == fs::read(place.path("three.png")).unwrap());
    expect(&place.rockfall("render small.toml --frame 5 --size 64x48 -o light.exr -q"), 0);
    assert!(fs::read(place.path("light.exr")).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]));
}

#[test]
fn whatever_is_wrong_is_said_and_nothing_is_written() {
    let plain = SCENE.replace("contacts = true", "").replace("columns = [\"asleep\"]", "");
    let place = Place::with("small.toml", &plain);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    fs::create_dir(place.path("empty")).unwrap();
    for (options, code, expected) in [
        ("missing.toml", 3, "does not exist"),
        ("empty", 1, "is not a run"),
        ("run --frame 9", 2, "frame 9 is not in the run, which has frames 0 to 8"),
        ("small.toml --frame 3..40", 2, "frame 40 is not in the run"),
        ("run --camera far", 2, "the scene has no camera `far`, expected `near` or `ball` or `auto`"),
        ("run -o pictures/a.png", 1, "there is no folder pictures"),
        ("run -o a.bmp", 2, "expected NAME.png, NAME.exr or NAME.mp4"),
        ("run -o empty/../empty", 2, "expected NAME.png, NAME.exr or NAME.mp4"),
        ("run -o a.exr --overlay bounds", 2, "overlays and captions need NAME.png"),
        ("run --color-by island", 2, "`contacts = true` in `[output]`"),
        ("run --color-by sleep", 2, "`columns = [\"asleep\"]` in `[output]`"),
        ("run --overlay normals", 2, "`contacts = true` in `[output]`"),
        ("run --color-by colour", 2, "expected one of body, material"),
        ("run --size 0x9", 2, "expected WIDTHxHEIGHT"),
        ("run --quality best", 2, "expected one of draft, default, fine"),
    ] {
        place.refuses(&format!("render {options} --quiet"), code, expected);
    }
    fs::create_dir(place.path("a.png")).unwrap();
    place.refuses("render run -o a.png --size 32x32 --quality draft", 1, "cannot write a.png");
    let pictures = |entry: fs::DirEntry| {
        let name = entry.file_name().into_string().unwrap();
        (name.ends_with(".png") || name.ends_with(".exr")) && entry.path().is_file()
    };
    assert!(!fs::read_dir(&place.folder).unwrap().map(Result::unwrap).any(pictures));
}
