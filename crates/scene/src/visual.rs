//! What bodies look like where that is not what they collide with: meshes in place of shapes, and colours. Nothing of it takes part in the simulation.

use crate::body;
use crate::error::Problem;
use crate::node::Table;
use crate::shapes::failed;
use crate::spec::{ANY, Key, POSITIVE, Spec, Ty, key, optional, required};
use rockfall::Shape;
use rockfall_import::mesh_file;
use rockfall_math::rotation::rotate;
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::Mesh;
use rockfall_tree::Tree;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Red, green and blue as screens have them (sRGB).
pub type Color = [u8; 3];

pub(crate) static VISUAL: Spec = Spec {
    name: "visual",
    about: "A mesh that is seen in place of a shape, in pictures, films, exports and on the live page. It collides with nothing: the shape does, and bodies move as if the visual were not \
            there. It need not be closed. Of a compound its own counts, and not those of its parts.",
    example: r##"[shapes.crate]
kind = "box"
size = [0.6, 0.4, 0.4]
color = "#8a5a2b"
visual = { file = "meshes/crate.glb", position = [0, 0, -0.2] }
"##,
    groups: &[&[
        required("file", Ty::Text, "An OBJ, STL, PLY, glTF or GLB file, its path from the scene file."),
        key(
            "position",
            Ty::Numbers(&[3], ANY),
            "[0, 0, 0]",
            "Where its origin is in the frame of the shape, m.",
        ),
        key("rotation", Ty::Rotation, "[0, 0, 0]", "How it is turned; forms as for bodies."),
        key("scale", Ty::Number(POSITIVE), "1", "Multiplies the coordinates in the file."),
    ]],
};

/// What all shapes have.
pub(crate) const LOOK: &[Key] = &[
    optional("color", Ty::Color, "Of bodies that have none of their own."),
    optional(
        "visual",
        Ty::Table(&VISUAL),
        "A mesh that is seen in its place, see below. It grows and shrinks with the sizes of a generator.",
    ),
];

/// What a body looks like, where the scene says so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// Index of the visual that is seen in place of its shape.
    pub visual: Option<u32>,
    /// Its own colour, or that of its shape; where there is neither, that of its material is seen.
    pub color: Option<Color>,
}

/// The bytes of `#rrggbb`.
pub(crate) fn parse(text: &str) -> Option<Color> {
    let digits =
        text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some([r, g, b])
}

/// The text of a colour.
pub(crate) fn spell([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// All visuals of a scene, each once at each size.
#[derive(Default)]
pub(crate) struct Visuals {
    pub(crate) shapes: Vec<Shape>,
    known: BTreeMap<(Source, u32), u32>,
    cooked: BTreeMap<Source, Arc<Mesh>>,
}

/// A file, and the bits of place, turn and scale.
type Source = (String, [u64; 8]);

impl Visuals {
    /// The one that a table with the keys of [`VISUAL`] describes, for a shape that is `size` times as large as the scene has it.
    ///
    /// # Errors
    /// A file that can't be read, or has no triangle with an area.
    pub(crate) fn of(&mut self, table: &Table, size: f32) -> Result<u32, Problem> {
        let (file, pose, scale) = (table.text("file"), body::pose(table)?, table.f64("scale"));
        let [x, y, z] = pose.position.to_array().map(f64::to_bits);
        let [a, b, c, d] = pose.rotation.to_array().map(|q| u64::from(q.to_bits()));
        let source = (file.to_owned(), [x, y, z, a, b, c, d, scale.to_bits()]);
        let key = (source, size.to_bits());
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let mesh = match self.cooked.get(&key.0) {
            Some(mesh) => Arc::clone(mesh),
            None => {
                let soup = mesh_file::read(Path::new(file)).map_err(|why| failed(table, "file", why))?;
                let (at, scale) = (pose.position.as_vec3(), scale as f32);
                let corners: Vec<Vec3> =
                    soup.vertices.iter().map(|v| at + rotate(pose.rotation, *v * scale)).collect();
                let mesh = Mesh::from_triangles(&corners, &soup.triangles);
                let mesh = Arc::new(mesh.map_err(|why| failed(table, "file", why))?);
                self.cooked.insert(key.0.clone(), Arc::clone(&mesh));
                mesh
            }
        };
        let mesh = if size == 1.0 { mesh } else { Arc::new(scaled(&mesh, size)) };
        let index = self.shapes.len() as u32;
        self.shapes.push(Shape::Mesh(mesh));
        self.known.insert(key, index);
        Ok(index)
    }
}

/// A mesh at another size. Cooked anew, it would look for its neighbours and for a ball that fits in, which takes far longer and is nothing that a visual is asked for.
fn scaled(mesh: &Mesh, by: f32) -> Mesh {
    let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| by * *v).collect();
    let corners = |t: &[u32; 3]| t.map(|corner| vertices[corner as usize]);
    let boxes: Vec<Aabb> = mesh.triangles.iter().map(|t| Aabb::from_points(corners(t))).collect();
    Mesh {
        tree: Tree::build(&boxes),
        bounds: Aabb::from_points(vertices.iter().copied()),
        inner_ball: (by * mesh.inner_ball.0, by * mesh.inner_ball.1),
        vertices,
        ..mesh.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_at_another_size_is_what_would_be_cooked_of_it() {
        let corners = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::Y, Vec3::Z, Vec3::new(3.0, 1.0, 0.5)];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [1, 4, 2]];
        let mesh = Mesh::from_triangles(&corners, &triangles).unwrap();
        let (other, cooked) =
            (scaled(&mesh, 0.5), Mesh::from_triangles(&corners.map(|c| 0.5 * c), &triangles).unwrap());
        other.check().unwrap();
        assert_eq!((other.vertices, other.bounds), (cooked.vertices, cooked.bounds));
        assert_eq!((other.normals, other.edges), (cooked.normals, cooked.edges));
        assert_eq!((other.closed, other.inner_ball), (cooked.closed, cooked.inner_ball));
    }

    #[test]
    fn colours_are_read_as_they_are_written() {
        for (text, color) in [("#000000", [0; 3]), ("#ff8001", [255, 128, 1]), ("#0a0B0c", [10, 11, 12])] {
            assert_eq!(parse(text), Some(color));
            assert_eq!(spell(color), text.to_lowercase());
        }
        for text in ["", "#", "ff8001", "#ff80", "#ff80011", "#ff80g1", "#+f8001", "#ff8ö1"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
