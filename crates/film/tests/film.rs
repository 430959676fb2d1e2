//! What other programs see of a film: `ffprobe` and `ffmpeg`. Without them the tests tell so and end; with `CI` set they fail.

use rockfall_film::{Effort, Error, Film, Format};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: [u32; 2] = [96, 64];

fn format(pictures: u64) -> Format {
    Format { width: SIZE[0], height: SIZE[1], rate: 24.0, pictures, effort: Effort::Standard, threads: 2 }
}

/// A square goes over a ground of several colours.
fn picture(k: u32) -> Vec<[u8; 3]> {
    let pixel = |x: u32, y: u32| {
        let square = (4 + k..20 + k).contains(&x) && (20..36).contains(&y);
        if square { [230, 70, 40] } else { [(2 * x) as u8, 90, 60 + 2 * y as u8] }
    };
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| pixel(x, y))).collect()
}

fn film(path: &Path, expected: u64, pictures: u32) -> rockfall_film::Done {
    let mut film = Film::create(path, &format(expected)).expect("a film");
    (0..pictures).for_each(|k| film.push(picture(k)).expect("a picture"));
    film.finish().expect("its end")
}

/// What a program says, or nothing where it is not there.
fn said(program: &str, arguments: &[&str], file: &Path) -> Option<Vec<u8>> {
    let place = arguments.iter().position(|argument| *argument == "FILE").expect("a place for the file");
    let file = file.to_str().expect("a path");
    let mut arguments = arguments.to_vec();
    arguments[place] = file;
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

/// What `ffprobe` counts and reads.
fn probe(file: &Path) -> Option<Value> {
    let arguments = ["-v", "error", "-count_frames", "-show_streams", "-show_format", "-of", "json", "FILE"];
    said("ffprobe", &arguments, file).map(|text| serde_json::from_slice(&text).expect("JSON"))
}

/// Its pictures, as `ffmpeg` decodes them.
fn decoded(file: &Path) -> Option<Vec<Vec<[u8; 3]>>> {
    // Every step of the conversion as exact as it can.
    let flags = "sws_flags=lanczos+accurate_rnd+full_chroma_int";
    let arguments = [
        "-v",
        "error",
        "-i",
        "FILE",
        "-vf",
        &format!("scale={flags}"),
        "-pix_fmt",
        "rgb24",
        "-f",
        "rawvideo",
        "-",
    ];
    let bytes = said("ffmpeg", &arguments, file)?;
    let (pixels, _) = bytes.as_chunks::<3>();
    Some(pixels.chunks((SIZE[0] * SIZE[1]) as usize).map(<[[u8; 3]]>::to_vec).collect())
}

/// Peak signal to noise, decibels.
fn psnr(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    let squares =
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    10.0 * (255.0_f64.powi(2) * (3 * a.len()) as f64 / squares.sum::<f64>()).log10()
}

fn place(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    (folder, path)
}

#[test]
fn a_film_has_the_length_size_count_and_colours_that_it_was_made_with() {
    let (_folder, path) = place("a.mp4");
    let done = film(&path, 40, 40);
    assert_eq!((done.pictures, done.seconds), (40, 40.0 / 24.0));
    assert_eq!(done.bytes, fs::metadata(&path).expect("a file").len());
    let Some(seen) = probe(&path) else { return };
    let stream = &seen["streams"][0];
    for (key, expected) in [
        ("codec_name", "av1"),
        ("pix_fmt", "yuv420p"),
        ("nb_read_frames", "40"),
        ("avg_frame_rate", "24/1"),
        ("duration", "1.666667"),
        ("color_range", "tv"),
        ("color_space", "bt709"),
        ("color_primaries", "bt709"),
        ("color_transfer", "iec61966-2-1"),
        ("chroma_location", "left"),
    ] {
        assert_eq!(stream[key], expected, "{key}");
    }
    assert_eq!([&stream["width"], &stream["height"]], [SIZE[0], SIZE[1]]);
    // The lowest level of all, 2.0: small and slow.
    assert_eq!(stream["level"], 0);
    assert_eq!(seen["format"]["duration"], "1.666667");
}

#[test]
fn pictures_come_out_as_they_went_in() {
    let (_folder, path) = place("a.mp4");
    film(&path, 30, 30);
    let Some(pictures) = decoded(&path) else { return };
    assert_eq!(pictures.len(), 30);
    for (k, picture_out) in (0..).zip(&pictures) {
        // The base of the quantizer is 100, whose step in a picture is 14 (AV1 specification, 7.12.2: 112 by 8). Errors evenly spread within a step are
        // 14/√12 = 4.0, which are 36 dB; what is lost of colours between pixels makes up for the rest. A picture some frames later, or one in the
        // colours of BT.601, has less than 28.
        let (here, later) = (psnr(picture_out, &picture(k)), psnr(picture_out, &picture(k + 6)));
        assert!(here > 32.0, "{here} dB at {k}");
        assert!(later < 28.0, "{later} dB at {k} and {}", k + 6);
        // Wide areas keep their colours to a few steps.
        let at = |pixels: &[[u8; 3]], x: usize, y: usize| pixels[y * SIZE[0] as usize + x];
        for (x, y) in [(80, 10), (90, 55), (12 + k as usize, 28)] {
            let (a, b) = (at(picture_out, x, y), at(&picture(k), x, y));
            assert!((0..3).all(|c| a[c].abs_diff(b[c]) <= 8), "{a:?} for {b:?} at {x}, {y} of {k}");
        }
    }
}

#[test]
fn the_same_pictures_make_the_same_bytes_for_any_number_of_threads() {
    let bytes = |threads: usize| {
        let (_folder, path) = place("a.mp4");
        let mut film = Film::create(&path, &Format { threads, ..format(14) }).expect("a film");
        (0..14).for_each(|k| film.push(picture(k)).expect("a picture"));
        film.finish().expect("its end");
        fs::read(&path).expect("a file")
    };
    assert!(bytes(1) == bytes(3));
}

#[test]
fn a_film_that_is_broken_off_is_whole_up_to_a_group() {
    let (_folder, path) = place("a.mp4");
    let done = film(&path, 40, 40);
    let whole = fs::read(&path).expect("a file");
    assert_eq!(done.bytes, whole.len() as u64);
    // As a killed program leaves it: groups of twelve, no index, and the third group not complete.
    let starts: Vec<usize> =
        (4..whole.len() - 4).filter(|&k| &whole[k..k + 4] == b"moof").map(|k| k - 4).collect();
    assert_eq!(starts.len(), 4);
    let index = (4..whole.len() - 4).find(|&k| &whole[k..k + 4] == b"sidx").expect("an index");
    let mut broken = whole[..starts[3]].to_vec();
    broken[index..index + 4].copy_from_slice(b"free");
    for (cut, pictures) in [(starts[3], 36), (starts[2], 24)] {
        fs::write(&path, &broken[..cut]).expect("a file");
        let Some(seen) = probe(&path) else { return };
        assert_eq!(seen["streams"][0]["nb_read_frames"], pictures.to_string());
    }
}

#[test]
fn a_film_that_ends_early_is_as_long_as_its_pictures() {
    let (_folder, path) = place("a.mp4");
    assert_eq!(film(&path, 1000, 30).pictures, 30);
    let Some(seen) = probe(&path) else { return };
    assert_eq!(
        (&seen["streams"][0]["nb_read_frames"], &seen["format"]["duration"]),
        (&"30".into(), &"1.250000".into())
    );
    // More than were expected are kept as well.
    assert_eq!(film(&path, 3, 30).pictures, 30);
    let seen = probe(&path).expect("it was there");
    assert_eq!(
        (&seen["streams"][0]["nb_read_frames"], &seen["format"]["duration"]),
        (&"30".into(), &"1.250000".into())
    );
}

#[test]
fn whatever_is_wrong_is_said() {
    let (folder, path) = place("a.mp4");
    let error = |format: Format, path: &Path| Film::create(path, &format).expect_err("no film").to_string();
    assert!(
        error(Format { width: 95, ..format(1) }, &path)
            .contains("95 × 64 pixels can't be made: both have to be even")
    );
    assert!(error(Format { height: 8, ..format(1) }, &path).contains("from 16"));
    assert!(error(Format { rate: 0.0, ..format(1) }, &path).contains("0 pictures a second"));
    assert!(error(Format { rate: f64::NAN, ..format(1) }, &path).contains("NaN pictures"));
    assert!(!path.exists());
    assert!(error(format(1), folder.path()).contains("cannot write"));
    assert!(error(format(1), &folder.path().join("no/a.mp4")).contains("cannot write"));
    let mut film = Film::create(&path, &format(1)).expect("a film");
    assert!(matches!(film.push(vec![[0; 3]; 7]), Err(Error::Picture { expected: 6144, found: 7 })));
    // Without a picture there is no film.
    assert_eq!(film.finish().expect("nothing").pictures, 0);
    assert!(!path.exists());
    #[cfg(target_os = "linux")]
    {
        let mut full = Film::create(Path::new("/dev/full"), &format(100)).expect("it opens");
        let pushed = (0..100).map(|k| full.push(picture(k))).find_map(Result::err);
        let error = pushed.or_else(|| full.finish().err()).expect("the disk is full").to_string();
        assert!(error.contains("cannot write /dev/full") && error.contains("No space"), "{error}");
    }
}
