//! Corners and faces of a hull sixteen side by side, and the faces around each corner: what loops over all of them read.

use super::{Hull, HullEdge};
use rockfall_math::Vec3;

/// Numbers side by side in a block.
pub const HULL_LANES: usize = 16;

/// x, y and z of sixteen corners, the last one repeated where there are fewer.
pub type CornerBlock = [[f32; HULL_LANES]; 3];

/// x, y and z of the normals of sixteen faces, and their offsets; idle faces have no direction, and are infinitely far out, so that
/// nothing is ever beyond them.
pub type FaceBlock = [[f32; HULL_LANES]; 4];

/// Of sixteen edges the normal and the offset of the face on the left, then of the one on the right, the cosine of the angle between both, and one over
/// that of half of it: how much further than along both normals something may reach along a direction between them; then x, y and z from one end to the other. Idle edges have idle faces and no length.
pub type EdgeBlock = [[f32; HULL_LANES]; 13];

/// What follows from the columns of a [`Hull`], in another layout.
#[derive(Clone, Default, PartialEq)]
pub struct HullBlocks {
    /// All corners.
    pub corners: Vec<CornerBlock>,
    /// All faces.
    pub faces: Vec<FaceBlock>,
    /// All edges.
    pub edges: Vec<EdgeBlock>,
    /// `rings[ring_starts[v]..ring_starts[v + 1]]` are the faces around corner v, ascending.
    pub ring_starts: Vec<u32>,
    /// Face indices, see `ring_starts`.
    pub rings: Vec<u32>,
}

impl HullBlocks {
    pub(super) fn of(hull: &Hull) -> Self {
        let faces: Vec<(Vec3, f32)> =
            hull.normals.iter().copied().zip(hull.offsets.iter().copied()).collect();
        let mut rings = vec![Vec::new(); hull.vertices.len()];
        for f in 0..faces.len() {
            hull.face(f).iter().for_each(|&v| rings[v as usize].push(f as u32));
        }
        let ends = rings.iter().scan(0, |end, ring| {
            *end += ring.len() as u32;
            Some(*end)
        });
        HullBlocks {
            corners: hull.vertices.chunks(HULL_LANES).map(corner_block).collect(),
            faces: faces.chunks(HULL_LANES).map(face_block).collect(),
            edges: hull
                .edges
                .chunks(HULL_LANES)
                .map(|edges| edge_block(&faces, &hull.vertices, edges))
                .collect(),
            ring_starts: std::iter::once(0).chain(ends).collect(),
            rings: rings.concat(),
        }
    }
}

/// One to sixteen corners.
fn corner_block(corners: &[Vec3]) -> CornerBlock {
    std::array::from_fn(|k| std::array::from_fn(|l| corners[l.min(corners.len() - 1)][k]))
}

/// Up to sixteen faces.
fn face_block(faces: &[(Vec3, f32)]) -> FaceBlock {
    let face = |l: usize| faces.get(l).copied().unwrap_or((Vec3::ZERO, f32::INFINITY));
    std::array::from_fn(|k| {
        std::array::from_fn(|l| {
            let (normal, offset) = face(l);
            if k < 3 { normal[k] } else { offset }
        })
    })
}

/// Up to sixteen edges between some of these faces.
fn edge_block(faces: &[(Vec3, f32)], vertices: &[Vec3], edges: &[HullEdge]) -> EdgeBlock {
    let mut block = EdgeBlock::default();
    // An edge that is not there lies in a face that is endlessly far out.
    let none = ([(Vec3::X, f32::INFINITY); 2], Vec3::ZERO);
    let known = edges.iter().map(|edge| {
        let [from, to] = edge.vertices.map(|v| vertices[v as usize]);
        (edge.faces.map(|f| faces[f as usize]), to - from)
    });
    for (l, (sides, along)) in known.chain(std::iter::repeat(none)).take(HULL_LANES).enumerate() {
        let [(left, of_left), (right, of_right)] = sides;
        let numbers = left.to_array().into_iter().chain([of_left]).chain(right.to_array()).chain([of_right]);
        let spread = 2.0 / (left + right).length();
        let numbers = numbers.chain([left.dot(right), spread]).chain(along.to_array());
        block.iter_mut().zip(numbers).for_each(|(row, x)| row[l] = x);
    }
    block
}

/// They say nothing that the columns of the hull don't.
impl std::fmt::Debug for HullBlocks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("HullBlocks")
    }
}
