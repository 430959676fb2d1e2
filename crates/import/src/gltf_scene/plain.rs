//! Files without physics: every node with a mesh is a body, its instances are bodies each.

use super::{DEEPEST, local, name, shared};
use crate::affine::Affine;
use crate::build::{Builder, Collider, Draft};
use crate::content::{Body, Content, Kind};
use crate::form::{Approximation, Form};
use crate::mesh_file::TriangleSoup;
use crate::mesh_file::gltf::{File, Size, roots};
use ::gltf::Node;
use rockfall_math::{DMat3, DQuat, DVec3, Vec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mesh thinner than this part of its length has no inside.
const FLAT: f32 = 1e-4;

pub(super) fn read(
    file: &File,
    json: &Value,
    root: &Affine,
    mut builder: Builder,
) -> Result<Content, String> {
    let mut soups: BTreeMap<usize, (Arc<TriangleSoup>, bool)> = BTreeMap::new();
    let mut size = Size::default();
    let mut seen = vec![false; file.document.nodes().len()];
    let mut bodies: Vec<Body> = Vec::new();
    builder.note("there are no physics in it: every mesh is a body that forces move, as its convex hull", "");
    let mut waiting: Vec<(Node<'_>, Affine, usize)> =
        roots(&file.document).into_iter().map(|node| (node, *root, 0)).collect();
    while let Some((node, parent, depth)) = waiting.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(shared(&node));
        }
        if depth > DEEPEST {
            return Err(format!("node {} is more than {DEEPEST} nodes deep", node.index()));
        }
        let place = parent.after(&local(&node));
        let children: Vec<_> = node.children().collect();
        waiting.extend(children.into_iter().rev().map(|child| (child, place, depth + 1)));
        let Some(mesh) = node.mesh() else { continue };
        let (soup, flat) = match soups.get(&mesh.index()) {
            Some(known) => known.clone(),
            None => {
                let soup = Arc::new(file.soup(&mesh, &mut size)?);
                let known = (soup.clone(), is_flat(&soup.vertices));
                soups.insert(mesh.index(), known.clone());
                known
            }
        };
        if soup.triangles.is_empty() {
            builder.note("a mesh without triangles is left out", &name(&node));
            continue;
        }
        if flat {
            builder.note("a flat mesh is a body that stands still", &name(&node));
        }
        let (kind, as_what) = match flat {
            true => (Kind::Static, Approximation::Triangles),
            false => (Kind::Dynamic, Approximation::Hull),
        };
        let mut add = |name: String, place: Affine| {
            let mut draft = Draft::new(name.clone(), kind, place);
            let form = Form::Mesh { soup: soup.clone(), as_what };
            draft.colliders.push(Collider { name, form, place, material: None, weight: None });
            bodies.extend(builder.body(&draft));
        };
        match instances(file, &json["nodes"][node.index()])? {
            None => add(name(&node), place),
            Some(all) => {
                let named = name(&node);
                all.iter().enumerate().for_each(|(k, at)| add(format!("{named}[{k}]"), place.after(at)));
            }
        }
    }
    Ok(builder.finish(bodies))
}

/// The instances of a node by `EXT_mesh_gpu_instancing`, each to the node.
fn instances(file: &File, node: &Value) -> Result<Option<Vec<Affine>>, String> {
    let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    if attributes.is_null() {
        return Ok(None);
    }
    let accessor = |name: &str| attributes[name].as_u64().and_then(|i| usize::try_from(i).ok());
    let vectors = |name: &str| accessor(name).map(|i| file.vectors::<3>(i)).transpose();
    let (places, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let turns = accessor("ROTATION").map(|i| file.vectors::<4>(i)).transpose()?;
    let lengths =
        [places.as_ref().map(Vec::len), scales.as_ref().map(Vec::len), turns.as_ref().map(Vec::len)];
    let count = lengths.iter().flatten().copied().max().unwrap_or(0);
    if lengths.iter().flatten().any(|&n| n != count) {
        return Err("attributes of instances have several lengths".into());
    }
    let vector = |all: &Option<Vec<[f32; 3]>>, k: usize, fallback: DVec3| {
        all.as_ref().map_or(fallback, |all| Vec3::from_array(all[k]).as_dvec3())
    };
    let instance = |k: usize| {
        let turn = turns.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[k].map(f64::from));
        let stretch = DMat3::from_diagonal(vector(&scales, k, DVec3::ONE));
        let turned = Affine::rotation(DQuat::from_array(turn)).after(&Affine::linear(stretch));
        Affine::translation(vector(&places, k, DVec3::ZERO)).after(&turned)
    };
    Ok(Some((0..count).map(instance).collect()))
}

/// Whether points lie in a plane, or nearly: as far as they reach from the largest triangle that is found by going as far as one can.
fn is_flat(points: &[Vec3]) -> bool {
    let Some(&a) = points.first() else { return true };
    let farthest = |distance: &dyn Fn(Vec3) -> f32| {
        let best = points.iter().map(|&p| (distance(p), p));
        best.fold((0.0, a), |best, next| if next.0 > best.0 { next } else { best })
    };
    let (length, b) = farthest(&|p| (p - a).length());
    if length == 0.0 {
        return true;
    }
    let along = (b - a) / length;
    let (width, c) = farthest(&|p| (p - a).cross(along).length());
    if width <= FLAT * length {
        return true;
    }
    let normal = (b - a).cross(c - a).normalize();
    let (height, _) = farthest(&|p| (p - a).dot(normal).abs());
    height <= FLAT * length
}
