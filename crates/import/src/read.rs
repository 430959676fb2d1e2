//! Files, from their path to their content.

use crate::affine::Affine;
use crate::content::Content;
use crate::foreign::foreign;
use crate::{gltf_scene, usd};
use rockfall_math::{DMat3, DQuat, DVec3, Pose};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// Why a scene of another program can't be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct ImportError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, and what was expected.
    pub reason: String,
}

/// How a file is laid into the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where its origin is, and how it is turned.
    pub pose: Pose,
    /// Multiplies all lengths.
    pub scale: f64,
}

impl Default for Place {
    fn default() -> Self {
        Place { pose: Pose::default(), scale: 1.0 }
    }
}

type Reader = fn(&Path, &Affine) -> Result<Content, String>;

/// Whether the name of a file says that it is a scene of another program.
pub fn is_scene(path: &Path) -> bool {
    reader(path).is_some()
}

fn reader(path: &Path) -> Option<Reader> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "usd" | "usda" | "usdc" | "usdz" => Some(usd::read),
        "gltf" | "glb" => Some(gltf_scene::read),
        _ => None,
    }
}

/// Stack of the thread that reads, bytes. The library for OpenUSD calls itself for prims in prims.
const STACK: usize = 256 << 20;

/// Reads a scene of another program; the format goes by the extension.
///
/// # Errors
/// A file that is missing, no file, or not of its format; numbers that are not finite; a scene in which there is nothing to collide with.
pub fn read(path: &Path, place: &Place) -> Result<Content, ImportError> {
    let failed = |reason: String| ImportError { path: path.to_owned(), reason };
    let expected = "expected .usd, .usda, .usdc, .usdz, .gltf or .glb";
    let read =
        reader(path).ok_or_else(|| failed(format!("can't tell the format by the name, {expected}")))?;
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() => {}
        Ok(_) => return Err(failed("not a file, expected a scene".into())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(failed("no such file, expected a scene".into()));
        }
        Err(error) => return Err(failed(error.to_string())),
    }
    let [x, y, z, w] = place.pose.rotation.to_array().map(f64::from);
    let turn = Affine::rotation(DQuat::from_xyzw(x, y, z, w));
    let scale = Affine::linear(DMat3::from_diagonal(DVec3::splat(place.scale)));
    let place = Affine::translation(place.pose.position).after(&turn).after(&scale);
    let gave_up = || Err("its reader gave up: the file is not sound".into());
    let job = || foreign(|| read(path, &place)).unwrap_or_else(gave_up);
    let content = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, job);
        let thread = thread.map_err(|error| error.to_string())?;
        thread.join().unwrap_or_else(|_| gave_up())
    });
    let mut content = content.map_err(|reason| failed(crate::mesh_file::brief(&reason)))?;
    content.checksum = checksum(path).map_err(|error| failed(error.to_string()))?;
    if content.bodies.is_empty() {
        let mut reason =
            "there is nothing to collide with in it, expected rigid bodies or colliders".to_owned();
        if let Some(note) = content.notes.first() {
            reason = format!("{reason}; {note}");
        }
        return Err(failed(reason));
    }
    Ok(content)
}

fn checksum(path: &Path) -> std::io::Result<u64> {
    let (mut file, mut hasher) = (File::open(path)?, Xxh3::new());
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hasher.digest()),
            count => hasher.update(&buffer[..count]),
        }
    }
}
