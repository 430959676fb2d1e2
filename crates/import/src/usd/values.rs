//! Values of properties, whatever precision they are written in.

use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, TimeCode};
use rockfall_math::{DQuat, DVec3, Vec3};

/// What the composition engine says of a file, as text.
pub(super) fn said(error: impl std::fmt::Display) -> String {
    format!("{error:#}")
}

/// The value of an attribute at the default time. Where there is none but samples, that at the first of them.
pub(super) fn value(prim: &Prim, name: &str) -> Result<Option<Value>, String> {
    let attribute = prim.attribute(name);
    if let Some(value) = attribute.get::<Value>().map_err(said)? {
        return Ok(Some(value).filter(|v| !matches!(v, Value::ValueBlock | Value::None)));
    }
    match attribute.time_sample_times().map_err(said)?.first() {
        Some(&time) => attribute.get_at::<Value>(TimeCode::from(time)).map_err(said),
        None => Ok(None),
    }
}

/// Whether an attribute has samples.
pub(super) fn is_animated(prim: &Prim, name: &str) -> Result<bool, String> {
    Ok(prim.attribute(name).num_time_samples().map_err(said)? > 0)
}

pub(super) fn number(prim: &Prim, name: &str) -> Result<Option<f64>, String> {
    Ok(value(prim, name)?.as_ref().and_then(as_number))
}

pub(super) fn flag(prim: &Prim, name: &str, fallback: bool) -> Result<bool, String> {
    Ok(match value(prim, name)? {
        Some(Value::Bool(flag)) => flag,
        _ => fallback,
    })
}

pub(super) fn word(prim: &Prim, name: &str) -> Result<Option<String>, String> {
    Ok(value(prim, name)?.as_ref().and_then(as_word))
}

pub(super) fn vector(prim: &Prim, name: &str) -> Result<Option<DVec3>, String> {
    Ok(value(prim, name)?.as_ref().and_then(as_vector))
}

pub(super) fn quaternion(prim: &Prim, name: &str) -> Result<Option<DQuat>, String> {
    Ok(value(prim, name)?.as_ref().and_then(as_quaternion))
}

/// A list of points or vectors.
pub(super) fn vectors(prim: &Prim, name: &str) -> Result<Vec<Vec3>, String> {
    Ok(match value(prim, name)? {
        Some(Value::Vec3fVec(all)) => all.iter().map(|v| Vec3::new(v.x, v.y, v.z)).collect(),
        Some(Value::Vec3dVec(all)) => all.iter().map(|v| DVec3::new(v.x, v.y, v.z).as_vec3()).collect(),
        Some(Value::Vec3hVec(all)) => {
            all.iter().map(|v| Vec3::new(v.x.to_f32(), v.y.to_f32(), v.z.to_f32())).collect()
        }
        _ => Vec::new(),
    })
}

pub(super) fn quaternions(prim: &Prim, name: &str) -> Result<Vec<DQuat>, String> {
    Ok(match value(prim, name)? {
        Some(Value::QuatfVec(all)) => all.into_iter().map(|q| quat([q.w, q.x, q.y, q.z])).collect(),
        Some(Value::QuathVec(all)) => {
            all.into_iter().map(|q| quat([q.w, q.x, q.y, q.z].map(|x| x.to_f32()))).collect()
        }
        Some(Value::QuatdVec(all)) => all.into_iter().map(|q| DQuat::from_xyzw(q.x, q.y, q.z, q.w)).collect(),
        _ => Vec::new(),
    })
}

pub(super) fn integers(prim: &Prim, name: &str) -> Result<Vec<i64>, String> {
    Ok(match value(prim, name)? {
        Some(Value::IntVec(all)) => all.into_iter().map(i64::from).collect(),
        Some(Value::UintVec(all)) => all.into_iter().map(i64::from).collect(),
        Some(Value::Int64Vec(all)) => all,
        _ => Vec::new(),
    })
}

/// Where a relationship leads.
pub(super) fn targets(prim: &Prim, name: &str) -> Result<Vec<Path>, String> {
    prim.relationship(name).forwarded_targets().map_err(said)
}

pub(super) fn as_number(value: &Value) -> Option<f64> {
    match value {
        Value::Double(x) => Some(*x),
        Value::Float(x) => Some(f64::from(*x)),
        Value::Half(x) => Some(x.to_f64()),
        Value::Int(x) => Some(f64::from(*x)),
        Value::Uint(x) => Some(f64::from(*x)),
        Value::Int64(x) => Some(*x as f64),
        _ => None,
    }
}

pub(super) fn as_word(value: &Value) -> Option<String> {
    match value {
        Value::Token(word) => Some(word.as_str().to_owned()),
        Value::String(word) => Some(word.clone()),
        _ => None,
    }
}

pub(super) fn as_vector(value: &Value) -> Option<DVec3> {
    match value {
        Value::Vec3d(v) => Some(DVec3::new(v.x, v.y, v.z)),
        Value::Vec3f(v) => Some(DVec3::new(v.x.into(), v.y.into(), v.z.into())),
        Value::Vec3h(v) => Some(DVec3::new(v.x.to_f64(), v.y.to_f64(), v.z.to_f64())),
        _ => None,
    }
}

pub(super) fn as_quaternion(value: &Value) -> Option<DQuat> {
    match value {
        Value::Quatd(q) => Some(DQuat::from_xyzw(q.x, q.y, q.z, q.w)),
        Value::Quatf(q) => Some(quat([q.w, q.x, q.y, q.z])),
        Value::Quath(q) => Some(quat([q.w, q.x, q.y, q.z].map(|x| x.to_f32()))),
        _ => None,
    }
}

fn quat([w, x, y, z]: [f32; 4]) -> DQuat {
    DQuat::from_xyzw(x.into(), y.into(), z.into(), w.into())
}

pub(super) fn radians(degrees: DVec3) -> DVec3 {
    DVec3::from_array(degrees.to_array().map(f64::to_radians))
}
