//! What the solver reads of memory, beside what the machine can read.

use crate::child::Block;
use crate::compare::{Line, median};
use serde::Serialize;

/// Of one engine on one scene, where the engine tells what it reads. All bytes are lower bounds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Roofline {
    /// That the sweeps of a step read, 10⁹ bytes.
    pub(crate) gigabytes_per_step: f64,
    /// While they do: over the time in the stage *solve*.
    pub(crate) gigabytes_per_second: f64,
    /// Of a streaming read with as many threads.
    pub(crate) of_bandwidth: f64,
    /// Time in which a streaming read would have so many bytes, milliseconds.
    pub(crate) limit_ms: f64,
    /// Time in the stage *solve*, milliseconds per step.
    pub(crate) solve_ms: f64,
}

/// The stage whose bytes are counted.
const STAGE: &str = "solve";

impl Roofline {
    /// Medians over timed turns; `bandwidth` in 10⁹ bytes a second. Nothing where the engine tells no bytes or no such stage.
    pub(crate) fn new(blocks: &[Block], bandwidth: f64) -> Option<Self> {
        let gigabytes = |b: &Block| Some(1e-9 * b.solver_bytes?);
        let solve = |b: &Block| b.stages.iter().find(|(name, _)| name == STAGE).map(|&(_, time)| time);
        let both = |b: &Block| Some((gigabytes(b)?, solve(b)?));
        let told: Vec<(f64, f64)> = blocks.iter().map(both).collect::<Option<_>>()?;
        if told.is_empty() {
            return None;
        }
        let gigabytes_per_second = median(told.iter().map(|(gigabytes, ms)| 1e3 * gigabytes / ms));
        let gigabytes_per_step = median(told.iter().map(|t| t.0));
        Some(Roofline {
            gigabytes_per_step,
            gigabytes_per_second,
            of_bandwidth: gigabytes_per_second / bandwidth,
            limit_ms: 1e3 * gigabytes_per_step / bandwidth,
            solve_ms: median(told.iter().map(|t| t.1)),
        })
    }
}

/// Names of the columns, and whether they are of numbers.
pub(crate) const COLUMNS: [(&str, bool); 11] = [
    ("scene", false),
    ("bodies", true),
    ("threads", true),
    ("engine", false),
    ("GB per step", true),
    ("limit, ms", true),
    ("solve, ms", true),
    ("step, ms", true),
    ("GB/s", true),
    ("of a streaming read", true),
    ("bytes per body and step", true),
];

/// A row of the table, as people read it; nothing of an engine that tells no bytes.
pub(crate) fn row(l: &Line) -> Option<[String; COLUMNS.len()]> {
    let r = l.roofline.as_ref()?;
    Some([
        l.scene.to_owned(),
        l.bodies.to_string(),
        l.threads.to_string(),
        l.engine.to_owned(),
        format!("{:.4}", r.gigabytes_per_step),
        format!("{:.2}", r.limit_ms),
        format!("{:.2}", r.solve_ms),
        format!("{:.2}", l.ms_per_step),
        format!("{:.1}", r.gigabytes_per_second),
        format!("{:.0} %", 100.0 * r.of_bandwidth),
        format!("{:.0}", 1e9 * r.gigabytes_per_step / l.bodies.max(1) as f64),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::sample;

    fn block(bytes: Option<f64>, ms: f64) -> Block {
        let stages = vec![("touch".to_owned(), 9.0), ("solve".to_owned(), ms)];
        Block { wall: 10.0, cpu: None, stages, first: None, solver_bytes: bytes, memory: None }
    }

    #[test]
    fn rates_are_those_of_the_hand() {
        // 20 million bytes in 2 ms are 10 GB/s; a quarter of 40.
        let blocks = [block(Some(2e7), 2.0), block(Some(2e7), 1.0), block(Some(2e7), 4.0)];
        let r = Roofline::new(&blocks, 40.0).expect("told");
        assert!((r.gigabytes_per_step - 0.02).abs() < 1e-12 && (r.gigabytes_per_second - 10.0).abs() < 1e-9);
        assert!((r.of_bandwidth - 0.25).abs() < 1e-9 && (r.limit_ms - 0.5).abs() < 1e-9 && r.solve_ms == 2.0);
    }

    #[test]
    fn who_tells_no_bytes_has_none() {
        assert_eq!(Roofline::new(&[block(None, 2.0)], 40.0), None);
        assert_eq!(Roofline::new(&[], 40.0), None);
        assert!(row(&Line { roofline: None, ..sample("a") }).is_none());
    }

    #[test]
    fn a_row_has_every_column() {
        let cells = row(&sample("a")).expect("told").join(" | ");
        assert_eq!(cells, "pyramid | 55 | 2 | a | 0.0020 | 0.10 | 0.40 | 12.34 | 5.0 | 25 % | 36364");
    }
}
