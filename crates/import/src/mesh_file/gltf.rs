//! glTF 2.0, as text with its buffers beside it or within it, and as one binary file.
//!
//! Every node of the scene that has a mesh adds its triangles, placed by the transforms on the way to it.
//! Skins and morph targets stay at rest; extensions that hide the triangles, such as compression, are
//! refused.

use super::{MOST_TRIANGLES, TriangleSoup, content};
use crate::affine::Affine;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::json::validation::Validate;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive};
use percent_encoding::percent_decode_str;
use rockfall_math::{DMat3, DVec3, Vec3};
use std::path::Path;

/// glTF has y up and looks along -z; Rockfall has z up.
pub(crate) const UPRIGHT: Affine =
    Affine { linear: DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y), translation: DVec3::ZERO };

/// A file with all that it needs beside it.
pub(crate) struct File {
    pub(crate) document: Document,
    buffers: Vec<Vec<u8>>,
}

/// All triangles of the scene; `path` is where to look for buffers.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<TriangleSoup, String> {
    let file = open(bytes, path, &[])?;
    let File { document, buffers } = &file;
    // First all is counted, then read: a small file must not take memory without bound.
    let mut size = Size::default();
    walk(document, |primitive, _| size.add(primitive, buffers))?;
    let mut soup = TriangleSoup::default();
    walk(document, |primitive, place| add(&mut soup, primitive, buffers, place))?;
    Ok(soup)
}

/// Reads a file that may ask for these extensions.
pub(crate) fn open(bytes: &[u8], path: &Path, known: &[&str]) -> Result<File, String> {
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|e| e.to_string())?;
    validate(document.as_json())?;
    if let Some(name) = document.extensions_required().find(|name| !known.contains(name)) {
        return Err(format!("it requires the extension {name}, which is not supported"));
    }
    let buffers = buffers(&document, blob, path)?;
    Ok(File { document, buffers })
}

/// What a file unfolds to.
#[derive(Default)]
pub(crate) struct Size {
    vertices: usize,
    triangles: usize,
}

impl Size {
    /// Checks a primitive and counts it.
    fn add(&mut self, primitive: &Primitive<'_>, buffers: &[Vec<u8>]) -> Result<(), String> {
        check(primitive, buffers)?;
        let (vertices, triangles) = counts(primitive);
        // One more each, so that empty ones come to an end as well.
        self.vertices += vertices + 1;
        self.triangles += triangles + 1;
        match self.vertices.max(self.triangles) > MOST_TRIANGLES {
            true => Err(format!("it unfolds to more than {MOST_TRIANGLES} triangles or vertices")),
            false => Ok(()),
        }
    }
}

impl File {
    /// The triangles of a mesh in its own frame, added to the `size` of the whole.
    pub(crate) fn soup(&self, mesh: &gltf::Mesh<'_>, size: &mut Size) -> Result<TriangleSoup, String> {
        mesh.primitives().try_for_each(|primitive| size.add(&primitive, &self.buffers))?;
        let mut soup = TriangleSoup::default();
        for primitive in mesh.primitives() {
            add(&mut soup, &primitive, &self.buffers, Affine::IDENTITY)?;
        }
        Ok(soup)
    }

    /// Vectors of floats, or of integers that stand for numbers from -1 to 1.
    pub(crate) fn vectors<const N: usize>(&self, accessor: usize) -> Result<Vec<[f32; N]>, String> {
        let missing = || format!("there is no accessor {accessor}");
        let accessor = self.document.accessors().nth(accessor).ok_or_else(missing)?;
        let dimensions = if N == 4 { Dimensions::Vec4 } else { Dimensions::Vec3 };
        let types = [DataType::F32, DataType::I16, DataType::I8];
        check_accessor(&accessor, &self.buffers, &types, dimensions)?;
        let view = accessor.view().ok_or_else(missing)?;
        let bytes = &self.buffers[view.buffer().index()][view.offset() + accessor.offset()..];
        let width = accessor.data_type().size();
        let stride = view.stride().unwrap_or(accessor.size());
        let number = |k: usize, i: usize| match bytes[k * stride + i * width..][..width] {
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            [a, b] => (f32::from(i16::from_le_bytes([a, b])) / 32767.0).max(-1.0),
            [a, ..] => (f32::from(a as i8) / 127.0).max(-1.0),
            [] => 0.0,
        };
        Ok((0..accessor.count()).map(|k| std::array::from_fn(|i| number(k, i))).collect())
    }
}

