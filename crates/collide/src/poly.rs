//! Boxes and hulls behind one face: what the functions over polyhedra read.

use rockfall_math::Vec3;
use rockfall_shape::{Hull, HullEdge};

/// A borrowed convex polyhedron; see [`Hull`] for the meaning of each slice.
#[derive(Clone, Copy)]
pub(crate) struct Poly<'a> {
    pub(crate) vertices: &'a [Vec3],
    pub(crate) normals: &'a [Vec3],
    pub(crate) offsets: &'a [f32],
    loop_starts: &'a [u32],
    loops: &'a [u32],
    pub(crate) edges: &'a [HullEdge],
    /// A point well inside.
    pub(crate) center: Vec3,
    /// Distance from `center` to the nearest face, metres.
    pub(crate) inner_radius: f32,
}

impl<'a> Poly<'a> {
    /// Corners of face `f`, counter-clockwise from outside.
    pub(crate) fn face(&self, f: usize) -> &'a [u32] {
        &self.loops[self.loop_starts[f] as usize..self.loop_starts[f + 1] as usize]
    }

    /// The face whose normal is nearest to `direction`, and its cosine; the first among equals.
    pub(crate) fn face_towards(&self, direction: Vec3) -> (usize, f32) {
        let mut best = (0, f32::NEG_INFINITY);
        for (f, n) in self.normals.iter().enumerate() {
            let cosine = n.dot(direction);
            if cosine > best.1 {
                best = (f, cosine);
            }
        }
        best
    }

    /// The vertex furthest along `direction`; the first among equals.
    pub(crate) fn support(&self, direction: Vec3) -> Vec3 {
        self.vertices[self.support_index(direction)]
    }

    fn support_index(&self, direction: Vec3) -> usize {
        let mut best = (0, f32::NEG_INFINITY);
        for (i, v) in self.vertices.iter().enumerate() {
            let along = v.dot(direction);
            if along > best.1 {
                best = (i, along);
            }
        }
        best.0
    }

    /// Of the faces around the vertex furthest along `direction`, the one that looks along it the most, and its cosine.
    /// (The face of a hull that looks along a direction the most need not hold that vertex.)
    pub(crate) fn face_at_support(&self, direction: Vec3) -> (usize, f32) {
        let corner = self.support_index(direction) as u32;
        let mut best = (0, f32::NEG_INFINITY);
        for (f, n) in self.normals.iter().enumerate() {
            let cosine = n.dot(direction);
            if cosine > best.1 && self.face(f).contains(&corner) {
                best = (f, cosine);
            }
        }
        best
    }
}

impl<'a> From<&'a Hull> for Poly<'a> {
    fn from(hull: &'a Hull) -> Self {
        Poly {
            vertices: &hull.vertices,
            normals: &hull.normals,
            offsets: &hull.offsets,
            loop_starts: &hull.loop_starts,
            loops: &hull.loops,
            edges: &hull.edges,
            center: hull.center,
            inner_radius: hull.inner_radius,
        }
    }
}

/// The numbers of a box that [`Poly`] borrows.
///
/// Bit k of a vertex's index is set where its coordinate k is positive. Faces are −x, +x, −y, +y, −z, +z.
pub(crate) struct BoxPoly {
    half: Vec3,
    vertices: [Vec3; 8],
    offsets: [f32; 6],
}

const BOX_NORMALS: [Vec3; 6] = [Vec3::NEG_X, Vec3::X, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_Z, Vec3::Z];
const BOX_LOOP_STARTS: [u32; 7] = [0, 4, 8, 12, 16, 20, 24];
#[rustfmt::skip]
const BOX_LOOPS: [u32; 24] = [
    0, 4, 6, 2,  1, 3, 7, 5,  0, 1, 5, 4,  2, 6, 7, 3,  0, 2, 3, 1,  4, 5, 7, 6,
];
const BOX_EDGES: [HullEdge; 12] = [
    HullEdge { vertices: [0, 1], faces: [2, 4] },
    HullEdge { vertices: [2, 3], faces: [4, 3] },
    HullEdge { vertices: [4, 5], faces: [5, 2] },
    HullEdge { vertices: [7, 6], faces: [5, 3] },
    HullEdge { vertices: [0, 2], faces: [4, 0] },
    HullEdge { vertices: [3, 1], faces: [4, 1] },
    HullEdge { vertices: [5, 7], faces: [5, 1] },
    HullEdge { vertices: [6, 4], faces: [5, 0] },
    HullEdge { vertices: [0, 4], faces: [0, 2] },
    HullEdge { vertices: [1, 5], faces: [2, 1] },
    HullEdge { vertices: [3, 7], faces: [1, 3] },
    HullEdge { vertices: [2, 6], faces: [3, 0] },
];

impl BoxPoly {
    /// The box around the origin with these half extents, metres.
    pub(crate) fn new(half: Vec3) -> Self {
        let corner = |i: usize| {
            let pick = |bit: usize, h: f32| if i & bit == 0 { -h } else { h };
            Vec3::new(pick(1, half.x), pick(2, half.y), pick(4, half.z))
        };
        BoxPoly {
            half,
            vertices: std::array::from_fn(corner),
            offsets: [half.x, half.x, half.y, half.y, half.z, half.z],
        }
    }

    pub(crate) fn poly(&self) -> Poly<'_> {
        Poly {
            vertices: &self.vertices,
            normals: &BOX_NORMALS,
            offsets: &self.offsets,
            loop_starts: &BOX_LOOP_STARTS,
            loops: &BOX_LOOPS,
            edges: &BOX_EDGES,
            center: Vec3::ZERO,
            inner_radius: self.half.min_element(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_the_topology_that_it_claims() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let cuboid = BoxPoly::new(half);
        let poly = cuboid.poly();
        for f in 0..6 {
            let corners: Vec<Vec3> = poly.face(f).iter().map(|&v| poly.vertices[v as usize]).collect();
            for k in 0..4 {
                assert_eq!(poly.normals[f].dot(corners[k]), poly.offsets[f]);
                let turn =
                    (corners[(k + 1) % 4] - corners[k]).cross(corners[(k + 2) % 4] - corners[(k + 1) % 4]);
                assert!((turn.normalize() - poly.normals[f]).length() < 1e-6);
            }
        }
        for edge in poly.edges {
            let follows = |f: u32, from: u32, to: u32| {
                let face = poly.face(f as usize);
                (0..4).any(|k| face[k] == from && face[(k + 1) % 4] == to)
            };
            assert!(follows(edge.faces[0], edge.vertices[0], edge.vertices[1]));
            assert!(follows(edge.faces[1], edge.vertices[1], edge.vertices[0]));
        }
    }
}
