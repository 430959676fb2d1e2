//! The result as one HTML page that needs nothing else.

use crate::compare::Line;
use crate::plot::{self, Curve, escape};
use crate::{process, table};

const HEAD: &str = "<!doctype html>
<html lang=\"en\">
<meta charset=\"utf-8\">
<meta name=\"viewport\" content=\"width=device-width\">
<title>Rockfall beside its peers</title>
<style>
body { font: 15px/1.4 system-ui, sans-serif; color: #222; max-width: 100rem; margin: 2rem auto; padding: 0 1rem }
figure { display: inline-block; width: min(100%, 44rem); margin: 0 1rem 1rem 0 }
figcaption { font-weight: 600 }
svg { width: 100%; font: 12px system-ui, sans-serif }
svg .grid { stroke: #ddd }
svg polyline, svg g path { stroke-width: 2 }
svg .middle { text-anchor: middle }
svg .end { text-anchor: end }
div { overflow-x: auto }
table { border-collapse: collapse }
th, td { padding: .2rem .6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap }
th { white-space: normal; vertical-align: bottom }
.text { text-align: left }
</style>
<h1>Rockfall beside its peers</h1>
";

/// The page: how the cost of a body changes with their number, a picture for each scene, and the table.
pub(crate) fn html(lines: &[Line], repeats: u32) -> String {
    let machine = escape(&process::machine());
    let mut text =
        format!("{HEAD}<p>{machine}, medians of {repeats} runs. Settled times unless said otherwise.</p>\n");
    for scene in distinct(lines, |line| line.scene) {
        let of_scene: Vec<&Line> = lines.iter().filter(|line| line.scene == scene).collect();
        let picture = plot::log_log("bodies", "µs per body and step", &curves(&of_scene));
        text += &format!("<figure><figcaption>{}</figcaption>\n{picture}</figure>\n", escape(scene));
    }
    let cells = |tag: &str, row: &[String]| {
        let cell = |(text, right): (&String, bool)| {
            let class = if right { "" } else { " class=\"text\"" };
            format!("<{tag}{class}>{}</{tag}>", escape(text))
        };
        let sides = table::COLUMNS.iter().map(|&(_, right)| right);
        format!("<tr>{}</tr>\n", row.iter().zip(sides).map(cell).collect::<String>())
    };
    text += "<div><table>\n";
    text += &cells("th", &table::COLUMNS.map(|(name, _)| name.to_owned()));
    text.extend(lines.iter().map(|line| cells("td", &table::row(line))));
    text + "</table></div>\n</html>\n"
}

/// A curve for each engine and number of threads; an engine keeps its colour.
fn curves(lines: &[&Line]) -> Vec<Curve> {
    let engines = distinct(lines, |line| line.engine);
    let threads = distinct(lines, |line| line.threads);
    let curve = |(colour, engine): (usize, &&'static str), number: usize, threads: usize| {
        let same = |line: &&&Line| line.engine == *engine && line.threads == threads;
        let cost = |line: &&Line| (line.bodies as f64, 1e3 * line.ms_per_step / line.bodies as f64);
        let name = format!("{engine}, {threads} thread{}", if threads == 1 { "" } else { "s" });
        Curve { name, points: lines.iter().filter(same).map(cost).collect(), colour, dashed: number > 0 }
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
        let text = html(&lines, 3);
        assert_eq!(text.matches("<figure>").count(), 2);
        // Two curves on the first scene, one of them with two points; one on the other.
        assert_eq!((text.matches("<polyline").count(), text.matches("<circle").count()), (3, 4));
        assert_eq!(text.matches("<tr>").count(), 1 + lines.len());
        assert_eq!(text.matches("<td").count(), lines.len() * table::COLUMNS.len());
        for outside in ["http://", "https://", "<script", "<link", "src="] {
            assert!(!text.contains(outside), "{outside}");
        }
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
