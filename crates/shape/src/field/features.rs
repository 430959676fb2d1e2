//! Corners and edges of a surface by which it touches others, each known to the samples near it.
//!
//! Two solids with flat sides touch at corners on sides and at edges that cross. Samples find where two bodies are near each other; what lies there is in the lists of those samples. A corner
//! with no edge that bends away, and an edge that does not, touch nobody: the surface around them sticks out as far.

use super::samples::{self, Samples};
use crate::mesh::TrianglePart;
use crate::{EdgeKind, Mesh};
use rockfall_math::{Aabb, Vec3};
use rockfall_tree::Tree;

/// Pieces of edges are no longer than this share of the samples' spacing.
const PIECE: f32 = 0.5;

/// Marks the number of an edge in the lists.
const EDGE: u32 = 1 << 31;

/// A corner or an edge of a [`Field`](super::Field)'s mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// By the number of its vertex.
    Corner(u32),
    /// By its number in [`Features::edges`].
    Edge(u32),
}

/// The normals of the triangles around a corner or an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normals {
    /// Unit vector out of the body, between them.
    pub out: Vec3,
    /// Cosine of the largest angle between that and one of them.
    pub cone: f32,
}

/// An edge at which the surface bends away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureEdge {
    /// Numbers of its vertices, the lower one first.
    pub ends: [u32; 2],
    /// Of its two triangles.
    pub normals: Normals,
}

/// The features of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Of each vertex.
    corners: Vec<Normals>,
    edges: Vec<FeatureEdge>,
    /// Where the list of each sample starts, and where the last one ends.
    starts: Vec<u32>,
    lists: Vec<u32>,
}

impl Features {
    pub(super) fn of(mesh: &Mesh, samples: &Samples, spacing: f32) -> Self {
        let corners: Vec<Normals> =
            samples::corners(mesh).iter().map(|s| Normals { out: s.normal, cone: s.cone }).collect();
        let edges: Vec<FeatureEdge> = edges(mesh);
        let boxes: Vec<Aabb> = samples.points().iter().map(|s| Aabb::from_points([s.position])).collect();
        let tree = Tree::build(&boxes);
        let nearest = |p: Vec3| {
            let mut best = (f32::INFINITY, 0);
            tree.nearest(&Aabb::from_points([p]), f32::INFINITY, |i, _| {
                let way = samples.points()[i as usize].position.distance(p);
                best = if way < best.0 || (way == best.0 && i < best.1) { (way, i) } else { best };
                best.0
            });
            best.1
        };
        let mut sharp = vec![false; corners.len()];
        // (sample, feature)
        let mut all: Vec<(u32, u32)> = Vec::new();
        for (number, edge) in edges.iter().enumerate() {
            let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
            let parts = (a.distance(b) / (PIECE * spacing)).ceil().max(1.0) as u32;
            let middle = |i: u32| a + (b - a) * ((i as f32 + 0.5) / parts as f32);
            all.extend((0..parts).map(|i| (nearest(middle(i)), EDGE | number as u32)));
            edge.ends.iter().for_each(|&v| sharp[v as usize] = true);
        }
        let corners_of = sharp.iter().enumerate().filter(|(_, sharp)| **sharp);
        all.extend(corners_of.map(|(v, _)| (nearest(mesh.vertices[v]), v as u32)));
        all.sort_unstable();
        all.dedup();
        let mut starts = vec![0; samples.points().len() + 1];
        all.iter().for_each(|&(sample, _)| starts[sample as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        Features { corners, edges, starts, lists: all.into_iter().map(|(_, feature)| feature).collect() }
    }

    /// The features that are nearer to a sample than to the others, of edges at least a piece.
    pub fn near(&self, sample: usize) -> impl Iterator<Item = Feature> {
        let list = self.starts[sample] as usize..self.starts[sample + 1] as usize;
        self.lists[list].iter().map(|&word| match word & EDGE {
            0 => Feature::Corner(word),
            _ => Feature::Edge(word & !EDGE),
        })
    }

    /// Normals around a vertex.
    pub fn corner(&self, vertex: u32) -> Normals {
        self.corners[vertex as usize]
    }

    /// Edges at which the surface bends away.
    pub fn edges(&self) -> &[FeatureEdge] {
        &self.edges
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        size_of::<Normals>() * self.corners.capacity()
            + size_of::<FeatureEdge>() * self.edges.capacity()
            + 4 * (self.starts.capacity() + self.lists.capacity())
    }
}

fn edges(mesh: &Mesh) -> Vec<FeatureEdge> {
    let mut edges = Vec::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for edge in 0..3 {
            if mesh.edges[t][edge] == EdgeKind::Convex && mesh.neighbours[t][edge] as usize > t {
                let out = samples::normal(mesh, t, TrianglePart::Edge(edge));
                let [a, b] = [corners[edge], corners[(edge + 1) % 3]];
                let normals = Normals { out, cone: out.dot(mesh.normals[t]) };
                edges.push(FeatureEdge { ends: [a.min(b), a.max(b)], normals });
            }
        }
    }
    edges
}
