//! What a run on disk promises.

use crate::synthetic;
use rockfall_cache::{Error, FRAMES, LOCK, Poses, RunFolder, RunReader, SCENE, SUMMARY, Status, TRAJECTORY};
use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

fn same_bits(a: &Poses, b: &Poses) -> bool {
    let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    bits(&a.positions) == bits(&b.positions) && bits(&a.orientations) == bits(&b.orientations)
}

fn expected(bodies: usize, frame: u64) -> Poses {
    let (ids, poses) = synthetic::state(bodies, frame);
    let mut expected = Poses::default();
    expected.gather(&synthetic::table(bodies), synthetic::ORIGIN, &ids, &poses).unwrap();
    expected
}

#[test]
fn every_value_reads_back() {
    // No body, one, some, and more than a chunk with the last one not full.
    for (bodies, frames) in [(0, 2), (1, 1), (10, 7), (3000, 35), (20_000, 3), (70_001, 3)] {
        let folder = tempfile::tempdir().unwrap();
        let written = synthetic::write(folder.path(), bodies, frames).unwrap();
        assert_eq!(written.frames, frames);
        let run = RunReader::open(folder.path()).unwrap();
        assert_eq!(run.summary().status, Status::Finished);
        assert_eq!(run.frames().unwrap(), frames);
        assert_eq!(run.bodies().unwrap(), synthetic::table(bodies));
        assert_eq!(run.origin().unwrap(), synthetic::ORIGIN);
        assert_eq!(run.times().unwrap(), (0..frames).map(synthetic::time).collect::<Vec<_>>());
        for frame in 0..frames {
            assert!(same_bits(&run.poses(frame).unwrap(), &expected(bodies, frame)), "{bodies} at {frame}");
            assert_eq!(run.velocities(frame).unwrap(), None);
        }
        assert_eq!(run.hashes().unwrap(), (0..frames).collect::<Vec<_>>());
        assert!(matches!(run.poses(frames), Err(Error::NoFrame { .. })));
        let rows = fs::read_to_string(folder.path().join(FRAMES)).unwrap();
        assert_eq!(rows.lines().count() as u64, frames, "a header and a row for each step");
        assert_eq!(fs::read_to_string(folder.path().join(SCENE)).unwrap(), "seed = 1\n");
        let parts = run.parts().unwrap();
        assert_eq!(
            parts.iter().map(|part| part.name).collect::<Vec<_>>(),
            [SCENE, SUMMARY, FRAMES, TRAJECTORY]
        );
        assert!(parts.iter().all(|part| part.files > 0 && part.bytes > 0));
    }
}

#[test]
fn more_frames_than_a_chunk_of_times() {
    let folder = tempfile::tempdir().unwrap();
    synthetic::write(folder.path(), 1, 1030).unwrap();
    let run = RunReader::open(folder.path()).unwrap();
    assert_eq!(run.times().unwrap(), (0..1030).map(synthetic::time).collect::<Vec<_>>());
    assert!(same_bits(&run.poses(1029).unwrap(), &expected(1, 1029)));
}

#[test]
fn a_run_that_was_cut_off_reads_up_to_its_last_complete_frame() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = 20_000;
    let [before, after] = ["before", "after"].map(|name| folder.path().join(name));
    synthetic::write(&before, bodies, 5).unwrap();
    synthetic::write(&after, bodies, 6).unwrap();
    // The state after a kill between the files of frame 5: its position is there, even announced, the rest is not.
    for name in ["c.0.0.0", "c.0.1.0", "zarr.json"] {
        let name = Path::new(TRAJECTORY).join("position").join(name);
        fs::copy(after.join(&name), before.join(&name)).unwrap();
    }
    fs::write(before.join(TRAJECTORY).join("orientation/.zarr.json.part"), "{").unwrap();

    let run = RunReader::open(&before).unwrap();
    assert_eq!(run.frames().unwrap(), 5);
    assert!(same_bits(&run.poses(4).unwrap(), &expected(bodies, 4)));
    assert!(matches!(run.poses(5), Err(Error::NoFrame { frame: 5, frames: 5 })));
}

