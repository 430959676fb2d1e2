//! `frames.csv`: one row per step.

use crate::{Error, checksum};
use rockfall::{STAGES, StepReport};
use std::fmt::Write;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Columns before those of the stages; units are part of the names.
const COLUMNS: [&str; 33] = [
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
    "p99_penetration_m",
    "kinetic_energy_J",
    "potential_energy_J",
    "momentum_x_kg_m_s",
    "momentum_y_kg_m_s",
    "momentum_z_kg_m_s",
    "angular_momentum_x_kg_m2_s",
    "angular_momentum_y_kg_m2_s",
    "angular_momentum_z_kg_m2_s",
    "support_x_N",
    "support_y_N",
    "support_z_N",
    "weight_x_N",
    "weight_y_N",
    "weight_z_N",
    "momentum_error",
    "energy_gain_J",
    "friction_use",
    "frozen",
    "memory_bytes",
];

/// Digits of a row's checksum.
const DIGITS: usize = 8;

/// The first line: names of the columns, then `STAGE_ms` for each of [`STAGES`], then `hash` and `checksum`.
pub fn header() -> String {
    let mut line = COLUMNS.join(",");
    for stage in STAGES {
        let _ = write!(line, ",{stage}_ms");
    }
    line.push_str(",hash,checksum\n");
    line
}

/// The line of one frame. Numbers are written so that reading them gives the same bits; the hash is hexadecimal,
/// and empty where it was not taken. `memory` is in bytes. The checksum is that of the line before it.
pub fn row(frame: u64, time: f64, report: &StepReport, memory: u64, hash: Option<u64>) -> String {
    let r = report;
    let mut line = format!(
        "{frame},{time},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
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
        r.p99_penetration,
        r.kinetic_energy,
        r.potential_energy,
    );
    // Writing to a string cannot fail.
    let balance = [r.momentum_error, r.energy_gain, r.friction_use];
    let vectors = [r.momentum, r.angular_momentum, r.support, r.weight, balance];
    for value in vectors.as_flattened() {
        let _ = write!(line, ",{value}");
    }
    let _ = write!(line, ",{},{memory}", r.frozen);
    for time in &r.times {
        let _ = write!(line, ",{:.3}", time.as_secs_f64() * 1e3);
    }
    line.push(',');
    if let Some(hash) = hash {
        let _ = write!(line, "{hash:016x}");
    }
    let sum = sum(&line);
    let _ = writeln!(line, ",{sum}");
    line
}

/// The checksum of a line.
fn sum(line: &str) -> String {
    checksum(line.as_bytes()).split_off(DIGITS)
}

/// A whole line, without its end and without its checksum, which is right.
fn sound(line: &str) -> Option<&str> {
    let (line, stored) = line.rsplit_once(',')?;
    (sum(line) == stored).then_some(line)
}

/// What a row says that other parts of the run say too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Simulated seconds.
    pub time: f64,
    /// Hash of the state, where it was taken.
    pub hash: Option<u64>,
}

/// Reads the file at `path`: the row of each frame from 1 on. A row that is not complete, at the end, is left out.
///
/// # Errors
/// [`Error::Damaged`] for the first row that is missing or that has a cell without a number; [`Error::Io`].
pub fn read(path: &Path) -> Result<Vec<Row>, Error> {
    let text = fs::read_to_string(path).map_err(|error| Error::io("read", path, &error))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let Some(rows) = whole.strip_prefix(&header()) else {
        return Err(Error::damaged(path, "the names of the columns are others"));
    };
    let row = |(line, frame): (&str, u64)| {
        let cells: Vec<&str> = sound(line)?.split(',').collect();
        let (&hash, numbers) = cells.split_last()?;
        let sound = numbers.len() == COLUMNS.len() + STAGES.len()
            && numbers[0].parse() == Ok(frame)
            && numbers.iter().all(|cell| cell.parse::<f64>().is_ok());
        let hash = if hash.is_empty() { None } else { Some(u64::from_str_radix(hash, 16).ok()?) };
        sound.then_some(Row { time: numbers[1].parse().ok()?, hash })
    };
    let damaged = |frame| Error::damaged(path, format!("the row of frame {frame} is missing or damaged"));
    rows.lines().zip(1..).map(|(line, frame)| row((line, frame)).ok_or_else(|| damaged(frame))).collect()
}

/// How many bytes of the file at `path` the header and the rows up to that of `frame` take, which has to end with `hash`.
pub(crate) fn kept_bytes(path: &Path, frame: u64, hash: u64) -> Result<u64, Error> {
    let file = File::open(path).map_err(|error| Error::io("read", path, &error))?;
    let mut lines = BufReader::new(file);
    let (mut bytes, mut line) = (0, String::new());
    for number in 0..=frame {
        line.clear();
        bytes += lines.read_line(&mut line).map_err(|error| Error::io("read", path, &error))? as u64;
        let row = line.strip_suffix('\n').and_then(sound);
        let whole = if number == 0 {
            line == header()
        } else {
            row.is_some_and(|row| row.starts_with(&format!("{number},")))
        };
        if !whole {
            return Err(Error::damaged(
                path,
                format!("the row of frame {number} is missing or damaged, or is of another version"),
            ));
        }
    }
    let last = line.strip_suffix('\n').and_then(sound).unwrap_or_default();
    if frame > 0 && !last.ends_with(&format!(",{hash:016x}")) {
        return Err(Error::damaged(path, format!("frame {frame} has another hash than its checkpoint")));
    }
    Ok(bytes)
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
        let (header, row) = (header(), row(3, 0.05, &report, 5000, Some(0xabc)));
        let cells: Vec<(&str, &str)> = header.trim_end().split(',').zip(row.trim_end().split(',')).collect();
        assert_eq!(header.matches(',').count(), row.matches(',').count());
        let cell = |name: &str| cells.iter().find(|(column, _)| *column == name).unwrap().1;
        assert_eq!(cell("frame"), "3");
        assert_eq!(cell("awake"), "7");
        assert_eq!(cell("mean_penetration_m").parse(), Ok(0.1f32));
        assert_eq!(cell("kinetic_energy_J").parse(), Ok(1.0f64 / 3.0));
        assert_eq!(cell("angular_momentum_y_kg_m2_s").parse(), Ok(-2.5e-9f64));
        assert_eq!(cell("frozen"), "2");
        assert_eq!(cell("memory_bytes"), "5000");
        assert_eq!(cell("report_ms"), "0.000");
        assert_eq!(cell("hash"), "0000000000000abc");
        assert!(sound(row.trim_end()).is_some());
        assert!(sound(&row.trim_end().replacen("7", "8", 1)).is_none());
    }
}
