//! Errors over steps, ours and published ones.

use crate::finding::{Figure, Findings};

/// What a run with one step came to.
#[derive(Clone, Copy)]
pub(super) struct Run {
    /// In the unit of the case.
    pub(super) error: f64,
    /// Processor time of all steps, s.
    pub(super) processor: f64,
}

/// What another engine got.
pub(super) struct Published {
    pub(super) engine: &'static str,
    /// Step (s), error, processor time of the whole run (s).
    pub(super) rows: &'static [[f64; 3]],
}

/// Steps per second as a step in words.
pub(super) fn step_of(rate: f32) -> String {
    format!("{} ms", f64::from(1e6 / rate) / 1e3)
}

/// What all others got with a step.
pub(super) fn at(published: &[Published], rate: f32) -> Vec<(&'static str, f64)> {
    let near = |row: &&[f64; 3]| (row[0] * f64::from(rate) - 1.0).abs() < 1e-3;
    let found = published.iter().filter_map(|p| Some((p.engine, p.rows.iter().find(near)?[1])));
    found.collect()
}

/// Errors against steps, with what is expected, and against time.
pub(super) fn draw(
    findings: &mut Findings,
    up: &'static str,
    ours: &[[f64; 3]],
    published: &[Published],
    expected: Option<(&str, Vec<(f64, f64)>)>,
) {
    let pick =
        |rows: &[[f64; 3]], column: usize| rows.iter().map(|row| (row[column], row[1])).collect::<Vec<_>>();
    let mut by_step = Figure::logarithmic("Error against step", "step, s", up).ours("", pick(ours, 0));
    let across = "processor time of the run, s (published ones on other machines)";
    let mut by_time = Figure::logarithmic("Error against time", across, up).ours("", pick(ours, 2));
    for Published { engine, rows } in published {
        by_step = by_step.published(engine, pick(rows, 0));
        by_time = by_time.published(engine, pick(rows, 2));
    }
    if let Some((name, points)) = expected {
        by_step = by_step.expected(name, points);
    }
    findings.draw(by_step).draw(by_time);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_found_by_their_rate() {
        const ROWS: Published = Published { engine: "ODE", rows: &[[1e-4, 1.0, 0.0], [4e-3, 2.0, 0.0]] };
        assert_eq!(at(&[ROWS], 250.0), [("ODE", 2.0)]);
        assert!(at(&[ROWS], 1000.0).is_empty());
        assert_eq!([1e4, 1000.0, 25.0].map(step_of), ["0.1 ms", "1 ms", "40 ms"]);
    }
}
