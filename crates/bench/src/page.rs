//! The result as one HTML page that needs nothing else.

use crate::bandwidth::Bandwidth;
use crate::compare::Line;
use crate::{process, roofline, table};
use rockfall_plot::{self as plot, Curve, Scale, Side, escape};

/// What the page has of its own: a wide table with long names.
const STYLE: &str = "th { white-space: normal }
";

/// The page: how the cost of a body changes with their number, a picture for each scene; how near the solver is to what memory
/// allows, a picture of all; and the tables.
pub(crate) fn html(roofs: &[Bandwidth], lines: &[Line], repeats: u32) -> String {
    let machine = escape(&process::machine());
    let mut text = plot::head("Rockfall beside its peers", STYLE);
    text += &format!("<p>{machine}, medians of {repeats} runs. Settled times unless said otherwise.</p>\n");
    for scene in distinct(lines, |line| line.scene) {
        let of_scene: Vec<&Line> = lines.iter().filter(|line| line.scene == scene).collect();
        let picture = log_log("bodies", "µs per body and step", &curves(&of_scene));
        text += &format!("<figure><figcaption>{}</figcaption>\n{picture}</figure>\n", escape(scene));
    }
    let under = under_the_roof(lines);
    if !under.is_empty() {
        let picture = log_log("ms for a streaming read of as many bytes", "ms per step", &under);
        text += &format!(
            "<figure><figcaption>Beside memory: a step (top), its stage solve (bottom), a streaming read (line)</figcaption>\n{picture}</figure>\n"
        );
    }
    text += &table_of(&table::COLUMNS, lines.iter().map(table::row));
    let read: Vec<_> = lines.iter().filter_map(roofline::row).collect();
    if !read.is_empty() {
        text +=
            &format!("<p>{}. Bytes are lower bounds: docs/performance.md.</p>\n", table::streaming(roofs));
        text += &table_of(&roofline::COLUMNS, read);
    }
    text + plot::FOOT
}

/// Curves on logarithmic axes.
fn log_log(across: &str, up: &str, curves: &[Curve]) -> String {
    let side = |name| Side { name, scale: Scale::Logarithmic };
    plot::picture(side(across), side(up), curves)
}

/// A table of columns, with their names and whether they are of numbers.
fn table_of<const N: usize>(
    columns: &[(&str, bool); N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let cells = |tag: &str, row: &[String]| {
        let cell = |(text, right): (&String, bool)| {
            let class = if right { "" } else { " class=\"text\"" };
            format!("<{tag}{class}>{}</{tag}>", escape(text))
        };
        let sides = columns.iter().map(|&(_, right)| right);
        format!("<tr>{}</tr>\n", row.iter().zip(sides).map(cell).collect::<String>())
    };
    let head = cells("th", &columns.map(|(name, _)| name.to_owned()));
    let body: String = rows.into_iter().map(|row| cells("td", &row)).collect();
    format!("<div class=\"wide\"><table>\n{head}{body}</table></div>\n")
}

/// For each line that tells what it reads, an upright from the time of its solver to that of its step, over the time that a
/// streaming read would take; and that time itself.
fn under_the_roof(lines: &[Line]) -> Vec<Curve> {
    let mut curves = Vec::new();
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let worlds = distinct(lines, |line| (line.scene, line.bodies));
    for line in lines {
        let Some(r) = &line.roofline else { continue };
        (least, most) = (least.min(r.limit_ms), most.max(r.limit_ms));
        let world = worlds.iter().position(|&of| of == (line.scene, line.bodies)).unwrap_or(0);
        // The colour of the text is for the limit.
        let colour = world % plot::OF_TEXT;
        let name = format!("{}, {}, {} thr.", line.scene, line.bodies, line.threads);
        let points = vec![(r.limit_ms, r.solve_ms), (r.limit_ms, line.ms_per_step)];
        curves.push(Curve { name, points, colour, dashed: line.threads > 1, dots: true });
    }
    if !curves.is_empty() {
        let points = vec![(least / 1.2, least / 1.2), (most * 1.2, most * 1.2)];
        let name = "limit".to_owned();
        curves.push(Curve { name, points, colour: plot::OF_TEXT, dashed: false, dots: false });
    }
    curves
}

/// A curve for each engine and number of threads; an engine keeps its colour.
fn curves(lines: &[&Line]) -> Vec<Curve> {
    let engines = distinct(lines, |line| line.engine);
    let threads = distinct(lines, |line| line.threads);
    let curve = |(colour, engine): (usize, &&'static str), number: usize, threads: usize| {
        let same = |line: &&&Line| line.engine == *engine && line.threads == threads;
        let cost = |line: &&Line| (line.bodies as f64, 1e3 * line.ms_per_step / line.bodies as f64);
        let name = format!("{engine}, {threads} thread{}", if threads == 1 { "" } else { "s" });
        let points = lines.iter().filter(same).map(cost).collect();
        Curve { name, points, colour, dashed: number > 0, dots: true }
    };
    let of_engine = |engine| threads.iter().enumerate().map(move |(number, &t)| (engine, number, t));
    let all = engines.iter().enumerate().flat_map(of_engine);
    all.map(|(engine, number, t)| curve(engine, number, t)).filter(|c| !c.points.is_empty()).collect()
}

/// Each value once, in the order in which they come.
fn distinct<L, T: PartialEq>(lines: &[L], value: impl Fn(&L) -> T) -> Vec<T> {
    let mut values = Vec::new();
    for value in lines.iter().map(value) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::tests::sample;

    #[test]
    fn every_scene_has_a_picture_with_every_engine_and_every_line_a_row() {
        let mut lines = vec![sample("rockfall"), sample("rapier"), sample("rockfall"), sample("rockfall")];
        lines[2].bodies = 210;
        lines[3].scene = "ball-pit";
        lines[1].roofline = None;
        let text = html(&[], &lines, 3);
        assert_eq!(text.matches("<figure>").count(), 3);
        // Two curves on the first scene, one of them with two points; one on the other; three uprights and the limit.
        assert_eq!((text.matches("<polyline").count(), text.matches("<circle").count()), (3 + 4, 4 + 6));
        assert_eq!(text.matches("<tr>").count(), 1 + lines.len() + 1 + 3);
        let cells = lines.len() * table::COLUMNS.len() + 3 * roofline::COLUMNS.len();
        assert_eq!(text.matches("<td").count(), cells);
        for outside in ["http://", "https://", "<script", "<link", "src="] {
            assert!(!text.contains(outside), "{outside}");
        }
    }

    #[test]
    fn a_step_stands_over_its_solver_and_both_over_the_limit() {
        let curves = under_the_roof(&[sample("rockfall")]);
        assert_eq!(curves[0].points, [(0.1, 0.4), (0.1, 12.34)]);
        assert!(curves[1].points.iter().all(|(x, y)| x == y) && !curves[1].dots);
        assert!(under_the_roof(&[Line { roofline: None, ..sample("rapier") }]).is_empty());
    }

    #[test]
    fn the_cost_of_a_body_is_in_microseconds() {
        let line = sample("rockfall");
        // 12.34 ms for 55 bodies.
        let curves = curves(&[&line]);
        let (bodies, cost) = curves[0].points[0];
        assert!(bodies == 55.0 && (cost - 224.36).abs() < 0.01, "{cost}");
        assert_eq!(curves[0].name, "rockfall, 2 threads");
    }
}