/// The library's own check, which looks up the places of a primitive before it checks that they are there.
fn validate(root: &Root) -> Result<(), String> {
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    for (_, accessor) in primitives.flat_map(|p| &p.attributes) {
        if accessor.value() >= root.accessors.len() {
            let (index, count) = (accessor.value(), root.accessors.len());
            return Err(format!("a mesh names accessor {index}, but there are only {count}"));
        }
    }
    let mut first = None;
    root.validate(root, gltf::json::Path::new, &mut |path, error| {
        let path = path().to_string();
        // Which extensions may be asked for is not the library's choice.
        if !path.starts_with("extensionsRequired") {
            first.get_or_insert_with(|| format!("{path}: {error}"));
        }
    });
    first.map_or(Ok(()), Err)
}

/// Visits every primitive of the scene with its place in the world, in the order of the file.
fn walk<'a>(
    document: &'a Document,
    mut visit: impl FnMut(&Primitive<'a>, Affine) -> Result<(), String>,
) -> Result<(), String> {
    let mut seen = vec![false; document.nodes().len()];
    let mut waiting: Vec<(Node<'a>, Affine)> = roots(document).into_iter().map(|n| (n, UPRIGHT)).collect();
    while let Some((node, parent)) = waiting.pop() {
        // Without this a cycle would never end.
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("node {} has two parents, or is its own ancestor", node.index()));
        }
        let place = parent.after(&matrix(node.transform().matrix()));
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            visit(&primitive, place)?;
        }
        // Last in, first out: backwards, so that nodes come in the order of the file.
        let children: Vec<_> = node.children().collect();
        waiting.extend(children.into_iter().rev().map(|c| (c, place)));
    }
    Ok(())
}

/// The top nodes of the scene that the file wants shown; without scenes those that are nobody's child. Last
/// first.
pub(crate) fn roots(document: &Document) -> Vec<Node<'_>> {
    let mut roots: Vec<Node<'_>> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().collect(),
        None => {
            let mut top = vec![true; document.nodes().len()];
            document.nodes().flat_map(|n| n.children()).for_each(|c| top[c.index()] = false);
            document.nodes().filter(|n| top[n.index()]).collect()
        }
    };
    roots.reverse();
    roots
}

fn buffers(document: &Document, blob: Option<Vec<u8>>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let mut blob = blob;
    let load = |buffer: gltf::Buffer<'_>| {
        let index = buffer.index();
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or(format!("buffer {index} is missing"))?,
            gltf::buffer::Source::Uri(uri) => fetch(uri, path).map_err(|e| format!("buffer {index}: {e}"))?,
        };
        if bytes.len() < buffer.length() {
            let (expected, found) = (buffer.length(), bytes.len());
            return Err(format!("buffer {index} should have {expected} bytes, but has only {found}"));
        }
        Ok(bytes)
    };
    document.buffers().map(load).collect()
}

/// The bytes of a `data:` address or of a file beside `path`.
fn fetch(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("its data are not in base64")?;
        return STANDARD.decode(text).map_err(|e| e.to_string());
    }
    if uri.contains("://") {
        return Err(format!("`{uri}` is not a file"));
    }
    let name = percent_decode_str(uri).decode_utf8().map_err(|e| e.to_string())?;
    content(&path.with_file_name("").join(name.as_ref())).map_err(|e| e.to_string())
}

