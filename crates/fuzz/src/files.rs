//! Files of any content.

use rockfall_cache::{Checkpoint, RunReader, START, Start};
use rockfall_import::{Place, mesh_file, read};
use rockfall_shape::Mesh;
use std::path::Path;

/// Endings of the mesh files that can be read.
pub const MESH_FILES: [&str; 5] = ["obj", "stl", "ply", "glb", "gltf"];

/// A mesh file in `folder` with such an ending and the content `bytes`: there is an error, or triangles of which a mesh can be made or not.
pub fn mesh_file(folder: &Path, ending: &str, bytes: &[u8]) {
    let path = folder.join(format!("mesh.{ending}"));
    std::fs::write(&path, bytes).expect("room for a file");
    if let Ok(soup) = mesh_file::read(&path)
        && let Ok(mesh) = Mesh::from_triangles(&soup.vertices, &soup.triangles)
    {
        mesh.check().expect("a mesh that was made passes its check");
    }
}

/// Endings of the scenes of other programs that can be read.
pub const IMPORTS: [&str; 5] = ["usda", "usdc", "usdz", "glb", "gltf"];

/// A scene of another program in `folder`, as [`mesh_file()`]: there is an error, or bodies with poses and shapes that are there.
pub fn import(folder: &Path, ending: &str, bytes: &[u8]) {
    let path = folder.join(format!("scene.{ending}"));
    std::fs::write(&path, bytes).expect("room for a file");
    let Ok(content) = read(&path, &Place::default()) else { return };
    for body in &content.bodies {
        assert!(body.pose.position.is_finite() && body.pose.rotation.is_normalized(), "{body:?}");
        assert!(!content.shapes[body.shape as usize].is_empty());
        assert!(body.material.is_none_or(|material| (material as usize) < content.materials.len()));
    }
    let parts = content.shapes.iter().flatten();
    assert!(parts.map(|part| part.geometry as usize).all(|geometry| geometry < content.geometries.len()));
}

/// Reads all of a run in `folder`: errors, or what is there.
pub fn run_folder(folder: &Path) {
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
