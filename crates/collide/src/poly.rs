//! Boxes and hulls behind one face: what the functions over polyhedra read.

use rockfall_math::Vec3;
use rockfall_shape::{CornerBlock, EdgeBlock, FaceBlock, HULL_LANES, Hull, HullEdge};

/// A borrowed convex polyhedron; see [`Hull`] for the meaning of each slice.
#[derive(Clone, Copy)]
pub(crate) struct Poly<'a> {
    pub(crate) vertices: &'a [Vec3],
    pub(crate) normals: &'a [Vec3],
    pub(crate) offsets: &'a [f32],
    loop_starts: &'a [u32],
    loops: &'a [u32],
    pub(crate) edges: &'a [HullEdge],
    pub(crate) corner_blocks: &'a [CornerBlock],
    pub(crate) face_blocks: &'a [FaceBlock],
    pub(crate) edge_blocks: &'a [EdgeBlock],
    ring_starts: &'a [u32],
    rings: &'a [u32],
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

    /// Where those are.
    pub(crate) fn corners(&self, f: usize) -> impl ExactSizeIterator<Item = Vec3> + use<'a> {
        let vertices = self.vertices;
        self.face(f).iter().map(move |&v| vertices[v as usize])
    }

    /// The face whose normal is nearest to `direction`, and its cosine; the first among equals.
    pub(crate) fn face_towards(&self, direction: Vec3) -> (usize, f32) {
        // Some face of a closed surface looks along any direction; idle ones look nowhere.
        let mut best = (0, 0.0);
        for (k, [x, y, z, _]) in self.face_blocks.iter().enumerate() {
            let cosines: Heights =
                std::array::from_fn(|l| x[l] * direction.x + y[l] * direction.y + z[l] * direction.z);
            let most = largest(&cosines);
            if most > best.1 {
                let first = cosines.iter().position(|&cosine| cosine == most).unwrap_or(0);
                best = (k * HULL_LANES + first, most);
            }
        }
        best
    }

    /// The vertex furthest along `direction`; the first among equals.
    pub(crate) fn support(&self, direction: Vec3) -> Vec3 {
        self.vertices[self.support_index(direction)]
    }

    /// How far the furthest vertex is along `direction`.
    pub(crate) fn reach(&self, direction: Vec3) -> f32 {
        let most = |most: f32, block| most.max(largest(&heights(block, direction)));
        self.corner_blocks.iter().fold(f32::NEG_INFINITY, most)
    }

    fn support_index(&self, direction: Vec3) -> usize {
        let mut best = (0, f32::NEG_INFINITY);
        for (k, block) in self.corner_blocks.iter().enumerate() {
            let heights = heights(block, direction);
            let highest = largest(&heights);
            if highest > best.1 {
                let first = heights.iter().position(|&h| h == highest).unwrap_or(0);
                best = (k * HULL_LANES + first, highest);
            }
        }
        best.0
    }

    /// Of the faces around the vertex furthest along `direction`, the one that looks along it the most, and its cosine.
    /// (The face of a hull that looks along a direction the most need not hold that vertex.)
    pub(crate) fn face_at_support(&self, direction: Vec3) -> (usize, f32) {
        let corner = self.support_index(direction);
        let mut best = (0, f32::NEG_INFINITY);
        for &f in &self.rings[self.ring_starts[corner] as usize..self.ring_starts[corner + 1] as usize] {
            let cosine = self.normals[f as usize].dot(direction);
            if cosine > best.1 {
                best = (f as usize, cosine);
            }
        }
        best
    }

    /// Whether a point is inside, or on the surface.
    pub(crate) fn holds(&self, p: Vec3) -> bool {
        self.face_blocks.iter().all(|[x, y, z, offset]| {
            let above: Heights = std::array::from_fn(|l| x[l] * p.x + y[l] * p.y + z[l] * p.z - offset[l]);
            largest(&above) <= 0.0
        })
    }
}

/// A number for each vertex or face of a block.
type Heights = [f32; HULL_LANES];

/// How far the vertices of a block are along a direction.
#[inline]
fn heights([x, y, z]: &CornerBlock, direction: Vec3) -> Heights {
    std::array::from_fn(|l| x[l] * direction.x + y[l] * direction.y + z[l] * direction.z)
}

/// The largest of sixteen numbers.
#[inline(always)]
pub(crate) fn largest(numbers: &Heights) -> f32 {
    fold(numbers, |a, b| if a > b { a } else { b })
}

/// The smallest of sixteen numbers.
#[inline(always)]
pub(crate) fn smallest(numbers: &Heights) -> f32 {
    fold(numbers, |a, b| if a < b { a } else { b })
}

