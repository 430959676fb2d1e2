//! A family of boxes, each edge of random length.

use super::{Cook, ShapeKind};
use crate::error::Problem;
use crate::node::Table;
use crate::random::Random;
use crate::spec::{POSITIVE, Spec, Ty, key, required};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_math::DVec3;

pub(super) static BOXES_KEYS: Spec = Spec {
    name: "boxes",
    about: "A family of boxes around the origin, each edge of random length. A generator picks one of them for each \
            body.",
    example: r#"[shapes.parcels]
kind = "boxes"
min = [0.3, 0.3, 0.1]
max = [0.8, 0.6, 0.5]
"#,
    groups: &[
        &[
            key("count", Ty::Int(1, 4096), "64", "Boxes in the family."),
            required("min", Ty::Numbers(&[3], POSITIVE), "Shortest edges along x, y, z, m."),
            required("max", Ty::Numbers(&[3], POSITIVE), "Longest edges along x, y, z, m."),
        ],
        LOOK,
    ],
};

pub(super) static BOXES: ShapeKind = ShapeKind {
    spec: &BOXES_KEYS,
    immovable: false,
    ground: false,
    members: |table| table.int("count"),
    memory: |table| 64 * table.int("count"),
    check,
    cook: |table, context| Ok(cook(table, context)),
};

fn check(table: &Table) -> Result<(), Problem> {
    if table.dvec3("min").cmple(table.dvec3("max")).all() {
        return Ok(());
    }
    let message = format!("`{}` is larger than `max`", table.path_of("min"));
    Err(Problem::at(table.span_of("min"), message).expecting("no edge longer than in `max`"))
}

fn cook(table: &Table, context: &Cook) -> Vec<Shape> {
    let (min, max): (DVec3, DVec3) = (table.dvec3("min"), table.dvec3("max"));
    let mut random = Random::new(context.seed, &table.path);
    (0..table.int("count")).map(|_| Shape::Box { half: (0.5 * random.point(min, max)).as_vec3() }).collect()
}
