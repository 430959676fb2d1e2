//! What films and contact sheets promise to those who call the program. Pictures are compared by `ffmpeg`; without it the tests tell so and end, with `CI` set they fail.

mod common;

use common::{Place, error, expect, out};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Balls fall on the ground.
const SCENE: &str = r#"
[world]
frames = 20
rate = 30

[shapes]
floor = { kind = "half-space" }
ball = { kind = "sphere", radius = 0.5 }

[[bodies]]
shape = "floor"
[[bodies]]
shape = "ball"
position = [0, 0, 2]
[[bodies]]
shape = "ball"
position = [1.3, 0.2, 3]
velocity = [-2, 0, 0]

[[cameras]]
name = "side"
position = [1, -8, 3]
target = [0.5, 0, 1]
"#;

const SIZE: [usize; 2] = [128, 96];

/// What a program prints, or nothing where it is not there.
fn said(program: &str, arguments: &[&str]) -> Option<Vec<u8>> {
    match Command::new(program).args(arguments).output() {
        Ok(output) => {
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && errors.is_empty(), "{program}: {errors}");
            Some(output.stdout)
        }
        Err(error) => {
            assert!(std::env::var_os("CI").is_none(), "{program}: {error}; it is in Debian's package ffmpeg");
            println!("{program} is not there: films are not checked by it");
            None
        }
    }
}

/// The pictures of a film or a picture, red, green and blue.
fn pictures(path: &Path) -> Option<Vec<Vec<u8>>> {
    let path = path.to_str().unwrap();
    let bytes = said(
        "ffmpeg",
        &[
            "-v",
            "error",
            "-i",
            path,
            "-vf",
            "scale=sws_flags=lanczos+accurate_rnd+full_chroma_int",
            "-pix_fmt",
            "rgb24",
            "-f",
            "rawvideo",
            "-",
        ],
    )?;
    Some(bytes.chunks(3 * SIZE[0] * SIZE[1]).map(<[u8]>::to_vec).collect())
}

/// Length in seconds, frames, and pictures a second.
fn probe(path: &Path) -> Option<String> {
    let entries = "stream=width,height,avg_frame_rate,nb_read_frames:format=duration";
    let bytes = said(
        "ffprobe",
        &[
            "-v",
            "error",
            "-count_frames",
            "-show_entries",
            entries,
            "-of",
            "csv=p=0:nk=1",
            path.to_str().unwrap(),
        ],
    )?;
    Some(String::from_utf8(bytes).unwrap().trim().replace('\n', ","))
}

fn psnr(a: &[u8], b: &[u8]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    10.0 * (255.0_f64.powi(2) * a.len() as f64 / squares).log10()
}

#[test]
fn a_film_shows_the_pictures_of_its_frames() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    let said = place.rockfall("render run -o film.mp4 --size 128x96");
    expect(&said, 0);
    assert!(out(&said).starts_with("film.mp4: 21 pictures, 0.70 s, "), "{}", out(&said));
    expect(&place.rockfall("render run --frame 0..20 --every 10 --size 128x96 -o still.png -q"), 0);
    let Some(film) = pictures(&place.path("film.mp4")) else { return };
    assert_eq!(film.len(), 21);
    for frame in [0, 10, 20] {
        let still = pictures(&place.path(&format!("still-{frame:06}.png"))).unwrap().remove(0);
        // As for the encoder by itself (`crates/film/tests`): errors evenly spread in the steps of its quantizer are 32 dB.
        let here = psnr(&film[frame], &still);
        assert!(here > 32.0, "frame {frame}: {here} dB");
        let other = psnr(&film[(frame + 10) % 21], &still);
        assert!(other < here - 6.0, "frame {frame}: {here} dB, and another one {other} dB");
    }
    assert_eq!(probe(&place.path("film.mp4")).unwrap(), "128,96,30/1,21,0.700000");
}

#[test]
fn a_film_of_the_run_is_one_of_the_scene_and_pace_and_frames_can_be_chosen() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --frames 3 --no-output --film run.mp4 --quiet"), 0);
    let Some(seen) = probe(&place.path("run.mp4")) else { return };
    assert_eq!(seen, "1280,720,30/1,4,0.133333");
    for (options, expected) in [
        ("--frames 5..14", "128,96,30/1,10,0.333333"),
        ("--every 5 --quality draft", "128,96,6/1,5,0.833333"),
        ("--frames 0..5 --fps 12.5 --blur 0.5 --quality draft --caption", "128,96,25/2,6,0.480000"),
    ] {
        expect(&place.rockfall(&format!("render small.toml -o film.mp4 --size 128x96 --quiet {options}")), 0);
        assert_eq!(probe(&place.path("film.mp4")).unwrap(), expected, "{options}");
    }
}

