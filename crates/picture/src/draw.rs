//! Lines, dots, areas and text on a picture.

use crate::{Picture, font};
use rockfall_math::Vec3;

/// A colour of the screen, red, green and blue from 0 to 255, and how much it covers, from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ink {
    pub(crate) color: [f32; 3],
    pub(crate) cover: f32,
}

impl Ink {
    pub(crate) const fn new(color: [f32; 3], cover: f32) -> Self {
        Ink { color, cover }
    }

    /// As a lit surface of a linear colour is seen.
    pub(crate) fn of_linear(color: [f32; 3]) -> Self {
        // Brighter than it gives back in the mean, as what faces the light.
        Ink { color: color.map(|x| crate::encode(crate::curve(1.6 * x))), cover: 1.0 }
    }
}

/// An end of what is seen of a line: its place, pixels, and its share of the whole line.
type End = ([f64; 2], f64);

impl Picture {
    /// Puts ink on a pixel, as much of it as `share`; outside of the picture nothing.
    pub(crate) fn dab(&mut self, x: i64, y: i64, ink: &Ink, share: f32) {
        let inside = (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        if !inside {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
        let under = Vec3::from_array(pixel.map(f32::from));
        let mixed = under.lerp(Vec3::from_array(ink.color), (ink.cover * share).clamp(0.0, 1.0));
        *pixel = mixed.to_array().map(|x| x.round().clamp(0.0, 255.0) as u8);
    }

    /// Fills a rectangle: left, top, width and height.
    pub(crate) fn fill(&mut self, [left, top, width, height]: [i64; 4], ink: &Ink) {
        // A rectangle that reaches out of the picture costs what is inside of it.
        let (right, bottom) = (left.saturating_add(width), top.saturating_add(height));
        for y in top.max(0)..bottom.min(self.height.into()) {
            for x in left.max(0)..right.min(self.width.into()) {
                self.dab(x, y, ink, 1.0);
            }
        }
    }

    /// Writes a line of text in letters `size` times as large as their points; (x, y) is its upper left corner.
    pub(crate) fn text(&mut self, x: i64, y: i64, size: i64, text: &str, ink: &Ink) {
        for (k, letter) in text.chars().enumerate() {
            let left = x + k as i64 * advance(size);
            for (row, bits) in (0..).zip(font::rows(letter)) {
                for column in (0..font::WIDTH).filter(|column| bits >> (font::WIDTH - 1 - column) & 1 == 1) {
                    self.fill([left + column as i64 * size, y + row * size, size, size], ink);
                }
            }
        }
    }

    /// A line from `a` to `b`, pixels, of some width, with round ends and smooth edges. `ink` says what a pixel gets at a share of the way.
    pub(crate) fn line(
        &mut self,
        a: [f64; 2],
        b: [f64; 2],
        width: f64,
        ink: impl Fn(&Self, i64, i64, f64) -> Ink,
    ) {
        let Some((a, b)) = self.clip(a, b, width) else { return };
        let (from, until) = a;
        let way = [b.0[0] - from[0], b.0[1] - from[1]];
        let squared = way[0] * way[0] + way[1] * way[1];
        let radius = 0.5 * width;
        let reach = radius + 1.0;
        let range = |p: f64, q: f64, size: u32| {
            let low = (p.min(q) - reach).floor().max(0.0) as i64;
            let high = (p.max(q) + reach).ceil().min(f64::from(size)) as i64;
            low..high
        };
        for y in range(from[1], b.0[1], self.height) {
            // Of the row only what is near: where the line passes it.
            let span = range(from[0], b.0[0], self.width);
            let slope = if way[1].abs() > 1e-9 { way[0] / way[1] } else { f64::INFINITY };
            let lean = reach * (1.0 + slope * slope).sqrt();
            let at = from[0] + (y as f64 + 0.5 - from[1]) * slope;
            let (low, high) = if lean.is_finite() && at.is_finite() {
                (span.start.max((at - lean).floor() as i64), span.end.min((at + lean).ceil() as i64 + 1))
            } else {
                (span.start, span.end)
            };
            for x in low..high {
                let p = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
                let along = if squared > 0.0 { (p[0] * way[0] + p[1] * way[1]) / squared } else { 0.0 };
                let along = along.clamp(0.0, 1.0);
                let off = [p[0] - along * way[0], p[1] - along * way[1]];
                let cover = radius + 0.5 - (off[0] * off[0] + off[1] * off[1]).sqrt();
                if cover > 0.0 {
                    let ink = ink(self, x, y, until + along * (b.1 - until));
                    self.dab(x, y, &ink, cover.min(1.0) as f32);
                }
            }
        }
    }

    /// What of a line may be seen: its ends and their shares of the whole (Liang and Barsky, "A New Concept and Method for Line Clipping", 1984).
    fn clip(&self, a: [f64; 2], b: [f64; 2], width: f64) -> Option<(End, End)> {
        let (mut from, mut until) = (0.0_f64, 1.0_f64);
        let margin = width + 2.0;
        for (axis, size) in [self.width, self.height].into_iter().enumerate() {
            let (low, high) = (-margin, f64::from(size) + margin);
            let way = b[axis] - a[axis];
            if !a[axis].is_finite() || !b[axis].is_finite() {
                return None;
            }
            if way == 0.0 {
                if !(low..=high).contains(&a[axis]) {
                    return None;
                }
                continue;
            }
            let (t, u) = ((low - a[axis]) / way, (high - a[axis]) / way);
            (from, until) = (from.max(t.min(u)), until.min(t.max(u)));
        }
        let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        (from <= until).then(|| ((at(from), from), (at(until), until)))
    }
}

/// Pixels from a letter to the next.
pub(crate) fn advance(size: i64) -> i64 {
    (font::WIDTH as i64 + 1) * size
}

/// Pixels that a line of text takes across.
pub(crate) fn text_width(text: &str, size: i64) -> i64 {
    text.chars().count() as i64 * advance(size) - size
}

/// The size of letters that suits a picture of so many rows.
pub(crate) fn text_size(height: u32) -> i64 {
    i64::from(height / 360).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn black(width: u32, height: u32) -> Picture {
        Picture { width, height, pixels: vec![[0; 3]; (width * height) as usize] }
    }

    const WHITE: Ink = Ink::new([255.0; 3], 1.0);

    /// White pixels, in units of whole ones.
    fn area(picture: &Picture) -> f64 {
        picture.pixels.iter().map(|p| f64::from(p[0]) / 255.0).sum()
    }

    #[test]
    fn a_line_covers_its_length_times_its_width_wherever_it_leads() {
        for b in [[80.0, 50.0], [50.0, 85.0], [75.0, 72.0], [20.0, 31.0], [23.0, 80.0]] {
            let mut picture = black(100, 100);
            picture.line([50.0, 50.0], b, 3.0, |_, _, _, _| WHITE);
            let length = f64::hypot(b[0] - 50.0, b[1] - 50.0);
            // Round ends are one disc together.
            let expected = 3.0 * length + 9.0 * 0.25 * std::f64::consts::PI;
            assert!(
                (area(&picture) / expected - 1.0).abs() < 0.04,
                "{b:?}: {} of {expected}",
                area(&picture)
            );
        }
    }

    #[test]
    fn what_reaches_out_of_the_picture_is_drawn_as_far_as_it_is_inside() {
        let mut whole = black(60, 40);
        whole.line([-1e7, 20.0], [1e7, 20.0], 2.0, |_, _, _, _| WHITE);
        assert!((area(&whole) - 120.0).abs() < 3.0, "{}", area(&whole));
        let mut none = black(60, 40);
        none.line([-50.0, -50.0], [-10.0, 90.0], 2.0, |_, _, _, _| WHITE);
        none.line([f64::NAN, 0.0], [10.0, 10.0], 2.0, |_, _, _, _| WHITE);
        none.fill([-5, -5, 5, 5], &WHITE);
        none.text(55, 38, 1, ".", &Ink::new([0.0; 3], 1.0));
        assert_eq!(area(&none), 0.0);
        none.fill([i64::MIN / 2, 39, i64::MAX, 5], &WHITE);
        assert_eq!(area(&none), 60.0);
    }

    #[test]
    fn text_has_the_points_of_its_letters() {
        let mut picture = black(40, 20);
        picture.text(3, 2, 2, "1-", &WHITE);
        let points: u32 = font::rows('1').iter().chain(&font::rows('-')).map(|row| row.count_ones()).sum();
        assert_eq!(area(&picture), f64::from(4 * points));
        assert_eq!(text_width("1-", 2), 22);
    }
}
