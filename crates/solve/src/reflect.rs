//! Response A of the report, **reflect**: the velocity is mirrored at the normal.

use rockfall_math::Vec3;

/// The velocity after a perfectly elastic bounce without friction off an object that can't be moved: with both v and
/// t = v · n reversed, v ← 2 t n − v; that is v ← v − 2 (v · n) n. `n` is the unit normal that points out of the object that
/// was hit. A velocity that does not point into it, v · n ≥ 0, stays.
pub fn reflect(v: Vec3, n: Vec3) -> Vec3 {
    if v.dot(n) >= 0.0 {
        return v;
    }
    let reversed = -v;
    let t = reversed.dot(n);
    2.0 * t * n - reversed
}

/// [`reflect`] for two bodies that both move, `a` hitting `b`: their relative velocity is mirrored in the frame of their
/// common centre of mass. Inverse masses in 1/kg; a body with 0 is not moved.
pub fn reflect_pair(v_a: Vec3, v_b: Vec3, inverse_masses: [f32; 2], n: Vec3) -> (Vec3, Vec3) {
    let relative = v_a - v_b;
    let change = reflect(relative, n) - relative;
    let [a, b] = inverse_masses;
    let share = |own: f32| if a + b > 0.0 { own / (a + b) } else { 0.0 };
    (v_a + change * share(a), v_b - change * share(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_what_points_inwards() {
        assert_eq!(reflect(Vec3::new(3.0, 0.0, -4.0), Vec3::Z), Vec3::new(3.0, 0.0, 4.0));
        assert_eq!(reflect(Vec3::new(3.0, 0.0, 4.0), Vec3::Z), Vec3::new(3.0, 0.0, 4.0));
    }

    #[test]
    fn equal_masses_swap_their_normal_velocities() {
        let (a, b) = reflect_pair(Vec3::X * 5.0, Vec3::X * -10.0, [1.0, 1.0], Vec3::NEG_X);
        assert_eq!((a, b), (Vec3::X * -10.0, Vec3::X * 5.0));
    }

    #[test]
    fn keeps_momentum_and_energy() {
        let (va, vb, ma, mb) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(-0.3, 1.0, 2.0), 2.0, 3.0);
        let n = Vec3::new(-0.36, 0.48, -0.8);
        let (wa, wb) = reflect_pair(va, vb, [1.0 / ma, 1.0 / mb], n);
        assert_ne!(va, wa);
        assert!((va * ma + vb * mb - wa * ma - wb * mb).length() < 1e-5);
        let energy = |a: Vec3, b: Vec3| ma * a.length_squared() + mb * b.length_squared();
        assert!((energy(va, vb) - energy(wa, wb)).abs() < 1e-4);
    }
}
