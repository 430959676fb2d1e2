//! The targets, fed without a fuzzer: the same inputs on every machine.
//!
//! Nothing may take longer than [`PATIENCE`]: what does not end is stopped with the number of its input.

use rockfall_cache::{
    BodyTable, Column, Contacts, Contents, Event, EventKind, FORMAT, Frame, NumberType, RunFolder, RunWriter,
    START, STATE, Start, State, Summary, VERSION, Values, WantedContacts, WantedEvents,
};
use rockfall_fuzz::{
    IMPORTS, MESH_FILES, checkpoint, good_checkpoint, hull, import, mesh, mesh_file, pair, run_folder, scene,
};
use rockfall_math::{DVec3, Pose, hash};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;

/// For one input.
const PATIENCE: Duration = Duration::from_secs(60);

struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        hash::mix(self.0)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.word() % count.max(1) as u64) as usize
    }

    fn bytes(&mut self, most: usize) -> Vec<u8> {
        (0..self.below(most + 1)).map(|_| self.word() as u8).collect()
    }

    /// Something that was right, with a few changes: bytes turned, cut out, doubled, or taken from elsewhere.
    fn spoilt(&mut self, right: &[u8]) -> Vec<u8> {
        let mut bytes = right.to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            let length = self.below(20).min(bytes.len() - at);
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..at + length)),
                2 => {
                    let copy = bytes[at..at + length].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, copy);
                }
                3 => {
                    let other = self.bytes(12);
                    bytes.splice(at..at + length, other);
                }
                _ if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                _ => {}
            }
        }
        bytes
    }
}

/// Calls `target` so many times, each in its own number.
fn drive(name: &'static str, count: u64, target: impl Fn(&mut Random) + Send + 'static) {
    let (said, heard) = channel();
    let thread = std::thread::spawn(move || {
        for number in 0..count {
            said.send(number).expect("somebody listens");
            target(&mut Random(number << 20));
        }
    });
    let mut last = None;
    loop {
        match heard.recv_timeout(PATIENCE) {
            Ok(number) => last = Some(number),
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                panic!("{name} does not end with input {last:?}")
            }
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
        }
    }
    if thread.join().is_err() {
        panic!("{name} breaks with input {last:?}");
    }
}

#[test]
fn hulls() {
    drive("hull", 4000, |random| hull(&random.bytes(600)));
}

#[test]
fn meshes() {
    drive("mesh", 4000, |random| mesh(&random.bytes(800)));
}

#[test]
fn pairs() {
    drive("pair", 20_000, |random| pair(&(0..400).map(|_| random.word() as u8).collect::<Vec<u8>>()));
}

fn shipped(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let entries = std::fs::read_dir(&folder).expect("the folder is there");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a file").path()).collect();
    paths.sort();
    let right = |path: &PathBuf| path.extension().is_some_and(|found| found == ending);
    paths.iter().filter(|path| right(path)).map(|path| std::fs::read(path).expect("a file")).collect()
}

/// Changes of the scenes that ship with the program, of which most are errors, and text that is none.
#[test]
fn scenes() {
    let scenes = shipped("scenes", "toml");
    drive("scene", 600, move |random| {
        let k = random.below(scenes.len() + 1);
        let text = if k < scenes.len() { random.spoilt(&scenes[k]) } else { random.bytes(300) };
        scene(&text);
    });
}

/// A tetrahedron in each format.
fn right(ending: &str) -> Vec<u8> {
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0_u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let lines = |mark: &str, one: u32| {
        let v: String = corners.iter().map(|c| format!("{mark}{} {} {}\n", c[0], c[1], c[2])).collect();
        let f = |f: &[u32; 3]| {
            format!("{}{} {} {}\n", if one == 1 { "f " } else { "3 " }, f[0] + one, f[1] + one, f[2] + one)
        };
        v + &faces.iter().map(f).collect::<String>()
    };
    let floats: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let indices: Vec<u8> = faces.iter().flatten().flat_map(|&i| (i as u16).to_le_bytes()).collect();
    let json = |uri: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\
             \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}}]}}],\
             \"buffers\":[{{\"byteLength\":72{uri}}}],\
             \"bufferViews\":[{{\"buffer\":0,\"byteLength\":48}},{{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24}}],\
             \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\
             \"min\":[0,0,0],\"max\":[1,1,1]}},{{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}}]}}"
        )
    };
    match ending {
        "obj" => lines("v ", 1).into_bytes(),
        "ply" => format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 4\nproperty list uchar int vertex_indices\nend_header\n{}",
            lines("", 0)
        )
        .into_bytes(),
        "stl" => {
            let mut bytes = vec![0; 80];
            bytes.extend(4_u32.to_le_bytes());
            for face in faces {
                bytes.extend([0_u8; 12]);
                bytes.extend(face.iter().flat_map(|&i| corners[i as usize]).flat_map(f32::to_le_bytes));
                bytes.extend([0_u8; 2]);
            }
            bytes
        }
        "glb" => {
            let (mut text, mut data) = (json("").into_bytes(), [floats, indices].concat());
            text.resize(text.len().next_multiple_of(4), b' ');
            data.resize(data.len().next_multiple_of(4), 0);
            let chunk = |kind: &[u8; 4], bytes: &[u8]| {
                [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat()
            };
            let body = [chunk(b"JSON", &text), chunk(b"BIN\0", &data)].concat();
            let length = (12 + body.len()) as u32;
            [&b"glTF"[..], &2_u32.to_le_bytes(), &length.to_le_bytes(), &body].concat()
        }
        _ => json(",\"uri\":\"data:application/octet-stream;base64,AAAA\"").into_bytes(),
    }
}

#[test]
fn mesh_files() {
    let folder = tempfile::tempdir().expect("a folder");
    drive("mesh_file", 3000, move |random| {
        let ending = MESH_FILES[random.below(MESH_FILES.len())];
        let bytes = if random.below(8) == 0 { random.bytes(300) } else { random.spoilt(&right(ending)) };
        mesh_file(folder.path(), ending, &bytes);
    });
}

#[test]
fn imports() {
    let folder = tempfile::tempdir().expect("a folder");
    let stage = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stages/chute.usda");
    let stage = std::fs::read(stage).expect("the stage that ships");
    drive("import", 600, move |random| {
        let ending = IMPORTS[random.below(IMPORTS.len())];
        let right = if ending.starts_with("usd") { stage.clone() } else { right(ending) };
        let bytes = if random.below(8) == 0 { random.bytes(300) } else { random.spoilt(&right) };
        import(folder.path(), ending, &bytes);
    });
}

#[test]
fn checkpoints() {
    let good = good_checkpoint();
    checkpoint(&good);
    drive("checkpoint", 1500, move |random| {
        let bytes = if random.below(8) == 0 { random.bytes(300) } else { random.spoilt(&good) };
        checkpoint(&bytes);
    });
}

/// A run of three bodies and a few frames.
fn write_run(path: &Path) {
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

/// Every file of a run with a few changes.
#[test]
fn runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run");
    write_run(&run);
    let mut files = Vec::new();
    let mut folders = vec![run.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("it is there") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    run_folder(&run);
    drive("run_folder", 1500, move |random| {
        let _ = &folder;
        let file = &files[random.below(files.len())];
        let right = std::fs::read(file).expect("a file");
        std::fs::write(file, random.spoilt(&right)).expect("room for a file");
        run_folder(&run);
        std::fs::write(file, right).expect("room for a file");
    });
}
