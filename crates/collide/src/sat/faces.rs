//! Which face of each of two polyhedra separates it from the other most, as many faces or corners at a time
//! as there are lanes.
//!
//! A polyhedron comes nearer to a face than its centre does by the radius of its inner ball at least. So a
//! face over which the centre is no higher than
//! the best separation so far and that radius can't separate by more, and its corners are not asked; the face
//! over which the centre is highest comes first.

use crate::poly::{Poly, largest, smallest};
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{CornerBlock, FaceBlock, HULL_LANES};
use smallvec::SmallVec;

/// Face and separation, of A and of B; of B minus infinity where its faces separate by less than that of A
/// and the `tie`.
pub(super) fn best(a: &Poly, b: &Poly, b_in_a: &Isometry, tie: f32) -> [(usize, f32); 2] {
    Width::native().run(Best { a, b, b_in_a, tie })
}

#[derive(Clone, Copy)]
struct Best<'a> {
    a: &'a Poly<'a>,
    b: &'a Poly<'a>,
    b_in_a: &'a Isometry,
    tie: f32,
}

impl Kernel for Best<'_> {
    type Output = [(usize, f32); 2];

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
        let Best { a, b, b_in_a, tie } = self;
        let b_seen = placed::<L>(token, b.corner_blocks, b_in_a);
        let over_a = Over { faces: a.face_blocks, center: b_in_a.point(b.center), radius: b.inner_radius };
        let of_a = over_a.best::<L>(token, &b_seen, f32::NEG_INFINITY);
        let a_in_b = b_in_a.inverse();
        let a_seen = placed::<L>(token, a.corner_blocks, &a_in_b);
        let over_b = Over { faces: b.face_blocks, center: a_in_b.point(a.center), radius: a.inner_radius };
        [of_a, over_b.best::<L>(token, &a_seen, of_a.1 - tie)]
    }
}

/// Corners of hulls of ordinary size stay on the stack.
type Placed = SmallVec<[CornerBlock; 4]>;

/// Corners in another frame.
#[inline(always)]
fn placed<L: Lanes>(token: L::Token, corners: &[CornerBlock], pose: &Isometry) -> Placed {
    let right = Lanes3::<L>::splat(token, pose.rotation.x_axis);
    let up = Lanes3::<L>::splat(token, pose.rotation.y_axis);
    let out = Lanes3::<L>::splat(token, pose.rotation.z_axis);
    let origin = Lanes3::<L>::splat(token, pose.translation);
    let mut seen = Placed::new();
    for block in corners {
        let mut to = [[0.0; HULL_LANES]; 3];
        for l in (0..HULL_LANES).step_by(L::WIDTH) {
            let row = |k: usize| L::load(token, &block[k][l..]);
            let p = right.scale(row(0)) + up.scale(row(1)) + out.scale(row(2)) + origin;
            p.x.store(&mut to[0][l..]);
            p.y.store(&mut to[1][l..]);
            p.z.store(&mut to[2][l..]);
        }
        seen.push(to);
    }
    seen
}

/// Faces, and what is known of a polyhedron over them: where its centre is, and the radius of its inner ball.
struct Over<'a> {
    faces: &'a [FaceBlock],
    center: Vec3,
    radius: f32,
}

