//! Rotations as people write them.

use crate::error::Problem;
use crate::node::{Table, Value};
use crate::spec::{ANY, Spec, Ty, required};
use rockfall_math::{Quat, rotation};

/// The table form of a rotation.
pub(crate) static AXIS_DEGREES: Spec = Spec {
    name: "rotation",
    about: "A rotation about an axis, counter-clockwise when the axis points at you.",
    example: r#"rotation = { axis = [0, 0, 1], degrees = 45 }
"#,
    groups: &[&[
        required("axis", Ty::Numbers(&[3], ANY), "Any length but zero."),
        required("degrees", Ty::Number(ANY), "Angle."),
    ]],
};

/// Reads one of the three forms: degrees about x, then y, then z (axes of the world); a quaternion x, y, z, w of any
/// length; an axis and an angle.
pub(crate) fn read(table: &Table, key: &str) -> Result<Quat, Problem> {
    let Some(node) = table.node(key) else { return Ok(Quat::IDENTITY) };
    let (numbers, degrees) = match &node.value {
        Value::Table(t) => (t.numbers("axis"), Some(t.f64("degrees"))),
        value => (value.numbers(), None),
    };
    let squares: f64 = numbers.iter().map(|x| x * x).sum();
    let zero = |what| {
        let message = format!("`{}` has {what} without length", table.path_of(key));
        Problem::at(node.span, message).expecting("numbers that are not all 0")
    };
    let scaled = |by: f64| -> Vec<f32> { numbers.iter().map(|x| (x * by / squares.sqrt()) as f32).collect() };
    let tiny = squares < 1e-12;
    Ok(match (&numbers[..], degrees) {
        ([_, _, _], Some(_)) if tiny => return Err(zero("an axis")),
        ([_, _, _], Some(degrees)) => {
            let (sin, cos) = libm::sincos(0.5 * degrees.to_radians());
            let axis = scaled(sin);
            Quat::from_xyzw(axis[0], axis[1], axis[2], cos as f32)
        }
        ([_, _, _, _], None) if tiny => return Err(zero("a quaternion")),
        ([_, _, _, _], None) => {
            let q = scaled(1.0);
            Quat::from_xyzw(q[0], q[1], q[2], q[3])
        }
        (&[x, y, z], None) => {
            let [x, y, z] = [x, y, z].map(|degrees| libm::sincos(0.5 * degrees.to_radians()));
            let x = Quat::from_xyzw(x.0 as f32, 0.0, 0.0, x.1 as f32);
            rotation::compose(
                heading_from(z),
                rotation::compose(Quat::from_xyzw(0.0, y.0 as f32, 0.0, y.1 as f32), x),
            )
        }
        _ => Quat::IDENTITY,
    })
}

/// A turn about the vertical, counter-clockwise from above.
pub(crate) fn heading(degrees: f64) -> Quat {
    heading_from(libm::sincos(0.5 * degrees.to_radians()))
}

fn heading_from((sin, cos): (f64, f64)) -> Quat {
    Quat::from_xyzw(0.0, 0.0, sin as f32, cos as f32)
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use rockfall_math::{Vec3, rotation::rotate};

    #[test]
    fn the_three_forms_of_a_rotation_agree() {
        let s = 0.5f64.sqrt();
        let forms = [
            "[0, 0, 90]".to_owned(),
            format!("[0, 0, {s}, {s}]"),
            "{ axis = [0, 0, 5], degrees = 90 }".to_owned(),
        ];
        for form in forms {
            let text = format!(
                "[shapes.b]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nshape = \"b\"\nrotation = {form}\n"
            );
            let plan = Scene::parse(&text, "x", ".").unwrap().plan().unwrap();
            let turned = rotate(plan.placed[0].1.rotation, Vec3::X);
            assert!((turned - Vec3::Y).length() < 1e-6, "{form}: {turned}");
        }
    }

    #[test]
    fn degrees_turn_about_x_then_y_then_z() {
        let text =
            "[shapes.b]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nshape = \"b\"\nrotation = [90, 90, 0]\n";
        let plan = Scene::parse(text, "x", ".").unwrap().plan().unwrap();
        // About x, y becomes z; then about y, z becomes x.
        assert!((rotate(plan.placed[0].1.rotation, Vec3::Y) - Vec3::X).length() < 1e-6);
    }
}