#[test]
fn a_run_is_readable_while_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = 3000;
    let mut writer = synthetic::start(folder.path(), bodies).unwrap();
    let mut seen = 0;
    for index in 0..50 {
        let frame = synthetic::frame(&writer, bodies, index);
        writer.push(frame).unwrap();
        let run = RunReader::open(folder.path()).unwrap();
        assert_eq!(run.summary().status, Status::Running);
        let frames = run.frames().unwrap();
        assert!(frames >= seen);
        if frames > seen {
            assert!(same_bits(&run.poses(frames - 1).unwrap(), &expected(bodies, frames - 1)));
        }
        seen = frames;
    }
    assert!(seen > 0, "nothing was to be seen before the end");
    assert_eq!(writer.finish().unwrap().frames, 50);
}

#[test]
fn a_frame_is_seen_soon_even_when_no_other_follows() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = synthetic::start(folder.path(), 10).unwrap();
    let frame = synthetic::frame(&writer, 10, 0);
    writer.push(frame).unwrap();
    let run = RunReader::open(folder.path()).unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    while run.frames().unwrap() == 0 {
        assert!(Instant::now() < deadline, "the frame was not written");
        thread::sleep(Duration::from_millis(20));
    }
    assert!(same_bits(&run.poses(0).unwrap(), &expected(10, 0)));
}

#[test]
fn a_removed_folder_comes_back_as_an_error_that_names_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let mut writer = synthetic::start(&path, 10).unwrap();
    let first = synthetic::frame(&writer, 10, 0);
    writer.push(first).unwrap();
    fs::rename(&path, folder.path().join("elsewhere")).unwrap();
    let error = (1..1000)
        .find_map(|index| {
            // A chunk of few bodies waits a while for more frames.
            thread::sleep(Duration::from_millis(5));
            let frame = synthetic::frame(&writer, 10, index);
            writer.push(frame).err()
        })
        .expect("the writer never noticed");
    let text = error.to_string();
    assert!(text.contains(&path.join(TRAJECTORY).display().to_string()), "{text}");
    assert!(text.contains("was the folder moved or removed?"), "{text}");
    assert!(!path.exists(), "half a run was made anew");
}

#[test]
fn a_former_run_is_replaced_on_request_only_and_other_files_stay() {
    let folder = tempfile::tempdir().unwrap();
    synthetic::write(folder.path(), 10, 5).unwrap();
    fs::write(folder.path().join("notes.txt"), "keep me").unwrap();
    let refused = RunFolder::at(folder.path(), false).unwrap_err();
    assert!(refused.to_string().ends_with("replace that run with --overwrite"), "{refused}");
    assert_eq!(RunReader::open(folder.path()).unwrap().frames().unwrap(), 5);
    RunFolder::at(folder.path(), true).unwrap();
    let mut left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, [LOCK, "notes.txt"]);
}

#[test]
fn damage_is_an_error_that_names_the_part() {
    let folder = tempfile::tempdir().unwrap();
    synthetic::write(folder.path(), 20_000, 17).unwrap();
    let trajectory = folder.path().join(TRAJECTORY);
    let chunk = trajectory.join("position/c.1.0.0");
    let mut bytes = fs::read(&chunk).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    fs::write(&chunk, bytes).unwrap();
    let run = RunReader::open(folder.path()).unwrap();
    assert!(run.poses(0).is_ok());
    let error = run.poses(16).unwrap_err();
    assert!(matches!(&error, Error::Damaged { path, .. } if *path == chunk), "{error}");
    fs::remove_file(&chunk).unwrap();
    assert!(matches!(run.poses(16), Err(Error::Damaged { path, .. }) if path == chunk));

    let metadata = trajectory.join("time/zarr.json");
    fs::write(&metadata, "{").unwrap();
    assert!(matches!(run.frames(), Err(Error::Damaged { path, .. }) if path == metadata));
    fs::remove_dir_all(&trajectory).unwrap();
    assert!(matches!(RunReader::open(folder.path()), Err(Error::NotARun { missing: TRAJECTORY, .. })));
    fs::remove_file(folder.path().join(SUMMARY)).unwrap();
    assert!(matches!(RunReader::open(folder.path()), Err(Error::NotARun { missing: SUMMARY, .. })));
}
