//! What bodies look like where that is not what they collide with: meshes in place of shapes, and colours. Nothing of it takes part in the simulation.

use crate::body;
use crate::error::Problem;
use crate::node::Table;
use crate::shapes::failed;
use crate::spec::{ANY, Key, POSITIVE, Spec, Ty, key, optional, required};
use rockfall::Shape;
use rockfall_import::mesh_file::{self, TriangleSoup};
use rockfall_math::rotation::rotate;
use rockfall_shape::Mesh;
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
    /// By file, and the bits of place, turn and scale.
    known: BTreeMap<(String, [u64; 8]), u32>,
    files: BTreeMap<String, TriangleSoup>,
}

impl Visuals {
    /// The one that a table with the keys of [`VISUAL`] describes, for a shape that is `size` times as large as the scene has it.
    ///
    /// # Errors
    /// A file that can't be read, or has no triangle with an area.
    pub(crate) fn of(&mut self, table: &Table, size: f32) -> Result<u32, Problem> {
        let (file, pose, scale) = (table.text("file"), body::pose(table)?, table.f32("scale"));
        let [x, y, z] = pose.position.to_array().map(f64::to_bits);
        let [a, b, c, d] = pose.rotation.to_array().map(|q| u64::from(q.to_bits()));
        let sizes = u64::from(scale.to_bits()) << 32 | u64::from(size.to_bits());
        let key = (file.to_owned(), [x, y, z, a, b, c, d, sizes]);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        if !self.files.contains_key(file) {
            let soup = mesh_file::read(Path::new(file)).map_err(|why| failed(table, "file", why))?;
            self.files.insert(file.to_owned(), soup);
        }
        let soup = &self.files[file];
        let at = pose.position.as_vec3();
        let place = |v: &rockfall_math::Vec3| (at + rotate(pose.rotation, *v * scale)) * size;
        let corners: Vec<_> = soup.vertices.iter().map(place).collect();
        let mesh =
            Mesh::from_triangles(&corners, &soup.triangles).map_err(|why| failed(table, "file", why))?;
        let index = self.shapes.len() as u32;
        self.shapes.push(Shape::Mesh(Arc::new(mesh)));
        self.known.insert(key, index);
        Ok(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
