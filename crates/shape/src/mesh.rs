//! Triangle surfaces of immovable bodies.

use rockfall_math::{Aabb, Vec3};
use rockfall_tree::Tree;

/// A triangle surface with what the pair functions need to avoid bumps at internal edges.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Corners, metres.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle, counter-clockwise from the outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normal of each triangle.
    pub normals: Vec<Vec3>,
    /// Edge i of a triangle runs from corner i to corner (i + 1) % 3.
    pub edges: Vec<[EdgeKind; 3]>,
    /// Neighbour over each edge, `u32::MAX` where there is none.
    pub neighbours: Vec<[u32; 3]>,
    /// Broad phase over the triangles' boxes.
    pub tree: Tree,
    /// Box around the vertices.
    pub bounds: Aabb,
    /// Every edge joins exactly two triangles that agree in orientation, so that the inside is defined.
    pub closed: bool,
}

/// How the surface bends at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Only one triangle, or more than two: the edge collides by itself.
    Boundary,
    /// The surface bends away: the edge collides, with normals between those of its two triangles.
    Convex,
    /// The two triangles lie in one plane: no body ever touches the edge alone.
    Flat,
    /// The surface bends inwards: the edge is out of reach.
    Concave,
}
