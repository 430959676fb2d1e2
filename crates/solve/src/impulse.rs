//! Response B of the report, **impulse**: four steps for a contact point.
//!
//! `n` is the unit normal that points out of the object that was hit, `v` the velocity of the point of the object that
//! hits, relative to the one that was hit; μ_N is the restitution, μ_T the friction.

use rockfall_math::{Mat3, Vec3};

/// Step 1: whether the point needs an update, v · N < 0.
pub fn approaches(v: Vec3, n: Vec3) -> bool {
    v.dot(n) < 0.0
}

/// a = max(1 − μ_T (1 + μ_N) ‖v_N‖ / ‖v_T‖, 0): the share of the tangential velocity that friction leaves
/// (Amontons–Coulomb, equality). Where nothing slides, `tangential` = 0, it is 0.
pub fn friction_scale(restitution: f32, friction: f32, normal: f32, tangential: f32) -> f32 {
    if tangential > 0.0 { (1.0 - friction * (1.0 + restitution) * normal / tangential).max(0.0) } else { 0.0 }
}

/// Step 2: the new velocity of the point, v_N' = −μ_N v_N and v_T' = a v_T.
pub fn new_velocity(v: Vec3, n: Vec3, restitution: f32, friction: f32) -> Vec3 {
    let v_n = n * v.dot(n);
    let v_t = v - v_n;
    let a = friction_scale(restitution, friction, v_n.length(), v_t.length());
    v_n * -restitution + v_t * a
}

/// \[x\]×: the matrix with `cross_matrix(x) * y == x.cross(y)`.
pub fn cross_matrix(x: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, x.z, -x.y), Vec3::new(-x.z, 0.0, x.x), Vec3::new(x.y, -x.x, 0.0))
}

/// K = (1/M) 1 − [R r]× I⁻¹ [R r]×: the velocity that a unit impulse gives to the point at `arm` = R r (m), in 1/kg.
/// `inverse_inertia` is in world axes. For two moving bodies K = K_a + K_b.
pub fn contact_matrix(inverse_mass: f32, inverse_inertia: &Mat3, arm: Vec3) -> Mat3 {
    let cross = cross_matrix(arm);
    Mat3::from_diagonal(Vec3::splat(inverse_mass)) - cross * *inverse_inertia * cross
}

/// Step 3: the impulse j = K⁻¹ (v' − v), N s; zero where K has no inverse.
pub fn impulse(k: &Mat3, v: Vec3, v_new: Vec3) -> Vec3 {
    let determinant = k.determinant();
    if determinant > 0.0 { k.inverse() * (v_new - v) } else { Vec3::ZERO }
}

/// The impulse of steps 1 to 3 that never adds energy; `None` where the point separates already.
///
/// The formulas bound ‖v'‖ by ‖v‖, but the kinetic energy belongs to the metric K⁻¹: where N is no eigenvector of K, the
/// impulse that keeps v_T can add energy (Kane's paradox). The work of an impulse j is j · v + ½ j · K j; an impulse
/// that adds energy is replaced by the frictionless one, along N alone, whose work is never positive for μ_N ≤ 1.
pub fn response(k: &Mat3, v: Vec3, n: Vec3, restitution: f32, friction: f32) -> Option<Vec3> {
    if !approaches(v, n) {
        return None;
    }
    let j = impulse(k, v, new_velocity(v, n, restitution, friction));
    if work(k, v, j) <= 0.0 {
        return Some(j);
    }
    let compliance = n.dot(*k * n);
    (compliance > 0.0).then(|| n * (-(1.0 + restitution) * v.dot(n) / compliance))
}

