//! Solid bodies of any form, from a closed mesh.

use super::mesh::{self, MESH_GROUP};
use super::{Cook, ShapeKind, failed, one};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{POSITIVE, Spec, Ty, optional, required};
use crate::visual::LOOK;
use etcetera::BaseStrategy;
use rockfall::Shape;
use rockfall_shape::{Field, FieldSettings};
use std::path::PathBuf;
use std::sync::Arc;

pub(super) static FIELD_KEYS: Spec = Spec {
    name: "field",
    about: "A solid of any form, concave or with holes, as the signed distance from a closed mesh, sampled once and kept in \
            the user's folder for caches. For bodies of any kind.",
    example: r#"[shapes.cup]
kind = "field"
file = "meshes/cup.obj"
error = 0.0005
"#,
    groups: &[
        &MESH_GROUP,
        &[
            required(
                "error",
                Ty::Number(POSITIVE),
                "By how much the distance may be off near the surface, m. Memory and the time to make it grow with its inverse.",
            ),
            optional(
                "spacing",
                Ty::Number(POSITIVE),
                "No point of the surface is further from one at which contacts are looked for, m. Smaller details of two bodies may \
                 miss each other. Four times the error where it is not given.",
            ),
        ],
        LOOK,
    ],
};

pub(super) static FIELD: ShapeKind = ShapeKind {
    spec: &FIELD_KEYS,
    immovable: false,
    ground: false,
    members: one,
    // What a body of a hundred times its error takes, with a mesh of 5,000 triangles.
    memory: |_| 4 << 20,
    check: mesh::check,
    cook: |table, context| Ok(vec![cook(table, context)?]),
};

fn cook(table: &Table, context: &Cook<'_>) -> Result<Shape, Problem> {
    let (mesh, source) = mesh::read(table, context)?;
    let with_error = FieldSettings::with_error(table.f32("error"));
    let settings = match table.has("spacing") {
        true => FieldSettings { spacing: table.f32("spacing"), ..with_error },
        false => with_error,
    };
    let mesh = Arc::new(mesh);
    let field = match folder() {
        Some(folder) => Field::cached(mesh, settings, &folder).map(|(field, _)| field),
        None => Field::new(mesh, settings),
    };
    let key = |why: &rockfall_shape::FieldError| match why {
        rockfall_shape::FieldError::Setting { what: "spacing", .. }
        | rockfall_shape::FieldError::TooMany { .. }
            if table.has("spacing") =>
        {
            "spacing"
        }
        rockfall_shape::FieldError::Open { .. }
        | rockfall_shape::FieldError::InsideOut
        | rockfall_shape::FieldError::Crossed { .. } => source,
        _ => "error",
    };
    Ok(Shape::Field(Arc::new(field.map_err(|why| failed(table, key(&why), why))?)))
}

/// Where fields are kept: `rockfall/fields` in the user's folder for caches; nowhere on a system without such a folder.
pub(crate) fn folder() -> Option<PathBuf> {
    let base = etcetera::choose_base_strategy().ok()?;
    Some(base.cache_dir().join("rockfall").join("fields"))
}
