//! What `KHR_physics_rigid_bodies` and `KHR_implicit_shapes` say, from the JSON of a file.

use crate::content::{Material, Mix};
use crate::form::Form;
use ::gltf::Glb;
use rockfall_math::{DMat3, DQuat, DVec3};
use serde_json::Value;

const PHYSICS: &str = "KHR_physics_rigid_bodies";
const SHAPES: &str = "KHR_implicit_shapes";

/// The JSON of a file, text or binary.
pub(super) fn json(bytes: &[u8]) -> Result<Value, String> {
    let text = match bytes.starts_with(b"glTF") {
        true => Glb::from_slice(bytes).map_err(|error| error.to_string())?.json.into_owned(),
        false => bytes.to_vec(),
    };
    serde_json::from_slice(&text).map_err(|error| error.to_string())
}

/// All that a file says of physics.
#[derive(Debug)]
pub(super) struct Physics {
    pub(super) shapes: Vec<Option<(Form, DMat3)>>,
    pub(super) materials: Vec<Material>,
    /// Who collides with whom.
    pub(super) filters: Vec<Filter>,
    /// Of each node, in their order.
    pub(super) nodes: Vec<Physical>,
}

/// A collision filter.
#[derive(Clone, Debug, Default)]
pub(super) struct Filter {
    systems: Vec<String>,
    /// It collides with these alone.
    with: Option<Vec<String>>,
    /// It collides with all but these.
    without: Vec<String>,
}

/// The physics of a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Physical {
    pub(super) motion: Option<Motion>,
    pub(super) collider: Option<Geometry>,
    /// What only tells who is in it.
    pub(super) trigger: Option<Geometry>,
    pub(super) joint: bool,
}

/// How a body moves, in the node's own frame.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) kinematic: bool,
    pub(super) mass: Option<f64>,
    pub(super) center: Option<DVec3>,
    /// Principal moments and their axes.
    pub(super) inertia: Option<(DVec3, DQuat)>,
    /// A moment of 0 stands for one without end.
    pub(super) endless: bool,
    pub(super) velocity: DVec3,
    /// rad/s.
    pub(super) spin: DVec3,
    pub(super) gravity: f64,
}

/// What a collider is made of: one of these.
#[derive(Clone, Debug, Default)]
pub(super) struct Geometry {
    pub(super) shape: Option<usize>,
    pub(super) mesh: Option<usize>,
    /// A node whose mesh it is.
    pub(super) node: Option<usize>,
    pub(super) hull: bool,
    pub(super) material: Option<usize>,
    pub(super) filter: Option<usize>,
}

impl Filter {
    /// Whether two filters let colliders meet: each must.
    pub(super) fn meets(&self, other: &Filter) -> bool {
        self.lets(other) && other.lets(self)
    }

    fn lets(&self, other: &Filter) -> bool {
        let any = |list: &[String]| other.systems.iter().any(|system| list.contains(system));
        self.with.as_deref().is_none_or(any) && !any(&self.without)
    }
}