/// Energy that the impulse `j` adds to bodies whose contact point moves at `v`: j · v + ½ j · K j, in J.
pub fn work(k: &Mat3, v: Vec3, j: Vec3) -> f32 {
    j.dot(v) + 0.5 * j.dot(*k * j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    /// Numbers in [-1, 1).
    struct Numbers(u64);
    impl Numbers {
        fn next(&mut self) -> f32 {
            self.0 += 1;
            (mix(self.0) >> 40) as f32 / (1 << 23) as f32 - 1.0
        }
        fn vector(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }
        fn inertia(&mut self) -> Mat3 {
            let m = Mat3::from_cols(self.vector(), self.vector(), self.vector());
            m * m.transpose() + Mat3::from_diagonal(Vec3::splat(0.1))
        }
    }

    #[test]
    fn k_is_the_derivative_of_the_points_velocity() {
        let mut random = Numbers(1);
        for _ in 0..1000 {
            let (inverse_mass, inertia, arm) = (random.next().abs() + 0.1, random.inertia(), random.vector());
            let k = contact_matrix(inverse_mass, &inertia, arm);
            let (v, w) = (random.vector(), random.vector());
            let point = |j: Vec3| v + inverse_mass * j + (w + inertia * arm.cross(j)).cross(arm);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let h = 0.5;
                let difference = (point(axis * h) - point(axis * -h)) / (2.0 * h);
                assert!((difference - k * axis).length() < 1e-4 * (1.0 + difference.length()));
            }
        }
    }

    #[test]
    fn a_at_its_limits() {
        assert_eq!(friction_scale(0.5, 0.3, 2.0, 0.0), 0.0, "nothing slides");
        assert_eq!(friction_scale(0.5, 0.3, 2.0, f32::MIN_POSITIVE), 0.0, "v_T → 0 sticks");
        assert_eq!(friction_scale(0.5, 0.0, 2.0, 1.0), 1.0, "no friction");
        assert_eq!(friction_scale(0.0, 1.0, 2.0, 1.0), 0.0, "sticking");
        assert!((friction_scale(0.5, 0.2, 1.0, 1.0) - 0.7).abs() < 1e-6, "sliding");
    }

    #[test]
    fn the_point_gets_its_new_velocity() {
        let mut random = Numbers(7);
        for _ in 0..1000 {
            let k = contact_matrix(1.0, &random.inertia(), random.vector());
            let n = random.vector().normalize();
            let v = random.vector();
            let wanted = new_velocity(v, n, 0.5, 0.3);
            let j = impulse(&k, v, wanted);
            assert!((v + k * j - wanted).length() < 1e-3);
        }
    }

    #[test]
    fn energy_never_rises() {
        let mut random = Numbers(3);
        let mut replaced = 0;
        for _ in 0..10_000 {
            let k = contact_matrix(random.next().abs() + 0.1, &random.inertia(), random.vector());
            let (n, v) = (random.vector().normalize(), random.vector());
            let (restitution, friction) = (random.next().abs(), random.next().abs());
            if let Some(j) = response(&k, v, n, restitution, friction) {
                assert!(work(&k, v, j) <= 1e-5, "{}", work(&k, v, j));
                assert!((v + k * j).dot(n) >= -1e-4, "still approaches");
                let plain = impulse(&k, v, new_velocity(v, n, restitution, friction));
                replaced += usize::from(work(&k, v, plain) > 1e-5);
            } else {
                assert!(v.dot(n) >= 0.0);
            }
        }
        assert!(replaced > 0, "the guard is there for a reason");
    }

    #[test]
    fn momentum_is_conserved_to_rounding() {
        let mut random = Numbers(5);
        for _ in 0..1000 {
            // Two bodies: masses, inertias, centres; contact at the origin.
            let body = |random: &mut Numbers| {
                (
                    random.next().abs() + 0.5,
                    random.inertia(),
                    random.vector(),
                    random.vector(),
                    random.vector(),
                )
            };
            let (ma, ia, pa, va, wa) = body(&mut random);
            let (mb, ib, pb, vb, wb) = body(&mut random);
            let (ra, rb) = (-pa, -pb);
            let (inv_a, inv_b) = (ia.inverse(), ib.inverse());
            let k = contact_matrix(1.0 / ma, &inv_a, ra) + contact_matrix(1.0 / mb, &inv_b, rb);
            let v = va + wa.cross(ra) - vb - wb.cross(rb);
            let n = random.vector().normalize();
            let Some(j) = response(&k, v, n, 0.5, 0.3) else { continue };
            let (va2, wa2) = (va + j / ma, wa + inv_a * ra.cross(j));
            let (vb2, wb2) = (vb - j / mb, wb - inv_b * rb.cross(j));
            let linear = |va: Vec3, vb: Vec3| va * ma + vb * mb;
            let angular = |va: Vec3, wa: Vec3, vb: Vec3, wb: Vec3| {
                pa.cross(va * ma) + ia * wa + pb.cross(vb * mb) + ib * wb
            };
            let size = 1.0 + j.length();
            assert!((linear(va, vb) - linear(va2, vb2)).length() < 1e-5 * size);
            assert!((angular(va, wa, vb, wb) - angular(va2, wa2, vb2, wb2)).length() < 3e-5 * size);
        }
    }
}
