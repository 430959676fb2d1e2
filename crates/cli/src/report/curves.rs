//! The curves of a report, each with the table that is behind it.

use super::table::Table;
use rockfall_plot::{Curve, Scale, Side, areas, escape, picture};

/// Points of a curve and rows of a table at most: of longer runs some are left out, evenly, and the last one stays.
const POINTS: usize = 600;
const ROWS: usize = 120;

/// Stages that have a colour of their own; the others are put together.
const STAGES: usize = 6;

/// Columns that no curve is made of: counters, and what is shown elsewhere or is no number.
const NOT_SHOWN: [&str; 4] = ["frame", "time_s", "hash", "checksum"];

/// A figure: its title, what is up with its unit, and its lines.
struct Figure {
    title: String,
    up: String,
    lines: Vec<Line>,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Lines(Scale),
    Areas,
}

struct Line {
    name: String,
    points: Vec<(f64, f64)>,
}

/// All figures that the columns allow, as text.
pub(super) fn sections(table: &Table) -> Vec<String> {
    let Some(time) = table.column("time_s").filter(|time| !time.is_empty()) else {
        return vec!["<p>No frame is complete yet.</p>\n".into()];
    };
    let mut shown: Vec<&str> = NOT_SHOWN.to_vec();
    let mut figures = Vec::new();
    let line = |name: &str, values: &[f64], scale: f64| {
        let points = time.iter().zip(values).map(|(&t, &y)| (t, scale * y)).collect();
        Line { name: name.to_owned(), points }
    };
    let mut add = |title: &str, up: &str, kind: Kind, scale: f64, columns: &[(&'static str, &str)]| {
        let found = |&(column, name): &(&'static str, &str)| Some(line(name, table.column(column)?, scale));
        let lines: Vec<Line> = columns.iter().filter_map(found).collect();
        shown.extend(columns.iter().map(|(column, _)| *column));
        if !lines.is_empty() {
            figures.push(Figure { title: title.to_owned(), up: up.to_owned(), lines, kind });
        }
    };
    let linear = Kind::Lines(Scale::Linear);
    add("Kinetic energy", "J", linear, 1.0, &[("kinetic_energy_J", "kinetic")]);
    add("Potential energy", "J", linear, 1.0, &[("potential_energy_J", "potential")]);
    let momentum = [("momentum_x_kg_m_s", "x"), ("momentum_y_kg_m_s", "y"), ("momentum_z_kg_m_s", "z")];
    add("Momentum", "kg m/s", linear, 1.0, &momentum);
    let angular = [
        ("angular_momentum_x_kg_m2_s", "x"),
        ("angular_momentum_y_kg_m2_s", "y"),
        ("angular_momentum_z_kg_m2_s", "z"),
    ];
    add("Angular momentum", "kg m²/s", linear, 1.0, &angular);
    let deep = [
        ("mean_penetration_m", "mean"),
        ("p99_penetration_m", "99 of 100"),
        ("deepest_penetration_m", "deepest"),
    ];
    add("Penetration", "mm", Kind::Lines(Scale::Logarithmic), 1e3, &deep);
    add("Bodies", "", linear, 1.0, &[("bodies", "all"), ("awake", "awake")]);
    let touching =
        [("pairs", "pairs whose boxes overlap"), ("touching", "pairs that touch"), ("contacts", "contacts")];
    add("Contacts", "", linear, 1.0, &touching);
    add("Memory of the world", "MB", linear, 1e-6, &[("memory_bytes", "held")]);
    // Energy that is neither kinetic nor potential can't come from nowhere: their sum beside each other.
    if let (Some(kinetic), Some(potential)) =
        (table.column("kinetic_energy_J"), table.column("potential_energy_J"))
    {
        let sum: Vec<f64> = kinetic.iter().zip(potential).map(|(a, b)| a + b).collect();
        if let Some(figure) = figures.iter_mut().find(|figure| figure.title == "Potential energy") {
            figure.title = "Energy".into();
            figure.lines.push(line("with the kinetic", &sum, 1.0));
        }
    }
    figures.extend(stages(table, time));
    // Whatever else there is, each by itself.
    for name in table.names().filter(|name| !shown.contains(name) && !name.ends_with("_ms")) {
        let Some(values) =
            table.column(name).filter(|values| values.iter().any(|x| x.is_finite() && *x != 0.0))
        else {
            continue;
        };
        let title = name.replace('_', " ");
        figures.push(Figure { title, up: String::new(), lines: vec![line(name, values, 1.0)], kind: linear });
    }
    figures.iter().map(Figure::text).collect()
}

/// What stages take, on top of each other: the largest at the bottom.
fn stages(table: &Table, time: &[f64]) -> Option<Figure> {
    let mut stages: Vec<(&str, &[f64])> =
        table.names().filter_map(|name| Some((name.strip_suffix("_ms")?, table.column(name)?))).collect();
    let sum = |values: &[f64]| values.iter().filter(|x| x.is_finite()).sum::<f64>();
    stages.sort_by(|a, b| sum(b.1).total_cmp(&sum(a.1)));
    let rest = stages.split_off(stages.len().min(STAGES));
    let mut lines: Vec<Line> = stages
        .iter()
        .map(|(name, values)| Line {
            name: (*name).to_owned(),
            points: time.iter().copied().zip(values.iter().copied()).collect(),
        })
        .collect();
    if !rest.is_empty() {
        let total =
            |k: usize| rest.iter().map(|(_, values)| values[k]).filter(|x| x.is_finite()).sum::<f64>();
        let points = time.iter().enumerate().map(|(k, &t)| (t, total(k))).collect();
        lines.push(Line { name: format!("{} others", rest.len()), points });
    }
    let title = "Time of a step, by stage".to_owned();
    (!lines.is_empty()).then_some(Figure { title, up: "ms".to_owned(), lines, kind: Kind::Areas })
}

impl Figure {
    fn text(&self) -> String {
        let curve = |(colour, line): (usize, &Line)| Curve {
            name: line.name.clone(),
            points: some(&line.points, POINTS).copied().collect(),
            colour,
            dashed: false,
            dots: line.points.len() == 1,
        };
        let curves: Vec<Curve> = self.lines.iter().enumerate().map(curve).collect();
        let across = Side { name: "time, s", scale: Scale::Linear };
        let drawn = match self.kind {
            Kind::Lines(scale) => picture(across, Side { name: &self.up, scale }, &curves),
            Kind::Areas => areas(across, Side { name: &self.up, scale: Scale::Linear }, &curves),
        };
        let title = escape(&self.title);
        format!(
            "<figure aria-label=\"{title}\"><figcaption>{title}</figcaption>\n{drawn}<details><summary>{title} as a table</summary>\n{}</details></figure>\n",
            self.table()
        )
    }

    /// A row for each time of the longest line.
    fn table(&self) -> String {
        let unit = if self.up.is_empty() { String::new() } else { format!(", {}", self.up) };
        let names = self
            .lines
            .iter()
            .map(|line| format!("<th scope=\"col\">{}{}</th>", escape(&line.name), escape(&unit)));
        let mut text = format!(
            "<div class=\"rows\" tabindex=\"0\"><table>\n<tr><th scope=\"col\">time, s</th>{}</tr>\n",
            names.collect::<String>()
        );
        let longest = self.lines.iter().map(|line| line.points.as_slice()).max_by_key(|points| points.len());
        for (time, _) in some(longest.unwrap_or_default(), ROWS) {
            let cell = |line: &Line| {
                let found = line.points.binary_search_by(|point| point.0.total_cmp(time));
                let value = found.ok().map(|k| line.points[k].1).filter(|value| value.is_finite());
                format!("<td>{}</td>", value.map_or_else(String::new, number))
            };
            text +=
                &format!("<tr><td>{time:.3}</td>{}</tr>\n", self.lines.iter().map(cell).collect::<String>());
        }
        text + "</table></div>\n"
    }
}

/// At most so many of them, evenly, with the last one.
fn some<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let step = all.len().div_ceil(most).max(1);
    let end = all.len().wrapping_sub(1);
    all.iter().enumerate().filter(move |(k, _)| k.is_multiple_of(step) || *k == end).map(|(_, one)| one)
}

/// Five figures that count; whole numbers as they are.
fn number(x: f64) -> String {
    if x == 0.0 || (x.fract() == 0.0 && x.abs() < 1e7) {
        return format!("{x}");
    }
    if (1e-3..1e7).contains(&x.abs()) {
        let digits = (4 - x.abs().log10().floor() as i32).max(0) as usize;
        return format!("{x:.digits$}");
    }
    format!("{x:.4e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_runs_are_thinned_and_keep_their_ends() {
        let all: Vec<u32> = (0..1000).collect();
        let kept: Vec<u32> = some(&all, 120).copied().collect();
        assert!(kept.len() <= 121 && kept[0] == 0 && kept.last() == Some(&999), "{kept:?}");
        assert_eq!(some(&all[..7], 120).count(), 7);
        assert_eq!(some(&all[..0], 120).count(), 0);
    }

    #[test]
    fn numbers_have_five_figures() {
        for (x, expected) in [
            (0.0, "0"),
            (20001.0, "20001"),
            (0.0123456, "0.012346"),
            (481.21106, "481.21"),
            (1.2345678e10, "1.2346e10"),
        ] {
            assert_eq!(number(x), expected);
        }
    }
}
