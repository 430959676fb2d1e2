//! The keys of `[[bodies]]`, and those that every moving body has, listed or generated.

use crate::error::Problem;
use crate::node::{Table, Value};
use crate::rotation;
use crate::spec::{ANY, Key, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, optional, required};
use crate::visual::{Color, VISUAL};
use rockfall::{Kind, Locks, MassOverride};
use rockfall_math::{Mat3, Pose, Quat, Vec3};

const LOCKS: &[&str] = &["x", "y", "z", "rx", "ry", "rz"];

/// What a body is made of and whom it meets.
pub(crate) const SURFACE: &[Key] = &[
    optional("name", Ty::Text, "For people, and for the random numbers of a generator."),
    key("material", Ty::Material, "\"default\"", "Name of its material."),
    optional("color", Ty::Color, "As `#rrggbb`, before that of its shape and that of its material."),
    key("group", Ty::Int(0, 0xffff_ffff), "1", "Collision groups that it belongs to, one bit each."),
    key(
        "mask",
        Ty::Int(0, 0xffff_ffff),
        "4294967295",
        "Groups that it meets. Two bodies meet when each one's mask has a group of the other.",
    ),
];

/// How a body starts and what slows it down.
pub(crate) const MOTION: &[Key] = &[
    key("velocity", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Of the centre of mass, m/s."),
    key("angular_velocity", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "rad/s, in the world's axes."),
    key("gravity_scale", Ty::Number(ANY), "1", "Gravity is multiplied by this."),
    key("linear_damping", Ty::Number(NOT_NEGATIVE), "0", "Share of the velocity lost per second, 1/s."),
    key(
        "angular_damping",
        Ty::Number(NOT_NEGATIVE),
        "0",
        "Share of the angular velocity lost per second, 1/s.",
    ),
    key(
        "locks",
        Ty::Choices(LOCKS),
        "[]",
        "Directions in which it can't move (`x`, `y`, `z`) and axes about which it can't turn (`rx`, `ry`, `rz`), all \
         of the world.",
    ),
];

pub(crate) static BODY: Spec = Spec {
    name: "body",
    about: "One body.",
    example: r#"[[bodies]]
name = "hammer"
shape = "ball"
position = [0, 0, 8]
rotation = { axis = [1, 0, 0], degrees = 30 }
velocity = [2, 0, 0]
locks = ["ry"]
"#,
    groups: &[
        &[
            required("shape", Ty::Shape, "Name of its shape."),
            optional(
                "visual",
                Ty::Table(&VISUAL),
                "A mesh that is seen in place of its shape, before that of the shape; [its keys](#the-table-visual).",
            ),
            key("member", Ty::Int(0, 0xffff_ffff), "0", "Which one of a family of shapes, counted from 0."),
            key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Where its shape's origin is, m."),
            key(
                "rotation",
                Ty::Rotation,
                "[0, 0, 0]",
                "Degrees about x, then y, then z; or a quaternion [x, y, z, w]; or `{ axis = [..], degrees = .. }`.",
            ),
            optional(
                "kind",
                Ty::Choice(&["dynamic", "kinematic", "static"]),
                "`dynamic`: moved by forces and contacts; `kinematic`: moves as told, whatever it meets; `static`: \
                 never moves. Dynamic where not given, but static for a half-space, mesh or height field, and for a compound \
                 with one.",
            ),
            key(
                "sensor",
                Ty::Bool,
                "false",
                "It collides with nothing; the run tells which dynamic and kinematic bodies come into it and leave it. Static where `kind` is not given.",
            ),
            optional(
                "id",
                Ty::Int(1, i64::MAX as u64),
                "A number of its own. Bodies without one are numbered from 1 in the order of the file, numbers that \
                 are taken left out.",
            ),
            optional("mass", Ty::Number(POSITIVE), "kg; replaces that of shape and density."),
            optional(
                "center",
                Ty::Numbers(&[3], ANY),
                "Centre of mass in the shape's frame, m; needs `mass`.",
            ),
            optional(
                "inertia",
                Ty::Numbers(&[3, 6], ANY),
                "About the centre of mass, kg m²: [xx, yy, zz] or [xx, yy, zz, xy, xz, yz]; needs `mass`.",
            ),
        ],
        SURFACE,
        MOTION,
    ],
};

/// What many bodies can share.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Template {
    pub(crate) kind: Kind,
    pub(crate) material: u32,
    pub(crate) group: u32,
    pub(crate) mask: u32,
    pub(crate) velocity: Vec3,
    pub(crate) angular_velocity: Vec3,
    pub(crate) gravity_scale: f32,
    pub(crate) linear_damping: f32,
    pub(crate) angular_damping: f32,
    pub(crate) locks: Locks,
    pub(crate) sensor: bool,
    pub(crate) mass: Option<MassOverride>,
    pub(crate) color: Option<Color>,
}