/// Half of the numbers with the other half, and so on, so that they stay side by side.
#[inline(always)]
fn fold(numbers: &Heights, better: impl Fn(f32, f32) -> f32) -> f32 {
    let (mut eight, mut four) = ([0.0; 8], [0.0; 4]);
    for l in 0..8 {
        eight[l] = better(numbers[l], numbers[l + 8]);
    }
    for l in 0..4 {
        four[l] = better(eight[l], eight[l + 4]);
    }
    better(better(four[0], four[2]), better(four[1], four[3]))
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
            corner_blocks: &hull.blocks.corners,
            face_blocks: &hull.blocks.faces,
            edge_blocks: &hull.blocks.edges,
            ring_starts: &hull.blocks.ring_starts,
            rings: &hull.blocks.rings,
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
    corner_block: CornerBlock,
    face_block: FaceBlock,
    edge_block: EdgeBlock,
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

const BOX_RING_STARTS: [u32; 9] = [0, 3, 6, 9, 12, 15, 18, 21, 24];
#[rustfmt::skip]
const BOX_RINGS: [u32; 24] = [
    0, 2, 4,  1, 2, 4,  0, 3, 4,  1, 3, 4,  0, 2, 5,  1, 2, 5,  0, 3, 5,  1, 3, 5,
];

/// The corners of the box around the origin with these half extents, metres.
pub(crate) fn box_corners(half: Vec3) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, h: f32| if i & bit == 0 { -h } else { h };
        Vec3::new(pick(1, half.x), pick(2, half.y), pick(4, half.z))
    })
}

impl BoxPoly {
    /// The box around the origin with these half extents, metres.
    pub(crate) fn new(half: Vec3) -> Self {
        let vertices = box_corners(half);
        let offsets = [half.x, half.x, half.y, half.y, half.z, half.z];
        let face = |k: usize, f: usize| match (k, f) {
            (0..3, 0..6) => BOX_NORMALS[f][k],
            (3, 0..6) => offsets[f],
            (3, _) => f32::INFINITY,
            _ => 0.0,
        };
        let edge = |k: usize, e: usize| match k {
            0..8 => face(k % 4, BOX_EDGES.get(e).map_or(6, |edge| edge.faces[k / 4] as usize)),
            8 => 0.0,
            9 => std::f32::consts::SQRT_2,
            _ => BOX_EDGES.get(e).map_or(0.0, |edge| {
                let [from, to] = edge.vertices.map(|v| vertices[v as usize]);
                (to - from)[k - 10]
            }),
        };
        BoxPoly {
            half,
            vertices,
            offsets,
            corner_block: std::array::from_fn(|k| std::array::from_fn(|l| vertices[l.min(7)][k])),
            face_block: std::array::from_fn(|k| std::array::from_fn(|l| face(k, l))),
            edge_block: std::array::from_fn(|k| std::array::from_fn(|l| edge(k, l))),
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
            corner_blocks: std::slice::from_ref(&self.corner_block),
            face_blocks: std::slice::from_ref(&self.face_block),
            edge_blocks: std::slice::from_ref(&self.edge_block),
            ring_starts: &BOX_RING_STARTS,
            rings: &BOX_RINGS,
            center: Vec3::ZERO,
            inner_radius: self.half.min_element(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    /// Also where there are more corners than a block has, and where several are as far.
    #[test]
    fn the_furthest_corner_is_that_of_a_scan() {
        // Between -1 and 1.
        let wave = |i: usize, k: u64| (mix(8 * i as u64 + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0;
        let points: Vec<Vec3> =
            (0..60).map(|i| Vec3::new(wave(i, 0), wave(i, 1), wave(i, 2)).normalize()).collect();
        let hull = Hull::from_points(&points).expect("points on a ball");
        let cuboid = BoxPoly::new(Vec3::new(1.0, 2.0, 3.0));
        for poly in [Poly::from(&hull), cuboid.poly()] {
            let axes = [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::ONE, Vec3::ZERO];
            for d in axes.into_iter().chain((0..500).map(|i| Vec3::new(wave(i, 3), wave(i, 4), wave(i, 5)))) {
                let height = |v: &Vec3| v.x * d.x + v.y * d.y + v.z * d.z;
                let highest = poly.vertices.iter().map(height).fold(f32::NEG_INFINITY, f32::max);
                assert_eq!(
                    Some(poly.support_index(d)),
                    poly.vertices.iter().position(|v| height(v) == highest)
                );
            }
        }
    }

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
        for v in 0..8 {
            let around: Vec<u32> = (0..6).filter(|&f| poly.face(f as usize).contains(&(v as u32))).collect();
            assert_eq!(&poly.rings[3 * v..3 * v + 3], around);
            assert_eq!(poly.ring_starts[v + 1], 3 * v as u32 + 3);
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
