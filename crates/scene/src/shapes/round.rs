//! Sphere, box, capsule, cylinder, cone, ellipsoid and half-space: shapes that a few numbers describe.

use super::{ShapeKind, nothing_to_check, one, small};
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use crate::visual::LOOK;
use rockfall::Shape;

pub(super) static SPHERE_KEYS: Spec = Spec {
    name: "sphere",
    about: "A ball around the origin.",
    example: r#"[shapes.ball]
kind = "sphere"
radius = 0.5
"#,
    groups: &[&[required("radius", Ty::Number(POSITIVE), "m.")], LOOK],
};

pub(super) static SPHERE: ShapeKind = ShapeKind {
    spec: &SPHERE_KEYS,
    immovable: false,
    ground: false,
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
    groups: &[&[required("size", Ty::Numbers(&[3], POSITIVE), "Edge lengths along x, y, z, m.")], LOOK],
};

pub(super) static BOX: ShapeKind = ShapeKind {
    spec: &BOX_KEYS,
    immovable: false,
    ground: false,
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
    groups: &[
        &[
            required("radius", Ty::Number(POSITIVE), "m."),
            required("length", Ty::Number(NOT_NEGATIVE), "Of the cylinder, without the half balls, m."),
        ],
        LOOK,
    ],
};

pub(super) static CAPSULE: ShapeKind = ShapeKind {
    spec: &CAPSULE_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| {
        let (half_length, radius) = (0.5 * table.f32("length"), table.f32("radius"));
        Ok(vec![Shape::Capsule { half_length, radius }])
    },
};

pub(super) static CYLINDER_KEYS: Spec = Spec {
    name: "cylinder",
    about: "A cylinder with flat ends, along z, around the origin.",
    example: r#"[shapes.drum]
kind = "cylinder"
radius = 0.4
length = 1
"#,
    groups: &[
        &[
            required("radius", Ty::Number(POSITIVE), "m."),
            required("length", Ty::Number(POSITIVE), "From end to end, m."),
        ],
        LOOK,
    ],
};

pub(super) static CYLINDER: ShapeKind = ShapeKind {
    spec: &CYLINDER_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| {
        let (half_length, radius) = (0.5 * table.f32("length"), table.f32("radius"));
        Ok(vec![Shape::Cylinder { half_length, radius }])
    },
};

pub(super) static CONE_KEYS: Spec = Spec {
    name: "cone",
    about: "A cone along z with its tip up, or a truncated one. The origin is half-way up.",
    example: r#"[shapes.cone]
kind = "cone"
radius = 0.5
length = 1.2

[shapes.bucket]
kind = "cone"
radius = 0.3
top_radius = 0.4
length = 0.6
"#,
    groups: &[
        &[
            required("radius", Ty::Number(NOT_NEGATIVE), "Of the lower end, m."),
            key("top_radius", Ty::Number(NOT_NEGATIVE), "0", "Of the upper end, m; 0 is a tip."),
            required("length", Ty::Number(POSITIVE), "From end to end, m."),
        ],
        LOOK,
    ],
};

pub(super) static CONE: ShapeKind = ShapeKind {
    spec: &CONE_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: small,
    check: |table| {
        if table.f64("radius") > 0.0 || table.f64("top_radius") > 0.0 {
            return Ok(());
        }
        let message = format!("`{}` has no width at either end", table.path);
        Err(Problem::at(table.span_of("radius"), message).expecting("`radius` or `top_radius` above 0"))
    },
    cook: |table, _| {
        let (lower, upper) = (table.f32("radius"), table.f32("top_radius"));
        Ok(vec![Shape::Cone { half_length: 0.5 * table.f32("length"), lower, upper }])
    },
};

pub(super) static ELLIPSOID_KEYS: Spec = Spec {
    name: "ellipsoid",
    about: "An ellipsoid around the origin.",
    example: r#"[shapes.pebble]
kind = "ellipsoid"
size = [0.6, 0.4, 0.2]
"#,
    groups: &[&[required("size", Ty::Numbers(&[3], POSITIVE), "Diameters along x, y, z, m.")], LOOK],
};

pub(super) static ELLIPSOID: ShapeKind = ShapeKind {
    spec: &ELLIPSOID_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| Ok(vec![Shape::Ellipsoid { half: 0.5 * table.vec3("size") }]),
};

pub(super) static HALF_SPACE_KEYS: Spec = Spec {
    name: "half-space",
    about: "Everything below a plane: an endless floor or wall.",
    example: r#"[shapes.floor]
kind = "half-space"
"#,
    groups: &[
        &[
            key(
                "normal",
                Ty::Numbers(&[3], ANY),
                "[0, 0, 1]",
                "Points out of the solid; any length but zero.",
            ),
            key("offset", Ty::Number(ANY), "0", "Distance of the plane from the origin along the normal, m."),
        ],
        LOOK,
    ],
};

pub(super) static HALF_SPACE: ShapeKind = ShapeKind {
    spec: &HALF_SPACE_KEYS,
    immovable: true,
    ground: true,
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
