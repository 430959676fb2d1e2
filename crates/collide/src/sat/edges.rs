//! Which pair of edges of two polyhedra separates them most: one edge of A against as many of B at a time as there are lanes.

use super::{Axis, Kind, edge_axis};
use crate::poly::Poly;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Aabb, Isometry, Vec3};
use rockfall_shape::HULL_LANES;
use smallvec::SmallVec;

/// The best pair among those edges that come within `reach` of the other polyhedron's box.
pub(super) fn best(a: &Poly, b: &Poly, b_in_a: &Isometry, reach: f32) -> Option<Axis> {
    let placed: Points = b.vertices.iter().map(|&v| b_in_a.point(v)).collect();
    let near_a = near(a, a.vertices, &bounds(&placed).grown(reach));
    let near_b = near(b, &placed, &bounds(a.vertices).grown(reach));
    if near_a.is_empty() || near_b.is_empty() {
        return None;
    }
    Width::native().run(Best { a, b, b_in_a, placed: &placed, near_a: &near_a, near_b: &near_b })
}

/// Points that stay on the stack for hulls of ordinary size.
type Points = SmallVec<[Vec3; 64]>;

fn bounds(points: &[Vec3]) -> Aabb {
    Aabb::from_points(points.iter().copied())
}

/// The edges that are not all on one side beyond a box, by the sides that each corner is beyond (Cohen and Sutherland's codes).
fn near(poly: &Poly, corners: &[Vec3], other: &Aabb) -> SmallVec<[u32; 64]> {
    let beyond: SmallVec<[u8; 64]> = corners
        .iter()
        .map(|p| {
            let (below, above) = (p.cmplt(other.min).bitmask(), p.cmpgt(other.max).bitmask());
            (below | above << 3) as u8
        })
        .collect();
    let is_near = |e: &u32| {
        let [p, q] = poly.edges[*e as usize].vertices;
        beyond[p as usize] & beyond[q as usize] == 0
    };
    (0..poly.edges.len() as u32).filter(is_near).collect()
}

struct Best<'a> {
    a: &'a Poly<'a>,
    b: &'a Poly<'a>,
    b_in_a: &'a Isometry,
    /// Corners of B in A's frame.
    placed: &'a [Vec3],
    near_a: &'a [u32],
    near_b: &'a [u32],
}

/// Edges of B in A's frame: normals of the faces on both sides, and direction. Idle lanes are zero and cross nothing.
type EdgeBlock = [[f32; HULL_LANES]; 9];

impl Kernel for Best<'_> {
    type Output = Option<Axis>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Option<Axis> {
        let Best { a, b, placed, near_a, near_b, .. } = self;
        let blocks: SmallVec<[EdgeBlock; 4]> =
            near_b.chunks(HULL_LANES).map(|chunk| self.block(chunk)).collect();
        let mut best: Option<Axis> = None;
        for &i in near_a {
            let edge = &a.edges[i as usize];
            let first = edge.vertices.map(|v| a.vertices[v as usize]);
            let [left, right] = edge.faces.map(|f| a.normals[f as usize]);
            let arc = Arc {
                left: Lanes3::<L>::splat(token, left),
                right: Lanes3::splat(token, right),
                along: Lanes3::splat(token, first[1] - first[0]),
            };
            for (k, block) in blocks.iter().enumerate() {
                for l in (0..HULL_LANES).step_by(L::WIDTH) {
                    let mut crossed = L::bits(arc.crosses(token, block, l));
                    while crossed != 0 {
                        let lane = l + crossed.trailing_zeros() as usize;
                        crossed &= crossed - 1;
                        let j = near_b[k * HULL_LANES + lane];
                        let second = b.edges[j as usize].vertices.map(|v| placed[v as usize]);
                        let Some((normal, separation)) = edge_axis(first, second, a.center) else { continue };
                        if best.is_none_or(|b| separation > b.separation) {
                            let kind = Kind::Edges(i as usize, j as usize);
                            best = Some(Axis { normal, separation, kind });
                        }
                    }
                }
            }
        }
        best
    }
}

impl Best<'_> {
    /// Up to sixteen edges of B.
    #[inline(always)]
    fn block(&self, edges: &[u32]) -> EdgeBlock {
        let mut block = EdgeBlock::default();
        for (lane, &j) in edges.iter().enumerate() {
            let edge = &self.b.edges[j as usize];
            let [left, right] = edge.faces.map(|f| self.b_in_a.vector(self.b.normals[f as usize]));
            let [p, q] = edge.vertices.map(|v| self.placed[v as usize]);
            for (k, x) in [left, right, q - p].iter().flat_map(|v| v.to_array()).enumerate() {
                block[k][lane] = x;
            }
        }
        block
    }
}

/// An edge of A: the normals of its faces, and its direction.
struct Arc<L> {
    left: Lanes3<L>,
    right: Lanes3<L>,
    along: Lanes3<L>,
}

impl<L: Lanes> Arc<L> {
    /// Whether the arc of A's edge crosses the mirrored ones of B's: each arc has its ends on both sides of the other's plane, and they
    /// do so on the same hemisphere.
    #[inline(always)]
    fn crosses(&self, token: L::Token, block: &EdgeBlock, l: usize) -> L::Mask {
        let vector = |k: usize| {
            Lanes3::new(
                L::load(token, &block[k][l..]),
                L::load(token, &block[k + 1][l..]),
                L::load(token, &block[k + 2][l..]),
            )
        };
        let (left, right, along) = (vector(0), vector(3), vector(6));
        let (left_of_b, right_of_b) = (left.dot(self.along), right.dot(self.along));
        let (left_of_a, right_of_a) = (along.dot(self.left), along.dot(self.right));
        let across = (left_of_b * right_of_b).max(left_of_a * right_of_a).max(left_of_b * right_of_a);
        across.lt(L::splat(token, 0.0))
    }
}
