//! The report as a table for terminals, which is one in Markdown, too.

use crate::engine::EngineName;
use crate::finding::{Check, Gate};
use crate::number::{number, with_unit};
use crate::report::Report;

const COLUMNS: [&str; 6] = ["case", "engine", "figure", "expected", "got", "verdict"];

/// What is expected, in words.
pub(crate) fn expected(check: &Check) -> String {
    match check.gate {
        Gate::Near { expected, tolerance } => {
            format!("{} ± {}", number(expected), with_unit(tolerance, check.unit))
        }
        Gate::AtMost(limit) => format!("≤ {}", with_unit(limit, check.unit)),
        Gate::AtLeast(limit) => format!("≥ {}", with_unit(limit, check.unit)),
        Gate::Shown => String::new(),
    }
}

/// Whether it passes, in a word.
pub(crate) fn verdict(check: &Check) -> &'static str {
    match (check.gate, check.passes()) {
        (Gate::Shown, true) => "",
        (_, true) => "pass",
        (_, false) => "FAIL",
    }
}

/// A row for each check.
pub(crate) fn table(report: &Report) -> String {
    let mut rows: Vec<[String; 6]> = vec![COLUMNS.map(str::to_owned)];
    for outcome in &report.outcomes {
        let (case, engine) = (outcome.case.to_owned(), outcome.engine.name().to_owned());
        if let Some(error) = &outcome.error {
            let verdict = if outcome.left_out { "" } else { "FAIL" };
            rows.push([case, engine, error.clone(), String::new(), String::new(), verdict.to_owned()]);
            continue;
        }
        for check in &outcome.checks {
            rows.push([
                case.clone(),
                engine.clone(),
                check.what.clone(),
                expected(check),
                with_unit(check.got, check.unit),
                verdict(check).to_owned(),
            ]);
        }
    }
    let widths: [usize; 6] =
        std::array::from_fn(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0));
    let line = |row: &[String; 6]| {
        let cells = row.iter().zip(widths).map(|(text, width)| format!(" {text:width$} |"));
        format!("|{}\n", cells.collect::<String>())
    };
    let rule: String = widths.iter().map(|width| format!("{}|", "-".repeat(width + 2))).collect();
    let body: String = rows[1..].iter().map(line).collect();
    format!("{}|{rule}\n{body}", line(&rows[0]))
}

/// A line for each engine.
pub(crate) fn summary(report: &Report) -> String {
    let mut lines = Vec::new();
    for engine in EngineName::ALL {
        let of = || report.outcomes.iter().filter(move |o| o.engine == engine && !o.left_out);
        if of().next().is_none() {
            continue;
        }
        let gated = || of().flat_map(|outcome| &outcome.checks).filter(|check| check.gate != Gate::Shown);
        let passed = gated().filter(|check| check.passes()).count();
        let (cases, whole) = (of().count(), of().filter(|outcome| outcome.passed).count());
        let name = engine.name();
        let mut line =
            format!("{name}: {whole} of {cases} cases pass, {passed} of {} checks", gated().count());
        let failed = report.failed(engine);
        if !failed.is_empty() {
            line += &format!("; not {}", failed.join(", "));
        }
        lines.push(line);
    }
    format!("{}\n{:.0} s", lines.join("\n"), report.seconds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn every_check_has_a_row_and_a_verdict() {
        let text = table(&sample());
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows.len(), 2 + 2);
        assert!(rows[2].contains("2 ± 0.1 m/s") && rows[2].contains("2.05 m/s") && rows[2].contains("pass"));
        assert!(rows[3].contains("reflect") && rows[3].contains("FAIL"));
        let width = rows[0].chars().count();
        assert!(rows.iter().all(|row| row.chars().count() == width), "{text}");
    }

    #[test]
    fn the_summary_counts_by_engine() {
        let text = summary(&sample());
        assert!(text.contains("soft-step: 1 of 1 cases pass, 1 of 1 checks\n"), "{text}");
        assert!(text.contains("reflect: 0 of 1 cases pass, 0 of 1 checks; not falling"), "{text}");
    }
}
