//! The box of Gazebo's benchmark flies for 10 s.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, EngineName, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, Stage, cuboid};
use rockfall::math::{DVec3, Vec3, rotation};

const BASE: Case = Case {
    name: "gazebo-simple",
    group: GROUP,
    title: "A box turns about its first axis",
    source: Source::Published("Gazebo's \"boxes\" benchmark (scpeters/benchmark), simple"),
    setup: "Box 0.1 × 0.4 × 0.9 m, 10 kg, no gravity, (−0.9, 0.4, 0.1) m/s, 0.5 rad/s about x, 10 s.",
    engines: ALL,
    long: false,
    run: simple,
};

pub(super) const CASES: [Case; 2] = [
    BASE,
    Case {
        name: "gazebo-complex",
        title: "A box is thrown and tumbles near its unstable axis",
        source: Source::Published("Gazebo's \"boxes\" benchmark (scpeters/benchmark), complex"),
        setup: "Box 0.1 × 0.4 × 0.9 m, 10 kg, g = 9.8, (−2, 2, 8) m/s, (0.1, 5, 0.1) rad/s, 10 s. Largest errors over the run; energy and \
                angular momentum relative to their start.",
        run: complex,
        ..BASE
    },
];

/// Principal moments, kg m².
const MOMENTS: DVec3 = DVec3::new(0.808_333_333, 0.683_333_333, 0.141_666_667);

/// Largest errors over a run.
#[derive(Default)]
struct Worst {
    position: f64,
    energy: f64,
    momentum: f64,
}

fn fly(
    stage: &mut Stage,
    velocity: Vec3,
    spin: Vec3,
    mut each: impl FnMut(f64, &Stage, usize) -> Result<(), Error>,
) -> Result<Worst, Error> {
    let shape = cuboid(0.1, 0.4, 0.9);
    let thing = Thing::new(shape, Surface::new(0.0, 0.0), DVec3::ZERO).mass(10.0).moving(velocity, spin);
    let body = stage.put(&thing)?;
    let (v, w) = (velocity.as_dvec3(), spin.as_dvec3());
    let energy = 0.5 * (10.0 * v.length_squared() + w.dot(w * MOMENTS));
    let momentum = w * MOMENTS;
    let mut worst = Worst::default();
    for step in 1..=stage.terms.steps_in(10.0) {
        stage.step()?;
        let t = step as f64 * stage.terms.dt();
        let exact = v * t + stage.terms.gravity.as_dvec3() * (0.5 * t * t);
        worst.position = worst.position.max((stage.position(body)? - exact).length());
        worst.energy = worst.energy.max((stage.energy()? / energy - 1.0).abs());
        worst.momentum = worst.momentum.max((stage.spun(body)? - momentum).length() / momentum.length());
        each(t, stage, body)?;
    }
    Ok(worst)
}

fn simple(rig: &Rig) -> Result<Findings, Error> {
    let mut stage = rig.stage(Terms { gravity: Vec3::ZERO, ..Terms::FINE })?;
    let mut end = DVec3::ZERO;
    let worst = fly(&mut stage, Vec3::new(-0.9, 0.4, 0.1), Vec3::X * 0.5, |_, stage, body| {
        end = rotation::to_rotation_vector(stage.rotation(body)?).as_dvec3();
        Ok(())
    })?;
    // 5 rad about x is 5 − 2π the other way round.
    let angle = (end - DVec3::X * (5.0 - core::f64::consts::TAU)).length();
    let mut findings = Findings::default();
    let rounding = "10,000 roundings to single precision, 6e-8 each, all on one side at the worst";
    findings
        .at_most("angle at 1 ms", "rad", angle, 6e-4, rounding)
        .beside(&[("ODE", 1.0e-7), ("Simbody", 2.6e-8), ("Bullet", 1.5e-13)])
        .at_most(
            "position at 1 ms",
            "m",
            worst.position,
            1e-4,
            "velocities are single precision: 6e-8 of 1 m/s for 10 s, and the step",
        )
        .at_most("energy at 1 ms", "", worst.energy, 1e-5, "nothing acts")
        .at_most("angular momentum at 1 ms", "", worst.momentum, 1e-5, "nothing acts");
    Ok(findings)
}

/// Angular velocity in the body's axes at 1, 2, 5 and 10 s: RK4 at 0.1 ms, its period checked against 4 K(k) / n to six digits.
const REFERENCE: [(f64, DVec3); 4] = [
    (1.0, DVec3::new(3.423_798_442, 2.819_185_438, 3.928_384_449)),
    (2.0, DVec3::new(0.336_649_761, -4.984_932_935, 0.382_181_881)),
    (5.0, DVec3::new(0.374_990_780, 4.980_946_881, -0.426_603_245)),
    (10.0, DVec3::new(2.755_840_405, -3.735_963_520, -3.161_809_003)),
];

