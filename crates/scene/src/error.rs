//! What can be wrong with a scene, said so that a person can mend it.

use crate::source::{Sources, Span};
use std::fmt;

/// Why a scene can't be read or built: every problem that was found, each with its place.
///
/// `Display` gives the first problem on one line; [`SceneError::render`] all of them with an excerpt of the file.
#[derive(Clone, Debug)]
pub struct SceneError {
    problems: Vec<Problem>,
    sources: Sources,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Where it is, if it is at a place in a file.
    pub place: Option<Box<Place>>,
    /// What is wrong.
    pub message: String,
    /// What was expected instead.
    pub expected: Option<String>,
    /// The nearest valid spelling.
    pub nearest: Option<String>,
    span: Option<Span>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// As the file was named.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
}

impl Problem {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Problem { place: None, message: message.into(), expected: None, nearest: None, span: None }
    }

    pub(crate) fn at(span: Span, message: impl Into<String>) -> Self {
        Problem { span: Some(span), ..Problem::new(message) }
    }

    pub(crate) fn expecting(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    /// Puts what it is about before the message.
    pub(crate) fn about(mut self, what: &str) -> Self {
        self.message = format!("{what}: {}", self.message);
        self
    }

    /// Adds the one of `names` that is nearest to `word`, if one is near enough to be meant.
    pub(crate) fn near<'a>(mut self, word: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        self.nearest = nearest(word, names).map(str::to_owned);
        self
    }

    fn locate(mut self, sources: &Sources) -> Self {
        if let Some(span) = self.span {
            let (line, column) = sources.line_column(span);
            let file = sources.get(span).name.clone();
            self.place = Some(Box::new(Place { file, line, column }));
        }
        self
    }
}

/// The name nearest to `word`, at most two slips or a third of its letters away.
fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let allowed = (word.chars().count() / 3).max(2);
    names
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(&lower, &name.to_lowercase()), name))
        .filter(|&(slips, name)| slips <= allowed && slips < name.chars().count())
        .min_by_key(|&(slips, _)| slips)
        .map(|(_, name)| name)
}

impl SceneError {
    /// Problems in the order of their places; there must be one.
    pub(crate) fn new(mut problems: Vec<Problem>, sources: &Sources) -> Self {
        problems.sort_by_key(|p| p.span.map(|s| (s.source, s.start)));
        SceneError {
            problems: problems.into_iter().map(|p| p.locate(sources)).collect(),
            sources: sources.clone(),
        }
    }

    pub(crate) fn one(problem: Problem, sources: &Sources) -> Self {
        SceneError::new(vec![problem], sources)
    }

    /// Everything that is wrong, in the order of the file.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// All problems, each with an excerpt of its file. Pass `color` where the text goes to a terminal.
    pub fn render(&self, color: bool) -> String {
        self.problems.iter().map(|p| p.render(&self.sources, color)).collect()
    }
}

impl Problem {
    fn render(&self, sources: &Sources, color: bool) -> String {
        use ariadne::{CharSet, Color, Config, IndexType, Label, Report, ReportKind, Source};
        let Some(span) = self.span else { return format!("Error: {self}\n") };
        let (name, text) = (&sources.get(span).name, &sources.get(span).text);
        // The report can't point past the end of the text.
        let end = text.len();
        let start = (span.start as usize).min(end);
        let range = start..(span.end as usize).clamp(start, end);
        let config = Config::default()
            .with_color(color)
            .with_index_type(IndexType::Byte)
            .with_char_set(if color { CharSet::Unicode } else { CharSet::Ascii });
        let label = self.expected.as_ref().map_or_else(|| "here".to_owned(), |e| format!("expected {e}"));
        let mut report = Report::build(ReportKind::Error, (name.as_str(), range.clone()))
            .with_config(config)
            .with_message(&self.message)
            .with_label(Label::new((name.as_str(), range)).with_message(label).with_color(Color::Red));
        if let Some(nearest) = &self.nearest {
            report = report.with_help(format!("did you mean `{nearest}`?"));
        }
        let mut out = Vec::new();
        match report.finish().write((name.as_str(), Source::from(text.as_str())), &mut out) {
            Ok(()) => String::from_utf8_lossy(&out).into_owned(),
            Err(_) => format!("Error: {self}\n"),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{}:{}:{}: ", place.file, place.line, place.column)?;
        }
        f.write_str(&self.message)?;
        if let Some(expected) = &self.expected {
            write!(f, ", expected {expected}")?;
        }
        if let Some(nearest) = &self.nearest {
            write!(f, "; did you mean `{nearest}`?")?;
        }
        Ok(())
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(first) = self.problems.first() {
            first.fmt(f)?;
        }
        match self.problems.len() {
            0 | 1 => Ok(()),
            2 => f.write_str(" (and 1 more problem)"),
            n => write!(f, " (and {} more problems)", n - 1),
        }
    }
}

impl std::error::Error for SceneError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_recognised_and_a_stranger_is_not() {
        let names = ["friction", "restitution", "density"];
        assert_eq!(nearest("frction", names), Some("friction"));
        assert_eq!(nearest("Densty", names), Some("density"));
        assert_eq!(nearest("colour", names), None);
        assert_eq!(nearest("x", ["y"]), None);
    }
}
