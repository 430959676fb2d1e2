//! Which pair of edges of two polyhedra separates them most: one edge of A against as many of B at a time as there are lanes.
//!
//! The axis of a pair is a direction between the normals of the faces on both sides of each edge. Along a
//! direction n a polyhedron comes nearer than its centre c does by
//! the radius of its inner ball at least, so the pair separates by no more than n · (c − p) less that radius,
//! with p on the edge. The largest
//! of these over all n between the two normals is known to a few percent from both of them, and most edges
//! are passed over for that.

use super::{Axis, Kind, edge_axis};
use crate::poly::Poly;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{EdgeBlock, HULL_LANES};
use smallvec::SmallVec;

/// The best of the pairs that separate by more than `floor`, and perhaps of some that don't.
pub(super) fn best(a: &Poly, b: &Poly, b_in_a: &Isometry, floor: f32) -> Option<Axis> {
    Width::native().run(Best { a, b, b_in_a, floor })
}

struct Best<'a> {
    a: &'a Poly<'a>,
    b: &'a Poly<'a>,
    b_in_a: &'a Isometry,
    floor: f32,
}

/// Of each block of edges those that are not passed over, a bit each; most hulls have a few blocks.
pub(crate) struct Edges(SmallVec<[u16; 8]>);

impl Edges {
    fn is_empty(&self) -> bool {
        self.0.iter().all(|&mask| mask == 0)
    }

    /// Their numbers, ascending.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(k, &mask)| lanes(mask).map(move |lane| k * HULL_LANES + lane))
    }
}

/// Numbers of the bits that are set, ascending.
#[inline(always)]
fn lanes(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < HULL_LANES).then_some(lane)
    })
}

/// The edges of a polyhedron along whose directions another one, with this centre and inner radius, may be
/// further away than `floor`.
#[inline(always)]
pub(crate) fn open<L: Lanes>(token: L::Token, poly: &Poly, center: Vec3, radius: f32, floor: f32) -> Edges {
    // Room for rounding.
    let size = center.abs().element_sum() + radius + floor.abs();
    let room = L::splat(token, 1e-5 * size);
    let least = L::splat(token, floor + radius) - room;
    let center = Lanes3::<L>::splat(token, center);
    let all = u16::MAX >> (HULL_LANES - L::WIDTH);
    let mut edges = SmallVec::new();
    for (k, block) in poly.edge_blocks.iter().enumerate() {
        let mut open = 0;
        for l in (0..HULL_LANES).step_by(L::WIDTH) {
            let row = |k: usize| L::load(token, &block[k][l..]);
            let height = |k: usize| Lanes3::new(row(k), row(k + 1), row(k + 2)).dot(center) - row(k + 3);
            let (left, right) = (height(0), height(4));
            let (high, low) = (left.max(right), left.min(right));
            // Between the normals lies the largest only if each of them is nearer to it than to the other one.
            let between = high.max(high * row(9));
            let most = L::select(low.lt(high * row(8) - room), high, between);
            open |= (!L::bits(most.lt(least)) & all) << l;
        }
        // Idle lanes are no edges, whatever came out for them: what is too far to be reckoned with is not a number.
        let real = (poly.edges.len() - k * HULL_LANES).min(HULL_LANES);
        edges.push(open & (u16::MAX >> (HULL_LANES - real)));
    }
    Edges(edges)
}

impl Kernel for Best<'_> {
    type Output = Option<Axis>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Option<Axis> {
        let Best { a, b, b_in_a, floor } = self;
        let of_a = open::<L>(token, a, b_in_a.point(b.center), b.inner_radius, floor);
        let of_b = open::<L>(token, b, b_in_a.inverse_point(a.center), a.inner_radius, floor);
        if of_a.is_empty() || of_b.is_empty() {
            return None;
        }
        let mut best: Option<Axis> = None;
        for i in of_a.numbers() {
            let edge = &a.edges[i];
            let first = edge.vertices.map(|v| a.vertices[v as usize]);
            // Edges of B are many, and stay where they are.
            let in_b = |v: Vec3| Lanes3::<L>::splat(token, b_in_a.inverse_vector(v));
            let [left, right] = edge.faces.map(|f| in_b(a.normals[f as usize]));
            let arc = Arc { left, right, along: in_b(first[1] - first[0]) };
            for (k, (block, &mask)) in b.edge_blocks.iter().zip(&of_b.0).enumerate() {
                if mask == 0 {
                    continue;
                }
                for l in (0..HULL_LANES).step_by(L::WIDTH) {
                    for lane in lanes(L::bits(arc.crosses(token, block, l)) << l & mask) {
                        let j = k * HULL_LANES + lane;
                        let second = b.edges[j].vertices.map(|v| b_in_a.point(b.vertices[v as usize]));
                        let Some((normal, separation)) = edge_axis(first, second, a.center) else { continue };
                        if best.is_none_or(|b| separation > b.separation) {
                            best = Some(Axis { normal, separation, kind: Kind::Edges(i, j) });
                        }
                    }
                }
            }
        }
        best
    }
}

/// An edge of A in B's frame: the normals of its faces, and its direction.
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
        let (left, right, along) = (vector(0), vector(4), vector(10));
        let (left_of_b, right_of_b) = (left.dot(self.along), right.dot(self.along));
        let (left_of_a, right_of_a) = (along.dot(self.left), along.dot(self.right));
        let across = (left_of_b * right_of_b).max(left_of_a * right_of_a).max(left_of_b * right_of_a);
        across.lt(L::splat(token, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;
    use rockfall_math::{Mat3, Quat};
    use rockfall_shape::Hull;

    /// Beside the same with nothing passed over: a hull of many edges, and a plate, whose inner ball says
    /// little.
    #[test]
    fn what_is_passed_over_separates_by_less() {
        // Between -1 and 1.
        let wave = |i: usize, k: u64| (mix(8 * i as u64 + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0;
        let cook = |n: usize, size: Vec3| {
            let corner = |i: usize| size * Vec3::new(wave(i, 0), wave(i, 1), wave(i, 2)).normalize();
            Hull::from_points(&(0..n).map(corner).collect::<Vec<_>>()).expect("points on an ellipsoid")
        };
        let (round, plate) = (cook(40, Vec3::ONE), cook(20, Vec3::new(1.0, 0.8, 0.05)));
        let mut found = 0;
        for i in 0..400 {
            let (a, b) = if i % 2 == 0 { (&round, &plate) } else { (&round, &round) };
            let (a, b) = (Poly::from(a), Poly::from(b));
            let turn = Quat::from_xyzw(wave(i, 1), wave(i, 2), wave(i, 3), 1.0).normalize();
            let translation = 1.5 * Vec3::new(wave(i, 4), wave(i, 5), wave(i, 6));
            let b_in_a = Isometry { rotation: Mat3::from_quat(turn), translation };
            let all = best(&a, &b, &b_in_a, -100.0);
            let Some(most) = all else { continue };
            for width in Width::all() {
                let floor = most.separation - 1e-3;
                let few = width.run(Best { a: &a, b: &b, b_in_a: &b_in_a, floor }).expect("the best is left");
                assert_eq!((few.kind, few.separation), (most.kind, most.separation), "{width:?}");
            }
            found += 1;
        }
        assert!(found > 100, "{found}");
    }
}