impl Over<'_> {
    /// Number and separation of the face beyond which the corners of the polyhedron stay furthest, the first
    /// among equals; only faces
    /// that separate by more than `floor` count.
    #[inline(always)]
    fn best<L: Lanes>(&self, token: L::Token, corners: &[CornerBlock], floor: f32) -> (usize, f32) {
        let center = Lanes3::<L>::splat(token, self.center);
        let mut heights: SmallVec<[[f32; HULL_LANES]; 8]> = SmallVec::new();
        let mut highest = (0, f32::NEG_INFINITY);
        for (k, face) in self.faces.iter().enumerate() {
            let mut to = [0.0; HULL_LANES];
            for l in (0..HULL_LANES).step_by(L::WIDTH) {
                let row = |k: usize| L::load(token, &face[k][l..]);
                (Lanes3::new(row(0), row(1), row(2)).dot(center) - row(3)).store(&mut to[l..]);
            }
            let most = largest(&to);
            if most > highest.1 {
                let lane = to.iter().position(|&height| height == most).unwrap_or(0);
                highest = (k * HULL_LANES + lane, most);
            }
            heights.push(to);
        }
        let mut best = (0, floor);
        let first = highest.0;
        if highest.1 >= self.least(floor) {
            let separation = self.separation::<L>(token, first, corners);
            if separation > floor {
                best = (first, separation);
            }
        }
        for (k, heights) in heights.iter().enumerate() {
            let least = L::splat(token, self.least(best.1));
            for l in (0..HULL_LANES).step_by(L::WIDTH) {
                let mut open = L::bits(least.lt(L::load(token, &heights[l..])));
                while open != 0 {
                    let lane = l + open.trailing_zeros() as usize;
                    open &= open - 1;
                    let f = k * HULL_LANES + lane;
                    if f == first || heights[lane] < self.least(best.1) {
                        continue;
                    }
                    let separation = self.separation::<L>(token, f, corners);
                    if separation > best.1 || (separation == best.1 && f < best.0) {
                        best = (f, separation);
                    }
                }
            }
        }
        if best.1 > floor { best } else { (0, f32::NEG_INFINITY) }
    }

    /// The height of the centre over a face below which that can't separate by more than `best`, with room
    /// for rounding.
    #[inline(always)]
    fn least(&self, best: f32) -> f32 {
        let size = self.center.abs().element_sum() + self.radius + best.abs();
        if best > f32::NEG_INFINITY { best + self.radius - 1e-5 * size } else { best }
    }

    /// How far some corners stay beyond a face, metres.
    #[inline(always)]
    fn separation<L: Lanes>(&self, token: L::Token, f: usize, corners: &[CornerBlock]) -> f32 {
        let number = |k: usize| self.faces[f / HULL_LANES][k][f % HULL_LANES];
        let normal = Lanes3::<L>::splat(token, Vec3::new(number(0), number(1), number(2)));
        let mut least = L::splat(token, f32::INFINITY);
        for corners in corners {
            for l in (0..HULL_LANES).step_by(L::WIDTH) {
                let row = |k: usize| L::load(token, &corners[k][l..]);
                least = normal.dot(Lanes3::new(row(0), row(1), row(2))).min(least);
            }
        }
        let mut numbers = [f32::INFINITY; HULL_LANES];
        least.store(&mut numbers);
        smallest(&numbers) - number(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;
    use rockfall_math::{Mat3, Quat};
    use rockfall_shape::Hull;

    /// Two hulls of more faces and corners than a block has, at some poses: beside a scan, and the same bits at each width.
    #[test]
    fn every_width_finds_what_a_scan_finds() {
        // Between -1 and 1.
        let wave = |i: usize, k: u64| (mix(8 * i as u64 + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0;
        let ball = |n: usize| -> Vec<Vec3> {
            (0..n).map(|i| Vec3::new(wave(i, 0), wave(i, 1), wave(i, 2)).normalize()).collect()
        };
        let [a, b] = [40, 17].map(|n| Hull::from_points(&ball(n)).expect("points on a ball"));
        for i in 0..50 {
            let turn = Quat::from_xyzw(wave(i, 1), wave(i, 2), wave(i, 3), 1.0).normalize();
            let translation = 1.5 * Vec3::new(wave(i, 4), wave(i, 5), wave(i, 6));
            let b_in_a = Isometry { rotation: Mat3::from_quat(turn), translation };
            let (a, b) = (Poly::from(&a), Poly::from(&b));
            let scan = |faces: &Poly, corners: &[Vec3], pose: &Isometry| {
                let separation = |(n, o): (&Vec3, &f32)| {
                    corners.iter().map(|&v| n.dot(pose.point(v))).fold(f32::INFINITY, f32::min) - o
                };
                let all = faces.normals.iter().zip(faces.offsets).map(separation);
                all.fold(f32::NEG_INFINITY, f32::max)
            };
            let expected = [scan(&a, b.vertices, &b_in_a), scan(&b, a.vertices, &b_in_a.inverse())];
            let best = Best { a: &a, b: &b, b_in_a: &b_in_a, tie: f32::INFINITY };
            let found = Width::Scalar.run(best);
            for ((f, separation), (expected, faces)) in found.iter().zip(expected.iter().zip([&a, &b])) {
                assert!((separation - expected).abs() < 1e-6 && *f < faces.normals.len());
            }
            for width in Width::all() {
                assert_eq!(width.run(best), found);
            }
        }
    }
}
