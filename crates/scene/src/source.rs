//! The texts that a scene was read from, and places in them.

use std::path::PathBuf;

/// A stretch of a text: the index of the text in [`Sources`], and byte offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Span {
    pub(crate) source: u32,
    pub(crate) start: u32,
    pub(crate) end: u32,
}

/// One text.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// As people call it: the path as given.
    pub(crate) name: String,
    pub(crate) text: String,
    /// Paths in the text start here.
    pub(crate) base: PathBuf,
}

/// All texts of a scene: the scene's own and what it includes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sources {
    pub(crate) list: Vec<Source>,
}

impl Sources {
    /// Adds a text and gives its index.
    pub(crate) fn add(&mut self, source: Source) -> u32 {
        self.list.push(source);
        (self.list.len() - 1) as u32
    }

    pub(crate) fn get(&self, span: Span) -> &Source {
        &self.list[span.source as usize]
    }

    /// Line and column of the start of a span, both from 1; a column is a character.
    pub(crate) fn line_column(&self, span: Span) -> (usize, usize) {
        let before = self.get(span).text.get(..span.start as usize).unwrap_or("");
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_and_in_characters() {
        let mut sources = Sources::default();
        let source = sources.add(Source { name: "x".into(), text: "a\nåb\nc".into(), base: "".into() });
        let at = |start| sources.line_column(Span { source, start, end: start });
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(4), (2, 2));
        assert_eq!(at(6), (3, 1));
    }
}
