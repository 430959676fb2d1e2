//! Triangles from mesh files: OBJ, STL, PLY, glTF and GLB.
//!
//! A file is taken into memory whole and never believed: what its header claims is held against its size
//! before anything is reserved, and what a reader hands over is checked again. Shading, colours and materials
//! are passed over.
//!
//! Coordinates stay as they are in the file, but for glTF, whose standard says that y is up: it is turned so
//! that z is.

pub(crate) mod gltf;
mod obj;
mod ply;
mod stl;

use crate::foreign::foreign;
use rockfall_math::Vec3;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// The largest file that is read, bytes.
const MOST_BYTES: u64 = 4 << 30;

/// The most triangles, and the most vertices, that a file may unfold to: a small glTF file can place one mesh
/// a million times.
const MOST_TRIANGLES: usize = 1 << 26;

/// Triangles as a file gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// Corners, in the file's unit of length.
    pub vertices: Vec<Vec3>,
    /// Indices of corners, counter-clockwise from outside. Polygons with more corners are cut into fans
    /// around their first corner.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh file can't be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// Nothing is there.
    #[error("{}: no such file, expected a mesh", .0.display())]
    Missing(PathBuf),
    /// Not a regular file.
    #[error("{}: not a file, expected a mesh", .0.display())]
    NotAFile(PathBuf),
    /// The name does not say which format it is.
    #[error("{}: can't tell the format by the name, expected .obj, .stl, .ply, .gltf or .glb", .0.display())]
    Extension(PathBuf),
    /// The system could not read it.
    #[error("{}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// No bytes.
    #[error("{}: the file is empty, expected a mesh", .0.display())]
    Empty(PathBuf),
    /// More than 4 GiB.
    #[error("{}: the file is larger than 4 GiB", .0.display())]
    TooLarge(PathBuf),
    /// The content does not follow its format.
    #[error("{}: not a sound {format} file: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// OBJ, STL, PLY or glTF.
        format: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A coordinate is NaN or infinite.
    #[error("{}: vertex {vertex} is not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Which one, from 0, in the order of the file.
        vertex: usize,
    },
    /// A triangle has a corner that is not there.
    #[error("{}: triangle {triangle} names vertex {vertex}, but there are only {count}", path.display())]
    Index {
        /// The file.
        path: PathBuf,
        /// Which one, from 0, in the order of the file.
        triangle: usize,
        /// What it names, from 0.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// Points and lines at most.
    #[error("{}: there are no triangles in the file", .0.display())]
    NoTriangles(PathBuf),
}

/// Triangles from the bytes of a file; the path is where other files may lie beside it. Errors are the
/// reason.
type Parse = fn(&[u8], &Path) -> Result<TriangleSoup, String>;

/// Reads the triangles of a mesh file; the format goes by the extension, capital or not.
///
/// All objects of the file are put together. glTF nodes are placed by their transforms, and the whole is
/// turned so that z is up.
///
/// # Errors
/// A file that is missing, no file, empty, larger than 4 GiB, cut off or otherwise not of its format;
/// coordinates that are not finite; corners that are not there; no triangles.
pub fn read(path: &Path) -> Result<TriangleSoup, MeshFileError> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let (format, parse): (_, Parse) = match extension.as_deref() {
        Some("obj") => ("OBJ", |bytes, _| obj::parse(bytes)),
        Some("stl") => ("STL", |bytes, _| stl::parse(bytes)),
        Some("ply") => ("PLY", |bytes, _| ply::parse(bytes)),
        Some("gltf" | "glb") => ("glTF", gltf::parse),
        // A folder is worth saying so whatever its name is.
        _ if path.is_dir() => return Err(MeshFileError::NotAFile(path.into())),
        _ => return Err(MeshFileError::Extension(path.into())),
    };
    let bytes = content(path)?;
    let malformed =
        |reason: String| MeshFileError::Malformed { path: path.into(), format, reason: brief(&reason) };
    let soup = foreign(|| parse(&bytes, path));
    let soup = soup.unwrap_or_else(|| Err("its reader gave up".into())).map_err(malformed)?;
    check(soup, path)
}

/// All bytes of a regular file.
pub(crate) fn content(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    let failed = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => MeshFileError::Missing(path.into()),
        _ => MeshFileError::Io { path: path.into(), reason: e.to_string() },
    };
    let length = match std::fs::metadata(path).map_err(failed)? {
        about if about.is_file() => about.len(),
        _ => return Err(MeshFileError::NotAFile(path.into())),
    };
    let mut bytes = Vec::new();
    if length <= MOST_BYTES {
        File::open(path).and_then(|f| f.take(MOST_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    }
    match bytes.len() as u64 {
        _ if length > MOST_BYTES => Err(MeshFileError::TooLarge(path.into())),
        0 => Err(MeshFileError::Empty(path.into())),
        read if read > MOST_BYTES => Err(MeshFileError::TooLarge(path.into())),
        _ => Ok(bytes),
    }
}

fn check(soup: TriangleSoup, path: &Path) -> Result<TriangleSoup, MeshFileError> {
    let path = || path.into();
    let count = soup.vertices.len();
    if let Some(vertex) = soup.vertices.iter().position(|v| !v.is_finite()) {
        return Err(MeshFileError::NotFinite { path: path(), vertex });
    }
    if soup.triangles.is_empty() {
        return Err(MeshFileError::NoTriangles(path()));
    }
    match soup.triangles.as_flattened().iter().position(|&c| c as usize >= count) {
        Some(i) => {
            let triangle = i / 3;
            let vertex = soup.triangles[triangle][i % 3];
            Err(MeshFileError::Index { path: path(), triangle, vertex, count })
        }
        None => Ok(soup),
    }
}

/// One line, not too long, of what a library has to say.
pub(crate) fn brief(reason: &str) -> String {
    let line: Vec<&str> = reason.split_whitespace().collect();
    let line = line.join(" ");
    match line.char_indices().nth(200) {
        Some((end, _)) => format!("{} ...", &line[..end]),
        None => line,
    }
}

impl TriangleSoup {
    /// Adds a polygon as a fan around its first corner.
    pub(crate) fn push_polygon(&mut self, corners: &[u32]) {
        if let [first, rest @ ..] = corners {
            self.triangles.extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
        }
    }
}

#[cfg(test)]
mod tests;