impl Physics {
    /// None where no node has physics.
    pub(super) fn read(json: &Value) -> Result<Option<Self>, String> {
        let physics = &json["extensions"][PHYSICS];
        let nodes = list(&json["nodes"]).iter().enumerate().map(|(index, node)| {
            physical(&node["extensions"][PHYSICS]).map_err(|why| format!("node {index}: {why}"))
        });
        let nodes = nodes.collect::<Result<Vec<Physical>, String>>()?;
        if nodes.iter().all(|node| node.motion.is_none() && node.collider.is_none() && node.trigger.is_none())
        {
            return Ok(None);
        }
        let shapes = list(&json["extensions"][SHAPES]["shapes"]).iter().map(shape);
        let materials = list(&physics["physicsMaterials"]).iter().enumerate().map(material);
        let words = |value: &Value| -> Vec<String> {
            list(value).iter().filter_map(Value::as_str).map(str::to_owned).collect()
        };
        let filter = |value: &Value| Filter {
            systems: words(&value["collisionSystems"]),
            with: value.get("collideWithSystems").map(words),
            without: words(&value["notCollideWithSystems"]),
        };
        Ok(Some(Physics {
            shapes: shapes.collect::<Result<_, String>>()?,
            materials: materials.collect::<Result<_, String>>()?,
            filters: list(&physics["collisionFilters"]).iter().map(filter).collect(),
            nodes,
        }))
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// A number, the fallback where it is not there.
fn number(value: &Value, name: &str, fallback: f64) -> Result<f64, String> {
    match &value[name] {
        Value::Null => Ok(fallback),
        found => found
            .as_f64()
            .filter(|x| x.abs() < 1e18)
            .ok_or_else(|| format!("`{name}` is {found}, expected a number")),
    }
}

fn length(value: &Value, name: &str, fallback: f64) -> Result<f64, String> {
    let found = number(value, name, fallback)?;
    let wrong = || format!("`{name}` is {found}, expected a number of at least 0");
    Some(found).filter(|x| *x >= 0.0).ok_or_else(wrong)
}

fn numbers<const N: usize>(value: &Value, name: &str) -> Result<Option<[f64; N]>, String> {
    let found = &value[name];
    if found.is_null() {
        return Ok(None);
    }
    let all: Option<Vec<f64>> = list(found).iter().map(Value::as_f64).collect();
    let all = all.filter(|all| all.iter().all(|x| x.abs() < 1e18));
    let all = all.and_then(|all| all.try_into().ok());
    all.map(Some).ok_or_else(|| format!("`{name}` is {found}, expected {N} numbers"))
}

fn index(value: &Value, name: &str) -> Result<Option<usize>, String> {
    match &value[name] {
        Value::Null => Ok(None),
        found => {
            let index = found.as_u64().and_then(|i| usize::try_from(i).ok());
            index.map(Some).ok_or_else(|| format!("`{name}` is {found}, expected an index"))
        }
    }
}

/// A shape and the turn from our axes to its own, which has y up; none for a kind that is not known.
fn shape(value: &Value) -> Result<Option<(Form, DMat3)>, String> {
    // Our z axis to y.
    let upright = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);
    let kind = value["type"].as_str().unwrap_or_default();
    let keys = &value[kind];
    Ok(Some(match kind {
        "sphere" => (Form::Ball { radius: length(keys, "radius", 0.5)? }, DMat3::IDENTITY),
        "box" => {
            let half = 0.5 * DVec3::from_array(numbers(keys, "size")?.unwrap_or([1.0; 3]));
            (Form::Cuboid { half }, DMat3::IDENTITY)
        }
        "capsule" => {
            let (bottom, top) = (length(keys, "radiusBottom", 0.25)?, length(keys, "radiusTop", 0.25)?);
            if bottom != top {
                return Ok(None);
            }
            (Form::Capsule { half_length: 0.5 * length(keys, "height", 0.5)?, radius: bottom }, upright)
        }
        "cylinder" => {
            let (lower, upper) = (length(keys, "radiusBottom", 0.25)?, length(keys, "radiusTop", 0.25)?);
            (Form::Cone { half_length: 0.5 * length(keys, "height", 0.5)?, lower, upper }, upright)
        }
        "plane" => (Form::Plane, upright),
        _ => return Ok(None),
    }))
}

fn material((number_of, value): (usize, &Value)) -> Result<Material, String> {
    let name = value["name"].as_str().map_or_else(|| format!("physics material {number_of}"), str::to_owned);
    let mix = |key: &str| match value[key].as_str() {
        Some("minimum") => Mix::Minimum,
        Some("maximum") => Mix::Maximum,
        Some("multiply") => Mix::Product,
        _ => Mix::Average,
    };
    Ok(Material {
        friction: length(value, "dynamicFriction", 0.6)? as f32,
        restitution: length(value, "restitution", 0.0)?.min(1.0) as f32,
        density: None,
        friction_mix: mix("frictionCombine"),
        restitution_mix: mix("restitutionCombine"),
        name,
    })
}

fn physical(value: &Value) -> Result<Physical, String> {
    let there = |name: &str| value.get(name).is_some_and(|found| !found.is_null());
    let geometry = |name: &str| -> Result<Option<Geometry>, String> {
        let (owner, keys) = (&value[name], &value[name]["geometry"]);
        let read = || -> Result<Geometry, String> {
            Ok(Geometry {
                shape: index(keys, "shape")?,
                mesh: index(keys, "mesh")?,
                node: index(keys, "node")?,
                hull: keys["convexHull"].as_bool().unwrap_or(false),
                material: index(owner, "physicsMaterial")?,
                filter: index(owner, "collisionFilter")?,
            })
        };
        there(name).then(read).transpose()
    };
    Ok(Physical {
        motion: there("motion").then(|| motion(&value["motion"])).transpose()?,
        collider: geometry("collider")?,
        trigger: geometry("trigger")?,
        joint: there("joint"),
    })
}

fn motion(value: &Value) -> Result<Motion, String> {
    let vector =
        |name: &str| -> Result<Option<DVec3>, String> { Ok(numbers(value, name)?.map(DVec3::from_array)) };
    let mass = length(value, "mass", 0.0)?;
    let moments = vector("inertiaDiagonal")?;
    let endless = moments.is_some_and(|m| m.min_element() <= 0.0);
    let axes = numbers(value, "inertiaOrientation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    Ok(Motion {
        kinematic: value["isKinematic"].as_bool().unwrap_or(false),
        mass: Some(mass).filter(|mass| *mass > 0.0),
        center: vector("centerOfMass")?,
        inertia: moments.filter(|_| !endless).map(|moments| (moments, DQuat::from_array(axes))),
        endless,
        velocity: vector("linearVelocity")?.unwrap_or_default(),
        spin: vector("angularVelocity")?.unwrap_or_default(),
        gravity: number(value, "gravityFactor", 1.0)?,
    })
}
