//! The result as Markdown, CSV and JSON; as a page, see `page`.

use crate::bandwidth::Bandwidth;
use crate::compare::Line;
use crate::options::Options;
use crate::roofline::Roofline;
use crate::{Error, page, process, roofline};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Names of the columns, and whether they are of numbers.
pub(crate) const COLUMNS: [(&str, bool); 20] = [
    ("scene", false),
    ("bodies", true),
    ("steps", true),
    ("threads", true),
    ("engine", false),
    ("ms per step", true),
    ("times the first", true),
    ("over all steps", true),
    ("first step, times a step", true),
    ("one thread, times as long", true),
    ("CPU ms per step", true),
    ("times the first", true),
    ("penetration mean / p99 / max, mm", true),
    ("overlapping pairs", true),
    ("escaped", true),
    ("motion left, mm/s", true),
    ("kinetic energy, J", true),
    ("moving", true),
    ("top sunk / gone sideways, mm", true),
    ("KB per body, at most / when timed", true),
];

/// A row of the table, as people read it.
pub(crate) fn row(l: &Line) -> [String; COLUMNS.len()] {
    let or_dash = |x: Option<f64>, digits: usize| x.map_or("–".to_owned(), |x| format!("{x:.digits$}"));
    let both = |(drop, drift): (f64, f64)| format!("{drop:.0} / {drift:.0}");
    [
        l.scene.to_owned(),
        l.bodies.to_string(),
        l.steps.to_string(),
        l.threads.to_string(),
        format!("{} {}", l.engine, l.version),
        short(l.ms_per_step, 1),
        short(l.times_first, 2),
        short(l.all_ms_per_step, 1),
        format!("{:.1}", l.first_step_times),
        or_dash(l.threads_worth, 2),
        l.cpu_ms_per_step.map_or("–".to_owned(), |x| short(x, 1)),
        l.cpu_times_first.map_or("–".to_owned(), |x| short(x, 2)),
        format!("{:.2} / {:.1} / {:.1}", l.penetration_mean_mm, l.penetration_p99_mm, l.penetration_max_mm),
        l.overlapping_pairs.to_string(),
        l.escaped.to_string(),
        format!("{:.1}", l.rms_speed_mm_per_s),
        format!("{:.3e}", l.kinetic_joule),
        l.moving.to_string(),
        l.top_drop_mm.zip(l.top_drift_mm).map_or("–".to_owned(), both),
        [l.bytes_per_body, l.timed_bytes_per_body]
            .map(|bytes| or_dash(bytes.map(|b| b / 1e3), 2))
            .join(" / "),
    ]
}

/// With so many digits behind the point; three where a tenth would say little.
fn short(x: f64, digits: usize) -> String {
    let digits = if x < 1.0 { 3 } else { digits };
    format!("{x:.digits$}")
}

/// The table, as the program prints it.
pub(crate) fn markdown(lines: &[Line]) -> String {
    rows_of(&COLUMNS, lines.iter().map(row))
}

/// What the solver reads beside what the machine can read, of those engines that tell it.
pub(crate) fn roofline(roofs: &[Bandwidth], lines: &[Line]) -> String {
    let mut rows = lines.iter().filter_map(roofline::row).peekable();
    if rows.peek().is_none() {
        return String::new();
    }
    format!("{}.\n\n{}\n", streaming(roofs), rows_of(&roofline::COLUMNS, rows))
}

