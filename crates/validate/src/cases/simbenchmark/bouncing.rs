//! Elastic balls bounce for 20 s: what happens to their energy?

use super::GROUP;
use super::sweep::{self, Published, Run, step_of};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{ALL, EngineName, Surface, Terms, Thing};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::Integrator;
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "bouncing",
    group: GROUP,
    title: "49 elastic balls bounce",
    source: Source::Published("SimBenchmark, bouncing"),
    setup: "49 balls of radius 0.1 m, 10 kg, 2 m apart, 5 m above the ground, e = 1, no friction, 20 s, no sub-steps. The mean over the steps \
            of (E − E₀)². The default solver by both integrators.",
    engines: ALL,
    long: false,
    run,
};

/// Step (s), error (J²), processor time (s).
const PUBLISHED: [Published; 4] = [
    Published {
        engine: "RaiSim",
        rows: &[[1e-4, 1.86e-6, 2.37], [1e-3, 0.0186, 0.235], [1e-2, 186.0, 0.025]],
    },
    Published { engine: "ODE", rows: &[[1e-4, 1.85, 19.8], [1e-3, 185.03, 1.86], [1e-2, 1.88e4, 0.19]] },
    Published { engine: "Bullet", rows: &[[1e-4, 752.0, 8.23], [1e-3, 7.52e4, 0.852], [1e-2, 7.41e6, 0.10]] },
    Published { engine: "DART", rows: &[[1e-4, 483.0, 31.9], [1e-3, 7.23e4, 3.21], [1e-2, 7.38e6, 0.34]] },
];

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rates: &[f32] = match rig.quick {
        true => &[1e3, 100.0, 10.0],
        false => &[25e3, 1e4, 2500.0, 1e3, 250.0, 100.0, 25.0, 10.0],
    };
    // Semi-implicit Euler measures the speed half a step ahead: E is off by ½ m g h v, whose mean square over a parabola from height s is
    // (½ M g h)² 2 g s / 3.
    let g = Terms::FINE.g();
    let euler = |h: f64| (0.5 * 490.0 * g * h).powi(2) * 2.0 * g * 4.9 / 3.0;
    let mut findings = Findings::default();
    if rig.engine == EngineName::SoftStep {
        second_order(rig, rates, &mut findings)?;
    }
    let mut curve = Vec::new();
    for &rate in rates {
        let h = f64::from(1.0 / rate);
        let Run { error, processor } = bounce(rig, rate, Integrator::SemiImplicit)?;
        curve.push([h, error, processor]);
        findings
            .at_most(
                format!("mean square error of the energy at {}, semi-implicit", step_of(rate)),
                "J²",
                error,
                1.02 * euler(h),
                "an exact bounce on semi-implicit Euler has (½ M g h)² · 2 g s / 3 exactly, 185.1 J² at 1 ms; 2 % for where in a step balls hit",
            )
            .beside(&sweep::at(&PUBLISHED, rate));
    }
    let line = [1e-5, 0.1].map(|h| (h, euler(h))).to_vec();
    let expected = Some(("semi-implicit Euler, exact bounce", line));
    sweep::draw(&mut findings, "mean square error of the energy, J²", &curve, &PUBLISHED, expected);
    Ok(findings)
}

/// The integrator that the default solver comes with.
fn second_order(rig: &Rig, rates: &[f32], findings: &mut Findings) -> Result<(), Error> {
    let mut curve = Vec::new();
    for &rate in rates {
        let h = f64::from(1.0 / rate);
        let Run { error, processor } = bounce(rig, rate, Integrator::SecondOrder)?;
        curve.push([h, error, processor]);
        let others = sweep::at(&PUBLISHED, rate);
        let what = format!("mean square error of the energy at {}", step_of(rate));
        match others.first() {
            Some(&(_, best)) => findings.at_most(what, "J²", error, best, "RaiSim's, the best of the four"),
            None => findings.shown(what, "J²", error),
        };
        findings.beside(&others);
    }
    sweep::draw(findings, "mean square error of the energy, J²", &curve, &PUBLISHED, None);
    Ok(())
}

/// The mean square error of the energy, J².
pub(super) fn bounce(rig: &Rig, rate: f32, integrator: Integrator) -> Result<Run, Error> {
    let terms = Terms { rate, threshold: 0.0, integrator, ..Terms::FINE };
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
    Ok(Run { error: sum / steps as f64, processor: stage.processor() })
}
