//! What came out of a case, beside what is expected.

use serde::Serialize;

/// How far off a figure may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gate {
    /// As much as expected, up to a tolerance that includes the uncertainty of what is expected.
    Near {
        /// What is expected.
        expected: f64,
        /// How far off it may be.
        tolerance: f64,
    },
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
    /// Anything: the figure is there to be seen.
    Shown,
}

impl Gate {
    /// Whether a figure passes. What is no number does not, whatever the gate.
    pub fn passes(&self, got: f64) -> bool {
        got.is_finite()
            && match *self {
                Gate::Near { expected, tolerance } => (got - expected).abs() <= tolerance,
                Gate::AtMost(limit) => got <= limit,
                Gate::AtLeast(limit) => got >= limit,
                Gate::Shown => true,
            }
    }
}

/// A figure of another engine for the same check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Published {
    /// Which.
    pub engine: String,
    /// In the unit of the check.
    pub value: f64,
}

/// One figure, and whether it is what it has to be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Of what.
    pub what: String,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// What came out.
    pub got: f64,
    /// What may come out.
    pub gate: Gate,
    /// Why so much and no more.
    pub reason: &'static str,
    /// What others got.
    pub published: Vec<Published>,
}

impl Check {
    /// Whether the figure is what it has to be.
    pub fn passes(&self) -> bool {
        self.gate.passes(self.got)
    }

    /// How far the figure is from what is expected or, where it is outside, from its limit; `None` where there is neither.
    pub fn error(&self) -> Option<f64> {
        match self.gate {
            Gate::Near { expected, .. } => Some(self.got - expected),
            Gate::AtMost(limit) => Some((self.got - limit).max(0.0)),
            Gate::AtLeast(limit) => Some((self.got - limit).min(0.0)),
            Gate::Shown => None,
        }
    }
}

/// What a line in a picture stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LineKind {
    /// The engine that the outcome is of.
    Ours,
    /// What is expected.
    Expected,
    /// Another engine, as published.
    Published,
}

/// A curve by its points.
pub(crate) type Points = Vec<(f64, f64)>;

/// Points of one curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// In the legend; of our own lines what tells them apart, if there are several.
    pub name: String,
    /// What it stands for.
    pub kind: LineKind,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// A picture of a case. Those of several engines with the same title are drawn into one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Above the picture.
    pub title: &'static str,
    /// What is along the horizontal axis, with its unit.
    pub across: &'static str,
    /// What is along the vertical axis, with its unit.
    pub up: &'static str,
    /// Whether both axes are logarithmic.
    pub logarithmic: bool,
    /// Curves.
    pub lines: Vec<Line>,
}

impl Figure {
    /// With linear axes.
    pub(crate) fn linear(title: &'static str, across: &'static str, up: &'static str) -> Figure {
        Figure { title, across, up, logarithmic: false, lines: Vec::new() }
    }

    /// With logarithmic axes.
    pub(crate) fn logarithmic(title: &'static str, across: &'static str, up: &'static str) -> Figure {
        Figure { logarithmic: true, ..Figure::linear(title, across, up) }
    }

    fn line(mut self, name: &str, kind: LineKind, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.lines.push(Line { name: name.to_owned(), kind, points: points.into_iter().collect() });
        self
    }

    /// A curve of the engine that runs.
    pub(crate) fn ours(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.line(name, LineKind::Ours, points)
    }

    /// What the curve ought to be.
    pub(crate) fn expected(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.line(name, LineKind::Expected, points)
    }

    /// What another engine got.
    pub(crate) fn published(self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.line(name, LineKind::Published, points)
    }
}

/// All that a case has to say of one engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Findings {
    pub(crate) checks: Vec<Check>,
    pub(crate) figures: Vec<Figure>,
}

impl Findings {
    fn check(
        &mut self,
        what: impl Into<String>,
        unit: &'static str,
        got: f64,
        gate: Gate,
        reason: &'static str,
    ) {
        self.checks.push(Check { what: what.into(), unit, got, gate, reason, published: Vec::new() });
    }

    /// `got` has to be `expected`, up to `tolerance`, for a reason.
    pub(crate) fn near(
        &mut self,
        what: impl Into<String>,
        unit: &'static str,
        got: f64,
        (expected, tolerance): (f64, f64),
        reason: &'static str,
    ) -> &mut Self {
        self.check(what, unit, got, Gate::Near { expected, tolerance }, reason);
        self
    }

    /// `got` must not be more than `limit`.
    pub(crate) fn at_most(
        &mut self,
        what: impl Into<String>,
        unit: &'static str,
        got: f64,
        limit: f64,
        reason: &'static str,
    ) -> &mut Self {
        self.check(what, unit, got, Gate::AtMost(limit), reason);
        self
    }

    /// `got` must not be less than `limit`.
    pub(crate) fn at_least(
        &mut self,
        what: impl Into<String>,
        unit: &'static str,
        got: f64,
        limit: f64,
        reason: &'static str,
    ) -> &mut Self {
        self.check(what, unit, got, Gate::AtLeast(limit), reason);
        self
    }

    /// `got` is there to be seen.
    pub(crate) fn shown(&mut self, what: impl Into<String>, unit: &'static str, got: f64) -> &mut Self {
        self.check(what, unit, got, Gate::Shown, "");
        self
    }

    /// What others got in the last check.
    pub(crate) fn beside(&mut self, published: &[(&str, f64)]) -> &mut Self {
        if let Some(check) = self.checks.last_mut() {
            let others =
                published.iter().map(|&(engine, value)| Published { engine: engine.to_owned(), value });
            check.published.extend(others);
        }
        self
    }

    /// A picture.
    pub(crate) fn draw(&mut self, figure: Figure) -> &mut Self {
        self.figures.push(figure);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gates_hold_at_their_limits_and_refuse_what_is_no_number() {
        let near = Gate::Near { expected: 2.0, tolerance: 0.5 };
        assert!(near.passes(2.5) && near.passes(1.5) && !near.passes(2.51));
        assert!(Gate::AtMost(1.0).passes(1.0) && !Gate::AtMost(1.0).passes(1.1));
        assert!(Gate::AtLeast(1.0).passes(1.0) && !Gate::AtLeast(1.0).passes(0.9));
        for gate in [near, Gate::AtMost(1.0), Gate::AtLeast(1.0), Gate::Shown] {
            assert!(!gate.passes(f64::NAN) && !gate.passes(f64::INFINITY));
        }
    }
}
