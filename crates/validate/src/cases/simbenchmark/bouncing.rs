//! Elastic balls bounce for 20 s: what happens to their energy?

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, Surface, Terms, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "bouncing",
    group: GROUP,
    title: "49 elastic balls bounce",
    source: Source::Published("SimBenchmark, bouncing"),
    setup: "49 balls of radius 0.1 m, 10 kg, 2 m apart, 5 m above the ground, e = 1, no friction, 20 s, no sub-steps. The mean over the steps \
            of (E − E₀)².",
    engines: ALL,
    long: false,
    run,
};

/// Steps (s) and errors (J²) of RaiSim, ODE, Bullet and DART, in this order.
const PUBLISHED: [(f64, [f64; 4]); 3] = [
    (1e-4, [1.86e-6, 1.85, 752.0, 483.0]),
    (1e-3, [0.0186, 185.03, 7.52e4, 7.23e4]),
    (1e-2, [186.0, 1.88e4, 7.41e6, 7.38e6]),
];
const ENGINES: [&str; 4] = ["RaiSim", "ODE", "Bullet", "DART"];

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rates: &[f32] = match rig.quick {
        true => &[1e3, 100.0, 10.0],
        false => &[25e3, 1e4, 2500.0, 1e3, 250.0, 100.0, 25.0, 10.0],
    };
    let mut findings = Findings::default();
    let mut curve = Vec::new();
    for &rate in rates {
        let dt = f64::from(1.0 / rate);
        let (error, g) = energy_error(rig, rate)?;
        curve.push((dt, error));
        // Semi-implicit Euler measures the speed half a step ahead: E is off by ½ m g h v, whose mean square over a parabola from height
        // s is (½ M g h)² 2 g s / 3.
        let euler = (0.5 * 490.0 * g * dt).powi(2) * 2.0 * g * 4.9 / 3.0;
        let published = PUBLISHED.iter().find(|(step, _)| (step / dt - 1.0).abs() < 1e-3);
        findings.at_most(
            format!("mean square error of the energy at {} ms", 1e3 * f64::from(1e6 / rate) / 1e6),
            "J²",
            error,
            1.02 * euler,
            "an exact bounce on semi-implicit Euler has (½ M g h)² · 2 g s / 3 exactly, 185.1 J² at 1 ms; 2 % for where in a step balls hit",
        );
        if let Some((_, errors)) = published {
            findings.beside(&std::array::from_fn::<_, 4, _>(|i| (ENGINES[i], errors[i])));
        }
    }
    let mut figure =
        Figure::logarithmic("Error against step", "step, s", "mean square error of the energy, J²")
            .ours("", curve)
            .expected(
                "semi-implicit Euler, exact bounce",
                [1e-4, 0.1].map(|h: f64| (h, 185.1 * (h / 1e-3).powi(2))),
            );
    for (i, engine) in ENGINES.iter().enumerate() {
        figure = figure.published(engine, PUBLISHED.map(|(step, errors)| (step, errors[i])));
    }
    findings.draw(figure);
    Ok(findings)
}

/// The mean square error of the energy, J², and gravity.
fn energy_error(rig: &Rig, rate: f32) -> Result<(f64, f64), Error> {
    let terms = Terms { rate, threshold: 0.0, ..Terms::FINE };
    let surface = Surface::new(0.0, 1.0);
    let mut stage = rig.on_ground(terms, surface)?;
    for i in 0..49 {
        let place = DVec3::new(2.0 * (i % 7) as f64, 2.0 * (i / 7) as f64, 5.0);
        stage.put(&Thing::new(ball(0.1), surface, place).mass(10.0))?;
    }
    let start = stage.energy()?;
    let steps = terms.steps_in(20.0);
    let mut sum = 0.0;
    for _ in 0..steps {
        sum += (stage.energy()? - start).powi(2);
        stage.step()?;
    }
    Ok((sum / steps as f64, terms.g()))
}
