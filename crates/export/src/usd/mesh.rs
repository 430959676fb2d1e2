//! Surfaces as meshes.

use crate::Surface;
use crate::prototypes::Prototypes;
use rockfall_math::Vec3;
use rockfall_usd::{Array, Attribute, Prim, Value};

/// A mesh in the frame of its body, without a look.
pub(super) fn of(name: String, surface: &Surface) -> Prim {
    let floats = |values: &[Vec3]| Value::Array(Array::Float3(values.iter().map(Vec3::to_array).collect()));
    let ints = |values: Vec<i32>| Value::Array(Array::Int(values));
    let corners = surface.triangles.as_flattened().iter().map(|&corner| corner as i32).collect();
    let (low, high) = surface
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    // Faces are what they are: nothing is to be made round.
    let mesh = Prim::def("Mesh", name)
        .with(Attribute::uniform("token", "subdivisionScheme", Value::Token("none".into())))
        .with(Attribute::new("float3[]", "extent", floats(&[low, high])))
        .with(Attribute::new("point3f[]", "points", floats(&surface.positions)))
        .with(Attribute::new("int[]", "faceVertexCounts", ints(vec![3; surface.triangles.len()])))
        .with(Attribute::new("int[]", "faceVertexIndices", ints(corners)));
    if surface.normals.is_empty() {
        return mesh;
    }
    let normals = Attribute::new("normal3f[]", "normals", floats(&surface.normals));
    mesh.with(normals.meta("interpolation", Value::Token("vertex".into())))
}

/// How far any of these surfaces reaches from the origin of its frame, metres.
pub(super) fn reach(surfaces: &Prototypes) -> f32 {
    let positions = surfaces.iter().flat_map(|(_, surface)| &surface.positions);
    positions.map(|p| p.length()).fold(0.0, f32::max)
}
