//! From values to pixels.

/// How values lie on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal lengths.
    Linear,
    /// Equal ratios are equal lengths; only positive values have a place.
    Logarithmic,
}

impl Scale {
    /// Whether a value has a place.
    pub(crate) fn shows(self, value: f64) -> bool {
        value.is_finite() && (self == Scale::Linear || value > 0.0)
    }
}

/// One side of a picture.
pub(crate) struct Axis {
    scale: Scale,
    /// The ends, values.
    low: f64,
    high: f64,
    /// Where the ends are, pixels.
    from: f64,
    to: f64,
}

impl Axis {
    /// With all these values inside, with room around them; a logarithmic one is at least an octave long.
    pub(crate) fn around(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
        let (least, most) = if least <= most { (least, most) } else { (1.0, 1.0) };
        let (low, high) = match scale {
            Scale::Logarithmic => (least / 1.5, most * 1.5),
            Scale::Linear => {
                let span = most - least;
                let room = if span > 0.0 { 0.05 * span } else { 0.5 * least.abs().max(1.0) };
                (least - room, most + room)
            }
        };
        Axis { scale, low, high, from, to }
    }

    pub(crate) fn place(&self, value: f64) -> f64 {
        let share = match self.scale {
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
            Scale::Linear => (value - self.low) / (self.high - self.low),
        };
        self.from + share * (self.to - self.from)
    }

    /// Round values on the axis. Of a logarithmic one the 1, 2 and 5 of each power of ten, or the 1 alone where there would be too
    /// many; of a linear one four to nine in equal steps.
    pub(crate) fn ticks(&self) -> Vec<f64> {
        let all: Vec<f64> = match self.scale {
            Scale::Logarithmic => {
                let powers = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
                let steps: &[f64] = if self.high / self.low > 1e4 { &[1.0] } else { &[1.0, 2.0, 5.0] };
                powers.flat_map(|n| steps.iter().map(move |step| step * 10f64.powi(n))).collect()
            }
            Scale::Linear => {
                let rough = (self.high - self.low) / 5.0;
                let power = 10f64.powf(rough.log10().floor());
                let step = [1.0, 2.0, 5.0].map(|s| s * power).into_iter().find(|s| *s >= rough);
                let step = step.unwrap_or(10.0 * power);
                let numbers = (self.low / step).ceil() as i64..=(self.high / step).floor() as i64;
                numbers.map(|n| n as f64 * step).collect()
            }
        };
        // Rounded, so that they print as people write them.
        let clean = |v: f64| format!("{v:.6e}").parse().unwrap_or(v);
        let ticks: Vec<f64> =
            all.into_iter().map(clean).filter(|v| (self.low..=self.high).contains(v)).collect();
        // Over dozens of powers of ten even these are too many.
        let stride = ticks.len().div_ceil(12).max(1);
        ticks.into_iter().step_by(stride).collect()
    }
}

/// A tick as people write it: powers of ten where zeros would be long.
pub(crate) fn label(tick: f64) -> String {
    if tick != 0.0 && !(1e-3..1e5).contains(&tick.abs()) { format!("{tick:e}") } else { tick.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_ratios_are_equal_lengths() {
        let axis = Axis::around(Scale::Logarithmic, [10.0, 1000.0].into_iter(), 0.0, 100.0);
        let [a, b, c] = [10.0, 100.0, 1000.0].map(|v| axis.place(v));
        assert!(((b - a) - (c - b)).abs() < 1e-9 && 0.0 < a && c < 100.0);
    }

    #[test]
    fn equal_differences_are_equal_lengths() {
        let axis = Axis::around(Scale::Linear, [-10.0, 30.0].into_iter(), 100.0, 0.0);
        let [a, b, c] = [-10.0, 10.0, 30.0].map(|v| axis.place(v));
        assert!(((b - a) - (c - b)).abs() < 1e-9 && 0.0 < c && a < 100.0);
    }

    #[test]
    fn ticks_are_round_and_on_the_axis() {
        let ticks =
            |values: &[f64]| Axis::around(Scale::Logarithmic, values.iter().copied(), 0.0, 1.0).ticks();
        assert_eq!(ticks(&[0.03, 0.3]), [0.02, 0.05, 0.1, 0.2]);
        assert_eq!(ticks(&[300.0]), [200.0]);
        assert_eq!(ticks(&[2.0, 1e6]), [10.0, 100.0, 1e3, 1e4, 1e5, 1e6]);
        assert_eq!(ticks(&[]), [1.0]);
        assert!(ticks(&[1e-30, 1e9]).len() <= 12);
        let ticks = |values: &[f64]| Axis::around(Scale::Linear, values.iter().copied(), 0.0, 1.0).ticks();
        assert_eq!(ticks(&[0.0, 1.0]), [0.0, 0.5, 1.0]);
        assert_eq!(ticks(&[-0.1, 0.3]), [-0.1, 0.0, 0.1, 0.2, 0.3]);
        assert!(!ticks(&[7.0]).is_empty() && !ticks(&[0.0]).is_empty());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([0.0, 0.02, 2000.0, 1e-7, 2e8].map(label), ["0", "0.02", "2000", "1e-7", "2e8"]);
    }
}
