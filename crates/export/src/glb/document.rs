//! A glTF document that grows: its parts as JSON, and the numbers that they refer to.

use crate::{Error, Inventory, Run, Surface};
use bytemuck::NoUninit;
use rockfall::{Kind, Shape};
use rockfall_scene::Color;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

/// What a body looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Look {
    /// What is seen of it, an index into the shapes.
    pub(super) shown: u32,
    pub(super) paint: Paint,
}

/// What a surface is painted with: a material of glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Paint {
    /// The scene's material.
    pub(super) material: u32,
    /// Whether nobody moves it.
    fixed: bool,
    /// A colour of its own.
    own: Option<Color>,
    /// Whether it has holes through which its other side is seen.
    open: bool,
}

/// The look of a body.
pub(super) fn look(inventory: &Inventory, row: u32) -> Look {
    let row = row as usize;
    let shown = inventory.shown_of[row];
    let open = matches!(&inventory.shapes[shown as usize], Shape::Mesh(mesh) if !mesh.closed);
    let (material, own) = (inventory.material_of[row], inventory.color_of[row]);
    Look { shown, paint: Paint { material, fixed: inventory.kinds[row] == Kind::Static, own, open } }
}

/// glTF's numbers for the types of components.
#[derive(Clone, Copy, Debug)]
pub(super) enum Component {
    U16 = 5123,
    U32 = 5125,
    F32 = 5126,
}

/// What a view of the buffer is for.
#[derive(Clone, Copy, Debug)]
enum Target {
    Vertices = 34962,
    Triangles = 34963,
}

/// A document. Indices are those of glTF.
#[derive(Default)]
pub(super) struct Document {
    /// The start of the binary chunk.
    bytes: Vec<u8>,
    /// Bytes that follow those, and are written elsewhere.
    more: u64,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    animation: Option<Value>,
    extension: Option<&'static str>,
    known_materials: BTreeMap<Paint, usize>,
    known_meshes: BTreeMap<Look, usize>,
}

impl Document {
    /// Numbers of the binary chunk as an accessor: `kind` is glTF's name for so many components, such as `VEC3`.
    pub(super) fn numbers<R: NoUninit>(&mut self, component: Component, kind: &str, rows: &[R]) -> usize {
        self.add(component, kind, rows, None)
    }

    fn add<R: NoUninit>(
        &mut self,
        component: Component,
        kind: &str,
        rows: &[R],
        target: Option<Target>,
    ) -> usize {
        let (offset, length) = (self.bytes.len() as u64, size_of_val(rows) as u64);
        self.bytes.extend_from_slice(bytemuck::cast_slice(rows));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.view(offset, length, target);
        self.accessor(view, 0, component, kind, rows.len())
    }

    /// Makes room for numbers that the caller writes behind all others. Nothing but nodes and accessors may be added afterwards.
    pub(super) fn tail(&mut self, bytes: u64) -> usize {
        self.more = bytes;
        self.view(self.bytes.len() as u64, bytes, None)
    }

    fn view(&mut self, offset: u64, length: u64, target: Option<Target>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        push(&mut self.views, view)
    }

    /// `count` elements of a view, from a byte of it on.
    pub(super) fn accessor(
        &mut self,
        view: usize,
        offset: u64,
        component: Component,
        kind: &str,
        count: usize,
    ) -> usize {
        let component = component as u32;
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if offset > 0 {
            accessor["byteOffset"] = json!(offset);
        }
        push(&mut self.accessors, accessor)
    }

    /// Times, ascending, seconds.
    pub(super) fn times(&mut self, times: &[f32]) -> usize {
        let accessor = self.numbers(Component::F32, "SCALAR", times);
        let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
        self.accessors[accessor]["min"] = json!([first]);
        self.accessors[accessor]["max"] = json!([last]);
        accessor
    }

    /// The mesh of bodies that look like that.
    pub(super) fn mesh(&mut self, look: Look, inventory: &Inventory, surface: &Surface) -> usize {
        if let Some(&mesh) = self.known_meshes.get(&look) {
            return mesh;
        }
        let (low, high) = surface
            .positions
            .iter()
            .fold((surface.positions[0], surface.positions[0]), |(low, high), p| (low.min(*p), high.max(*p)));
        let corner = |p: &rockfall_math::Vec3| p.to_array();
        let positions: Vec<[f32; 3]> = surface.positions.iter().map(corner).collect();
        let positions = self.add(Component::F32, "VEC3", &positions, Some(Target::Vertices));
        self.accessors[positions]["min"] = json!(low.to_array());
        self.accessors[positions]["max"] = json!(high.to_array());
        let mut attributes = json!({ "POSITION": positions });
        // Without normals faces are flat.
        if !surface.normals.is_empty() {
            let normals: Vec<[f32; 3]> = surface.normals.iter().map(corner).collect();
            attributes["NORMAL"] = json!(self.add(Component::F32, "VEC3", &normals, Some(Target::Vertices)));
        }
        let corners = surface.triangles.as_flattened();
        // The largest number of each type is not an index.
        let indices = if surface.positions.len() < usize::from(u16::MAX) {
            let corners: Vec<u16> = corners.iter().map(|&corner| corner as u16).collect();
            self.add(Component::U16, "SCALAR", &corners, Some(Target::Triangles))
        } else {
            self.add(Component::U32, "SCALAR", corners, Some(Target::Triangles))
        };
        let material = self.material(look.paint, inventory);
        let mesh = json!({
            "name": format!("shape {}", look.shown),
            "primitives": [{ "attributes": attributes, "indices": indices, "material": material }],
        });
        let mesh = push(&mut self.meshes, mesh);
        self.known_meshes.insert(look, mesh);
        mesh
    }

