//! What these cases take of a processor at 1 ms, beside the peers that are built.

use super::GROUP;
use super::sweep::Run;
use super::{bouncing, elastic, pile, rolling};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, EngineName};
use crate::finding::Findings;
use crate::number::with_unit;
use crate::stage::Rig;
use rockfall::Integrator;

pub(super) const CASE: Case = Case {
    name: "cost",
    group: GROUP,
    title: "Processor time at 1 ms beside the fastest peer's",
    source: Source::Suite("peers in the same run, on the same machine"),
    setup: "The other cases of this group at 1 ms, by the default solver with the second-order integrator and by each peer that is built, in \
            turns, five times (three in the quick form), one thread. Of each the least of the processor time that all steps took, whatever thread took it. A \
            peer counts even where its answer is wrong; what was right is told beside its time.",
    engines: DEFAULT,
    long: false,
    run,
};

/// One of the other cases at 1 ms.
struct Scene {
    name: &'static str,
    /// Of the error.
    unit: &'static str,
    /// The largest error of an answer that is right.
    right: f64,
    run: fn(&Rig) -> Result<Run, Error>,
}

const SCENES: [Scene; 5] = [
    Scene { name: "rolling along y", unit: "m²/s²", right: 1e-6, run: |rig| rolling::roll(rig, 0) },
    Scene { name: "rolling at 60°", unit: "m²/s²", right: 1e-6, run: |rig| rolling::roll(rig, 1) },
    // An exact bounce by semi-implicit steps, which is what peers fly by.
    Scene {
        name: "bouncing",
        unit: "J²",
        right: 189.0,
        run: |rig| bouncing::bounce(rig, 1e3, Integrator::SecondOrder),
    },
    Scene { name: "666", unit: "m²", right: 1.35e-4, run: |rig| pile::settle(rig, 1e3) },
    Scene {
        name: "elastic 666",
        unit: "J²",
        right: 8.37,
        run: |rig| Ok(elastic::fall(rig, 1e3, elastic::SWEEPS)?.0),
    },
];

fn run(rig: &Rig) -> Result<Findings, Error> {
    let peers = EngineName::built().into_iter().filter(|engine| engine.is_peer());
    let engines: Vec<EngineName> = [rig.engine].into_iter().chain(peers).collect();
    let mut findings = Findings::default();
    for Scene { name, unit, right, run } in SCENES {
        let mut runs: Vec<Run> = Vec::new();
        for turn in 0..if rig.quick { 3 } else { 5 } {
            for (i, &engine) in engines.iter().enumerate() {
                let now = run(&Rig { engine, ..*rig })?;
                match turn {
                    0 => runs.push(now),
                    _ => runs[i].processor = runs[i].processor.min(now.processor),
                }
            }
        }
        let (ours, theirs) = (runs[0].processor, &runs[1..]);
        let what = format!("processor time of {name}");
        match theirs.iter().map(|run| run.processor).reduce(f64::min) {
            Some(fastest) => findings.at_most(what, "s", ours, fastest, "no more than the fastest peer's"),
            None => findings.shown(what, "s", ours),
        };
        for (engine, Run { error, processor }) in engines[1..].iter().zip(theirs) {
            let verdict = if *error <= right { "right" } else { "wrong" };
            let what = format!(
                "the same, {}, whose error of {} is {verdict}",
                engine.name(),
                with_unit(*error, unit)
            );
            findings.shown(what, "s", *processor);
        }
    }
    Ok(findings)
}
