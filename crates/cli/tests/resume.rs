//! Nothing is lost: a run that was killed, stopped, or ran out of room goes on, and ends as if nothing had happened.

mod common;

use common::{Place, error, expect, out, signal, wait_for};
use rockfall_cache::{CHECKPOINTS, Checkpoint, FRAMES, RunReader, SCENE, SUMMARY, Status, TRAJECTORY};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// Boxes fall into a heap, balls are poured on it.
const SCENE_TEXT: &str = r#"
[world]
frames = 300

[shapes.floor]
kind = "half-space"
[shapes.ball]
kind = "sphere"
radius = 0.2
[shapes.crate]
kind = "box"
size = [0.5, 0.4, 0.3]

[[bodies]]
shape = "floor"
[[generators]]
kind = "grid"
shape = "crate"
count = [4, 4, 3]
spacing = [0.6, 0.6, 0.6]
position = [0, 0, 2]
[[generators]]
kind = "pour"
shape = "ball"
count = 60
rate = 30
region = { min = [-1, -1, 6], max = [1, 1, 7] }
"#;

/// Everything that a run can write.
const ALL_OUTPUT: &str = "
[output]
position_error = 0.0001
rotation_error = 0.1
velocities = true
";

fn place() -> Place {
    Place::with("heap.toml", SCENE_TEXT)
}

