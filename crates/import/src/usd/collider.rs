//! Colliders: the geometry of prims with `PhysicsCollisionAPI`.

use super::values::{integers, number, said, vectors, word};
use crate::affine::Affine;
use crate::build::Builder;
use crate::form::{Approximation, Form};
use crate::mesh_file::TriangleSoup;
use openusd::usd::Prim;
use rockfall_math::{DMat3, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Samples along the longest side of a field where the stage does not say (PhysX' own number).
const FIELD: u32 = 256;

/// Meshes that have been read, by the path of what they are made of: instances share it.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    known: BTreeMap<String, Option<Arc<TriangleSoup>>>,
}

/// The form of a collider and how it lies in its prim; none, with a note, where there is none that is supported.
pub(super) fn form(
    prim: &Prim,
    meshes: &mut Meshes,
    builder: &mut Builder,
) -> Result<Option<(Form, Affine)>, String> {
    let kind = prim.type_name().map_err(said)?;
    let kind = kind.as_ref().map_or("", |kind| kind.as_str());
    let length =
        |name: &str, fallback: f64| -> Result<f64, String> { Ok(number(prim, name)?.unwrap_or(fallback)) };
    let radius = |name: &str, fallback: f64| -> Result<f64, String> {
        number(prim, name)?.map_or_else(|| length("radius", fallback), Ok)
    };
    let form = match kind {
        "Cube" => Form::Cuboid { half: DVec3::splat(0.5 * length("size", 2.0)?) },
        "Sphere" => Form::Ball { radius: length("radius", 1.0)? },
        "Capsule" | "Capsule_1" => {
            let (bottom, top) = (radius("radiusBottom", 0.5)?, radius("radiusTop", 0.5)?);
            if bottom != top {
                builder.note("a capsule with ends of two sizes is left out", prim.path().as_str());
                return Ok(None);
            }
            Form::Capsule { half_length: 0.5 * length("height", 1.0)?, radius: bottom }
        }
        "Cylinder" | "Cylinder_1" => Form::Cone {
            half_length: 0.5 * length("height", 2.0)?,
            lower: radius("radiusBottom", 1.0)?,
            upper: radius("radiusTop", 1.0)?,
        },
        "Cone" => Form::Cone {
            half_length: 0.5 * length("height", 2.0)?,
            lower: length("radius", 1.0)?,
            upper: 0.0,
        },
        "Plane" => Form::Plane,
        "Mesh" => match meshes.read(prim, builder)? {
            Some(soup) => Form::Mesh { soup, as_what: approximation(prim, builder)? },
            None => return Ok(None),
        },
        other => {
            let what = if other.is_empty() { "a prim without type" } else { other };
            builder.note(format!("{what} as a collider is left out"), prim.path().as_str());
            return Ok(None);
        }
    };
    let axis = match form {
        Form::Capsule { .. } | Form::Cone { .. } | Form::Plane => word(prim, "axis")?,
        _ => None,
    };
    Ok(Some((form, along(axis.as_deref().unwrap_or("Z")))))
}

/// Our z axis to another one; axes change places in a ring, so that all numbers stay as they are.
fn along(axis: &str) -> Affine {
    Affine::linear(match axis {
        "X" => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        "Y" => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
        _ => DMat3::IDENTITY,
    })
}

/// What stands for a mesh, by `physics:approximation`.
fn approximation(prim: &Prim, builder: &mut Builder) -> Result<Approximation, String> {
    let word = word(prim, "physics:approximation")?;
    Ok(match word.as_deref().unwrap_or("none") {
        "none" => Approximation::Triangles,
        "convexHull" => Approximation::Hull,
        "convexDecomposition" => {
            let most = number(prim, "physxConvexDecompositionCollision:maxConvexHulls")?;
            Approximation::Decomposition { max_hulls: most.map(|n| n.clamp(4.0, 1024.0) as u32) }
        }
        "boundingCube" => Approximation::Cube,
        "boundingSphere" => Approximation::Sphere,
        "sdf" => {
            let resolution = number(prim, "physxSDFMeshCollision:sdfResolution")?;
            Approximation::Field { resolution: resolution.map_or(FIELD, |n| n.clamp(8.0, 4096.0) as u32) }
        }
        "meshSimplification" => {
            builder.note("a mesh that is to be simplified is taken as it is", prim.path().as_str());
            Approximation::Triangles
        }
        other => {
            let what = format!("approximation `{other}` is not known: the mesh is taken as it is");
            builder.note(what, prim.path().as_str());
            Approximation::Triangles
        }
    })
}

impl Meshes {
    /// The triangles of a mesh, polygons cut into fans; none, with a note, where there is nothing in it.
    fn read(&mut self, prim: &Prim, builder: &mut Builder) -> Result<Option<Arc<TriangleSoup>>, String> {
        // In an instance it is the mesh of the prototype that all instances share.
        let shared = prim.prim_in_prototype().map_err(said)?;
        let key = shared.as_ref().unwrap_or(prim).path().as_str().to_owned();
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let soup = read(prim, builder)?.map(Arc::new);
        self.known.insert(key, soup.clone());
        Ok(soup)
    }
}

fn read(prim: &Prim, builder: &mut Builder) -> Result<Option<TriangleSoup>, String> {
    let name = prim.path().as_str();
    let vertices = vectors(prim, "points")?;
    let (counts, corners) = (integers(prim, "faceVertexCounts")?, integers(prim, "faceVertexIndices")?);
    let holes = integers(prim, "holeIndices")?;
    if let Some(index) = vertices.iter().position(|v| !v.is_finite()) {
        return Err(format!("{name}: point {index} is not finite"));
    }
    let mut soup = TriangleSoup { vertices, triangles: Vec::new() };
    let mut rest = corners.as_slice();
    for (face, &count) in counts.iter().enumerate() {
        let taken = usize::try_from(count).ok().filter(|&n| n <= rest.len());
        let Some(taken) = taken else {
            return Err(format!("{name}: face {face} has {count} corners, but {} are left", rest.len()));
        };
        let (mine, others) = rest.split_at(taken);
        rest = others;
        let corner = |&index: &i64| {
            u32::try_from(index).ok().filter(|&i| (i as usize) < soup.vertices.len()).ok_or_else(|| {
                format!("{name}: face {face} names point {index}, but there are {}", soup.vertices.len())
            })
        };
        let polygon = mine.iter().map(corner).collect::<Result<Vec<u32>, String>>()?;
        if !holes.contains(&(face as i64)) {
            soup.push_polygon(&polygon);
        }
    }
    if soup.triangles.is_empty() {
        builder.note("a mesh without faces is left out", name);
        return Ok(None);
    }
    if word(prim, "orientation")?.as_deref() == Some("leftHanded") {
        soup.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    // The cage of a subdivision surface is taken as it is, as other engines do.
    Ok(Some(soup))
}
