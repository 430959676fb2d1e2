//! Sphere, box, capsule and half-space: shapes that a few numbers describe.

use super::{ShapeKind, nothing_to_check, one, small};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use rockfall::Shape;

pub(super) static SPHERE_KEYS: Spec = Spec {
    name: "sphere",
    about: "A ball around the origin.",
    example: r#"[shapes.ball]
kind = "sphere"
radius = 0.5
"#,
    groups: &[&[required("radius", Ty::Number(POSITIVE), "m.")]],
};

pub(super) static SPHERE: ShapeKind = ShapeKind {
    spec: &SPHERE_KEYS,
    immovable: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| Ok(vec![Shape::Sphere { radius: table.f32("radius") }]),
};

pub(super) static BOX_KEYS: Spec = Spec {
    name: "box",
    about: "A box around the origin.",
    example: r#"[shapes.crate]
kind = "box"
size = [1, 0.6, 0.4]
"#,
    groups: &[&[required("size", Ty::Numbers(&[3], POSITIVE), "Edge lengths along x, y, z, m.")]],
};

pub(super) static BOX: ShapeKind = ShapeKind {
    spec: &BOX_KEYS,
    immovable: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| Ok(vec![Shape::Box { half: 0.5 * table.vec3("size") }]),
};

pub(super) static CAPSULE_KEYS: Spec = Spec {
    name: "capsule",
    about: "A cylinder with half balls at its ends, along z, around the origin.",
    example: r#"[shapes.log]
kind = "capsule"
radius = 0.2
length = 1.5
"#,
    groups: &[&[
        required("radius", Ty::Number(POSITIVE), "m."),
        required("length", Ty::Number(NOT_NEGATIVE), "Of the cylinder, without the half balls, m."),
    ]],
};

pub(super) static CAPSULE: ShapeKind = ShapeKind {
    spec: &CAPSULE_KEYS,
    immovable: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| {
        let (half_length, radius) = (0.5 * table.f32("length"), table.f32("radius"));
        Ok(vec![Shape::Capsule { half_length, radius }])
    },
};

pub(super) static HALF_SPACE_KEYS: Spec = Spec {
    name: "half-space",
    about: "Everything below a plane: an endless floor or wall.",
    example: r#"[shapes.floor]
kind = "half-space"
"#,
    groups: &[&[
        key("normal", Ty::Numbers(&[3], ANY), "[0, 0, 1]", "Points out of the solid; any length but zero."),
        key("offset", Ty::Number(ANY), "0", "Distance of the plane from the origin along the normal, m."),
    ]],
};

pub(super) static HALF_SPACE: ShapeKind = ShapeKind {
    spec: &HALF_SPACE_KEYS,
    immovable: true,
    members: one,
    memory: small,
    check: |table| {
        if table.dvec3("normal").length_squared() > 1e-12 {
            return Ok(());
        }
        let message = format!("`{}` has no length", table.path_of("normal"));
        Err(Problem::at(table.span_of("normal"), message).expecting("numbers that are not all 0"))
    },
    cook: |table, _| Ok(vec![half_space(table)]),
};

fn half_space(table: &Table) -> Shape {
    let normal = table.dvec3("normal");
    Shape::HalfSpace { normal: (normal / normal.length()).as_vec3(), offset: table.f32("offset") }
}
