//! Files of any content.

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
