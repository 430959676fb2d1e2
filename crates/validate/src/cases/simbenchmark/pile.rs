//! "666": 6 × 6 × 6 balls fall into a heap without friction: how far do they overlap?

use super::GROUP;
use super::sweep::{self, Published, Run, step_of};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Numbers, Rig, Stage, ball};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "pile",
    group: GROUP,
    title: "216 balls fall into a heap (\"666\")",
    source: Source::Published("SimBenchmark, 666"),
    setup: "6 × 6 × 6 balls of radius 0.1 m, 10 kg, 0.21 m apart, each moved at random by up to 1 mm, e = 0, no friction, 10 s, no sub-steps. \
            The mean over the steps of the sum of all squared overlaps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Step (s), error (m²), processor time (s).
const PUBLISHED: [Published; 5] = [
    Published {
        engine: "RaiSim",
        rows: &[[1e-4, 1.64e-6, 12.9], [1e-3, 1.35e-4, 1.51], [4e-3, 2.11e-3, 0.388], [1e-2, 1.53e-2, 0.168]],
    },
    Published {
        engine: "ODE quick",
        rows: &[[1e-4, 1.59e-6, 99.0], [1e-3, 1.57e-4, 10.0], [4e-3, 2.08e-3, 2.53], [1e-2, 1.62e-2, 1.00]],
    },
    Published {
        engine: "DART",
        rows: &[[1e-4, 1.98e-7, 197.0], [1e-3, 2.82e-4, 22.9], [4e-3, 9293.0, 6.57], [1e-2, 215.0, 3.07]],
    },
    Published {
        engine: "Bullet",
        rows: &[[1e-4, 3.53e-3, 79.6], [1e-3, 0.382, 12.0], [4e-3, 5.78, 4.14], [1e-2, 37.4, 2.01]],
    },
    Published {
        engine: "MuJoCo",
        rows: &[[1e-4, 1.13e-2, 92.3], [1e-3, 9.50e-2, 12.1], [4e-3, 0.374, 4.33], [1e-2, 0.934, 1.79]],
    },
];

/// Metres.
const RADIUS: f64 = 0.1;

fn run(rig: &Rig) -> Result<Findings, Error> {
    let rates: &[f32] = if rig.quick { &[1e3, 100.0] } else { &[1e4, 1e3, 250.0, 100.0] };
    let mut findings = Findings::default();
    let mut curve = Vec::new();
    for &rate in rates {
        let Run { error, processor } = settle(rig, rate)?;
        curve.push([f64::from(1.0 / rate), error, processor]);
        let others = sweep::at(&PUBLISHED, rate);
        let what = format!("mean sum of squared overlaps at {}", step_of(rate));
        findings
            .at_most(what, "m²", error, others[0].1, "RaiSim's, the best of the five at most steps")
            .beside(&others);
    }
    sweep::draw(&mut findings, "mean sum of squared overlaps, m²", &curve, &PUBLISHED, None);
    Ok(findings)
}

/// 6 × 6 × 6 balls, the lowest centres at `height`.
pub(super) fn lattice(rig: &Rig, terms: Terms, surface: Surface, height: f64) -> Result<Stage, Error> {
    let mut stage = rig.on_ground(terms, surface)?;
    let mut random = Numbers(42);
    for i in 0..216 {
        let place = DVec3::new((i % 6) as f64, (i / 6 % 6) as f64, (i / 36) as f64) * 0.21;
        let place = place + random.vector() * 1e-3 + DVec3::Z * height;
        stage.put(&Thing::new(ball(RADIUS as f32), surface, place).mass(10.0))?;
    }
    Ok(stage)
}

/// The mean of the sum of squared overlaps, m².
pub(super) fn settle(rig: &Rig, rate: f32) -> Result<Run, Error> {
    let terms = Terms { rate, ..Terms::FINE };
    let mut stage = lattice(rig, terms, Surface::new(0.0, 0.0), RADIUS + 1e-3)?;
    let movers: Vec<usize> = stage.movers().collect();
    let steps = terms.steps_in(10.0);
    let mut sum = 0.0;
    for _ in 0..steps {
        let places = movers.iter().map(|&body| stage.position(body)).collect::<Result<Vec<_>, _>>()?;
        sum += squared_overlaps(places);
        stage.step()?;
    }
    Ok(Run { error: sum / steps as f64, processor: stage.processor() })
}

/// Of balls with these centres with each other and with the ground, m².
fn squared_overlaps(mut places: Vec<DVec3>) -> f64 {
    places.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mut sum = 0.0;
    for (i, a) in places.iter().enumerate() {
        sum += (RADIUS - a.z).max(0.0).powi(2);
        for b in places[i + 1..].iter().take_while(|b| b.x - a.x < 2.0 * RADIUS) {
            sum += (2.0 * RADIUS - (*b - *a).length()).max(0.0).powi(2);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlaps_are_those_of_pairs_and_of_the_ground() {
        let places = vec![
            DVec3::new(0.0, 0.0, 0.09),
            DVec3::new(1.0, 0.0, 0.5),
            DVec3::new(1.0, 0.18, 0.5),
            DVec3::new(1.1, 3.0, 0.5),
        ];
        assert!((squared_overlaps(places) - (0.01_f64.powi(2) + 0.02_f64.powi(2))).abs() < 1e-12);
    }
}
