//! Boxes and hulls with round edges and corners.

use super::hull::{self, HULL_GROUP};
use super::{ShapeKind, nothing_to_check, one, only_one_of, small};
use crate::spec::{Key, POSITIVE, Spec, Ty, required};
use crate::visual::LOOK;
use rockfall::Shape;

static RADIUS: [Key; 1] = [required(
    "radius",
    Ty::Number(POSITIVE),
    "By how much it grows to all sides: the radius of its edges, m.",
)];

pub(super) static ROUNDED_BOX_KEYS: Spec = Spec {
    name: "rounded-box",
    about: "A box around the origin that has grown to all sides, so that its edges and corners are round.",
    example: r#"[shapes.die]
kind = "rounded-box"
size = [0.8, 0.8, 0.8]
radius = 0.1
"#,
    groups: &[
        &[required("size", Ty::Numbers(&[3], POSITIVE), "Edge lengths along x, y, z before it grows, m.")],
        &RADIUS,
        LOOK,
    ],
};

pub(super) static ROUNDED_BOX: ShapeKind = ShapeKind {
    spec: &ROUNDED_BOX_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: small,
    check: nothing_to_check,
    cook: |table, _| {
        Ok(vec![Shape::RoundedBox { half: 0.5 * table.vec3("size"), radius: table.f32("radius") }])
    },
};

pub(super) static ROUNDED_HULL_KEYS: Spec = Spec {
    name: "rounded-hull",
    about: "A convex hull that has grown to all sides, so that its edges and corners are round.",
    example: r#"[shapes.soap]
kind = "rounded-hull"
points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]]
radius = 0.1
"#,
    groups: &[&HULL_GROUP, &RADIUS, LOOK],
};

pub(super) static ROUNDED_HULL: ShapeKind = ShapeKind {
    spec: &ROUNDED_HULL_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: |_| 16 << 10,
    check: |table| only_one_of(table, &["points", "file"]).map(|_| ()),
    cook: |table, _| Ok(vec![Shape::RoundedHull { hull: hull::read(table)?, radius: table.f32("radius") }]),
};
