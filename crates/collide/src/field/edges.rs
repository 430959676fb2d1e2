//! Which edges of two fields may cross: those that are near enough and have sides that may face each other.
//!
//! What flows in: edges of both that are near the other body. What flows out: pairs of them. Bodies that touch have some eighty each there, and one pair in fifteen passes, so they are tried as many at a time as there are lanes.

use rockfall_math::Vec3;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_shape::HULL_LANES;

/// Single precision errs by no more in the cosine of an angle between two cones.
const ROUNDING: f32 = 1e-5;

/// An edge in A's frame.
pub(super) struct Edge {
    pub(super) number: u32,
    pub(super) ends: [Vec3; 2],
    /// Between the normals of its sides, and the cosine of the largest angle to one of them.
    pub(super) out: Vec3,
    pub(super) cone: f32,
    /// Cosine and sine of the largest angle to `out` that the common normal with another edge may have.
    pub(super) faces: [f32; 2],
}

impl Edge {
    fn middle(&self) -> Vec3 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// Metres.
    fn half_length(&self) -> f32 {
        0.5 * self.ends[0].distance(self.ends[1])
    }
}

/// Up to so many edges: rows of their middles, half lengths, directions and cosines and sines of [`Edge::faces`].
type Block = [[f32; HULL_LANES]; 9];

/// Numbers of edges in `ones` and `twos` whose nearest points may be no further apart than `most` metres, and which may have a common normal within the cones of both.
pub(super) fn may_cross(ones: &[Edge], twos: &[Edge], most: f32) -> Vec<[usize; 2]> {
    if ones.is_empty() || twos.is_empty() {
        return Vec::new();
    }
    let mut along_x: Vec<usize> = (0..twos.len()).collect();
    along_x.sort_by(|&i, &j| twos[i].middle().x.total_cmp(&twos[j].middle().x).then(i.cmp(&j)));
    let blocks: Vec<Block> = along_x.chunks(HULL_LANES).map(|chunk| block(twos, chunk)).collect();
    let widest = twos.iter().fold(0.0_f32, |widest, two| widest.max(two.half_length()));
    Width::native().run(Pairs { ones, along_x: &along_x, blocks: &blocks, widest, most })
}

fn block(edges: &[Edge], chunk: &[usize]) -> Block {
    let mut block = Block::default();
    for lane in 0..HULL_LANES {
        // Lanes that are left over repeat the last one, and are masked.
        let edge = &edges[chunk[lane.min(chunk.len() - 1)]];
        let [middle, out] = [edge.middle(), edge.out].map(|v| v.to_array());
        let rows = middle.into_iter().chain([edge.half_length()]).chain(out).chain(edge.faces);
        block.iter_mut().zip(rows).for_each(|(row, x)| row[lane] = x);
    }
    block
}

struct Pairs<'a> {
    ones: &'a [Edge],
    /// Numbers of the other body's edges in the order of the lanes: along x.
    along_x: &'a [usize],
    blocks: &'a [Block],
    /// The largest half length of them.
    widest: f32,
    most: f32,
}

impl Kernel for Pairs<'_> {
    type Output = Vec<[usize; 2]>;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
        let mut pairs = Vec::new();
        for (i, one) in self.ones.iter().enumerate() {
            let (middle, half) = (one.middle(), one.half_length());
            let window = half + self.widest + self.most;
            let from = self.blocks.partition_point(|block| block[0][HULL_LANES - 1] < middle.x - window);
            let [cosine, sine] = one.faces.map(|x| L::splat(token, x));
            let (at, out) = (Lanes3::<L>::splat(token, middle), Lanes3::splat(token, one.out));
            let room = L::splat(token, half + self.most);
            for (k, block) in self.blocks.iter().enumerate().skip(from) {
                if block[0][0] > middle.x + window {
                    break;
                }
                let real = self.along_x.len() - k * HULL_LANES;
                for l in (0..HULL_LANES.min(real)).step_by(L::WIDTH) {
                    let row = |k: usize| L::load(token, &block[k][l..]);
                    let way = at - Lanes3::new(row(0), row(1), row(2));
                    let far = room + row(3);
                    let apart = L::bits((far * far).lt(way.dot(way)));
                    // The directions are further apart than both cones are wide, which together are no whole ball.
                    let facing = -out.dot(Lanes3::new(row(4), row(5), row(6)));
                    let least = cosine * row(7) - sine * row(8) - L::splat(token, ROUNDING);
                    let averted = L::bits(facing.lt(least)) & L::bits((-cosine).lt(row(7)));
                    let mut left = !(apart | averted) & ((1_u32 << L::WIDTH.min(real - l)) - 1) as u16;
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        pairs.push([i, self.along_x[k * HULL_LANES + l + lane]]);
                    }
                }
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash;

    /// Short edges in a box of 2 cm, with any cone.
    fn edges(seed: u64, count: u32) -> Vec<Edge> {
        let number = |k: u64| (hash::mix(seed << 32 | k) >> 40) as f32 / (1 << 23) as f32 - 1.0;
        let vector = |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2));
        let edge = |number_of: u32| {
            let k = 16 * u64::from(number_of);
            let start = 0.01 * vector(k);
            let angle = 1.6 * (number(k + 9) + 1.0);
            let (sin, cos) = rockfall_math::trig::sin_cos(angle);
            Edge {
                number: number_of,
                ends: [start, start + 0.003 * vector(k + 3)],
                out: vector(k + 6).normalize_or(Vec3::Z),
                cone: cos,
                faces: if angle < 3.0 { [cos, sin] } else { [-1.0, 0.0] },
            }
        };
        (0..count).map(edge).collect()
    }

    #[test]
    fn pairs_are_those_that_one_by_one_would_be() {
        for (seed, [m, n]) in [[1, 1], [3, 16], [40, 17], [25, 70], [0, 5], [5, 0]].into_iter().enumerate() {
            let (ones, twos) = (edges(2 * seed as u64, m), edges(2 * seed as u64 + 1, n));
            let most = 0.004;
            let mut found = may_cross(&ones, &twos, most);
            found.sort_unstable();
            let may = |one: &Edge, two: &Edge| {
                let far = one.half_length() + two.half_length() + most;
                let ([c, s], [d, t]) = (one.faces, two.faces);
                let facing = c <= -d || -one.out.dot(two.out) >= c * d - s * t - ROUNDING;
                facing && one.middle().distance(two.middle()) <= far
            };
            let mut wanted = Vec::new();
            for (i, one) in ones.iter().enumerate() {
                wanted.extend((0..twos.len()).filter(|&j| may(one, &twos[j])).map(|j| [i, j]));
            }
            assert_eq!(found, wanted, "{m} and {n}");
            assert!(wanted.len() < (m * n) as usize || m * n < 50);
        }
    }
}
