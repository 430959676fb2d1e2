//! Meshes of any corners and triangles.

use crate::Bytes;
use rockfall_math::Vec3;
use rockfall_shape::Mesh;

/// Corners and indices from `bytes`: there is an error, or a mesh that passes its own check.
pub fn mesh(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let corners = usize::from(bytes.byte() % 40);
    let vertices: Vec<Vec3> = (0..corners).map(|_| bytes.vector()).collect();
    let mut triangles = Vec::new();
    while !bytes.is_empty() {
        triangles.push([0; 3].map(|_: u32| match bytes.byte() {
            255 => bytes.word(),
            index => u32::from(index) % (corners as u32 + 1),
        }));
    }
    if let Ok(mesh) = Mesh::from_triangles(&vertices, &triangles) {
        mesh.check().expect("a mesh that was made passes its check");
    }
}
