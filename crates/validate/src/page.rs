//! The report as one HTML page that needs nothing else.

use crate::engine::EngineName;
use crate::finding::{Check, Figure, LineKind};
use crate::number::{number, with_unit};
use crate::report::{Outcome, Report};
use crate::table::{expected, summary, verdict};
use rockfall_plot::{Curve, FOOT, OF_TEXT, Scale, Side, escape, head, picture};

/// What the page has of its own.
const STYLE: &str = "h2 { margin-top: 3rem; border-bottom: 2px solid light-dark(#ddd, #444) }
h3 { margin-top: 2rem; margin-bottom: .3rem }
h3 small { font-weight: 400; color: light-dark(#666, #999) }
.why { text-align: left; white-space: normal; min-width: 16rem; color: light-dark(#555, #aaa) }
.pass { color: light-dark(#176b2c, #7ec98f) }
.FAIL { color: light-dark(#b00020, #ff8a80); font-weight: 600 }
";

/// The page: a summary, and for each case where it is from, its set-up, its checks by engine beside what others published, and its
/// pictures.
pub(crate) fn html(report: &Report) -> String {
    let form = if report.quick { "the quick form" } else { "the whole" };
    let mut text = head("Rockfall against known answers", STYLE);
    text +=
        &format!("<p>Version {}, {form}. Figures in red are not what they have to be.</p>\n", report.version);
    for line in summary(report).lines() {
        text += &format!("<p>{}</p>\n", escape(line));
    }
    let mut group = "";
    for outcomes in report.outcomes.chunk_by(|a, b| a.case == b.case) {
        let first = &outcomes[0];
        if first.group != group {
            group = first.group;
            text += &format!("<h2>{}</h2>\n", escape(group));
        }
        text += &case(first, outcomes);
    }
    text + FOOT
}

fn case(first: &Outcome, outcomes: &[Outcome]) -> String {
    let name = escape(first.case);
    let mut text = format!("<h3 id=\"{name}\">{} <small>{name}</small></h3>\n", escape(first.title));
    let source = escape(&first.source);
    let (initial, rest) = source.split_at(source.chars().next().map_or(0, char::len_utf8));
    text += &format!("<p>{}{rest}.</p>\n<p>{}</p>\n", initial.to_uppercase(), escape(first.setup));
    for outcome in outcomes {
        if let Some(error) = &outcome.error {
            let class = if outcome.left_out { "" } else { "FAIL" };
            text += &format!("<p class=\"{class}\">{}: {}</p>\n", outcome.engine.name(), escape(error));
        }
    }
    text += &checks(outcomes);
    for title in distinct(outcomes.iter().flat_map(|o| &o.figures).map(|figure| figure.title)) {
        let of = |o: &'_ Outcome| o.figures.iter().find(|f| f.title == title).cloned().map(|f| (o.engine, f));
        text += &figure(title, &outcomes.iter().filter_map(of).collect::<Vec<_>>());
    }
    text
}

/// A row for each check, a column for each engine.
fn checks(outcomes: &[Outcome]) -> String {
    let whats = distinct(outcomes.iter().flat_map(|o| &o.checks).map(|check| check.what.as_str()));
    if whats.is_empty() {
        return String::new();
    }
    let others = distinct(
        outcomes.iter().flat_map(|o| &o.checks).flat_map(|c| &c.published).map(|p| p.engine.as_str()),
    );
    let mut head = "<th class=\"text\">figure</th><th>expected</th>".to_owned();
    for outcome in outcomes {
        head += &format!("<th>{}</th>", outcome.engine.name());
    }
    for other in &others {
        head += &format!("<th>{}</th>", escape(other));
    }
    let mut rows = String::new();
    for what in whats {
        let find = |o: &'_ Outcome| o.checks.iter().find(|check| check.what == what).cloned();
        let found: Vec<Option<Check>> = outcomes.iter().map(find).collect();
        let Some(any) = found.iter().flatten().next() else { continue };
        let mut row = format!("<td class=\"text\">{}</td><td>{}</td>", escape(what), escape(&expected(any)));
        for check in &found {
            row += &check.as_ref().map_or("<td></td>".to_owned(), |check| {
                format!("<td class=\"{}\">{}</td>", verdict(check), escape(&with_unit(check.got, check.unit)))
            });
        }
        for other in &others {
            let value = any.published.iter().find(|p| p.engine == *other).map(|p| number(p.value));
            row += &format!("<td>{}</td>", value.unwrap_or_default());
        }
        row += &format!("<td class=\"why\">{}</td>", escape(any.reason));
        rows += &format!("<tr>{row}</tr>\n");
    }
    let mut times = "<td class=\"text\">wall-clock time</td><td></td>".to_owned();
    for outcome in outcomes {
        times += &format!("<td>{:.2} s</td>", outcome.seconds);
    }
    format!(
        "<div class=\"wide\"><table>\n<tr>{head}<th class=\"text\">why</th></tr>\n{rows}<tr>{times}</tr>\n</table></div>\n"
    )
}

/// The lines of all engines in one picture; what is expected and what was published stand there once.
fn figure(title: &str, figures: &[(EngineName, Figure)]) -> String {
    let Some((_, first)) = figures.first() else { return String::new() };
    let mut curves: Vec<Curve> = Vec::new();
    let mut colour = 0;
    for (engine, figure) in figures {
        for line in figure.lines.iter().filter(|line| line.kind == LineKind::Ours) {
            let engine = engine.name();
            let name =
                if line.name.is_empty() { engine.to_owned() } else { format!("{engine}, {}", line.name) };
            curves.push(Curve {
                name,
                points: line.points.clone(),
                colour,
                dashed: false,
                dots: dots(&line.points),
            });
            colour = next(colour);
        }
    }
    let theirs = |kind: LineKind| first.lines.iter().filter(move |line| line.kind == kind);
    for line in theirs(LineKind::Published) {
        let (name, points) = (line.name.clone(), line.points.clone());
        curves.push(Curve { name, dots: dots(&points), points, colour, dashed: true });
        colour = next(colour);
    }
    for line in theirs(LineKind::Expected) {
        let (name, points) = (line.name.clone(), line.points.clone());
        curves.push(Curve { name, points, colour: OF_TEXT, dashed: true, dots: false });
    }
    let scale = if first.logarithmic { Scale::Logarithmic } else { Scale::Linear };
    let side = |name| Side { name, scale };
    let picture = picture(side(first.across), side(first.up), &curves);
    format!("<figure><figcaption>{}</figcaption>\n{picture}</figure>\n", escape(title))
}

/// Dots of many points would hide the line.
fn dots(points: &[(f64, f64)]) -> bool {
    points.len() <= 40
}

/// The colour after this one; that of the text is for what is expected.
fn next(colour: usize) -> usize {
    if colour + 1 == OF_TEXT { colour + 2 } else { colour + 1 }
}

/// Each value once, in the order in which they come.
fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut once = Vec::new();
    for value in values {
        if !once.contains(&value) {
            once.push(value);
        }
    }
    once
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn engines_share_a_table_and_a_picture_and_nothing_is_fetched() {
        let text = html(&sample());
        assert_eq!((text.matches("<h3").count(), text.matches("<table").count()), (1, 1));
        // Two engines and the formula, which is there once.
        assert_eq!((text.matches("<figure>").count(), text.matches("<polyline").count()), (1, 3));
        assert!(
            text.contains("<td class=\"pass\">2.05 m/s</td><td class=\"FAIL\">3 m/s</td><td>2.5</td>"),
            "{text}"
        );
        assert!(text.contains("speed &lt;1 s&gt;") && text.contains("Closed form: Galilei."));
        for outside in ["http://", "https://", "<script", "<link", "src="] {
            assert!(!text.contains(outside), "{outside}");
        }
    }
}
