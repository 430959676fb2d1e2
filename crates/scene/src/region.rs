//! Where a fill may put bodies: in a box, above ground, or inside a closed mesh.

use crate::error::Problem;
use crate::inside::Inside;
use crate::node::Table;
use crate::plan::Yard;
use crate::random::Random;
use crate::rotation;
use crate::spec::{ANY, Kinds, NOT_NEGATIVE, Spec, Ty, key, required};
use rockfall::Shape;
use rockfall_math::{DVec3, Pose, rotation::rotate};
use rockfall_shape::HeightField;
use std::sync::Arc;

pub(crate) static BOX_KEYS: Spec = Spec {
    name: "box",
    about: "A box; whole bodies are in it.",
    example: r#"region = { min = [-5, -5, 0], max = [5, 5, 10] }
"#,
    groups: &[&[
        required("min", Ty::Numbers(&[3], ANY), "Lower corner, m."),
        required("max", Ty::Numbers(&[3], ANY), "Upper corner, m."),
    ]],
};

static ABOVE_KEYS: Spec = Spec {
    name: "above",
    about: "A layer above a height field; x and y of the corners are places, z is the height above the highest ground \
            below a body.",
    example: r#"region = { kind = "above", shape = "ramp", min = [-4, -2, 0.1], max = [4, 2, 3] }
"#,
    groups: &[&[
        required("shape", Ty::Shape, "Name of the height field."),
        key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Where the height field is, m."),
        required("min", Ty::Numbers(&[3], ANY), "Lower corner, m; z at least 0."),
        required("max", Ty::Numbers(&[3], ANY), "Upper corner, m."),
    ]],
};

static INSIDE_KEYS: Spec = Spec {
    name: "inside",
    about: "The inside of a closed mesh.",
    example: r#"region = { kind = "inside", shape = "valley", margin = 0.05 }
"#,
    groups: &[&[
        required("shape", Ty::Shape, "Name of the mesh."),
        key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Where the mesh is, m."),
        key("rotation", Ty::Rotation, "[0, 0, 0]", "How it is turned; forms as for bodies."),
        key("margin", Ty::Number(NOT_NEGATIVE), "0", "Least distance of bodies from the surface, m."),
    ]],
};

pub(crate) static REGIONS: Kinds =
    Kinds { name: "region", default: Some("box"), cases: &[&BOX_KEYS, &ABOVE_KEYS, &INSIDE_KEYS] };

/// What the types of the keys can't say.
pub(crate) fn check(table: &Table) -> Result<(), Problem> {
    if table.spec.key("rotation").is_some() {
        rotation::read(table, "rotation")?;
        return Ok(());
    }
    let (min, max) = (table.dvec3("min"), table.dvec3("max"));
    if !min.cmplt(max).all() {
        let message = format!("`{}` is not below `max`", table.path_of("min"));
        return Err(
            Problem::at(table.span_of("min"), message).expecting("three numbers below those of `max`")
        );
    }
    if table.spec.key("shape").is_some() && min.z < 0.0 {
        let message = format!("`{}` is below the ground", table.path_of("min"));
        return Err(Problem::at(table.span_of("min"), message).expecting("a z of at least 0"));
    }
    Ok(())
}

/// A region, ready to be sampled.
pub(crate) enum Region {
    Box { min: DVec3, max: DVec3 },
    Above { ground: Arc<HeightField>, position: DVec3, min: DVec3, max: DVec3 },
    Inside { mesh: Inside, pose: Pose, margin: f64 },
}

impl Region {
    pub(crate) fn read(table: &Table, yard: &mut Yard<'_>) -> Result<Self, Problem> {
        let wrong = |what: &str| {
            let message = format!("`{}` is not {what}", table.path_of("shape"));
            Problem::at(table.span_of("shape"), message).expecting(format!("the name of {what}"))
        };
        if table.spec.name == "box" {
            return Ok(Region::Box { min: table.dvec3("min"), max: table.dvec3("max") });
        }
        let shape = yard.first_of(table, "shape")?;
        let position = table.dvec3("position");
        match (table.spec.name, shape) {
            ("above", Shape::HeightField(ground)) => {
                Ok(Region::Above { ground, position, min: table.dvec3("min"), max: table.dvec3("max") })
            }
            ("above", _) => Err(wrong("a height field")),
            (_, Shape::Mesh(mesh)) => {
                let mesh = Inside::new(&mesh).map_err(|why| {
                    let message = format!("`{}`: {why}", table.path_of("shape"));
                    Problem::at(table.span_of("shape"), message).expecting("a closed mesh")
                })?;
                let pose = Pose { position, rotation: rotation::read(table, "rotation")? };
                Ok(Region::Inside { mesh, pose, margin: table.f64("margin") })
            }
            _ => Err(wrong("a mesh")),
        }
    }

    /// m³; an upper bound for bodies that are in the region.
    pub(crate) fn volume(&self) -> f64 {
        match self {
            Region::Box { min, max } => (*max - *min).to_array().iter().product(),
            // The layer is counted from the highest ground below a body, so it may fill more than its own height.
            Region::Above { ground, min, max, .. } => {
                let rise = f64::from(ground.bounds.max.z - ground.bounds.min.z);
                (*max - *min + DVec3::Z * rise).to_array().iter().product()
            }
            Region::Inside { mesh, .. } => mesh.volume(),
        }
    }

    /// The centre of a ball of `radius` at a random place, if the place that was drawn will do.
    pub(crate) fn sample(&self, radius: f64, random: &mut Random) -> Option<DVec3> {
        let r = DVec3::splat(radius);
        match self {
            Region::Box { min, max } => {
                let (low, high) = (*min + r, *max - r);
                low.cmple(high).all().then(|| random.point(low, high))
            }
            Region::Above { ground, position, min, max } => {
                let (low, high) = (*min + r, *max - r);
                if !low.cmple(high).all() {
                    return None;
                }
                let p = random.point(low, high);
                let height = highest(ground, p - *position, radius)?;
                Some(DVec3::new(p.x, p.y, p.z + position.z + height))
            }
            Region::Inside { mesh, pose, margin } => {
                let (min, max) = mesh.bounds();
                let p = random.point(min, max);
                if !mesh.contains_ball(p, radius + margin) {
                    return None;
                }
                Some(pose.position + rotate(pose.rotation, p.as_vec3()).as_dvec3())
            }
        }
    }
}

/// The highest ground in the square of half width `radius` around `p`; none beyond the field. Over a cell the ground is
/// never higher than at the cell's corners.
fn highest(ground: &HeightField, p: DVec3, radius: f64) -> Option<f64> {
    let index = |x: f64, samples: u32, spacing: f32| x / f64::from(spacing) + 0.5 * f64::from(samples - 1);
    let range = |x: f64, samples: u32, spacing: f32| {
        let (low, high) = (index(x - radius, samples, spacing), index(x + radius, samples, spacing));
        let inside = low >= 0.0 && high <= f64::from(samples - 1);
        inside.then(|| (low.floor() as usize, high.ceil() as usize))
    };
    let (i0, i1) = range(p.x, ground.columns, ground.spacing.x)?;
    let (j0, j1) = range(p.y, ground.rows, ground.spacing.y)?;
    let row = |j: usize| &ground.heights[j * ground.columns as usize..][i0..=i1];
    (j0..=j1).flat_map(row).copied().reduce(f32::max).map(f64::from)
}