/// The machine's memory, in words.
pub(crate) fn streaming(roofs: &[Bandwidth]) -> String {
    let one = |roof: &Bandwidth| {
        let threads = if roof.threads == 1 { "thread" } else { "threads" };
        format!("{:.1} GB/s with {} {threads}", roof.gigabytes_per_second, roof.threads)
    };
    format!("A streaming read of memory makes {}", roofs.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// A table of columns, with their names and whether they are of numbers.
fn rows_of<const N: usize>(
    columns: &[(&str, bool); N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let names = columns.map(|(name, _)| name.to_owned());
    let sides = columns.map(|(_, right)| if right { "--:" } else { "---" });
    let mut text = format!("| {} |\n|{}|\n", names.join(" | "), sides.join("|"));
    text.extend(rows.into_iter().map(|row| format!("| {} |\n", row.join(" | "))));
    text
}

/// Where the time of those engines goes that tell it.
pub(crate) fn stages(lines: &[Line]) -> String {
    let mut text = String::new();
    for l in lines.iter().filter(|l| !l.stages.is_empty()) {
        let shown: Vec<String> = l
            .stages
            .iter()
            .filter(|(_, time)| *time >= 0.005)
            .map(|(name, time)| format!("{name} {time:.2}"))
            .collect();
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{}, {} bodies, {} threads, {}: {} ms",
            l.scene,
            l.bodies,
            l.threads,
            l.engine,
            shown.join(", ")
        );
    }
    text
}

/// What another thread is worth, stage by stage, where the same engine ran with one thread and with more: the time with one over the
/// time with more, and the share of the work that must have been serial for that (Amdahl's law).
pub(crate) fn serial(lines: &[Line]) -> String {
    let mut text = String::new();
    for one in lines.iter().filter(|l| l.threads == 1) {
        let same = |l: &&Line| (l.scene, l.bodies, l.engine) == (one.scene, one.bodies, one.engine);
        for more in lines.iter().filter(same).filter(|l| l.threads > 1) {
            let shown = |name: &str, [slow, fast]: [f64; 2]| {
                let (speedup, n) = (slow / fast, more.threads as f64);
                let share = ((n / speedup - 1.0) / (n - 1.0)).max(0.0);
                format!("{name} {speedup:.2} ({:.0} %)", 100.0 * share)
            };
            let mut stages = vec![shown("step", [one.ms_per_step, more.ms_per_step])];
            for ((name, slow), (_, fast)) in one.stages.iter().zip(&more.stages) {
                if *slow >= 0.01 * one.ms_per_step {
                    stages.push(shown(name, [*slow, *fast]));
                }
            }
            let of = format!("{}, {} bodies, {}", one.scene, one.bodies, one.engine);
            // Writing to a string can't fail.
            let _ =
                writeln!(text, "{of}: {} threads worth (serial share): {}", more.threads, stages.join(", "));
        }
    }
    text
}

/// All tables as text.
pub(crate) fn all(roofs: &[Bandwidth], lines: &[Line]) -> String {
    format!("{}\n{}{}{}", markdown(lines), roofline(roofs, lines), stages(lines), serial(lines))
}

/// Writes all forms into a folder, which is made if need be.
pub(crate) fn write(
    folder: &Path,
    options: &Options,
    roofs: &[Bandwidth],
    lines: &[Line],
) -> Result<(), Error> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("bench.md"), all(roofs, lines))?;
    fs::write(folder.join("bench.csv"), csv(lines)?)?;
    fs::write(folder.join("bench.html"), page::html(roofs, lines, options.repeats))?;
    let json = serde_json::json!({
        "machine": process::machine(),
        "streaming_reads": roofs,
        "timed": options.timed,
        "turn": options.turn,
        "repeats": options.repeats,
        "seed": options.seed,
        "lines": lines,
    });
    Ok(fs::write(folder.join("bench.json"), serde_json::to_string_pretty(&json)? + "\n")?)
}

