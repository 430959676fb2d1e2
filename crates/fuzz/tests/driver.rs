//! The targets, fed without a fuzzer: the same inputs on every machine.
//!
//! Nothing may take longer than [`PATIENCE`]: what does not end is stopped with the number of its input.
//!
//! Each target gets as many inputs as take a second or a few. `ROCKFALL_FUZZ_SECONDS=30` goes on with each for half a minute at least, two of them
//! at a time on two processors; `ROCKFALL_FUZZ_FROM=1000` begins with the input of that number, as it is named when something breaks.

use rockfall_fuzz::{
    GoodRun, IMPORTS, MESH_FILES, checkpoint, good_checkpoint, hull, import, mesh, mesh_file, pair, scene,
};
use rockfall_math::hash;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// For one input.
const PATIENCE: Duration = Duration::from_secs(60);

/// A whole number from the environment, 0 where there is none.
fn wanted(name: &str) -> u64 {
    let Ok(text) = std::env::var(name) else { return 0 };
    text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, expected a whole number"))
}

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

/// Calls `target` so many times, or for as long as is wanted, each time with a number of its own.
fn drive(name: &'static str, count: u64, target: impl Fn(&mut Random) + Send + 'static) {
    let (first, seconds) =
        (wanted("ROCKFALL_FUZZ_FROM"), Duration::from_secs(wanted("ROCKFALL_FUZZ_SECONDS")));
    let (said, heard) = channel();
    let thread = std::thread::spawn(move || {
        let start = Instant::now();
        for number in (first..).take_while(|number| number - first < count || start.elapsed() < seconds) {
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
    println!("{name}: up to input {last:?}");
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

/// Every file of a run with a few changes.
#[test]
fn runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = GoodRun::write(folder.path());
    (0..run.files()).for_each(|k| run.with(k, run.file(k)));
    drive("run_file", 1500, move |random| {
        let _ = &folder;
        let k = random.below(run.files());
        run.with(k, &random.spoilt(run.file(k)));
    });
}
