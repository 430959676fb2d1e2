//! Convex polyhedra: the cooked form that the pair functions read.

use rockfall_math::{Aabb, Vec3};

/// A convex polyhedron, faces merged where they are coplanar.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners, metres, in the user's frame.
    pub vertices: Vec<Vec3>,
    /// Outward unit normal of each face.
    pub normals: Vec<Vec3>,
    /// `normals[f] · p == offsets[f]` for every point p of face f.
    pub offsets: Vec<f32>,
    /// `loops[loop_starts[f]..loop_starts[f + 1]]` are the corners of face f, counter-clockwise from outside.
    pub loop_starts: Vec<u32>,
    /// Vertex indices, see `loop_starts`.
    pub loops: Vec<u32>,
    /// Every edge once.
    pub edges: Vec<HullEdge>,
    /// Box around the vertices.
    pub bounds: Aabb,
    /// A point well inside: the centroid of the volume.
    pub center: Vec3,
    /// Distance from `center` to the nearest face.
    pub inner_radius: f32,
}

/// An edge of a [`Hull`] with the two faces that it joins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HullEdge {
    /// The edge runs from `vertices[0]` to `vertices[1]`, counter-clockwise around `faces[0]`.
    pub vertices: [u32; 2],
    /// The face on the left, seen from outside, and the one on the right.
    pub faces: [u32; 2],
}

impl Hull {
    /// Corners of face `f`, counter-clockwise from outside.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.loops[self.loop_starts[f] as usize..self.loop_starts[f + 1] as usize]
    }
}
