//! The gaps between two boxes along the fifteen axes, of as many pairs at a time as there are lanes.
//!
//! Axes 0 to 2 are the face normals of A, 3 to 5 those of B, 6 + 3 i + j the cross product of edge direction i of A and j of B. The latter are taken with
//! their lengths, which come from the two components that the cross product has and not from 1 − r_ij², so that
//! nearly parallel edges keep all their digits; and an axis is never skipped for being short, except at 10 µrad.

use rockfall_math::lanes::{Kernel, Lanes};
use rockfall_math::{Isometry, Vec3};

/// Pairs side by side.
pub(crate) const SIDE: usize = 16;

/// Below this squared length a cross product of edges has no direction.
const SHORT: f32 = 1e-10;

/// The two other axes, in cyclic order.
pub(super) const NEXT: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// Two boxes, or as many pairs of them as there are lanes, in the frame of A.
#[derive(Clone, Copy)]
pub(crate) struct Pair<L> {
    /// Half extents.
    pub(super) a: [L; 3],
    pub(super) b: [L; 3],
    /// `r[i][j]`: coordinate i of axis j of B.
    pub(super) r: [[L; 3]; 3],
    /// Centre of B.
    pub(super) t: [L; 3],
}

impl Pair<f32> {
    #[inline]
    pub(crate) fn new(a: Vec3, b: Vec3, b_in_a: &Isometry) -> Self {
        let axes_of_b = [b_in_a.rotation.x_axis, b_in_a.rotation.y_axis, b_in_a.rotation.z_axis];
        let r = std::array::from_fn(|i| std::array::from_fn(|j| axes_of_b[j][i]));
        Pair { a: a.to_array(), b: b.to_array(), r, t: b_in_a.translation.to_array() }
    }
}

impl<L: Lanes> Pair<L> {
    /// The gap along axis `k`, metres; minus infinity where that has no direction.
    #[inline(always)]
    pub(crate) fn gap(&self, token: L::Token, k: usize) -> L {
        let Pair { a, b, r, t } = self;
        let abs = L::abs;
        match k {
            0..3 => {
                let reach = abs(r[k][0]) * b[0] + abs(r[k][1]) * b[1] + abs(r[k][2]) * b[2];
                abs(t[k]) - (a[k] + reach)
            }
            3..6 => {
                let j = k - 3;
                let along = t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j];
                let reach = abs(r[0][j]) * a[0] + abs(r[1][j]) * a[1] + abs(r[2][j]) * a[2];
                abs(along) - (b[j] + reach)
            }
            _ => {
                let (i, j) = ((k - 6) / 3, (k - 6) % 3);
                let ([p, q], [u, v]) = (NEXT[i], NEXT[j]);
                // e_i × b_j = r_pj e_q − r_qj e_p
                let (x, y) = (r[p][j], r[q][j]);
                let squared = x * x + y * y;
                let along = x * t[q] - y * t[p];
                let of_a = abs(x) * a[q] + abs(y) * a[p];
                let of_b = abs(x * r[q][u] - y * r[p][u]) * b[u] + abs(x * r[q][v] - y * r[p][v]) * b[v];
                let gap = (abs(along) - (of_a + of_b)) / squared.sqrt();
                L::select(squared.lt(L::splat(token, SHORT)), L::splat(token, f32::NEG_INFINITY), gap)
            }
        }
    }
}

/// Gaps along all axes.
pub(crate) type Gaps = [f32; 15];

/// Those of one pair.
#[inline]
pub(super) fn gaps(pair: &Pair<f32>) -> Gaps {
    std::array::from_fn(|k| pair.gap((), k))
}

/// Up to sixteen pairs, number by number.
#[derive(Default)]
pub(crate) struct Pairs {
    numbers: [[f32; SIDE]; 18],
}

impl Pairs {
    pub(crate) fn set(&mut self, lane: usize, &Pair { a, b, r, t }: &Pair<f32>) {
        for (k, x) in [a, b, r[0], r[1], r[2], t].as_flattened().iter().enumerate() {
            self.numbers[k][lane] = *x;
        }
    }

    pub(crate) fn get(&self, lane: usize) -> Pair<f32> {
        let n = |k: usize| self.numbers[k][lane];
        let three = |k: usize| [n(k), n(k + 1), n(k + 2)];
        Pair { a: three(0), b: three(3), r: [three(6), three(9), three(12)], t: three(15) }
    }
}

/// Finds the gaps of up to sixteen pairs, axis by axis.
pub(crate) struct Measure<'a> {
    pub(crate) pairs: &'a Pairs,
    pub(crate) gaps: &'a mut [[f32; SIDE]; 15],
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) {
        for l in (0..SIDE).step_by(L::WIDTH) {
            let n = |k: usize| L::load(token, &self.pairs.numbers[k][l..]);
            let pair = Pair {
                a: [n(0), n(1), n(2)],
                b: [n(3), n(4), n(5)],
                r: [[n(6), n(7), n(8)], [n(9), n(10), n(11)], [n(12), n(13), n(14)]],
                t: [n(15), n(16), n(17)],
            };
            // Written out, because a loop over axes would not be unrolled, and each axis has equations of its own.
            macro_rules! measure {
                ($($k:literal)*) => { $(pair.gap(token, $k).store(&mut self.gaps[$k][l..]);)* };
            }
            measure!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;
    use rockfall_math::lanes::Width;
    use rockfall_math::{Mat3, Quat};

    #[test]
    fn every_width_measures_what_one_pair_alone_gives() {
        let random = |i: usize, k: u64| (mix(16 * i as u64 + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0;
        let boxes = |i: usize| {
            let half = |k: u64| Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2)).abs() + 0.1;
            let turn = Quat::from_xyzw(random(i, 6), random(i, 7), random(i, 8), 0.6).normalize();
            // Of some the axes are parallel.
            let turn = if i.is_multiple_of(5) { Quat::IDENTITY } else { turn };
            let translation = 2.0 * Vec3::new(random(i, 9), random(i, 10), random(i, 11));
            (half(0), half(3), Isometry { rotation: Mat3::from_quat(turn), translation })
        };
        for first in (0..200 * SIDE).step_by(SIDE) {
            let mut pairs = Pairs::default();
            for lane in 0..SIDE {
                let (a, b, b_in_a) = boxes(first + lane);
                pairs.set(lane, &Pair::new(a, b, &b_in_a));
            }
            for width in Width::all() {
                let mut found = [[0.0; SIDE]; 15];
                width.run(Measure { pairs: &pairs, gaps: &mut found });
                for lane in 0..SIDE {
                    let (a, b, b_in_a) = boxes(first + lane);
                    assert_eq!(found.map(|row| row[lane]), gaps(&Pair::new(a, b, &b_in_a)));
                }
            }
        }
    }
}
