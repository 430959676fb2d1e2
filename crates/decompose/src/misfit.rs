//! How far a compound is from the mesh that it stands for: the Hausdorff distance of the two solids, by sampling.
//!
//! Two one-sided distances say two things. *Missing* is how far a point of the mesh's solid may be from the hulls: what would be seen to
//! sink in. *Filled* is how far a point of the hulls may be from the mesh's solid: what would be held off by nothing. Both solids are
//! sampled on a grid, which finds what is filled in the middle of an opening, and on their surfaces.

use rayon::prelude::*;
use rockfall_collide::nearest_point;
use rockfall_math::{Aabb, DVec3, Vec3};
use rockfall_shape::{Compound, Mesh, Shape};
use std::sync::Arc;

/// The Hausdorff distance of two solids from both sides, by samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// The farthest that a sample of the mesh's solid is from the hulls, metres.
    pub missing: f32,
    /// The farthest that a sample of the hulls is from the mesh's solid, metres.
    pub filled: f32,
    /// Samples are no further apart than this along each axis of the grid, and on surfaces, metres. A distance changes by no more than one
    /// goes: between samples each of the two may be larger by up to 0.87 times as much.
    pub spacing: f32,
    /// How many points were looked at.
    pub samples: usize,
}

impl Misfit {
    /// The larger of the two.
    pub fn largest(&self) -> f32 {
        self.missing.max(self.filled)
    }
}

/// Measures the misfit of a compound and the closed mesh that it stands for, at points `spacing` metres apart.
pub fn misfit(mesh: &Mesh, compound: &Compound, spacing: f32) -> Misfit {
    let solid = Shape::Mesh(Arc::new(mesh.clone()));
    let hulls = Shape::Compound(Arc::new(compound.clone()));
    let points = samples(mesh, compound, spacing);
    let far =
        |shape: &Shape, p: DVec3| nearest_point(shape, p, f32::INFINITY).map_or(0.0, |near| near.distance);
    let at = |p: &Vec3| {
        let p = p.as_dvec3();
        let (from_mesh, from_hulls) = (far(&solid, p), far(&hulls, p));
        // A point of a surface is in its solid, whatever rounding says.
        let slack = 1e-6 * (mesh.bounds.half_extents().length() + mesh.bounds.center().length());
        let missing = if from_mesh <= slack { from_hulls } else { 0.0 };
        let filled = if from_hulls <= slack { from_mesh } else { 0.0 };
        [missing, filled]
    };
    let both = points.par_iter().with_min_len(256).map(at);
    let [missing, filled] = both.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    Misfit { missing, filled, spacing, samples: points.len() }
}

/// A grid over both, and points of both surfaces.
fn samples(mesh: &Mesh, compound: &Compound, spacing: f32) -> Vec<Vec3> {
    let mut points = Vec::new();
    let Aabb { min, max } = mesh.bounds.union(&compound.bounds());
    let [x, y, z] = ((max - min) / spacing).to_array().map(|n| n.ceil() as u32);
    for k in 0..=z {
        for j in 0..=y {
            let row = (0..=x).map(|i| min + spacing * Vec3::new(i as f32, j as f32, k as f32));
            points.extend(row);
        }
    }
    for t in 0..mesh.triangles.len() {
        triangle(mesh.triangle(t), spacing, &mut points);
    }
    for part in compound.parts() {
        if let Shape::Hull(hull) = &part.shape {
            for face in (0..hull.normals.len()).map(|f| hull.face(f)) {
                let corner = |c: u32| part.place.point(hull.vertices[c as usize]);
                for pair in face[1..].windows(2) {
                    triangle([face[0], pair[0], pair[1]].map(corner), spacing, &mut points);
                }
            }
        }
    }
    points
}

/// Points of a triangle, its corners included, no further apart than `spacing` along its edges.
fn triangle([a, b, c]: [Vec3; 3], spacing: f32, points: &mut Vec<Vec3>) {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let n = (longest / spacing).ceil().max(1.0) as u32;
    for i in 0..=n {
        for j in 0..=n - i {
            let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
            points.push(a + u * (b - a) + v * (c - a));
        }
    }
}
