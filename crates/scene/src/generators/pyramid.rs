//! A pyramid of boxes, one box deep: each course has one box less than the one below.

use super::{GeneratorKind, nothing_to_check};
use crate::body::{MOTION, SURFACE};
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::rotation;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use rockfall::Shape;
use rockfall_math::{Pose, Vec3, rotation::rotate};

pub(super) static PYRAMID_KEYS: Spec = Spec {
    name: "pyramid",
    about: "A pyramid one box deep: each course has one box less than the one below. Numbered from the bottom.",
    example: r#"[[generators]]
kind = "pyramid"
base = 20
brick = [1, 0.5, 0.5]
"#,
    groups: &[
        &[
            required("base", Ty::Int(1, 4_294_967_295), "Boxes in the lowest course."),
            key("brick", Ty::Numbers(&[3], POSITIVE), "[1, 1, 1]", "Length, depth, height of a box, m."),
            key("gap", Ty::Number(NOT_NEGATIVE), "0", "Between neighbours in a course, m."),
            key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Middle of the pyramid's foot, m."),
            key(
                "heading",
                Ty::Number(ANY),
                "0",
                "The pyramid runs along x, turned about z by this, degrees.",
            ),
        ],
        SURFACE,
        MOTION,
    ],
};

pub(super) static PYRAMID: GeneratorKind = GeneratorKind {
    spec: &PYRAMID_KEYS,
    count: |table| {
        let base = u128::from(table.int("base"));
        base * (base + 1) / 2
    },
    check: nothing_to_check,
    place,
};

fn place(table: &Table, _: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let template = yard.moving(table);
    let (brick, base) = (table.dvec3("brick"), table.int("base"));
    let pitch = brick.x + table.f64("gap");
    let shape = yard.shape(Shape::Box { half: 0.5 * brick.as_vec3() }, table)?;
    let rotation = rotation::heading(table.f64("heading"));
    for course in 0..base {
        let boxes = base - course;
        for i in 0..boxes {
            let along = (i as f64 - 0.5 * (boxes - 1) as f64) * pitch;
            let turned = rotate(rotation, Vec3::new(along as f32, 0.0, 0.0)).as_dvec3();
            let mut position = table.dvec3("position") + turned;
            position.z += (course as f64 + 0.5) * brick.z;
            yard.add(template, shape, 1.0, Pose { position, rotation });
        }
    }
    Ok(())
}
