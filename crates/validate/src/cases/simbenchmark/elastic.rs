//! "Elastic 666": the same lattice falls with e = 1: what happens to the energy where many bounce at once?

use super::GROUP;
use super::sweep::{self, Published, Run, step_of};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, EngineName, Terms};
use crate::finding::{Figure, Findings, Points};
use crate::stage::Rig;

pub(super) const CASE: Case = Case {
    name: "elastic-pile",
    group: GROUP,
    title: "216 elastic balls fall onto each other (\"elastic 666\")",
    source: Source::Published("SimBenchmark, elastic 666"),
    setup: "6 × 6 × 6 balls of radius 0.1 m, 10 kg, 0.21 m apart, each moved at random by up to 1 mm, the lowest 1 m above the ground, e = 1, no \
            friction, 10 s, no sub-steps. The mean over the steps of (E − E₀)². The default solver with one sweep of restitution, and with as \
            many as it takes.",
    engines: ALL,
    long: false,
    run,
};

/// Step (s), error (J²), processor time (s).
const PUBLISHED: [Published; 4] = [
    Published {
        engine: "RaiSim",
        rows: &[[1e-4, 1.1e-3, 6.12], [1e-3, 8.37, 0.655], [4e-3, 264.0, 0.181], [1e-2, 5.2e6, 0.070]],
    },
    Published {
        engine: "ODE",
        rows: &[[1e-4, 1.10, 56.0], [1e-3, 112.3, 5.6], [4e-3, 1.65e3, 1.43], [1e-2, 8.6e6, 0.58]],
    },
    Published {
        engine: "Bullet",
        rows: &[[1e-4, 168.0, 21.5], [1e-3, 4.15e4, 2.32], [4e-3, 8.40e5, 0.65], [1e-2, 9.9e6, 0.32]],
    },
    Published {
        engine: "DART",
        rows: &[[1e-4, 2438.0, 141.0], [1e-3, 3.47e5, 8.06], [4e-3, 6.62e6, 1.95], [1e-2, 1.3e10, 0.84]],
    },
];

/// Sweeps of restitution, at most: as many as it takes.
pub(super) const SWEEPS: u32 = 500;

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rates: &[f32] = if rig.quick { &[1e3, 100.0] } else { &[1e4, 1e3, 250.0, 100.0] };
    let mut findings = Findings::default();
    let (mut curve, mut energies) = (Vec::new(), Vec::new());
    let ours = rig.engine == EngineName::SoftStep;
    for (&rate, sweeps) in
        rates.iter().flat_map(|rate| [(rate, SWEEPS), (rate, 1)]).filter(|(_, n)| ours || *n == 1)
    {
        let (Run { error, processor }, energy) = fall(rig, rate, sweeps)?;
        if ours && sweeps == 1 {
            findings.shown(format!("the same at {} with one sweep", step_of(rate)), "J²", error);
            continue;
        }
        curve.push([f64::from(1.0 / rate), error, processor]);
        if rate == 1e3 {
            energies = energy;
        }
        let others = sweep::at(&PUBLISHED, rate);
        let what = format!("mean square error of the energy at {}", step_of(rate));
        findings.at_most(what, "J²", error, others[0].1, "RaiSim's, the best of the four").beside(&others);
    }
    sweep::draw(&mut findings, "mean square error of the energy, J²", &curve, &PUBLISHED, None);
    findings.draw(
        Figure::linear("Energy at 1 ms", "time, s", "share of the start")
            .ours("", energies)
            .expected("kept", [(0.0, 1.0), (10.0, 1.0)]),
    );
    Ok(findings)
}

/// The mean square error of the energy, J², and the energy over time, relative to the start.
pub(super) fn fall(rig: &Rig, rate: f32, sweeps: u32) -> Result<(Run, Points), Error> {
    let terms = Terms { rate, sweeps, threshold: 0.0, ..Terms::FINE };
    let mut stage = super::elastic_lattice(rig, terms)?;
    let start = stage.energy()?;
    let steps = terms.steps_in(10.0);
    let (mut sum, mut curve) = (0.0, Vec::new());
    for step in 0..steps {
        let energy = stage.energy()?;
        sum += (energy - start).powi(2);
        if step % (steps / 200).max(1) == 0 {
            curve.push((stage.time(), energy / start));
        }
        stage.step()?;
    }
    Ok((Run { error: sum / steps as f64, processor: stage.processor() }, curve))
}
