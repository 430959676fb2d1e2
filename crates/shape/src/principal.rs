//! Principal axes of inertia.

use crate::MassProperties;
use rockfall_math::{Mat3, Quat, Vec3, rotation};

/// Entries off the diagonal below this part of the largest moment are rounding: a box or a ball, cooked as a
/// hull or not, keeps its own axes.
const DIAGONAL: f64 = 1e-6;

impl MassProperties {
    /// The moments of inertia about the principal axes, kg m², and the rotation from the frame of those axes
    /// to the frame of the shape. The rotation is the identity where the inertia is diagonal as it is; the
    /// axes are in no order, each near the one of the shape's frame that it came from.
    ///
    /// By Jacobi's method in double precision, in a fixed order: the same bits on every machine.
    pub fn principal(&self) -> (Vec3, Quat) {
        principal(self.inertia)
    }
}

fn principal(inertia: Mat3) -> (Vec3, Quat) {
    let mut a = inertia.to_cols_array_2d().map(|column| column.map(f64::from));
    let largest = a[0][0].max(a[1][1]).max(a[2][2]);
    let off = |a: &[[f64; 3]; 3]| a[1][0].abs().max(a[2][1].abs()).max(a[0][2].abs());
    // Quaternion x, y, z, w of the axes found so far.
    let mut axes = [0.0, 0.0, 0.0, 1.0];
    if off(&a) > DIAGONAL * largest {
        // Convergence is quadratic: five rounds are plenty, NaN ends as well.
        for _ in 0..16 {
            if off(&a) <= 1e-15 * largest {
                break;
            }
            for k in 0..3 {
                turn(&mut a, &mut axes, k);
            }
        }
    }
    let [x, y, z, w] = axes.map(|c| c as f32);
    (
        Vec3::new(a[0][0] as f32, a[1][1] as f32, a[2][2] as f32),
        rotation::normalize(Quat::from_xyzw(x, y, z, w)),
    )
}

/// One Jacobi rotation about axis `k`, which clears the entry of the other two (Golub and Van Loan, 8.5).
fn turn(a: &mut [[f64; 3]; 3], axes: &mut [f64; 4], k: usize) {
    let (p, q) = ((k + 1) % 3, (k + 2) % 3);
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        let (x, y) = (row[p], row[q]);
        (row[p], row[q]) = (c * x - s * y, s * x + c * y);
    }
    let (x, y) = (a[p], a[q]);
    for i in 0..3 {
        (a[p][i], a[q][i]) = (c * x[i] - s * y[i], s * x[i] + c * y[i]);
    }
    // The new axes are p' = c p - s q and q' = s p + c q: a turn by -θ about axis k, after the turns so far.
    let half = (0.5 * (1.0 + c)).sqrt();
    let mut turn = [0.0, 0.0, 0.0, half];
    turn[k] = -0.5 * s / half;
    *axes = product(*axes, turn);
}

fn product([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hull, Shape};
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};
    use std::sync::Arc;

    /// frame · diag(moments) · frameᵀ
    fn rebuilt(moments: Vec3, frame: Quat) -> Mat3 {
        let r = Mat3::from_quat(frame);
        r * Mat3::from_diagonal(moments) * r.transpose()
    }

    fn difference(a: Mat3, b: Mat3) -> f32 {
        let d = a - b;
        d.x_axis.abs().max(d.y_axis.abs()).max(d.z_axis.abs()).max_element()
    }

    #[test]
    fn rebuilds_any_symmetric_matrix() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..1000 {
            let mut next = || (rng.next_u32() >> 8) as f32 / (1 << 24) as f32;
            let moments = Vec3::new(next(), next(), next());
            let frame =
                rotation::normalize(Quat::from_xyzw(next() - 0.5, next() - 0.5, next() - 0.5, next()));
            let inertia = rebuilt(moments, frame);
            let (found, axes) = principal(inertia);
            assert!(difference(rebuilt(found, axes), inertia) < 1e-6, "{inertia}");
            let mut sorted = [moments.to_array(), found.to_array()];
            sorted.iter_mut().for_each(|s| s.sort_by(f32::total_cmp));
            assert!((0..3).all(|i| (sorted[0][i] - sorted[1][i]).abs() < 1e-6));
        }
    }

    #[test]
    fn what_is_diagonal_already_is_not_turned() {
        let shapes = [
            Shape::Sphere { radius: 0.3 },
            Shape::Box { half: Vec3::new(3.0, 1.0, 2.0) },
            Shape::Capsule { half_length: 2.0, radius: 0.1 },
            Shape::Hull(Arc::new(Hull::cuboid(Vec3::new(0.1, 0.7, 0.3)))),
            Shape::Hull(Arc::new(Hull::cuboid(Vec3::splat(0.3)))),
        ];
        for shape in shapes {
            let mass = shape.mass_properties(1000.0).unwrap();
            let (moments, frame) = mass.principal();
            assert_eq!(frame, Quat::IDENTITY, "{}", shape.name());
            assert_eq!(
                moments,
                mass.inertia
                    .to_cols_array_2d()
                    .into_iter()
                    .enumerate()
                    .map(|(i, c)| c[i])
                    .collect::<Vec<_>>()[..]
                    .try_into()
                    .map(|a: [f32; 3]| Vec3::from_array(a))
                    .unwrap()
            );
        }
    }

    #[test]
    fn a_nearly_round_body_is_not_turned() {
        let mut inertia = Mat3::IDENTITY;
        inertia.x_axis.y = 1e-7;
        inertia.y_axis.x = 1e-7;
        assert_eq!(principal(inertia).1, Quat::IDENTITY);
    }

    #[test]
    fn nan_ends() {
        assert!(principal(Mat3::from_diagonal(Vec3::NAN)).0.is_nan());
    }
}
