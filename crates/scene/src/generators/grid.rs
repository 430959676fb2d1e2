//! Bodies on a regular grid.

use super::{GeneratorKind, SHAPED, nothing_to_check};
use crate::body::{MOTION, SURFACE};
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::random::Random;
use crate::rotation;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use rockfall_math::{DVec3, Pose};

pub(super) static GRID_KEYS: Spec = Spec {
    name: "grid",
    about: "Bodies on a regular grid, numbered along x, then y, then z.",
    example: r#"[[generators]]
kind = "grid"
shape = "ball"
count = [10, 10, 5]
spacing = [1.1, 1.1, 1.1]
position = [0, 0, 1]
jitter = 0.02
"#,
    groups: &[
        SHAPED,
        &[
            required("count", Ty::Ints(3, 1, 4_294_967_295), "Bodies along x, y, z."),
            required("spacing", Ty::Numbers(&[3], POSITIVE), "Distance of their origins along x, y, z, m."),
            key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Middle of the lowest layer, m."),
            key("rotation", Ty::Rotation, "[0, 0, 0]", "Of each body; forms as for bodies."),
            key("jitter", Ty::Number(NOT_NEGATIVE), "0", "Each coordinate is moved by up to so much, m."),
        ],
        SURFACE,
        MOTION,
    ],
};

pub(super) static GRID: GeneratorKind = GeneratorKind {
    spec: &GRID_KEYS,
    count: |table| table.ints("count").into_iter().map(u128::from).product(),
    check: nothing_to_check,
    place,
};

fn place(table: &Table, label: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let template = yard.moving(table);
    let choices = yard.choices(table)?;
    let mut random = Random::new(yard.seed, label);
    let (spacing, jitter) = (table.dvec3("spacing"), table.f64("jitter"));
    let rotation = rotation::read(table, "rotation")?;
    let count = table.ints("count");
    let middle = DVec3::new((count[0] - 1) as f64, (count[1] - 1) as f64, 0.0) * 0.5;
    for k in 0..count[2] {
        for j in 0..count[1] {
            for i in 0..count[0] {
                let (shape, scale) = yard.draw(&choices, table, &mut random)?;
                let moved = random.point(DVec3::splat(-jitter), DVec3::splat(jitter));
                let at = (DVec3::new(i as f64, j as f64, k as f64) - middle) * spacing;
                let position = table.dvec3("position") + at + moved;
                yard.add(template, shape, scale, Pose { position, rotation });
            }
        }
    }
    Ok(())
}