impl Template {
    /// A body of `material` that nobody moves; `table` has the keys of [`SURFACE`].
    pub(crate) fn fixed(table: &Table, material: u32) -> Self {
        Template {
            kind: Kind::Static,
            material,
            group: table.int("group") as u32,
            mask: table.int("mask") as u32,
            velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            locks: Locks::default(),
            sensor: false,
            mass: None,
            color: table.color("color"),
        }
    }

    /// A dynamic body; `table` has the keys of [`SURFACE`] and [`MOTION`].
    pub(crate) fn moving(table: &Table, material: u32) -> Self {
        let words = table.list("locks");
        let locked = |word| words.iter().any(|n| n.value.text() == word);
        Template {
            kind: Kind::Dynamic,
            velocity: table.vec3("velocity"),
            angular_velocity: table.vec3("angular_velocity"),
            gravity_scale: table.f32("gravity_scale"),
            linear_damping: table.f32("linear_damping"),
            angular_damping: table.f32("angular_damping"),
            locks: Locks {
                linear: [locked("x"), locked("y"), locked("z")],
                angular: [locked("rx"), locked("ry"), locked("rz")],
            },
            ..Template::fixed(table, material)
        }
    }

    /// The body that `table`, which has the keys of [`BODY`], describes.
    pub(crate) fn body(table: &Table, material: u32) -> Result<Self, Problem> {
        let kind = match table.text("kind") {
            "static" => Kind::Static,
            "kinematic" => Kind::Kinematic,
            _ => Kind::Dynamic,
        };
        let sensor = table.bool("sensor");
        Ok(Template { kind, sensor, mass: mass(table)?, ..Template::moving(table, material) })
    }
}

/// Where the body of `table` is.
pub(crate) fn pose(table: &Table) -> Result<Pose, Problem> {
    let rotation: Quat = rotation::read(table, "rotation")?;
    Ok(Pose { position: table.dvec3("position"), rotation })
}

fn mass(table: &Table) -> Result<Option<MassOverride>, Problem> {
    if !table.has("mass") {
        for key in ["center", "inertia"] {
            if table.has(key) {
                let message = format!("`{}` without `mass`", table.path_of(key));
                return Err(Problem::at(table.span_of(key), message).expecting("both or none"));
            }
        }
        return Ok(None);
    }
    let center = table.has("center").then(|| table.vec3("center"));
    let inertia = table.node("inertia").map(|node| &node.value).map(Value::numbers);
    let inertia = match inertia.as_deref() {
        None => None,
        Some(m) => {
            let (xy, xz, yz) = if m.len() == 6 { (m[3], m[4], m[5]) } else { (0.0, 0.0, 0.0) };
            let (xx, yy, zz) = (m[0], m[1], m[2]);
            let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
            if !(xx > 0.0 && xx * yy - xy * xy > 0.0 && determinant > 0.0) {
                let message = format!("`{}` is not positive definite", table.path_of("inertia"));
                let problem = Problem::at(table.span_of("inertia"), message);
                return Err(problem.expecting("an inertia that resists rotation about every axis"));
            }
            Some(Mat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz].map(|x| x as f32)))
        }
    };
    Ok(Some(MassOverride { mass: table.f32("mass"), center, inertia }))
}