#[test]
fn what_moves_is_blurred_and_the_rest_is_not() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    for (name, options) in [("sharp", ""), ("soft", "--blur 1")] {
        expect(
            &place.rockfall(&format!("render run --frame 9..10 --size 128x96 -o {name}.png -q {options}")),
            0,
        );
    }
    let [sharp, soft] = ["sharp-000010.png", "soft-000010.png"].map(|name| pictures(&place.path(name)));
    let (Some(sharp), Some(soft)) = (sharp, soft) else { return };
    let differ = |row: usize| {
        let line = 3 * SIZE[0] * row..3 * SIZE[0] * (row + 1);
        let off = sharp[0][line.clone()].iter().zip(&soft[0][line]).map(|(a, b)| a.abs_diff(*b));
        off.max().unwrap()
    };
    // Balls fall by 0.1 m within the frame, 2 pixels; the foreground stands still.
    let most = (0..70).map(differ).max().unwrap();
    assert!(most > 40, "{most}");
    let still = (84..96).map(differ).max().unwrap();
    assert!(still < 6, "{still}");
}

#[test]
fn a_contact_sheet_has_moments_from_the_first_to_the_last() {
    let place = Place::with("small.toml", SCENE);
    let said = place.rockfall(
        "render small.toml --contact-sheet 3x2 --size 64x48 --quality draft --caption -o sheet.png",
    );
    expect(&said, 0);
    assert!(out(&said).contains("sheet.png: 6 moments, 208 × 108"), "{}", out(&said));
    let bytes = fs::read(place.path("sheet.png")).unwrap();
    assert_eq!(&bytes[16..24], [0, 0, 0, 208, 0, 0, 0, 108]);
    // Fewer frames than places: all of them.
    let said = place.rockfall("render small.toml --contact-sheet --frames 2..4 --size 64x48 --quality draft");
    expect(&said, 0);
    assert!(out(&said).contains("small-sheet.png: 3 moments"), "{}", out(&said));
}

#[test]
fn whatever_is_wrong_with_a_film_is_said_before_the_work_begins() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    fs::create_dir(place.path("dir.mp4")).unwrap();
    for (options, code, expected) in [
        ("run -o a.mp4 --size 129x96", 2, "both have to be even"),
        ("run -o a.mp4 --frames 3..21", 2, "frame 21 is not in the run, which has frames 0 to 20"),
        ("missing -o a.mp4", 3, "does not exist"),
        ("run -o no/a.mp4", 1, "there is no folder no"),
        ("run -o dir.mp4", 1, "cannot write dir.mp4"),
        ("run -o a.mp4 --fps 0", 2, "expected a number from 0.001 to 1000"),
        ("run -o a.png --fps 10", 2, "--fps is for films"),
        ("run -o a.mp4 --contact-sheet", 2, "a contact sheet is one picture"),
        ("run --contact-sheet 0x3", 2, "expected COLUMNSxROWS"),
        ("run -o a.mp4 --blur 2", 2, "expected a number from 0.001 to 1"),
        ("run -o a.avi", 2, "expected NAME.png, NAME.exr or NAME.mp4"),
    ] {
        place.refuses(&format!("render {options} --quiet"), code, expected);
        assert!(!place.path("a.mp4").exists(), "{options}");
    }
    for (options, expected) in
        [("--film a.avi", "expected NAME.mp4"), ("--film no/a.mp4", "cannot write no/a.mp4")]
    {
        let said = place.rockfall(&format!("run small.toml --no-output {options}"));
        assert!(!said.status.success() && error(&said).contains(expected), "{options}: {}", error(&said));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_film_and_not_the_run() {
    // So slow that each picture is written at once.
    let place = Place::with("small.toml", &SCENE.replace("rate = 30", "rate = 2"));
    std::os::unix::fs::symlink("/dev/full", place.path("full.mp4")).unwrap();
    place.refuses("run small.toml --frames 4 --out run --film full.mp4 --quiet", 1, "cannot write full.mp4");
    expect(&place.rockfall("verify run"), 0);
    let summary = fs::read_to_string(place.path("run/summary.json")).unwrap();
    assert!(summary.contains("\"finished\""), "{summary}");
}
