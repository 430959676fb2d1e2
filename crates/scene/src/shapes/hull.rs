//! Convex hulls of points, or of the corners of a mesh file.

use super::{ShapeKind, failed, one, only_one_of};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{Key, POSITIVE, Spec, Ty, key, optional};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_import::mesh_file;
use rockfall_math::Vec3;
use rockfall_shape::{Hull, HullError};
use std::path::Path;
use std::sync::Arc;

pub(super) static HULL_KEYS: Spec = Spec {
    name: "hull",
    about: "The convex hull of points, or of the corners of any mesh file.",
    example: r#"[shapes.wedge]
kind = "hull"
points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]]
"#,
    groups: &[&HULL_GROUP, LOOK],
};

/// What all hulls have.
pub(super) static HULL_GROUP: [Key; 5] = [
    optional("points", Ty::Points, "At least 4 that are not in one plane, m. Either this or `file`."),
    optional("file", Ty::Text, "An OBJ, STL, PLY, glTF or GLB file, its path from the scene file."),
    key("scale", Ty::Number(POSITIVE), "1", "Multiplies the coordinates."),
    key("max_vertices", Ty::Int(4, 256), "64", "A hull with more corners is simplified."),
    key("centered", Ty::Bool, "false", "Moves the origin to the centre of mass."),
];

pub(super) static HULL: ShapeKind = ShapeKind {
    spec: &HULL_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: |_| 16 << 10,
    check: |table| only_one_of(table, &["points", "file"]).map(|_| ()),
    cook: |table, _| Ok(vec![Shape::Hull(read(table)?)]),
};

/// The hull of at most `max_vertices` corners.
pub(crate) fn cook(points: &[Vec3], max_vertices: usize) -> Result<Arc<Hull>, HullError> {
    Ok(Arc::new(Hull::from_points_at_most(points, max_vertices)?))
}

/// The hull that a table with [`HULL_GROUP`] describes.
pub(super) fn read(table: &Table) -> Result<Arc<Hull>, Problem> {
    let key = only_one_of(table, &["points", "file"])?;
    let mut points = if key == "file" {
        mesh_file::read(Path::new(table.text("file"))).map_err(|e| failed(table, "file", e))?.vertices
    } else {
        table.points("points")
    };
    let scale = table.f32("scale");
    points.iter_mut().for_each(|p| *p *= scale);
    let most = table.int("max_vertices") as usize;
    let hull = Hull::from_points_at_most(&points, most).map_err(|e| failed(table, key, e))?;
    if !table.bool("centered") {
        return Ok(Arc::new(hull));
    }
    let moved: Vec<Vec3> = hull.vertices.iter().map(|v| *v - hull.center).collect();
    cook(&moved, most).map_err(|e| failed(table, key, e))
}