fn begin(place: &Place, arguments: &str) -> Child {
    place.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// A whole run, and its hash.
fn whole(place: &Place) -> String {
    let run = place.rockfall("run heap.toml --out whole --hash --quiet --threads 1");
    expect(&run, 0);
    out(&run)
}

/// Goes on with `part` to its end, which is that of `whole`.
fn ends_as_the_whole(place: &Place, options: &str, hash: &str) {
    let run = place.rockfall(&format!("run --resume part --hash --quiet {options}"));
    expect(&run, 0);
    assert_eq!(out(&run), hash);
    same(&place.path("whole"), &place.path("part"));
}

/// The rows of `frames.csv` without what is the machine's: times of the stages, the memory, whose room goes with what was there before, and the checksums that cover them.
fn rows(run: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(run.join(FRAMES)).unwrap();
    let names: Vec<String> = text.lines().next().unwrap().split(',').map(str::to_owned).collect();
    let row = |line: &str| -> Vec<String> {
        let machine = |name: &str| name.ends_with("_ms") || ["memory_bytes", "checksum"].contains(&name);
        let cells = line.split(',').zip(&names).filter(|(_, name)| !machine(name));
        cells.map(|(cell, _)| cell.to_owned()).collect()
    };
    text.lines().map(row).collect()
}

/// Two finished runs are the same but for times.
fn same(whole: &Path, part: &Path) {
    let (a, b) = (RunReader::open(whole).unwrap(), RunReader::open(part).unwrap());
    assert_eq!((a.times().unwrap(), a.bodies().unwrap()), (b.times().unwrap(), b.bodies().unwrap()));
    for frame in 0..a.frames().unwrap() {
        let bits = |run: &RunReader| {
            let poses = run.poses(frame).unwrap();
            poses.positions.iter().chain(&poses.orientations).map(|x| x.to_bits()).collect::<Vec<u32>>()
        };
        assert!(bits(&a) == bits(&b), "frame {frame}");
    }
    assert_eq!(a.hashes().unwrap(), b.hashes().unwrap());
    assert_eq!(rows(whole), rows(part));
    let (a, b) = (a.summary(), b.summary());
    assert_eq!((&a.hash, &a.last, a.status, a.frames), (&b.hash, &b.last, b.status, b.frames));
    assert_eq!(a.whole.most_contacts, b.whole.most_contacts);
    assert_eq!(a.whole.deepest_penetration_m, b.whole.deepest_penetration_m);
    assert!(!part.join(CHECKPOINTS).exists(), "a finished run needs no checkpoints");
}

/// Every frame that a killed run says it has is that of the whole run.
fn is_readable(run: &Path, whole: &RunReader) -> u64 {
    // Killed before it had written anything.
    let Ok(reader) = RunReader::open(run) else { return 0 };
    let Ok(frames) = reader.frames() else { return 0 };
    for frame in (0..frames).step_by(17).chain(frames.checked_sub(1)) {
        assert_eq!(reader.poses(frame).unwrap().positions.len(), whole.poses(frame).unwrap().positions.len());
        let sum = |run: &RunReader| {
            run.poses(frame).unwrap().positions.iter().map(|x| u64::from(x.to_bits())).sum::<u64>()
        };
        assert_eq!(sum(&reader), sum(whole), "frame {frame}");
    }
    frames
}

/// Numbers from 0 to 1, the same in every run of the test.
fn random(i: u64) -> f64 {
    (rockfall::math::hash::mix(i) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Kills runs at `kills` moments, some of them several times, and goes on with each.
fn killed(kills: u64) {
    let place = Place::with("heap.toml", &format!("{SCENE_TEXT}{ALL_OUTPUT}"));
    let start = Instant::now();
    let hash = whole(&place);
    let length = start.elapsed();
    let whole = RunReader::open(&place.path("whole")).unwrap();
    let (mut done, mut runs, mut resumed) = (0, 0, 0);
    while done < kills {
        let _ = fs::remove_dir_all(place.path("part"));
        let mut arguments = "run heap.toml --out part --checkpoint-every 7".to_owned();
        for _ in 0..1 + runs % 3 {
            let mut child = begin(&place, &arguments);
            std::thread::sleep(length.mul_f64(random(1000 * kills + done)));
            let _ = child.kill();
            child.wait().unwrap();
            done += 1;
            is_readable(&place.path("part"), &whole);
            if RunReader::open(&place.path("part")).is_ok() {
                arguments = format!(
                    "run --resume part --checkpoint-every {} --threads {}",
                    1 + done % 9,
                    1 + done % 3
                );
                resumed += u64::from(!Checkpoint::all(&place.path("part")).unwrap().is_empty());
            } else {
                arguments = "run heap.toml --out part --overwrite --checkpoint-every 5".into();
                // Killed before it was a run at all.
                if !RunReader::is_run(&place.path("part")) {
                    let _ = fs::remove_dir_all(place.path("part"));
                }
            }
        }
        if RunReader::open(&place.path("part")).is_ok() {
            let lanes = [1, 4, 8, 16][runs as usize % 4];
            ends_as_the_whole(&place, &format!("--threads {} --lanes {lanes}", 1 + runs % 3), &hash);
        }
        runs += 1;
    }
    println!("{done} kills of {runs} runs, {resumed} with checkpoints");
    assert!(resumed > kills / 3, "{resumed} of {kills} had a checkpoint");
}

#[test]
fn a_run_that_is_killed_at_any_moment_goes_on() {
    killed(10);
}

#[test]
#[ignore = "some minutes: cargo test -p rockfall-cli --test resume -- --ignored"]
fn a_run_that_is_killed_at_a_hundred_moments_goes_on() {
    killed(100);
}

#[test]
fn an_interrupted_run_goes_on_from_where_it_was() {
    let place = place();
    let hash = whole(&place);
    let child = begin(&place, "run heap.toml --out part --quiet");
    wait_for("frame", || {
        RunReader::open(&place.path("part")).and_then(|run| run.frames()).is_ok_and(|frames| frames > 20)
    });
    // Nobody else may write into it meanwhile; it waits for them, lest it be done before.
    signal(&child, "-STOP");
    let second = place.rockfall("run --resume part");
    let third = place.rockfall("run heap.toml --out part --overwrite");
    signal(&child, "-INT");
    signal(&child, "-CONT");
    let ended = child.wait_with_output().unwrap();
    for refused in [second, third] {
        expect(&refused, 1);
        assert!(error(&refused).contains("part is in use by another run"), "{}", error(&refused));
    }
    expect(&ended, 130);
    let reader = RunReader::open(&place.path("part")).unwrap();
    assert_eq!(reader.summary().status, Status::Interrupted);
    let checkpoints = Checkpoint::all(&place.path("part")).unwrap();
    assert_eq!(checkpoints[0].frame, reader.summary().frames);
    ends_as_the_whole(&place, "--lanes 4", &hash);
    // Going on with what is finished is no failure, and changes nothing.
    let again = place.rockfall(&format!("run --resume part --hash --expect-hash {hash}"));
    expect(&again, 0);
    assert_eq!(out(&again), hash);
    expect(&place.rockfall("run --resume part --quiet --expect-hash 0123456789abcdef"), 4);
    same(&place.path("whole"), &place.path("part"));
}

/// A run that was killed when it had two checkpoints.
fn with_two_checkpoints() -> (Place, String) {
    let place = place();
    let hash = whole(&place);
    let mut child = begin(&place, "run heap.toml --out part --checkpoint-every 20 --quiet");
    wait_for("checkpoint", || Checkpoint::all(&place.path("part")).is_ok_and(|all| all.len() == 2));
    let _ = child.kill();
    child.wait().unwrap();
    assert_eq!(Checkpoint::all(&place.path("part")).unwrap().len(), 2);
    (place, hash)
}

fn damage(path: &Path, change: impl FnOnce(&mut Vec<u8>)) {
    let mut bytes = fs::read(path).unwrap();
    change(&mut bytes);
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_checkpoint_that_is_damaged_gives_way_to_the_one_before_it() {
    let (place, hash) = with_two_checkpoints();
    let all = Checkpoint::all(&place.path("part")).unwrap();
    let middle = |bytes: &mut Vec<u8>| {
        let at = bytes.len() / 2;
        bytes[at] ^= 1;
    };
    damage(&all[0].path, middle);
    let copy = place.path("copy");
    copy_folder(&place.path("part"), &copy);
    let run = place.rockfall("run --resume part --hash");
    expect(&run, 0);
    assert!(error(&run).contains("the checksum of"), "{}", error(&run));
    assert!(error(&run).contains(&format!("going on after frame {}", all[1].frame)), "{}", error(&run));
    assert_eq!(out(&run), hash);
    same(&place.path("whole"), &place.path("part"));

    // Both.
    fs::rename(&copy, place.path("part2")).unwrap();
    let all = Checkpoint::all(&place.path("part2")).unwrap();
    damage(&all[1].path, |bytes| bytes.truncate(5000));
    let frames = RunReader::open(&place.path("part2")).unwrap().frames().unwrap();
    let run = place.rockfall("run --resume part2");
    expect(&run, 1);
    let text = error(&run);
    assert!(text.contains("it ends within the column") && text.contains("--overwrite"), "{text}");
    assert_eq!(RunReader::open(&place.path("part2")).unwrap().frames().unwrap(), frames);
}

#[test]
fn a_checkpoint_of_another_scene_or_version_is_refused() {
    let (place, _) = with_two_checkpoints();
    let scene = place.path("part").join(SCENE);
    let text = fs::read_to_string(&scene).unwrap();
    fs::write(&scene, text.replace("0.4", "0.41")).unwrap();
    place.refuses("run --resume part", 1, "it belongs to a world with other scene.toml");
    fs::write(&scene, &text).unwrap();
    for checkpoint in Checkpoint::all(&place.path("part")).unwrap() {
        damage(&checkpoint.path, |bytes| bytes[12..16].copy_from_slice(&77_u32.to_ne_bytes()));
    }
    place.refuses("run --resume part", 1, "it has version 77");
    // What is no run can't go on.
    expect(&place.rockfall("run --resume nowhere"), 1);
    for arguments in [
        "run --resume part --frames 5",
        "run heap.toml --resume part",
        "run heap.toml --checkpoint-every soon",
    ] {
        expect(&place.rockfall(arguments), 2);
    }
}

#[test]
fn a_run_without_a_checkpoint_starts_again() {
    let place = place();
    let hash = whole(&place);
    let mut child = begin(&place, "run heap.toml --out part --checkpoint-every never --quiet");
    wait_for("frame", || {
        RunReader::open(&place.path("part")).and_then(|run| run.frames()).is_ok_and(|frames| frames > 20)
    });
    let _ = child.kill();
    child.wait().unwrap();
    ends_as_the_whole(&place, "", &hash);
}

/// A small file system in memory, for as long as it is kept.
struct Disk {
    path: PathBuf,
}

impl Disk {
    /// One of so many megabytes at the place's `disk`, or `None`, with a word of it, where a test may mount nothing.
    fn mount(place: &Place, megabytes: u32) -> Option<Disk> {
        let path = place.path("disk");
        fs::create_dir(&path).unwrap();
        let size = format!("size={megabytes}m");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&path).output();
        if mount.is_ok_and(|done| done.status.success()) {
            return Some(Disk { path });
        }
        let root = Command::new("id").arg("-u").output().is_ok_and(|id| id.stdout == b"0\n");
        assert!(
            !(root && std::env::var_os("CI").is_some()),
            "root could mount no file system, so no disk was filled"
        );
        println!("SKIPPED: this machine lets the test mount no file system, so no disk was filled");
        None
    }

    /// Makes it one that nobody may write to, or gives that back.
    fn allow(&self, what: &str) {
        let options = format!("remount,{what}");
        assert!(Command::new("mount").args(["-o", &options]).arg(&self.path).status().unwrap().success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.path).status();
    }
}

/// Runs in a file system of 3 MB that is filled to the brim.
#[test]
fn a_full_disk_stops_the_run_and_it_goes_on_when_there_is_room() {
    let place = place();
    let hash = whole(&place);
    let Some(disk) = Disk::mount(&place, 3) else { return };
    let whole = RunReader::open(&place.path("whole")).unwrap();
    let (part, filler) = (disk.path.join("part"), disk.path.join("filler"));
    let mut resumed = 0;
    for room in [500_000, 400_000, 300_000, 200_000, 100_000, 20_000, 0] {
        let _ = fs::remove_dir_all(&part);
        // Less is written where the disk is full earlier.
        let _ = fs::write(&filler, vec![1; (3 << 20) - room]);
        let run = place.rockfall("run heap.toml --out disk/part --checkpoint-every 3 --quiet");
        let text = error(&run);
        if run.status.success() {
            continue;
        }
        expect(&run, 1);
        assert!(text.contains("disk/part") && text.contains("free some space"), "{text}");
        is_readable(&part, &whole);
        // Without more room it fails again, and loses nothing.
        let again = place.rockfall("run --resume disk/part --quiet");
        assert!(!again.status.success());
        is_readable(&part, &whole);
        fs::remove_file(&filler).unwrap();
        if RunReader::open(&part).is_err() {
            continue;
        }
        let run = place.rockfall("run --resume disk/part --hash --quiet --checkpoint-every never");
        expect(&run, 0);
        assert_eq!(out(&run), hash);
        resumed += 1;
    }
    assert!(resumed >= 2, "{resumed} runs went on");
}

/// Nothing is lost where nobody may write; and the run goes on when somebody may.
#[test]
fn a_disk_that_is_read_only_is_told_of() {
    let place = place();
    let hash = whole(&place);
    let Some(disk) = Disk::mount(&place, 30) else { return };
    let mut child = begin(&place, "run heap.toml --out disk/part --checkpoint-every 20 --quiet");
    wait_for("checkpoint", || Checkpoint::all(&disk.path.join("part")).is_ok_and(|all| all.len() == 2));
    let _ = child.kill();
    child.wait().unwrap();
    disk.allow("ro");
    for arguments in ["run --resume disk/part --quiet", "run heap.toml --out disk/new --quiet"] {
        let refused = place.rockfall(arguments);
        expect(&refused, 1);
        let text = error(&refused);
        assert!(text.contains("disk/") && text.contains("you may write to"), "{text}");
    }
    assert!(is_readable(&disk.path.join("part"), &RunReader::open(&place.path("whole")).unwrap()) > 20);
    expect(&place.rockfall("verify disk/part"), 0);
    disk.allow("rw");
    let run = place.rockfall("run --resume disk/part --hash --quiet");
    expect(&run, 0);
    assert_eq!(out(&run), hash);
}

/// Promise: a run whose folder is gone says so, and makes no second one without a beginning.
#[test]
fn a_folder_that_is_removed_ends_the_run() {
    let place = place();
    let mut child = place
        .command("run heap.toml --out part --frames 100000 --checkpoint-every 20 --quiet")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let part = place.path("part");
    wait_for("frame", || RunReader::open(&part).and_then(|run| run.frames()).is_ok_and(|frames| frames > 20));
    fs::rename(&part, place.path("elsewhere")).unwrap();
    let mut text = String::new();
    std::io::Read::read_to_string(child.stderr.as_mut().unwrap(), &mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{text}");
    assert!(text.contains("part/") && text.contains("was the folder moved or removed?"), "{text}");
    assert!(!part.exists());
    assert!(RunReader::open(&place.path("elsewhere")).unwrap().frames().unwrap() > 20);
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_folder(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

#[test]
fn verify_and_diff_tell_what_is_wrong() {
    let (place, _) = with_two_checkpoints();
    let good = place.rockfall("verify whole");
    expect(&good, 0);
    assert!(out(&good).contains("301 frames and 0 checkpoints are whole"), "{}", out(&good));
    let part = place.rockfall("verify part");
    expect(&part, 0);
    assert!(out(&part).contains("and 2 checkpoints are whole"), "{}", out(&part));
    let info = place.rockfall("info part");
    assert!(out(&info).contains("checkpoints") && out(&info).contains("in 2 files"), "{}", out(&info));

    let wrong = |file: &Path, what: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let before = fs::read(file).unwrap();
        damage(file, |bytes| change(bytes));
        let verified = place.rockfall(if file.starts_with(place.path("whole")) {
            "verify whole"
        } else {
            "verify part"
        });
        expect(&verified, 1);
        assert!(error(&verified).contains(what), "{}", error(&verified));
        fs::write(file, before).unwrap();
    };
    let flip = |bytes: &mut Vec<u8>| {
        let at = bytes.len() / 2;
        bytes[at] ^= 0x10;
    };
    let whole = place.path("whole");
    // In a column its checksum tells, in a name or a length what can't be read.
    wrong(&Checkpoint::all(&place.path("part")).unwrap()[1].path, "frame-000000020 can't be used", &flip);
    wrong(&whole.join(TRAJECTORY).join("position/c.0.0.0"), "position", &flip);
    wrong(&whole.join(SUMMARY), "is damaged", &|bytes| bytes.truncate(100));
    wrong(&whole.join(FRAMES), "the row of frame 7", &|bytes| {
        let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
        *bytes = [&lines[..7], &lines[8..]].concat().concat();
    });
    wrong(&whole.join(FRAMES), "the summary has 300 frames", &|bytes| bytes.truncate(20_000));
    let scene = whole.join(SCENE);
    for at in [0, 9, 40, 200] {
        wrong(&scene, "its checksum is another one", &|bytes| bytes[at] ^= 0x01);
    }
    wrong(&whole.join(TRAJECTORY).join("hash/zarr.json"), "its checksum is another one", &|bytes| {
        let at = bytes.windows(7).position(|word| word == b"\"shape\"").unwrap() + 10;
        bytes[at] = b'2';
    });
    expect(&place.rockfall("verify whole"), 0);

    let same = place.rockfall("diff whole whole");
    expect(&same, 0);
    assert!(out(&same).contains("301 frames are the same"), "{}", out(&same));
    let shorter = place.rockfall("diff whole part");
    expect(&shorter, 4);
    assert!(out(&shorter).contains("the same as far as they go: 301 and"), "{}", out(&shorter));
    expect(&place.rockfall("run heap.toml --out other --substeps 5 --quiet"), 0);
    let other = place.rockfall("diff whole other");
    expect(&other, 4);
    assert!(out(&other).contains("frame 1: body 2 is the first of 48 that differ, by"), "{}", out(&other));
}

/// One byte of each kind of file is altered, at many places: going on, the run is refused or ends as it should.
#[test]
fn altered_bytes_are_an_error_or_change_nothing() {
    let (place, hash) = with_two_checkpoints();
    let copy = place.path("copy");
    fs::rename(place.path("part"), &copy).unwrap();
    let last = Checkpoint::all(&copy).unwrap()[0].clone();
    let name = |path: &Path| path.strip_prefix(&copy).unwrap().to_owned();
    let kinds = [
        PathBuf::from(SUMMARY),
        PathBuf::from(FRAMES),
        name(&last.path),
        Path::new(TRAJECTORY).join("zarr.json"),
    ];
    let mut refused = 0;
    for (kind, case) in kinds.iter().flat_map(|kind| (0..6).map(move |case| (kind, case))) {
        let _ = fs::remove_dir_all(place.path("part"));
        copy_folder(&copy, &place.path("part"));
        damage(&place.path("part").join(kind), |bytes| {
            let at = (random(case) * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << (case % 8);
        });
        let run = place.rockfall("run --resume part --hash --quiet");
        match run.status.code() {
            Some(0) => assert_eq!(out(&run), hash, "{}", kind.display()),
            Some(1 | 3) => refused += 1,
            other => panic!("{other:?} with {}: {}", kind.display(), error(&run)),
        }
    }
    assert!(refused > 0);
}
