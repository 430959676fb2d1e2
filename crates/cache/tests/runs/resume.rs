//! A run that ended early goes on, and its folder becomes that of one that did not.

use crate::synthetic::{
    ORIGIN, everything, fill, frame, full_frame, start, start_with, summary, table, write,
};
use rockfall_cache::{Contents, Error, FRAMES, RunFolder, RunReader, RunWriter, SUMMARY, TRAJECTORY};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// All files at and below a folder by name, without those that tell times or locks.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(below, content)| (format!("{name}/{below}"), content)));
        } else if name != SUMMARY && name != ".lock" {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

fn resume(path: &Path, bodies: usize, at: u64, hash: u64) -> Result<RunWriter, Error> {
    RunWriter::resume(&RunFolder::of_run(path)?, &summary(), &table(bodies), at, hash)
}

/// Promise: wherever a run goes on, after however many frames it ended, its folder becomes the same to the byte.
#[test]
fn a_resumed_run_is_that_of_one_that_was_not_interrupted() {
    let place = tempfile::tempdir().unwrap();
    // Chunks of 256, 32 and 16 frames, and of several in a frame; times go over a chunk of 1024.
    for (bodies, frames, cases) in [
        (3, 1100, &[(0, 1), (255, 300), (256, 257), (700, 701), (1023, 1090), (1024, 1025)][..]),
        (3000, 40, &[(0, 5), (31, 33), (32, 32), (39, 40)]),
        (20_000, 18, &[(0, 2), (15, 17)]),
    ] {
        for (kind, contents, frame) in [
            ("lossless", Contents::from(ORIGIN), frame as fn(&_, _, _) -> _),
            ("everything", everything(), full_frame),
        ] {
            let whole = place.path().join(format!("whole-{bodies}-{kind}"));
            fill(start_with(&whole, bodies, contents.clone()).unwrap(), &whole, bodies, 0..frames, frame)
                .unwrap();
            for &(at, ended) in cases {
                let path = place.path().join(format!("part-{bodies}-{at}-{kind}"));
                let mut writer = start_with(&path, bodies, contents.clone()).unwrap();
                for index in 0..ended.max(at + 1) {
                    let frame = frame(&writer, bodies, index);
                    writer.push(frame).unwrap();
                }
                writer.sync().unwrap();
                drop(writer);
                let writer = resume(&path, bodies, at, at).unwrap();
                assert_eq!(RunReader::open(&path).unwrap().frames().unwrap(), at + 1);
                fill(writer, &path, bodies, at + 1..frames, frame).unwrap();
                let (expected, found) = (files(&whole), files(&path));
                assert!(expected.keys().eq(found.keys()), "{bodies} bodies from {at}");
                for (name, content) in &expected {
                    assert!(found[name] == *content, "{name} of {bodies} bodies from {at}, {kind}");
                }
            }
        }
    }
    assert_eq!(RunReader::open(&place.path().join("part-3-0-everything")).unwrap().origin().unwrap(), ORIGIN);
}

/// Promise: a run whose frames don't fit the checkpoint is left as it is, and told what is missing.
#[test]
fn a_run_that_does_not_fit_is_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("run");
    write(&path, 3, 20).unwrap();
    let before = files(&path);
    let refused = |at, hash, bodies, file: &str| {
        let error = resume(&path, bodies, at, hash).unwrap_err();
        assert!(matches!(&error, Error::Damaged { path, .. } if path.ends_with(file)), "{error}");
        assert_eq!(files(&path), before);
    };
    refused(20, 20, 3, FRAMES);
    refused(10, 11, 3, FRAMES);
    refused(10, 10, 4, TRAJECTORY);
    let rows = fs::read_to_string(path.join(FRAMES)).unwrap();
    let torn: String = rows.lines().take(10).map(|line| format!("{line}\n")).collect::<String>() + "10,0.1";
    fs::write(path.join(FRAMES), torn).unwrap();
    assert!(resume(&path, 3, 10, 10).is_err());
    assert!(resume(&path, 3, 9, 9).is_ok());
}

/// Promise: nobody else writes into the folder meanwhile.
#[test]
fn two_runs_never_share_a_folder() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("run");
    let writer = start(&path, 3).unwrap();
    assert!(matches!(RunFolder::at(&path, true), Err(Error::Locked(_))));
    assert!(matches!(resume(&path, 3, 0, 0), Err(Error::Locked(_))));
    writer.finish().unwrap();
    RunFolder::at(&path, true).unwrap();
}
