//! Scenes of glTF: bodies of `KHR_physics_rigid_bodies` with shapes of `KHR_implicit_shapes`; in a file without them, every node with a mesh as a body.

mod bodies;
mod extension;
mod plain;

use crate::affine::Affine;
use crate::build::Builder;
use crate::content::Content;
use crate::mesh_file::{self, gltf as file};
use ::gltf::Node;
use ::gltf::scene::Transform;
use extension::Physics;
use rockfall_math::{DMat3, DQuat, DVec3};
use std::path::Path;

/// Extensions that a file may ask for: those that are read, and those that change how things look.
const KNOWN: &[&str] = &[
    "KHR_physics_rigid_bodies",
    "KHR_implicit_shapes",
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "EXT_texture_webp",
];

/// Nodes in nodes.
const DEEPEST: usize = 500;

/// Reads a scene; `place` is where it lies in the world, in metres and with z up.
pub(crate) fn read(path: &Path, place: &Affine) -> Result<Content, String> {
    let bytes = mesh_file::content(path).map_err(|error| error.to_string())?;
    let scene = file::open(&bytes, path, KNOWN)?;
    let root = place.after(&file::UPRIGHT);
    let json = extension::json(&bytes)?;
    let mut builder = Builder::default();
    if scene.document.animations().len() > 0 {
        builder.note("animations are not played: nodes stand where they are at first", "");
    }
    match Physics::read(&json)? {
        Some(physics) => bodies::read(&scene, &physics, &root, builder),
        None => plain::read(&scene, &json, &root, builder),
    }
}

/// How a node lies in its parent.
fn local(node: &Node<'_>) -> Affine {
    let vector = |v: [f32; 3]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    match node.transform() {
        Transform::Matrix { matrix } => file::matrix(matrix),
        Transform::Decomposed { translation, rotation: [x, y, z, w], scale } => {
            let turn = Affine::rotation(DQuat::from_xyzw(x.into(), y.into(), z.into(), w.into()));
            let stretch = Affine::linear(DMat3::from_diagonal(vector(scale)));
            Affine::translation(vector(translation)).after(&turn).after(&stretch)
        }
    }
}

/// What people know a node by: its name, else its number.
fn name(node: &Node<'_>) -> String {
    node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned)
}

/// Says that a file is no tree.
fn shared(node: &Node<'_>) -> String {
    format!("node {} has two parents, or is its own ancestor", node.index())
}
