//! Runs with files of any content.

use rockfall::math::{DVec3, Pose};
use rockfall_cache::{
    BodyTable, Checkpoint, Column, Contacts, Contents, Event, EventKind, FORMAT, Frame, NumberType,
    RunFolder, RunReader, RunWriter, START, STATE, Start, State, Summary, VERSION, Values, WantedContacts,
    WantedEvents,
};
use std::path::{Path, PathBuf};

/// A run as it should be: three bodies, a few frames, and all that a run can hold.
#[derive(Debug)]
pub struct GoodRun {
    folder: PathBuf,
    /// In the order of their names, with what is in them.
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl GoodRun {
    /// Writes it to a folder `run` in `parent`.
    pub fn write(parent: &Path) -> Self {
        let folder = parent.join("run");
        write(&folder);
        let mut files = Vec::new();
        let mut folders = vec![folder.clone()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("it is there") {
                let path = entry.expect("an entry").path();
                if path.is_dir() { folders.push(path) } else { files.push(path) }
            }
        }
        files.sort();
        let files = files.into_iter().map(|path| {
            let bytes = std::fs::read(&path).expect("a file that was written");
            (path, bytes)
        });
        Self { folder, files: files.collect() }
    }

    /// How many files it has.
    pub fn files(&self) -> usize {
        self.files.len()
    }

    /// What is in a file, of which the last follows the first again.
    pub fn file(&self, k: usize) -> &[u8] {
        &self.files[k % self.files.len()].1
    }

    /// Reads all of the run while the file has other `bytes`: there are errors, or what is there.
    pub fn with(&self, k: usize, bytes: &[u8]) {
        let (path, right) = &self.files[k % self.files.len()];
        std::fs::write(path, bytes).expect("room for a file");
        read(&self.folder);
        std::fs::write(path, right).expect("room for a file");
    }
}

/// Reads all of the run with `bytes` in one of its files. The first tells in which, the second whether they take the place of others or of all that follows, and two more
/// from where on.
pub fn run_file(run: &GoodRun, bytes: &[u8]) {
    let Some((&[file, way, low, high], rest)) = bytes.split_first_chunk() else { return };
    let right = run.file(usize::from(file));
    let at = usize::from(u16::from_le_bytes([low, high])) % (right.len() + 1);
    let behind = if way.is_multiple_of(2) { (at + rest.len()).min(right.len()) } else { right.len() };
    run.with(usize::from(file), &[&right[..at], rest, &right[behind..]].concat());
}

/// Reads all of a run.
fn read(folder: &Path) {
    for checkpoint in Checkpoint::all(folder).into_iter().flatten() {
        let _ = checkpoint.verify();
    }
    let Ok(reader) = RunReader::open(folder) else { return };
    let _ = (reader.times(), reader.origin(), reader.bodies(), reader.parts());
    let _ = (reader.end(), Start::read(&folder.join(START)));
    let (contacts, events) = (reader.contacts().ok().flatten(), reader.events().ok().flatten());
    let columns = reader.columns().unwrap_or_default();
    let columns: Vec<_> = columns.iter().filter_map(|column| reader.column(column).ok()).collect();
    for frame in 0..reader.frames().unwrap_or(0).min(4) {
        let _ = (reader.poses(frame), reader.velocities(frame));
        let _ = (contacts.as_ref().map(|all| all.at(frame)), events.as_ref().map(|all| all.at(frame)));
        columns.iter().for_each(|column| drop(column.at(frame)));
    }
}

fn write(path: &Path) {
    let table = BodyTable {
        ids: vec![0, 1, 2],
        names: vec![String::new(); 3],
        shapes: vec![0; 3],
        scales: vec![1.0; 3],
    };
    let summary = Summary {
        format: FORMAT.into(),
        format_version: VERSION,
        frames_per_second: 60.0,
        ..Summary::default()
    };
    let folder = RunFolder::at(path, false).expect("a folder");
    let column = Column {
        name: "heat".into(),
        numbers: NumberType::U32,
        units: "1".into(),
        description: String::new(),
    };
    let contents = Contents {
        velocities: true,
        contacts: Some(WantedContacts { every: 1, force: 0.0, friction: true }),
        events: Some(WantedEvents { sensors: true, touches: true, hits: Some(1.0) }),
        columns: vec![column],
        ..Contents::default()
    };
    let mut writer = RunWriter::create(&folder, "seed = 1\n", &summary, &table, contents).expect("a run");
    for frame in 0..5_u32 {
        let mut poses = writer.buffer();
        let ids: Vec<_> = (0..3).map(rockfall::BodyId).collect();
        let at = |k: u32| Pose::at(DVec3::new(f64::from(k), f64::from(frame), 0.0));
        poses.gather(&table, DVec3::ZERO, &ids, &[at(0), at(1), at(2)]).expect("all are in the table");
        writer
            .push(Frame {
                time: f64::from(frame),
                poses,
                contacts: Contacts {
                    a: vec![0],
                    b: vec![1],
                    positions: vec![[0.0; 3]],
                    normals: vec![[1.0, 0.0, 0.0]],
                    distances: vec![-0.5],
                    forces: vec![2.0],
                    frictions: vec![[0.0, 1.0, 0.0]],
                },
                events: vec![Event { kind: EventKind::Hit, a: 0, b: 1, impulse: 3.0 }],
                columns: vec![Values::U32(vec![frame; 3])],
                ..Frame::default()
            })
            .expect("a frame");
    }
    writer.sync().expect("all frames");
    let (ids, poses, velocities) = (vec![7], vec![Pose::default()], vec![Default::default()]);
    let state = State { ids, poses, velocities, ..State::default() };
    state.write(&path.join(STATE)).expect("a state");
    Start { last_id: 7, state, ..Start::default() }.write(&path.join(START)).expect("a start");
}
