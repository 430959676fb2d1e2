//! Triangle meshes: from a file, from lists, or procedural terrain.

use super::{Cook, ShapeKind, failed, one, only_one_of};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{Key, POSITIVE, Spec, Ty, key, optional};
use crate::terrain::{self, TERRAIN};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_import::mesh_file;
use rockfall_math::Vec3;
use rockfall_shape::Mesh;
use std::path::Path;
use std::sync::Arc;

pub(super) static MESH_KEYS: Spec = Spec {
    name: "mesh",
    about: "A triangle surface, open or closed, hit from the side that its triangles show counter-clockwise. A body \
            of it is static unless its `kind` says otherwise, and may be dynamic where the mesh is closed.",
    example: r#"[shapes.valley]
kind = "mesh"
file = "meshes/valley.obj"
scale = 0.01 # the file is in centimetres
"#,
    groups: &[&MESH_GROUP, &[optional("terrain", Ty::Table(&TERRAIN), "Procedural terrain.")], LOOK],
};

/// What all meshes have.
pub(super) static MESH_GROUP: [Key; 4] = [
    optional("file", Ty::Text, "An OBJ, STL, PLY, glTF or GLB file, its path from the scene file."),
    optional("vertices", Ty::Points, "Corners, m; with `triangles`."),
    optional("triangles", Ty::Triangles, "Three indices into `vertices` each, counted from 0."),
    key("scale", Ty::Number(POSITIVE), "1", "Multiplies the coordinates."),
];

pub(super) static MESH: ShapeKind = ShapeKind {
    spec: &MESH_KEYS,
    immovable: false,
    ground: true,
    members: one,
    // Per triangle: corners, normal, edges, neighbours and its share of the tree.
    memory: |table| {
        let cells = table.table("terrain").map_or(0, |t| t.ints("cells").iter().product::<u64>());
        160 * (2 * cells + table.list("triangles").len() as u64) + 256
    },
    check,
    cook: |table, context| Ok(vec![Shape::Mesh(Arc::new(read(table, context)?.0))]),
};

/// Where the triangles of a table with [`MESH_GROUP`] come from.
fn source(table: &Table) -> Result<&'static str, Problem> {
    let all = &["file", "vertices", "terrain"];
    only_one_of(table, if table.spec.key("terrain").is_some() { all } else { &all[..2] })
}

/// What the types of [`MESH_GROUP`] can't say.
pub(super) fn check(table: &Table) -> Result<(), Problem> {
    let source = source(table)?;
    if (source == "vertices") != table.has("triangles") {
        let message = format!("`{}` has only one of `vertices` and `triangles`", table.path);
        return Err(Problem::at(table.span, message).expecting("both"));
    }
    let corners = table.list("vertices").len() as u64;
    for triangle in table.list("triangles") {
        if let Some(index) = triangle.value.ints().into_iter().find(|&i| i >= corners) {
            let message = format!("`{}` has the index {index}", table.path_of("triangles"));
            let expected = format!("indices below {corners}, the number of vertices");
            return Err(Problem::at(triangle.span, message).expecting(expected));
        }
    }
    Ok(())
}

/// The mesh that a table with [`MESH_GROUP`] describes, and the key that it comes from.
pub(super) fn read(table: &Table, context: &Cook<'_>) -> Result<(Mesh, &'static str), Problem> {
    let source = source(table)?;
    let (mut vertices, triangles) = match source {
        "file" => {
            let soup =
                mesh_file::read(Path::new(table.text("file"))).map_err(|e| failed(table, "file", e))?;
            (soup.vertices, soup.triangles)
        }
        "terrain" => ground(table, context),
        _ => {
            let triangle = |n: &crate::node::Node| match n.value.ints()[..] {
                [i, j, k] => [i as u32, j as u32, k as u32],
                _ => [0; 3],
            };
            (table.points("vertices"), table.list("triangles").iter().map(triangle).collect())
        }
    };
    let scale = table.f32("scale");
    vertices.iter_mut().for_each(|v| *v *= scale);
    let mesh = Mesh::from_triangles(&vertices, &triangles).map_err(|e| failed(table, source, e))?;
    Ok((mesh, source))
}

/// Terrain as triangles, each cell cut from (i, j) to (i + 1, j + 1) as in a height field.
fn ground(table: &Table, context: &Cook<'_>) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let Some(keys) = table.table("terrain") else { return (Vec::new(), Vec::new()) };
    let grid = terrain::heights(keys, context.seed, &table.path);
    let (columns, rows) = (grid.columns, grid.rows);
    let at = |n: u32, of: u32, spacing: f32| (n as f32 - 0.5 * (of - 1) as f32) * spacing;
    let vertices = grid.heights.iter().zip(0..).map(|(&z, n)| {
        Vec3::new(at(n % columns, columns, grid.spacing[0]), at(n / columns, rows, grid.spacing[1]), z)
    });
    let cell = |n: u32| {
        let a = n / (columns - 1) * columns + n % (columns - 1);
        let (b, c, d) = (a + 1, a + columns + 1, a + columns);
        [[a, b, c], [a, c, d]]
    };
    (vertices.collect(), (0..(columns - 1) * (rows - 1)).flat_map(cell).collect())
}