/// Position, angular momentum, energy; ODE, Bullet, Simbody and DART at 1 ms.
const PUBLISHED: [[(&str, f64); 4]; 3] = [
    [("ODE", 0.049), ("Bullet", 0.049), ("Simbody", 0.0245), ("DART", 0.049)],
    [("ODE", 1.31e-2), ("Bullet", 1.25e-2), ("Simbody", 6.4e-3), ("DART", 2.19)],
    [("ODE", 1.25e-2), ("Bullet", 1.36e-2), ("Simbody", 6.2e-3), ("DART", 3.8e-2)],
];

fn complex(rig: &Rig) -> Result<Findings, Error> {
    let mut stage = rig.stage(Terms { gravity: Vec3::Z * -9.8, ..Terms::FINE })?;
    let (mut curve, mut tumbling) = (Vec::new(), 0.0_f64);
    let mut steps = 0;
    let worst = fly(&mut stage, Vec3::new(-2.0, 2.0, 8.0), Vec3::new(0.1, 5.0, 0.1), |t, stage, body| {
        let inner = rotation::rotate_back_double(stage.rotation(body)?, stage.spin(body)?);
        steps += 1;
        if steps % 50 == 0 {
            curve.push((t, inner.y));
        }
        for (when, known) in REFERENCE {
            if (t - when).abs() < 0.5 * stage.terms.dt() {
                tumbling = tumbling.max((inner - known).length());
            }
        }
        Ok(())
    })?;
    let energy = if rig.engine == EngineName::SoftStep { 1e-4 } else { 6.2e-3 };
    let mut findings = Findings::default();
    findings
        .at_most("position at 1 ms", "m", worst.position, 0.0245, "Simbody's, the best of the four")
        .beside(&PUBLISHED[0])
        .at_most(
            "angular momentum at 1 ms",
            "",
            worst.momentum,
            1e-5,
            "nothing turns it; the splitting keeps it to rounding",
        )
        .beside(&PUBLISHED[1])
        .at_most(
            "energy at 1 ms",
            "",
            worst.energy,
            energy,
            "Simbody's 6.2e-3, the best of the four; of positions that are exact under gravity, rounding",
        )
        .beside(&PUBLISHED[2])
        .at_most(
            "angular velocity off the reference at 1, 2, 5, 10 s",
            "rad/s",
            tumbling,
            0.1,
            "2 %: what is off at the start grows by e^(4.5 t) while the box tips over, twice in the run",
        )
        .draw(
            Figure::linear("Tumbling", "time, s", "angular velocity about the middle axis, rad/s")
                .ours("", curve)
                .expected(
                    "RK4 at 1 ms",
                    turning(DVec3::new(0.1, 5.0, 0.1)).into_iter().step_by(50).map(|(t, w)| (t, w.y)),
                ),
        );
    if !rig.quick {
        let mut stage = rig.stage(Terms { gravity: Vec3::Z * -9.8, rate: 1e4, ..Terms::FINE })?;
        let velocity = Vec3::new(-2.0, 2.0, 8.0);
        let worst = fly(&mut stage, velocity, Vec3::new(0.1, 5.0, 0.1), |_, _, _| Ok(()))?;
        findings
            .at_most("position at 0.1 ms", "m", worst.position, 0.00245, "Simbody's")
            .beside(&[("ODE", 0.0049), ("Bullet", 0.0049), ("Simbody", 0.00245), ("DART", 0.049)])
            .at_most("energy at 0.1 ms", "", worst.energy, 6.2e-4, "Simbody's")
            .beside(&[("ODE", 1.25e-3), ("Bullet", 1.36e-3), ("Simbody", 6.2e-4), ("DART", 2.7e-2)]);
    }
    Ok(findings)
}

/// Euler's equations in the body's axes by RK4: time and angular velocity at every millisecond for 10 s.
fn turning(start: DVec3) -> Vec<(f64, DVec3)> {
    let rate = |w: DVec3| -w.cross(w * MOMENTS) / MOMENTS;
    let (h, mut w, mut curve) = (1e-3, start, Vec::new());
    for step in 0..=10_000 {
        curve.push((f64::from(step) * h, w));
        let a = rate(w);
        let b = rate(w + a * (0.5 * h));
        let c = rate(w + b * (0.5 * h));
        let d = rate(w + c * h);
        w += (a + (b + c) * 2.0 + d) * (h / 6.0);
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_through_the_reference() {
        let curve = turning(DVec3::new(0.1, 5.0, 0.1));
        for (time, known) in REFERENCE {
            let (_, w) = curve[(time * 1000.0).round() as usize];
            assert!((w - known).length() < 1e-6, "{time}: {w} {known}");
        }
    }
}