/// How many vertices and, at most, triangles a primitive adds.
fn counts(primitive: &Primitive<'_>) -> (usize, usize) {
    let Some(positions) = triangles_of(primitive) else { return (0, 0) };
    let corners = primitive.indices().map_or(positions.count(), |i| i.count());
    (positions.count(), if primitive.mode() == Mode::Triangles { corners / 3 } else { corners })
}

/// Where the corners of a primitive are, if it is made of triangles.
fn triangles_of<'a>(primitive: &Primitive<'a>) -> Option<Accessor<'a>> {
    let solid = matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
    primitive.get(&gltf::Semantic::Positions).filter(|_| solid)
}

fn add(
    soup: &mut TriangleSoup,
    primitive: &Primitive<'_>,
    buffers: &[Vec<u8>],
    place: Affine,
) -> Result<(), String> {
    if triangles_of(primitive).is_none() {
        return Ok(());
    }
    let reader = primitive.reader(|b| buffers.get(b.index()).map(Vec::as_slice));
    let first = soup.vertices.len() as u32;
    let positions = reader.read_positions().into_iter().flatten();
    soup.vertices.extend(positions.map(|p| place.point(Vec3::from_array(p).as_dvec3()).as_vec3()));
    let count = soup.vertices.len() as u32 - first;
    let mut corners: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..count).collect(),
    };
    // Beyond its own vertices it would find those of its neighbours.
    if let Some(c) = corners.iter().find(|&&c| c >= count) {
        return Err(format!("a triangle names vertex {c}, but its primitive has only {count}"));
    }
    corners.iter_mut().for_each(|c| *c += first);
    let from = soup.triangles.len();
    match primitive.mode() {
        Mode::TriangleStrip => {
            // Every other triangle of a strip runs backwards.
            let turned =
                |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            soup.triangles.extend(corners.windows(3).enumerate().map(turned));
        }
        Mode::TriangleFan => soup.push_polygon(&corners),
        _ => soup.triangles.extend(corners.as_chunks().0),
    }
    if place.linear.determinant() < 0.0 {
        soup.triangles[from..].iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(())
}

/// The reader takes types and lengths on trust; they are checked here.
fn check(primitive: &Primitive<'_>, buffers: &[Vec<u8>]) -> Result<(), String> {
    let Some(positions) = triangles_of(primitive) else { return Ok(()) };
    check_accessor(&positions, buffers, &[DataType::F32], Dimensions::Vec3)?;
    match primitive.indices() {
        Some(indices) => check_accessor(
            &indices,
            buffers,
            &[DataType::U8, DataType::U16, DataType::U32],
            Dimensions::Scalar,
        ),
        None => Ok(()),
    }
}

fn check_accessor(
    accessor: &Accessor<'_>,
    buffers: &[Vec<u8>],
    types: &[DataType],
    dimensions: Dimensions,
) -> Result<(), String> {
    let index = accessor.index();
    if !types.contains(&accessor.data_type()) || accessor.dimensions() != dimensions {
        return Err(format!("accessor {index} is of a type that it can't have in its place"));
    }
    if accessor.sparse().is_some() {
        return Err(format!("accessor {index} is sparse, which is not supported"));
    }
    let view = accessor.view().ok_or(format!("accessor {index} has no data"))?;
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    let last = accessor.count().checked_sub(1).and_then(|n| n.checked_mul(stride));
    let end = last.and_then(|l| l.checked_add(accessor.offset())).and_then(|l| l.checked_add(size));
    let view_end = view.offset().checked_add(view.length());
    let length = buffers[view.buffer().index()].len();
    let fits = end.is_some_and(|e| e <= view.length()) && view_end.is_some_and(|e| e <= length);
    if stride < size || !fits {
        return Err(format!("accessor {index} reaches beyond its data"));
    }
    Ok(())
}

/// A matrix given by columns.
pub(crate) fn matrix(matrix: [[f32; 4]; 4]) -> Affine {
    let column = |c: [f32; 4]| DVec3::new(c[0].into(), c[1].into(), c[2].into());
    let [x, y, z, translation] = matrix.map(column);
    Affine { linear: DMat3::from_cols(x, y, z), translation }
}
