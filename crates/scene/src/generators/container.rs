//! A box without a lid, of fixed walls: somewhere to pour things into.

use super::{GeneratorKind, nothing_to_check};
use crate::body::{SURFACE, Template};
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::spec::{ANY, POSITIVE, Spec, Ty, key, required};
use rockfall::Shape;
use rockfall_math::{DVec3, Pose};

pub(super) static CONTAINER_KEYS: Spec = Spec {
    name: "container",
    about: "Fixed walls around a box-shaped room, and a floor. They are called `left` and `right` along x, `front` and `back` along y, `floor` and `lid`, each \
            behind the name of the generator and a dot, such as `silo.left`; without a name, `container.left`.",
    example: r#"[[generators]]
kind = "container"
size = [20, 20, 15]
"#,
    groups: &[
        &[
            required("size", Ty::Numbers(&[3], POSITIVE), "Of the room inside, m."),
            key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Middle of the floor's surface, m."),
            key("thickness", Ty::Number(POSITIVE), "1", "Of walls, floor and lid, m."),
            key("floor", Ty::Bool, "true", "Whether it has a floor."),
            key("lid", Ty::Bool, "false", "Whether it has a lid."),
        ],
        SURFACE,
    ],
};

pub(super) static CONTAINER: GeneratorKind = GeneratorKind {
    spec: &CONTAINER_KEYS,
    count: |table| 4 + u128::from(table.bool("floor")) + u128::from(table.bool("lid")),
    check: nothing_to_check,
    place,
};

/// Names of the walls, behind that of the container: those across x, those across y, floor and lid. Events and exports tell them apart by it.
const NAMES: [[&str; 2]; 3] = [["left", "right"], ["front", "back"], ["floor", "lid"]];

fn place(table: &Table, _: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let material = yard.material(table);
    let template = yard.template(Template::fixed(table, material));
    let (room, t) = (table.dvec3("size"), table.f64("thickness"));
    let middle = table.dvec3("position") + DVec3::new(0.0, 0.0, 0.5 * room.z);
    let name = Some(table.text("name")).filter(|name| !name.is_empty()).unwrap_or(CONTAINER_KEYS.name);
    let mut part = |axis: usize, size: DVec3, sign: f64| -> Result<(), Problem> {
        let shape = yard.shape(Shape::Box { half: (0.5 * size).as_vec3() }, table)?;
        let mut position = middle;
        position[axis] += sign * 0.5 * (room[axis] + t);
        yard.add(template, shape, 1.0, Pose::at(position));
        yard.name(&format!("{name}.{}", NAMES[axis][usize::from(sign > 0.0)]));
        Ok(())
    };
    // The x walls cover the ends of the y walls; floor and lid cover all four.
    let plate = DVec3::new(room.x + 2.0 * t, room.y + 2.0 * t, t);
    if table.bool("floor") {
        part(2, plate, -1.0)?;
    }
    for sign in [-1.0, 1.0] {
        part(0, DVec3::new(t, room.y + 2.0 * t, room.z), sign)?;
        part(1, DVec3::new(room.x, t, room.z), sign)?;
    }
    if table.bool("lid") {
        part(2, plate, 1.0)?;
    }
    Ok(())
}
