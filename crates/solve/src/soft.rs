//! Soft contacts: position correction as a damped spring that is solved implicitly.
//!
//! Catto, "Soft Constraints", GDC 2011, and "Solver2D", 2024. A spring of natural frequency f and damping ratio ζ is
//! independent of mass: the same three numbers serve every contact.

use core::f32::consts::TAU;

/// The three numbers of a soft contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Speed of correction per metre of overlap, 1/s.
    pub rate: f32,
    /// Factor on the effective mass.
    pub mass_scale: f32,
    /// Share of the accumulated impulse that leaks in one iteration.
    pub impulse_scale: f32,
}

impl Softness {
    /// Of a spring of `hertz` Hz and damping ratio `damping` over a sub-step of `h` seconds.
    pub fn new(hertz: f32, damping: f32, h: f32) -> Self {
        let omega = TAU * hertz;
        let a1 = 2.0 * damping + h * omega;
        let a2 = h * omega * a1;
        let a3 = 1.0 / (1.0 + a2);
        Softness { rate: omega / a1, mass_scale: a2 * a3, impulse_scale: a3 }
    }
}

/// What all contacts of a sweep share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubStep {
    /// Length of the sub-step, s.
    pub h: f32,
    /// Fastest correction of an overlap, m/s.
    pub push_speed: f32,
    /// Contacts between two bodies that move.
    pub two_sided: Softness,
    /// Contacts with immovable bodies: stiffer, because nothing gives way.
    pub one_sided: Softness,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An overlap under the soft correction alone, integrated as the solver does, dies away as the spring that
    /// it stands for: implicit Euler of x'' + 2 ζ ω x' + ω² x = 0.
    #[test]
    fn is_an_implicit_spring() {
        let (h, hertz, damping) = (1.0 / 240.0, 5.0, 1.0);
        let soft = Softness::new(hertz, damping, h);
        let omega = TAU * hertz;
        let (mut x, mut v) = (0.01_f32, 0.0_f32);
        let (mut y, mut w) = (x, v);
        for _ in 0..100 {
            // One body of mass 1; the impulse starts from zero in each step, as without warm start.
            v -= soft.mass_scale * (v + soft.rate * x);
            x += h * v;
            w = (w - h * omega * omega * y) / (1.0 + 2.0 * damping * omega * h + h * h * omega * omega);
            y += h * w;
        }
        assert!((x - y).abs() < 1e-6, "{x} {y}");
    }
}