/// One row for each line, and of the roofline a column for each of its fields; stages, which differ from engine to engine, are in
/// the JSON only.
fn csv(lines: &[Line]) -> Result<Vec<u8>, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut head = true;
    for line in lines {
        let serde_json::Value::Object(mut fields) = serde_json::to_value(line)? else { continue };
        fields.remove("stages");
        fields.remove("roofline");
        let r = line.roofline.as_ref();
        let of = |read: fn(&Roofline) -> f64| serde_json::json!(r.map(read));
        fields.insert("gigabytes_per_step".to_owned(), of(|r| r.gigabytes_per_step));
        fields.insert("gigabytes_per_second".to_owned(), of(|r| r.gigabytes_per_second));
        fields.insert("of_bandwidth".to_owned(), of(|r| r.of_bandwidth));
        fields.insert("limit_ms".to_owned(), of(|r| r.limit_ms));
        fields.insert("solve_ms".to_owned(), of(|r| r.solve_ms));
        if std::mem::take(&mut head) {
            writer.write_record(fields.keys())?;
        }
        let text = |value: &serde_json::Value| match value {
            serde_json::Value::Null => String::new(),
            serde_json::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        writer.write_record(fields.values().map(text))?;
    }
    Ok(writer.into_inner().map_err(|e| e.into_error())?)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn sample(engine: &'static str) -> Line {
        Line {
            scene: "pyramid",
            bodies: 55,
            steps: 600,
            threads: 2,
            engine,
            version: "1.2.3".to_owned(),
            ms_per_step: 12.34,
            all_ms_per_step: 10.06,
            best_ms_per_step: 11.0,
            first_step_ms: 49.36,
            first_step_times: 4.0,
            threads_worth: None,
            times_first: 1.5,
            cpu_ms_per_step: Some(20.0),
            cpu_times_first: None,
            mass_kg: 10.0,
            overlapping_pairs: 110,
            penetration_mean_mm: 2.345,
            penetration_p99_mm: 9.87,
            penetration_max_mm: 12.0,
            escaped: 0,
            kinetic_joule: 0.5,
            rms_speed_mm_per_s: 3.25,
            moving: 4,
            top_drop_mm: Some(740.4),
            top_drift_mm: Some(12.0),
            bytes_per_body: Some(2456.0),
            timed_bytes_per_body: Some(1234.0),
            roofline: Some(Roofline {
                gigabytes_per_step: 0.002,
                gigabytes_per_second: 5.0,
                of_bandwidth: 0.25,
                limit_ms: 0.1,
                solve_ms: 0.4,
            }),
            stages: vec![("touch".to_owned(), 3.0), ("link".to_owned(), 0.0)],
        }
    }

    #[test]
    fn every_row_of_the_table_has_every_column() {
        let text = markdown(&[sample("a"), sample("b")]);
        let columns: Vec<usize> = text.lines().map(|line| line.matches('|').count()).collect();
        assert_eq!(columns, [21; 4]);
        assert!(text.contains(
            "| 12.3 | 1.50 | 10.1 | 4.0 | – | 20.0 | – | 2.35 / 9.9 / 12.0 | 110 | 0 | 3.2 | 5.000e-1 | 4 | 740 / 12 | 2.46 / 1.23 |"
        ));
        assert_eq!(stages(&[sample("a")]), "pyramid, 55 bodies, 2 threads, a: touch 3.00 ms\n");
    }

    #[test]
    fn small_numbers_have_more_digits() {
        assert_eq!([0.0342, 0.99, 1.0, 12.34].map(|x| short(x, 1)), ["0.034", "0.990", "1.0", "12.3"]);
        assert_eq!(short(1.234, 2), "1.23");
    }

    #[test]
    fn only_engines_that_tell_what_they_read_are_under_the_roof() {
        let roofs = [(1, 12.0), (2, 20.0)]
            .map(|(threads, gigabytes_per_second)| Bandwidth { threads, gigabytes_per_second });
        let mute = Line { roofline: None, ..sample("b") };
        let text = roofline(&roofs, &[sample("a"), mute.clone()]);
        assert!(text.contains("12.0 GB/s with 1 thread, 20.0 GB/s with 2 threads"), "{text}");
        assert_eq!(text.matches("| pyramid |").count(), 1);
        assert_eq!(roofline(&roofs, &[mute]), "");
    }

    #[test]
    fn the_share_that_is_serial_follows_from_two_numbers_of_threads() {
        let (mut one, mut two) = (sample("a"), sample("a"));
        (one.threads, one.ms_per_step, two.ms_per_step) = (1, 16.0, 10.0);
        one.stages[0].1 = 6.0;
        assert_eq!(
            serial(&[one, two, sample("b")]),
            "pyramid, 55 bodies, a: 2 threads worth (serial share): step 1.60 (25 %), touch 2.00 (0 %)\n"
        );
    }

    #[test]
    fn the_csv_reads_back() {
        let bytes = csv(&[sample("a"), sample("b")]).expect("written");
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let column = reader.headers().expect("a head").iter().position(|h| h == "engine").expect("there");
        let engines: Vec<String> = reader.records().map(|r| r.expect("a row")[column].to_owned()).collect();
        assert_eq!(engines, ["a", "b"]);
    }
}
