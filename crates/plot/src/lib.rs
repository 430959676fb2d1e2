//! Curves as SVG text, and the head of pages that need nothing else: the bench's, those of the validation, and reports of runs.

#![forbid(unsafe_code)]

mod axis;
mod page;

pub use axis::Scale;
pub use page::{FOOT, head};

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
    let frame = Frame::around(across, up, points(), curves);
    let mut svg = frame.begin(across, up);
    for (number, curve) in curves.iter().enumerate() {
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let dashes = if curve.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
        let mut points: Vec<(f64, f64)> =
            curve.points.iter().filter(|p| shown(p)).map(|p| frame.place(*p)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Writing to a string can't fail.
        let _ = writeln!(svg, "<g stroke=\"{colour}\" fill=\"{colour}\">");
        let _ = writeln!(svg, "<polyline fill=\"none\" points=\"{}\"{dashes}/>", joined(&points));
        for (x, y) in points.iter().filter(|_| curve.dots) {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        }
        let y = TOP + 10.0 + 20.0 * number as f64;
        let _ = writeln!(svg, "<path d=\"M{} {y}h24\"{dashes}/>\n</g>", frame.right + 12.0);
        frame.name(&mut svg, y, &curve.name);
    }
    svg + "</svg>\n"
}

/// Curves as areas on top of each other, the first at the bottom: what each adds to a sum. All have the same places across, in ascending order, and values that
/// are not negative; what is no number adds nothing.
pub fn areas(across: Side<'_>, up: Side<'_>, curves: &[Curve]) -> String {
    let mut sums: Vec<(f64, f64)> =
        curves.first().map_or_else(Vec::new, |curve| curve.points.iter().map(|p| (p.0, 0.0)).collect());
    let mut tops = vec![sums.clone()];
    for curve in curves {
        for (sum, (_, y)) in sums.iter_mut().zip(&curve.points) {
            sum.1 += if y.is_finite() { y.max(0.0) } else { 0.0 };
        }
        tops.push(sums.clone());
    }
    let ends = tops[0].iter().chain(&sums).copied();
    let frame = Frame::around(across, up, ends, curves);
    let mut svg = frame.begin(across, up);
    // The topmost is the first in the legend, as in the picture.
    for (number, (curve, pair)) in curves.iter().zip(tops.windows(2)).rev().enumerate() {
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let border = pair[1].iter().chain(pair[0].iter().rev()).map(|p| frame.place(*p)).collect::<Vec<_>>();
        let y = TOP + 10.0 + 20.0 * number as f64;
        let (left, top) = (frame.right + 12.0, y - 6.0);
        let _ = writeln!(
            svg,
            "<g fill=\"{colour}\"><polygon points=\"{}\"/><rect x=\"{left}\" y=\"{top}\" width=\"24\" height=\"12\"/></g>",
            joined(&border)
        );
        frame.name(&mut svg, y, &curve.name);
    }
    svg + "</svg>\n"
}

fn joined(points: &[(f64, f64)]) -> String {
    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// The axes of a picture, and how large it is with its legend.
struct Frame {
    horizontal: Axis,
    vertical: Axis,
    right: f64,
    size: [f64; 2],
}

impl Frame {
    fn around(
        across: Side<'_>,
        up: Side<'_>,
        points: impl Iterator<Item = (f64, f64)> + Clone,
        curves: &[Curve],
    ) -> Frame {
        let longest = curves.iter().map(|curve| curve.name.chars().count()).max().unwrap_or(0);
        let right = WIDTH - RIGHT;
        Frame {
            horizontal: Axis::around(across.scale, points.clone().map(|p| p.0), LEFT, right),
            vertical: Axis::around(up.scale, points.map(|p| p.1), HEIGHT - BOTTOM, TOP),
            right,
            size: [
                right + RIGHT.max(SAMPLE + LETTER * longest as f64),
                HEIGHT.max(TOP + 20.0 * (curves.len() + 1) as f64),
            ],
        }
    }

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.horizontal.place(x), self.vertical.place(y))
    }

    /// Grid, numbers and names of the axes.
    fn begin(&self, across: Side<'_>, up: Side<'_>) -> String {
        let (right, bottom) = (self.right, HEIGHT - BOTTOM);
        let [width, height] = self.size;
        let mut svg = format!("<svg viewBox=\"0 0 {width:.0} {height}\" role=\"img\">\n");
        for tick in self.horizontal.ticks() {
            let (x, y) = (self.horizontal.place(tick), bottom + 18.0);
            let _ = writeln!(svg, "<path class=\"grid\" d=\"M{x:.1} {TOP}V{bottom}\"/>");
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"middle\">{}</text>", label(tick));
        }
        for tick in self.vertical.ticks() {
            let (x, y) = (LEFT - 8.0, self.vertical.place(tick));
            let _ = writeln!(svg, "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
            let _ =
                writeln!(svg, "<text x=\"{x:.1}\" y=\"{:.1}\" class=\"end\">{}</text>", y + 4.0, label(tick));
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
        svg
    }

    /// A name in the legend.
    fn name(&self, svg: &mut String, y: f64, name: &str) {
        let _ =
            writeln!(svg, "<text x=\"{}\" y=\"{}\">{}</text>", self.right + SAMPLE, y + 4.0, escape(name));
    }
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
    fn areas_stand_on_each_other() {
        let side = |name| Side { name, scale: Scale::Linear };
        let first = curve(&[(0.0, 1.0), (1.0, 1.0)]);
        let svg = areas(side("x"), side("y"), &[first, curve(&[(0.0, 2.0), (1.0, f64::NAN)])]);
        let borders: Vec<Vec<f64>> = svg
            .split("polygon points=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().expect("an end"))
            .map(|text| text.split([' ', ',']).map(|n| n.parse().expect("a number")).collect())
            .collect();
        // The last one first: its lower side, from right to left, is the upper side of the other.
        assert_eq!(borders[0][4..8], [borders[1][2], borders[1][3], borders[1][0], borders[1][1]]);
        // Heights of 1 and 3 at the left, of 1 and 1 at the right.
        let height = |y: f64| borders[1][5] - y;
        assert!((height(borders[0][1]) - 3.0 * height(borders[1][1])).abs() < 0.3);
        assert_eq!(borders[0][3], borders[1][3]);
        assert!(!svg.contains("NaN"));
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
