//! Which face of each of two polyhedra separates it from the other most, as many faces at a time as there are lanes.

use crate::poly::Poly;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{CornerBlock, FaceBlock, HULL_LANES};
use smallvec::SmallVec;

/// Face and separation, of A and of B.
pub(super) fn best(a: &Poly, b: &Poly, b_in_a: &Isometry) -> [(usize, f32); 2] {
    Width::native().run(Best { a, b, b_in_a })
}

struct Best<'a> {
    a: &'a Poly<'a>,
    b: &'a Poly<'a>,
    b_in_a: &'a Isometry,
}

impl Kernel for Best<'_> {
    type Output = [(usize, f32); 2];

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
        let Best { a, b, b_in_a } = self;
        let b_seen = placed::<L>(token, b.corner_blocks, b_in_a);
        let a_seen = placed::<L>(token, a.corner_blocks, &b_in_a.inverse());
        [
            furthest::<L>(token, a.face_blocks, &b_seen, b.vertices.len()),
            furthest::<L>(token, b.face_blocks, &a_seen, a.vertices.len()),
        ]
    }
}

/// Corners of hulls of ordinary size stay on the stack.
type Placed = SmallVec<[CornerBlock; 4]>;

/// Corners in another frame.
#[inline(always)]
fn placed<L: Lanes>(token: L::Token, corners: &[CornerBlock], pose: &Isometry) -> Placed {
    let [right, up, out] =
        [pose.rotation.x_axis, pose.rotation.y_axis, pose.rotation.z_axis].map(|v| Lanes3::splat(token, v));
    let origin = Lanes3::<L>::splat(token, pose.translation);
    let mut seen = Placed::new();
    for block in corners {
        let mut to = [[0.0; HULL_LANES]; 3];
        for l in (0..HULL_LANES).step_by(L::WIDTH) {
            let [x, y, z] = block.each_ref().map(|row| L::load(token, &row[l..]));
            let p = right.scale(x) + up.scale(y) + out.scale(z) + origin;
            p.x.store(&mut to[0][l..]);
            p.y.store(&mut to[1][l..]);
            p.z.store(&mut to[2][l..]);
        }
        seen.push(to);
    }
    seen
}

/// Number and separation of the face beyond which the first `count` of some corners stay furthest; the first among equals.
#[inline(always)]
fn furthest<L: Lanes>(
    token: L::Token,
    faces: &[FaceBlock],
    corners: &[CornerBlock],
    count: usize,
) -> (usize, f32) {
    let mut best = (0, f32::NEG_INFINITY);
    for (k, block) in faces.iter().enumerate() {
        let mut separations = [0.0; HULL_LANES];
        for l in (0..HULL_LANES).step_by(L::WIDTH) {
            let [x, y, z, offset] = block.each_ref().map(|row| L::load(token, &row[l..]));
            let normal = Lanes3::new(x, y, z);
            let mut least = L::splat(token, f32::INFINITY);
            for (corners, from) in corners.iter().zip((0..).step_by(HULL_LANES)) {
                let [xs, ys, zs] = corners;
                for ((&x, &y), &z) in xs.iter().zip(ys).zip(zs).take(count - from) {
                    let corner = Vec3::new(x, y, z);
                    least = normal.dot(Lanes3::splat(token, corner)).min(least);
                }
            }
            (least - offset).store(&mut separations[l..]);
        }
        for (l, &separation) in separations.iter().enumerate() {
            if separation > best.1 {
                best = (k * HULL_LANES + l, separation);
            }
        }
    }
    best
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
            let found = Width::Scalar.run(Best { a: &a, b: &b, b_in_a: &b_in_a });
            for ((f, separation), (expected, faces)) in found.iter().zip(expected.iter().zip([&a, &b])) {
                assert!((separation - expected).abs() < 1e-6 && *f < faces.normals.len());
            }
            for width in Width::all() {
                assert_eq!(width.run(Best { a: &a, b: &b, b_in_a: &b_in_a }), found);
            }
        }
    }
}
