//! Closed meshes as compounds of hulls.

use super::mesh::{self, MESH_GROUP};
use super::{Cook, ShapeKind, failed, one};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{SHARE, Spec, Ty, key};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_decompose::{Decomposition, Options, decompose};
use std::sync::Arc;

pub(super) static DECOMPOSITION_KEYS: Spec = Spec {
    name: "decomposition",
    about: "A closed mesh cut into convex hulls, which move as one: for dynamic bodies that are hollow. `rockfall info` tells how \
            many hulls there are and how far they are from the mesh. The mass is that of the mesh.",
    example: r#"[shapes.step]
kind = "decomposition"
vertices = [[0, 0, 0], [2, 0, 0], [2, 0, 1], [1, 0, 1], [1, 0, 2], [0, 0, 2],
            [0, 1, 0], [2, 1, 0], [2, 1, 1], [1, 1, 1], [1, 1, 2], [0, 1, 2]]
triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [6, 8, 7], [6, 9, 8], [6, 10, 9], [6, 11, 10],
             [0, 6, 7], [0, 7, 1], [1, 7, 8], [1, 8, 2], [2, 8, 9], [2, 9, 3], [3, 9, 10], [3, 10, 4],
             [4, 10, 11], [4, 11, 5], [5, 11, 6], [5, 6, 0]]
resolution = 32
max_hulls = 4
"#,
    groups: &[
        &MESH_GROUP,
        &[
            key(
                "resolution",
                Ty::Int(8, 512),
                "64",
                "Voxels along its longest side; the time to cut grows with the cube.",
            ),
            key(
                "max_hulls",
                Ty::Int(4, 1024),
                "32",
                "The most hulls there may be. Pieces are halved, so that a power of two is made use of: 24 is 16.",
            ),
            key(
                "concavity",
                Ty::Number(SHARE),
                "0.002",
                "A piece is halved while it lacks more than this share of its hull, as a share of the hull of the whole.",
            ),
            key(
                "max_vertices",
                Ty::Int(4, 255),
                "32",
                "Of each hull; those that stick out farthest are kept.",
            ),
        ],
        LOOK,
    ],
};

pub(super) static DECOMPOSITION: ShapeKind = ShapeKind {
    spec: &DECOMPOSITION_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: |table| (16 << 10) * table.int("max_hulls"),
    check: mesh::check,
    cook: |table, context| Ok(vec![Shape::Compound(Arc::new(cook(table, context)?.compound))]),
};

/// Whether a table is for [`cook`].
pub(crate) fn is_decomposition(table: &Table) -> bool {
    std::ptr::eq(table.spec, &DECOMPOSITION_KEYS)
}

/// Cuts up the mesh that a table describes.
pub(crate) fn cook(table: &Table, context: &Cook<'_>) -> Result<Decomposition, Problem> {
    let (mesh, source) = mesh::read(table, context)?;
    let options = Options {
        resolution: table.int("resolution") as u32,
        max_hulls: table.int("max_hulls") as u32,
        concavity: table.f32("concavity"),
        max_vertices: table.int("max_vertices") as u32,
    };
    decompose(&mesh, &options).map_err(|e| failed(table, source, e))
}