    fn material(&mut self, paint: Paint, inventory: &Inventory) -> usize {
        if let Some(&known) = self.known_materials.get(&paint) {
            return known;
        }
        let Paint { material, fixed, own, open } = paint;
        let kind = if fixed { Kind::Static } else { Kind::Dynamic };
        let [r, g, b] = inventory.color(own, material, kind);
        let name = &inventory.materials[material as usize];
        // Ground is often a surface without another side.
        let described = json!({
            "name": if fixed { format!("{name}, static") } else { name.clone() },
            "doubleSided": fixed || open,
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8 },
        });
        let index = push(&mut self.materials, described);
        self.known_materials.insert(paint, index);
        index
    }

    /// A node below the one that turns the world.
    pub(super) fn node(&mut self, node: Value) -> usize {
        push(&mut self.nodes, node)
    }

    /// Gives a node another size than one.
    pub(super) fn scale(&mut self, node: usize, scale: f32) {
        self.nodes[node]["scale"] = json!([scale, scale, scale]);
    }

    /// Says which extension a reader has to know.
    pub(super) fn require(&mut self, extension: &'static str) {
        self.extension = Some(extension);
    }

    /// Makes things move.
    pub(super) fn animate(&mut self, channels: Vec<Value>, samplers: Vec<Value>) {
        self.animation = Some(json!({ "channels": channels, "samplers": samplers }));
    }

    /// Writes the document, and `more` as the rest of the binary chunk.
    ///
    /// # Errors
    /// [`Error::Limit`] where it would be larger than the format can say; [`Error::Io`].
    pub(super) fn write(mut self, run: &Run, to: &Path, more: impl Read) -> Result<(), Error> {
        let bytes = std::mem::take(&mut self.bytes);
        let binary = bytes.len() as u64 + self.more;
        let mut text = self.text(run, binary).to_string();
        text.push_str(&" ".repeat(text.len().next_multiple_of(4) - text.len()));
        let total = 12 + 8 + text.len() as u64 + if binary > 0 { 8 + binary } else { 0 };
        let (Ok(total), Ok(binary)) = (u32::try_from(total), u32::try_from(binary)) else {
            return Err(too_large(total));
        };
        let write = || -> io::Result<()> {
            let mut file = BufWriter::new(File::create_new(to)?);
            let word = |word: u32| word.to_le_bytes();
            file.write_all(b"glTF")?;
            file.write_all(&[word(2), word(total), word(text.len() as u32)].concat())?;
            file.write_all(b"JSON")?;
            file.write_all(text.as_bytes())?;
            if binary > 0 {
                file.write_all(&word(binary))?;
                file.write_all(b"BIN\0")?;
                file.write_all(&bytes)?;
                io::copy(&mut { more }, &mut file)?;
            }
            file.flush()
        };
        write().map_err(|error| Error::io("write", to, &error))
    }

    fn text(self, run: &Run, binary: u64) -> Value {
        let mut nodes = self.nodes;
        let root = nodes.len();
        // A quarter turn about x: z, which was up, becomes y.
        let half = 0.5_f64.sqrt();
        let mut world = json!({
            "name": "world, z up",
            "rotation": [-half, 0.0, 0.0, half],
            "extras": { "origin_m": run.origin().to_array() },
        });
        if root > 0 {
            world["children"] = json!((0..root).collect::<Vec<_>>());
        }
        nodes.push(world);
        let mut text = json!({
            "asset": { "version": "2.0", "generator": concat!("rockfall ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [root] }],
            "nodes": nodes,
        });
        let lists = [
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
        ];
        // A list without anything in it is not allowed.
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            text[name] = Value::Array(list);
        }
        if binary > 0 {
            text["buffers"] = json!([{ "byteLength": binary }]);
        }
        if let Some(extension) = self.extension {
            text["extensionsUsed"] = json!([extension]);
            text["extensionsRequired"] = json!([extension]);
        }
        if let Some(animation) = self.animation {
            text["animations"] = json!([animation]);
        }
        text
    }
}

/// What to say of a file that would be larger than four gigabytes.
pub(super) fn too_large(bytes: u64) -> Error {
    Error::Limit(format!(
        "the file would have {bytes} bytes, and a .glb has less than 4,294,967,296; choose fewer frames with --frames and --every, or fewer bodies with --bodies"
    ))
}

fn push(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}
