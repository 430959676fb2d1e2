//! `frames.csv`: one row per step.

use rockfall::{STAGES, StepReport};
use std::fmt::Write;

/// Columns before those of the stages; units are part of the names.
const COLUMNS: [&str; 22] = [
    "frame",
    "time_s",
    "bodies",
    "awake",
    "pairs",
    "touching",
    "manifolds",
    "contacts",
    "colors",
    "split",
    "serial",
    "deepest_penetration_m",
    "mean_penetration_m",
    "kinetic_energy_J",
    "potential_energy_J",
    "momentum_x_kg_m_s",
    "momentum_y_kg_m_s",
    "momentum_z_kg_m_s",
    "angular_momentum_x_kg_m2_s",
    "angular_momentum_y_kg_m2_s",
    "angular_momentum_z_kg_m2_s",
    "frozen",
];

/// The first line: names of the columns, then `STAGE_ms` for each of [`STAGES`], then `hash`.
pub fn header() -> String {
    let mut line = COLUMNS.join(",");
    for stage in STAGES {
        let _ = write!(line, ",{stage}_ms");
    }
    line.push_str(",hash\n");
    line
}

/// The line of one frame. Numbers are written so that reading them gives the same bits; the hash is hexadecimal,
/// and empty where it was not taken.
pub fn row(frame: u64, time: f64, report: &StepReport, hash: Option<u64>) -> String {
    let r = report;
    let mut line = format!(
        "{frame},{time},{},{},{},{},{},{},{},{},{},{},{},{},{}",
        r.bodies,
        r.awake,
        r.pairs,
        r.touching,
        r.manifolds,
        r.contacts,
        r.colors,
        r.split,
        r.serial,
        r.deepest_penetration,
        r.mean_penetration,
        r.kinetic_energy,
        r.potential_energy,
    );
    // Writing to a string cannot fail.
    for value in r.momentum.iter().chain(&r.angular_momentum) {
        let _ = write!(line, ",{value}");
    }
    let _ = write!(line, ",{}", r.frozen);
    for time in &r.times {
        let _ = write!(line, ",{:.3}", time.as_secs_f64() * 1e3);
    }
    line.push(',');
    if let Some(hash) = hash {
        let _ = write!(line, "{hash:016x}");
    }
    line.push('\n');
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_has_a_value_that_reads_back() {
        let report = StepReport {
            awake: 7,
            mean_penetration: 0.1,
            kinetic_energy: 1.0 / 3.0,
            angular_momentum: [1.0, -2.5e-9, 3.0e20],
            frozen: 2,
            ..StepReport::default()
        };
        let (header, row) = (header(), row(3, 0.05, &report, Some(0xabc)));
        let cells: Vec<(&str, &str)> = header.trim_end().split(',').zip(row.trim_end().split(',')).collect();
        assert_eq!(header.matches(',').count(), row.matches(',').count());
        let cell = |name: &str| cells.iter().find(|(column, _)| *column == name).unwrap().1;
        assert_eq!(cell("frame"), "3");
        assert_eq!(cell("awake"), "7");
        assert_eq!(cell("mean_penetration_m").parse(), Ok(0.1f32));
        assert_eq!(cell("kinetic_energy_J").parse(), Ok(1.0f64 / 3.0));
        assert_eq!(cell("angular_momentum_y_kg_m2_s").parse(), Ok(-2.5e-9f64));
        assert_eq!(cell("frozen"), "2");
        assert_eq!(cell("report_ms"), "0.000");
        assert_eq!(cell("hash"), "0000000000000abc");
    }
}
