//! The stack of transforms of a prim (`xformOpOrder`): the last in the list is done first.

use super::values::{as_number, as_quaternion, as_vector, is_animated, said, value};
use crate::affine::Affine;
use openusd::sdf::Value;
use openusd::usd::Prim;
use rockfall_math::{DMat3, DVec3};

/// How a prim lies in its parent.
#[derive(Debug)]
pub(super) struct Local {
    pub(super) map: Affine,
    /// It does not lie in its parent, but in the world.
    pub(super) resets: bool,
    /// It has samples in time.
    pub(super) animated: bool,
    /// An operation that is not known, or that has no inverse although it is to be undone.
    pub(super) unknown: Option<String>,
}

const RESET: &str = "!resetXformStack!";
const UNDO: &str = "!invert!";

/// Reads the stack of a prim. Trigonometry is `libm`'s, so that a stage is the same on every machine.
pub(super) fn local(prim: &Prim) -> Result<Local, String> {
    let mut local = Local { map: Affine::IDENTITY, resets: false, animated: false, unknown: None };
    let order = match value(prim, "xformOpOrder").map_err(said)? {
        Some(Value::TokenVec(order)) => order,
        _ => return Ok(local),
    };
    for name in order {
        let name = name.as_str();
        if name == RESET {
            // What stands before it is of no use any more.
            local = Local { map: Affine::IDENTITY, resets: true, ..local };
            continue;
        }
        let attribute = name.strip_prefix(UNDO).unwrap_or(name);
        local.animated |= is_animated(prim, attribute)?;
        let Some(value) = value(prim, attribute)? else { continue };
        let map = operation(attribute, &value);
        let map = if attribute == name { map } else { map.and_then(|map| map.inverse()) };
        match map {
            Some(map) => local.map = local.map.after(&map),
            None => local.unknown = Some(name.to_owned()),
        }
    }
    Ok(local)
}

/// `xformOp:KIND` or `xformOp:KIND:SUFFIX`.
fn operation(name: &str, value: &Value) -> Option<Affine> {
    let kind = name.split(':').nth(1)?;
    let axis = |letter: char| match letter {
        'X' => DVec3::X,
        'Y' => DVec3::Y,
        _ => DVec3::Z,
    };
    let last = kind.chars().last()?;
    Some(match kind {
        "translate" => Affine::translation(as_vector(value)?),
        "translateX" | "translateY" | "translateZ" => Affine::translation(axis(last) * as_number(value)?),
        "scale" => Affine::linear(DMat3::from_diagonal(as_vector(value)?)),
        "scaleX" | "scaleY" | "scaleZ" => {
            let stretch = axis(last) * (as_number(value)? - 1.0);
            Affine::linear(DMat3::from_diagonal(DVec3::ONE + stretch))
        }
        "orient" => Affine::rotation(as_quaternion(value)?),
        "rotateX" | "rotateY" | "rotateZ" => turn(last, as_number(value)?),
        "rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX" => {
            let degrees = as_vector(value)?;
            let angle = |letter| axis(letter).dot(degrees);
            // The first letter is done first.
            let turns = kind.trim_start_matches("rotate").chars().map(|letter| turn(letter, angle(letter)));
            turns.fold(Affine::IDENTITY, |all, next| next.after(&all))
        }
        "transform" => match value {
            // Rows are the images of the axes, the last one the place.
            Value::Matrix4d(matrix) => {
                let row = |i: usize| DVec3::new(matrix.0[4 * i], matrix.0[4 * i + 1], matrix.0[4 * i + 2]);
                Affine { linear: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) }
            }
            _ => return None,
        },
        _ => return None,
    })
}

/// A turn about an axis of the frame, counter-clockwise when it points at you.
fn turn(axis: char, degrees: f64) -> Affine {
    // Quarter turns are exact.
    let quarters = degrees / 90.0;
    let (sin, cos) = match (quarters == quarters.round(), quarters.rem_euclid(4.0) as u8) {
        (true, 0) => (0.0, 1.0),
        (true, 1) => (1.0, 0.0),
        (true, 2) => (0.0, -1.0),
        (true, _) => (-1.0, 0.0),
        _ => libm::sincos(degrees.to_radians()),
    };
    Affine::linear(match axis {
        'X' => DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos)),
        'Y' => DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)),
        _ => DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z),
    })
}
