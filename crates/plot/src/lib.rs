//! Curves as SVG text, for pages that need nothing else: the bench's and those of the validation.

#![forbid(unsafe_code)]

mod axis;

pub use axis::Scale;

use axis::{Axis, label};
use std::fmt::Write;

/// A named curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// Points; those that have no place on the axes are left out.
    pub points: Vec<(f64, f64)>,
    /// Into a palette of eight colours, over and over.
    pub colour: usize,
    /// Whether the line is dashed.
    pub dashed: bool,
    /// Whether each point has a dot.
    pub dots: bool,
}

/// One side of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side<'a> {
    /// What is along it, with its unit.
    pub name: &'a str,
    /// How values lie on it.
    pub scale: Scale,
}

/// Colours that most people can tell apart (Okabe and Ito 2008); their black is that of the text, which is light on dark pages.
const COLOURS: [&str; 8] =
    ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", TEXT, "#999933"];

const TEXT: &str = "currentColor";

/// The number of the colour that the text has.
pub const OF_TEXT: usize = 6;

/// Sizes in pixels: of the picture where its legend is not longer, and of what is around the frame with the curves.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 48.0;

/// What is to the left of a name in the legend, and the width of a letter, generously, pixels.
const SAMPLE: f64 = 42.0;
const LETTER: f64 = 6.6;

/// One picture with its legend.
pub fn picture(across: Side<'_>, up: Side<'_>, curves: &[Curve]) -> String {
    let shown = |&(x, y): &(f64, f64)| across.scale.shows(x) && up.scale.shows(y);
    let points = || curves.iter().flat_map(|curve| &curve.points).copied().filter(shown);
    let horizontal = Axis::around(across.scale, points().map(|p| p.0), LEFT, WIDTH - RIGHT);
    let vertical = Axis::around(up.scale, points().map(|p| p.1), HEIGHT - BOTTOM, TOP);
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);

    // Writing to a string can't fail.
    let height = HEIGHT.max(TOP + 20.0 * (curves.len() + 1) as f64);
    let longest = curves.iter().map(|curve| curve.name.chars().count()).max().unwrap_or(0);
    let width = right + RIGHT.max(SAMPLE + LETTER * longest as f64);
    let mut svg = format!("<svg viewBox=\"0 0 {width:.0} {height}\" role=\"img\">\n");
    for tick in horizontal.ticks() {
        let x = horizontal.place(tick);
        let _ = writeln!(svg, "<path class=\"grid\" d=\"M{x:.1} {TOP}V{bottom}\"/>");
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" class=\"middle\">{}</text>",
            bottom + 18.0,
            label(tick)
        );
    }
    for tick in vertical.ticks() {
        let y = vertical.place(tick);
        let _ = writeln!(svg, "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" class=\"end\">{}</text>",
            LEFT - 8.0,
            y + 4.0,
            label(tick)
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" class=\"middle\">{}</text>\n\
         <text transform=\"translate(16 {:.1}) rotate(-90)\" class=\"middle\">{}</text>",
        0.5 * (LEFT + right),
        HEIGHT - 8.0,
        escape(across.name),
        0.5 * (TOP + bottom),
        escape(up.name)
    );
    for (number, curve) in curves.iter().enumerate() {
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let dashes = if curve.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
        let place = |(x, y): &(f64, f64)| (horizontal.place(*x), vertical.place(*y));
        let mut points: Vec<(f64, f64)> = curve.points.iter().filter(|p| shown(p)).map(place).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let line: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(svg, "<g stroke=\"{colour}\" fill=\"{colour}\">");
        let _ = writeln!(svg, "<polyline fill=\"none\" points=\"{}\"{dashes}/>", line.join(" "));
        for (x, y) in points.iter().filter(|_| curve.dots) {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        }
        let y = TOP + 10.0 + 20.0 * number as f64;
        let _ = writeln!(svg, "<path d=\"M{} {y}h24\"{dashes}/>\n</g>", right + 12.0);
        let name = escape(&curve.name);
        let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">{name}</text>", right + SAMPLE, y + 4.0);
    }
    svg + "</svg>\n"
}

/// Text that may stand in HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Curve {
        Curve { name: "a<b".to_owned(), points: points.to_vec(), colour: 0, dashed: false, dots: true }
    }

    const LOGARITHMIC: Side<'_> = Side { name: "n", scale: Scale::Logarithmic };

    #[test]
    fn a_large_legend_makes_the_picture_larger() {
        let size = |curves: usize, letters: usize| {
            let one = |_| Curve { name: "a".repeat(letters), ..curve(&[(1.0, 1.0)]) };
            let svg = picture(LOGARITHMIC, LOGARITHMIC, &(0..curves).map(one).collect::<Vec<_>>());
            let mut numbers = svg.split('"').nth(1).expect("a box").split(' ').skip(2);
            [(); 2].map(|()| numbers.next().expect("a size").parse::<f64>().expect("a number"))
        };
        assert_eq!(size(3, 5), [WIDTH, HEIGHT]);
        assert!(size(40, 5)[1] >= 40.0 * 20.0 + TOP);
        assert!(size(3, 60)[0] >= WIDTH - RIGHT + 60.0 * LETTER);
    }

    #[test]
    fn the_colour_of_text_is_its_own() {
        assert_eq!(COLOURS.iter().position(|&c| c == TEXT), Some(OF_TEXT));
    }

    #[test]
    fn a_curve_goes_from_left_to_right_and_leaves_out_what_has_no_place() {
        let svg = picture(
            LOGARITHMIC,
            LOGARITHMIC,
            &[curve(&[(100.0, 2.0), (10.0, 1.0), (50.0, f64::NAN), (0.0, 1.0)])],
        );
        assert_eq!(svg.matches("<circle").count(), 2);
        let line = svg.split("points=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a line");
        let xs: Vec<f64> =
            line.split(' ').map(|p| p.split(',').next().expect("x").parse().expect("a number")).collect();
        assert!(xs.len() == 2 && xs[0] < xs[1], "{line}");
        assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
    }
}
