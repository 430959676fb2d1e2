//! Whatever happens to the bytes of a run, it is told, or nothing changes.

use crate::synthetic::{self, everything};
use rockfall_cache::{
    BodyTable, Checkpoint, Contacts, Error, Event, FRAMES, Poses, RunReader, SCENE, START, STATE, Start,
    State, Summary, Velocities, checksum, csv,
};
use rockfall_math::hash::mix;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

/// Everything that can be read of a run.
#[derive(Debug, PartialEq)]
struct Everything {
    summary: Summary,
    table: BodyTable,
    times: Vec<f64>,
    hashes: Vec<u64>,
    precision: rockfall_cache::Precision,
    origin: [f64; 3],
    rows: Vec<csv::Row>,
    frames: Vec<(Bits, Bits)>,
    history: Bits,
    extras: Vec<(Contacts, Vec<Event>)>,
    columns: String,
    end: Option<State>,
    start: Option<Start>,
    checkpoints: Vec<(u64, Vec<(String, u64)>)>,
}

/// Numbers by their bits, so that NaN equals itself.
type Bits = Vec<u32>;

fn bits(numbers: [&[f32]; 2]) -> Bits {
    numbers.iter().flat_map(|numbers| numbers.iter().map(|x| x.to_bits())).collect()
}

fn read(path: &Path) -> Result<Everything, Error> {
    let run = RunReader::open(path)?;
    let frame = |frame| {
        let Poses { positions, orientations } = run.poses(frame)?;
        let Velocities { linear, angular } = run.velocities(frame)?.unwrap_or_default();
        Ok((bits([&positions, &orientations]), bits([&linear, &angular])))
    };
    let history = run.history(3)?;
    let (contacts, events) = (run.contacts()?, run.events()?);
    let extra = |frame| {
        let contacts = contacts.as_ref().map(|contacts| contacts.at(frame)).transpose()?;
        let events = events.as_ref().map(|events| events.at(frame)).transpose()?;
        Ok((contacts.unwrap_or_default(), events.unwrap_or_default()))
    };
    let mut columns = String::new();
    for column in run.columns()? {
        let reader = run.column(&column)?;
        for frame in 0..run.frames()? {
            // As text, in which NaN equals itself.
            columns += &format!("{column:?} {:?}", reader.at(frame)?);
        }
    }
    let checkpoints = Checkpoint::all(path)?;
    let checkpoints = checkpoints.iter().map(|checkpoint| Ok((checkpoint.frame, checkpoint.verify()?)));
    Ok(Everything {
        summary: run.summary().clone(),
        table: run.bodies()?,
        times: run.times()?,
        hashes: run.hashes()?,
        precision: run.precision()?,
        origin: run.origin()?.to_array(),
        rows: csv::read(&path.join(FRAMES))?,
        frames: (0..run.frames()?).map(frame).collect::<Result<_, Error>>()?,
        history: bits([&history.positions, &history.orientations]),
        extras: (0..run.frames()?).map(extra).collect::<Result<_, Error>>()?,
        columns,
        end: run.end()?,
        start: Start::read(&path.join(START))?,
        checkpoints: checkpoints.collect::<Result<_, Error>>()?,
    })
}

/// All files of a run but the lock and the scene, which its reader leaves alone.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else if !path.ends_with(".lock") && !path.ends_with(SCENE) {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// Promise: a file of any kind that lost a bit, many bits, its end, or all of itself is an error, or it reads as before: never another
/// pose, and never a panic.
#[test]
fn damage_of_any_file_is_told_or_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut refused = 0;
    for (kind, path) in ["lossless", "everything"].map(|kind| (kind, folder.path().join(kind))) {
        if kind == "everything" {
            synthetic::write_everything(&path, 40, 12).unwrap();
            let run = RunReader::open(&path).unwrap();
            let state = State { hash: 11, ..State::of_run(&run, 11).unwrap() };
            state.write(&path.join(STATE)).unwrap();
            let (scene, state) = ("seed = 2\n".to_owned(), State { frame: 5, ..state });
            let first = Start { run: "first".into(), scene, last_id: 99, state, start: None };
            let second = Start { run: "second".into(), start: Some(Box::new(first.clone())), ..first };
            second.write(&path.join(START)).unwrap();
        } else {
            synthetic::write(&path, 40, 12).unwrap();
        }
        Checkpoint::write(&path, 7, |to| to.column("numbers", &[7_u64; 300])).unwrap();
        let whole = read(&path).unwrap();
        assert_eq!(whole.precision == everything().precision, kind == "everything");
        let files = files(&path);
        assert!(files.len() >= 20, "{files:?}");
        for file in files {
            let good = fs::read(&file).unwrap();
            let mut cases: Vec<(String, Option<Vec<u8>>)> = vec![
                ("removed".into(), None),
                ("emptied".into(), Some(Vec::new())),
                ("cut in half".into(), Some(good[..good.len() / 2].to_vec())),
                ("without its last byte".into(), Some(good[..good.len() - 1].to_vec())),
                ("doubled".into(), Some([&good[..], &good].concat())),
                ("all ones".into(), Some(vec![0xff; good.len()])),
            ];
            for case in 0..24 {
                // The first and the last bytes, and others all over the file.
                let at = match case {
                    0..4 => case.min(good.len() - 1),
                    4..8 => good.len().saturating_sub(case - 3),
                    _ => mix(case as u64) as usize % good.len(),
                };
                let mut bad = good.clone();
                bad[at] ^= if case % 3 == 2 { 0xff } else { 1 << (case % 8) };
                cases.push((format!("byte {at}, case {case}"), Some(bad)));
            }
            for (what, bad) in cases {
                match bad {
                    Some(bad) => fs::write(&file, bad).unwrap(),
                    None => fs::remove_file(&file).unwrap(),
                }
                let outcome = catch_unwind(|| read(&path));
                let name = file.strip_prefix(&path).unwrap().display();
                match outcome.unwrap_or_else(|_| panic!("{kind}: {name}, {what}: a panic")) {
                    Err(_) => refused += 1,
                    // The end of a table of rows that was cut off can't be told from that of a run that was killed; and
                    // a checkpoint that is gone is one that was not taken.
                    Ok(other) if file.ends_with(FRAMES) => {
                        assert!(whole.rows.starts_with(&other.rows), "{kind}: {what}")
                    }
                    Ok(other) if what == "removed" && name.to_string().contains("frame-") => {
                        assert!(other.checkpoints.is_empty());
                    }
                    Ok(other) => assert!(other == whole, "{kind}: {name}, {what}: something else was read"),
                }
            }
            fs::write(&file, good).unwrap();
        }
        assert!(read(&path).unwrap() == whole);
    }
    assert!(refused > 500, "{refused}");
}

#[test]
fn a_checksum_tells_texts_apart() {
    assert_eq!(checksum(b"seed = 1\n"), checksum(b"seed = 1\n"));
    assert_ne!(checksum(b"seed = 1\n"), checksum(b"seed = 2\n"));
    assert_eq!(checksum(b"").len(), 16);
}
