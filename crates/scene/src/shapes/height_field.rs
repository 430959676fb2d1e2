//! Height fields of immovable bodies: listed heights, or procedural terrain.

use super::{Cook, ShapeKind, failed, one, only_one_of};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{ANY, POSITIVE, Spec, Ty, optional};
use crate::terrain::{self, TERRAIN};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_math::Vec2;
use rockfall_shape::HeightField;
use std::sync::Arc;

pub(super) static HEIGHT_FIELD_KEYS: Spec = Spec {
    name: "height-field",
    about: "Ground over a regular grid, centred on the origin, solid below. For bodies that are static or kinematic.",
    example: r#"[shapes.ramp]
kind = "height-field"
heights = [2, 1, 0, 2, 1, 0]
columns = 3
spacing = [5, 5]
"#,
    groups: &[
        &[
            optional("terrain", Ty::Table(&TERRAIN), "Procedural terrain. Either this or `heights`."),
            optional(
                "heights",
                Ty::Numbers(&[], ANY),
                "m, row by row, each row along x; with `columns` and `spacing`.",
            ),
            optional("columns", Ty::Int(2, 4097), "Samples in a row."),
            optional("spacing", Ty::Numbers(&[2], POSITIVE), "Distance of samples along x and y, m."),
        ],
        LOOK,
    ],
};

pub(super) static HEIGHT_FIELD: ShapeKind = ShapeKind {
    spec: &HEIGHT_FIELD_KEYS,
    immovable: true,
    ground: true,
    members: one,
    memory: |table| {
        let cells = table.table("terrain").map_or(0, |t| t.ints("cells").iter().product::<u64>());
        8 * (cells + table.list("heights").len() as u64) + 256
    },
    check,
    cook: |table, context| Ok(vec![cook(table, context)?]),
};

fn check(table: &Table) -> Result<(), Problem> {
    let listed = only_one_of(table, &["terrain", "heights"])? == "heights";
    for key in ["columns", "spacing"] {
        if table.has(key) != listed {
            let expected = if listed { "it beside `heights`" } else { "it only beside `heights`" };
            let what = if listed { "is missing" } else { "is out of place" };
            let message = format!("`{}` {what}", table.path_of(key));
            return Err(Problem::at(table.span_of(key), message).expecting(expected));
        }
    }
    let (heights, columns) = (table.list("heights").len() as u64, table.int("columns"));
    if listed && (heights % columns != 0 || heights < 2 * columns) {
        let message = format!("`{}` has {heights} numbers", table.path_of("heights"));
        let expected = format!("at least 2 rows of `columns` = {columns}");
        return Err(Problem::at(table.span_of("heights"), message).expecting(expected));
    }
    Ok(())
}

fn cook(table: &Table, context: &Cook) -> Result<Shape, Problem> {
    let (key, columns, rows, spacing, heights) = if let Some(keys) = table.table("terrain") {
        let grid = terrain::heights(keys, context.seed, &table.path);
        ("terrain", grid.columns, grid.rows, grid.spacing, grid.heights)
    } else {
        let heights: Vec<f32> = table.numbers("heights").into_iter().map(|h| h as f32).collect();
        let columns = table.int("columns").max(1);
        let (dx, dy) = table.pair("spacing");
        let rows = heights.len() as u64 / columns;
        ("heights", columns as u32, rows as u32, [dx as f32, dy as f32], heights)
    };
    let field = HeightField::new(columns, rows, Vec2::from(spacing), heights);
    Ok(Shape::HeightField(Arc::new(field.map_err(|e| failed(table, key, e))?)))
}
