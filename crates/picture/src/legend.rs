//! What explains the colours of a picture, in its lower left corner; and what is said of its moment, in the upper one.

use crate::Picture;
use crate::draw::{Ink, advance, text_size, text_width};
use crate::font;
use crate::ramp::ramp;

/// The numbers at the ends of the colours.
pub type Span = [f32; 2];

/// What explains colours.
#[derive(Clone, Debug, PartialEq)]
pub enum Legend {
    /// Nothing has to be said.
    None,
    /// Colours of numbers.
    Scale {
        /// What the number is.
        title: &'static str,
        /// Its unit.
        unit: &'static str,
        /// The numbers at both ends.
        span: Span,
    },
    /// Colours of words.
    Names {
        /// What the words say.
        title: &'static str,
        /// Words and their colours, linear.
        entries: Vec<(String, [f32; 3])>,
    },
}

const PANEL: Ink = Ink::new([18.0, 20.0, 24.0], 0.62);
const TEXT: Ink = Ink::new([244.0, 244.0, 240.0], 1.0);
const DIM: Ink = Ink::new([190.0, 192.0, 194.0], 1.0);

/// Length of a scale, in letters.
const LENGTH: i64 = 28;

/// Words that are listed at most; what is left is counted.
const MOST_NAMES: usize = 12;

impl Legend {
    /// Draws it.
    pub fn draw(&self, picture: &mut Picture) {
        let size = text_size(picture.height);
        let (line, gap) = ((font::HEIGHT as i64 + 4) * size, 4 * size);
        let margin = 8 * size;
        match self {
            Legend::None => {}
            Legend::Scale { title, unit, span } => {
                let length = LENGTH * advance(size);
                let bar = font::HEIGHT as i64 * size;
                let height = line + bar + gap + line + gap;
                let (left, top) = (margin, i64::from(picture.height) - margin - height);
                picture.fill([left, top, length + 4 * gap, height], &PANEL);
                let (x, y) = (left + 2 * gap, top + gap);
                picture.text(x, y, size, &format!("{title}, {unit}"), &TEXT);
                let y = y + line;
                for column in 0..length {
                    let color = ramp((column as f32 + 0.5) / length as f32).to_array();
                    picture.fill([x + column, y, 1, bar], &Ink::of_linear(color));
                }
                for k in 0..=4 {
                    let share = k as f32 / 4.0;
                    let label = number(span[0] + share * (span[1] - span[0]));
                    let at = x + (share * length as f32) as i64;
                    let shift = (share * text_width(&label, size) as f32) as i64;
                    picture.text(at - shift, y + bar + gap, size, &label, &DIM);
                }
            }
            Legend::Names { title, entries } => {
                let mut names: Vec<(&str, Option<[f32; 3]>)> = entries
                    .iter()
                    .take(MOST_NAMES)
                    .map(|(name, color)| (name.as_str(), Some(*color)))
                    .collect();
                let rest = format!("and {} more", entries.len().saturating_sub(MOST_NAMES));
                if entries.len() > MOST_NAMES {
                    names.push((&rest, None));
                }
                let swatch = font::HEIGHT as i64 * size;
                let widths = names.iter().map(|(name, _)| swatch + gap + text_width(name, size));
                let width = widths.chain([text_width(title, size)]).max().unwrap_or(0) + 4 * gap;
                let height = (names.len() as i64 + 1) * line + gap;
                let (left, top) = (margin, i64::from(picture.height) - margin - height);
                picture.fill([left, top, width, height], &PANEL);
                let (x, mut y) = (left + 2 * gap, top + gap);
                picture.text(x, y, size, title, &TEXT);
                for (name, color) in names {
                    y += line;
                    if let Some(color) = color {
                        picture.fill([x, y, swatch, swatch], &Ink::of_linear(color));
                    }
                    picture.text(x + swatch + gap, y, size, name, &DIM);
                }
            }
        }
    }
}

/// Writes a line in the upper left corner.
pub fn caption(picture: &mut Picture, text: &str) {
    let size = text_size(picture.height);
    let (margin, gap) = (8 * size, 4 * size);
    picture.fill(
        [margin, margin, text_width(text, size) + 4 * gap, (font::HEIGHT as i64) * size + 2 * gap],
        &PANEL,
    );
    picture.text(margin + 2 * gap, margin + gap, size, text, &TEXT);
}

/// A number as it fits under a scale.
fn number(x: f32) -> String {
    let size = x.abs();
    let trim = |text: String| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    };
    match size {
        0.0 => "0".into(),
        1e6.. => trim(format!("{:.2}", f64::from(x) / 1e6)) + "M",
        1e4.. => trim(format!("{:.2}", f64::from(x) / 1e3)) + "k",
        0.01.. => trim(format!("{x:.4}")),
        _ => format!("{x:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_right() {
        let cases = [
            (0.0, "0"),
            (2.5, "2.5"),
            (1250.0, "1250"),
            (50_000.0, "50k"),
            (2.5e6, "2.5M"),
            (5e-4, "5.0e-4"),
        ];
        for (x, expected) in cases {
            assert_eq!(number(x), expected);
        }
    }

    #[test]
    fn a_scale_shows_the_colours_of_both_ends_within_the_picture() {
        let mut picture = Picture { width: 320, height: 180, pixels: vec![[90; 3]; 320 * 180] };
        Legend::Scale { title: "speed", unit: "m/s", span: [0.0, 10.0] }.draw(&mut picture);
        for end in [0.0, 1.0] {
            let expected = Ink::of_linear(ramp(end).to_array()).color.map(|x| x.round() as u8);
            let near = |p: &&[u8; 3]| p.iter().zip(expected).all(|(a, b)| a.abs_diff(b) < 6);
            assert!(picture.pixels.iter().filter(near).count() > 4, "{expected:?}");
        }
        // Nothing is cut off: there is a border of what was there before.
        assert!((0..320).all(|x| picture.pixels[179 * 320 + x] == [90; 3]));
    }
}
