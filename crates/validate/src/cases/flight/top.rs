//! A symmetric top turns freely.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, Surface, Terms, Thing};
use crate::finding::Findings;
use crate::stage::{Numbers, Rig, cuboid};
use rockfall::math::{DQuat, DVec3, Pose, Vec3, rotation};

pub(super) const CASE: Case = Case {
    name: "symmetric-top",
    group: GROUP,
    title: "A symmetric top turns freely",
    source: Source::Suite(
        "Drake's free cylinder (Kane, Likins and Levinson: R(t) = e^(L t / I) R₀ e^((1 − J / I) ω₃ t))",
    ),
    setup: "I = 0.04 kg m² across, J = 0.02 kg m² along the axis, no gravity; 10 random attitudes and spins of up to 3 rad/s, 10 s at 1 ms.",
    engines: ALL,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let (across, along) = (0.04_f32, 0.02_f32);
    let mut random = Numbers(3);
    let mut stage = rig.stage(Terms { gravity: Vec3::ZERO, ..Terms::FINE })?;
    let mut starts = Vec::new();
    for i in 0..10 {
        let turn = rotation::from_rotation_vector((random.vector() * 3.0).as_vec3());
        let spin = (random.vector() * 2.0 - 1.0).as_vec3() * 3.0;
        let pose = Pose { position: DVec3::X * f64::from(i) * 10.0, rotation: turn };
        let top = Thing::new(cuboid(0.1, 0.1, 0.2), Surface::new(0.0, 0.0), DVec3::ZERO);
        let top = Thing { moments: Some(Vec3::new(across, across, along)), ..top.mass(1.0).pose(pose) };
        starts.push((stage.put(&top.moving(Vec3::ZERO, spin))?, turn, spin));
    }
    stage.seconds(10.0)?;
    let (mut angle, mut spins) = (0.0_f64, 0.0_f64);
    for (top, turn, spin) in starts {
        let body = rotation::rotate_back_double(turn, spin.as_dvec3());
        let (i, j) = (f64::from(across), f64::from(along));
        let momentum = double(turn) * DVec3::new(i * body.x, i * body.y, j * body.z);
        let exact =
            exp(momentum * (10.0 / i)) * double(turn) * exp(DVec3::Z * (10.0 * (1.0 - j / i) * body.z));
        let off = double(stage.rotation(top)?) * exact.conjugate();
        angle = angle.max(2.0 * libm::asin(off.xyz().length().min(1.0)));
        spins = spins.max((stage.spun(top)? - momentum).length() / momentum.length());
    }
    let mut findings = Findings::default();
    findings
        .at_most(
            "largest angle from the exact attitude",
            "rad",
            angle,
            1e-3,
            "10,000 roundings of a quaternion in single precision, 6e-8 each, and some 1e-5 of the splitting",
        )
        .at_most(
            "largest relative error of the angular momentum",
            "",
            spins,
            1e-4,
            "the splitting keeps it; what is left is rounding of the attitude",
        );
    Ok(findings)
}

fn double(q: rockfall::math::Quat) -> DQuat {
    q.as_dquat().normalize()
}

/// The turn about `v` by |v|.
fn exp(v: DVec3) -> DQuat {
    let angle = v.length();
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = if angle > 0.0 { v / angle } else { DVec3::Z } * sin;
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_turns_by_its_length() {
        let turned = exp(DVec3::Z * core::f64::consts::FRAC_PI_2) * DVec3::X;
        assert!((turned - DVec3::Y).length() < 1e-15);
    }
}
