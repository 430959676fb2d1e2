//! "Elastic 666": the same lattice falls with e = 1: what happens to the energy where many bounce at once?

use super::{GROUP, pile};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, Surface, Terms};
use crate::finding::{Figure, Findings};
use crate::stage::Rig;

pub(super) const CASE: Case = Case {
    name: "elastic-pile",
    group: GROUP,
    title: "216 elastic balls fall onto each other (\"elastic 666\")",
    source: Source::Published("SimBenchmark, elastic 666"),
    setup: "6 × 6 × 6 balls of radius 0.1 m, 10 kg, 0.21 m apart, each moved at random by up to 1 mm, the lowest 1 m above the ground, e = 1, no \
            friction, 10 s, no sub-steps. The mean over the steps of (E − E₀)².",
    engines: ALL,
    long: false,
    run,
};

/// Steps (s) and errors (J²) of RaiSim, ODE, Bullet and DART, in this order.
const PUBLISHED: [(f64, [f64; 4]); 4] = [
    (1e-4, [1.1e-3, 1.10, 168.0, 2438.0]),
    (1e-3, [8.37, 112.3, 4.15e4, 3.47e5]),
    (4e-3, [264.0, 1.65e3, 8.40e5, 6.62e6]),
    (1e-2, [5.2e6, 8.6e6, 9.9e6, 1.3e10]),
];
const ENGINES: [&str; 4] = ["RaiSim", "ODE", "Bullet", "DART"];

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rates: &[f32] = if rig.quick { &[1e3, 100.0] } else { &[1e4, 1e3, 250.0, 100.0] };
    let mut findings = Findings::default();
    let mut curve = Vec::new();
    for &rate in rates {
        let dt = f64::from(1.0 / rate);
        let terms = Terms { rate, threshold: 0.0, ..Terms::FINE };
        let mut stage = pile::lattice(rig, terms, Surface::new(0.0, 1.0), 1.101)?;
        let start = stage.energy()?;
        let steps = terms.steps_in(10.0);
        let mut sum = 0.0;
        for _ in 0..steps {
            sum += (stage.energy()? - start).powi(2);
            stage.step()?;
        }
        let error = sum / steps as f64;
        curve.push((dt, error));
        let what = format!("mean square error of the energy at {} ms", 1e3 * f64::from(1e6 / rate) / 1e6);
        if let Some((_, errors)) = PUBLISHED.iter().find(|(step, _)| (step / dt - 1.0).abs() < 1e-3) {
            findings
                .at_most(what, "J²", error, errors[0], "RaiSim's, the best of the four")
                .beside(&std::array::from_fn::<_, 4, _>(|i| (ENGINES[i], errors[i])));
        }
    }
    let mut figure =
        Figure::logarithmic("Error against step", "step, s", "mean square error of the energy, J²");
    figure = figure.ours("", curve);
    for (i, engine) in ENGINES.iter().enumerate() {
        figure = figure.published(engine, PUBLISHED.map(|(step, errors)| (step, errors[i])));
    }
    findings.draw(figure);
    Ok(findings)
}
