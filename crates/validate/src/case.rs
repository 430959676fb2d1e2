//! What a case is.

use crate::Error;
use crate::engine::EngineName;
use crate::finding::Findings;
use crate::stage::Rig;

/// Where an answer is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Tables that were published with the set-up.
    Published(&'static str),
    /// The test suite of another engine.
    Suite(&'static str),
    /// A formula.
    ClosedForm(&'static str),
    /// Something measured.
    Experiment(&'static str),
}

impl Source {
    /// As a sentence has it.
    pub fn text(&self) -> String {
        match self {
            Source::Published(text) => format!("published: {text}"),
            Source::Suite(text) => format!("test suite: {text}"),
            Source::ClosedForm(text) => format!("closed form: {text}"),
            Source::Experiment(text) => format!("experiment: {text}"),
        }
    }
}

/// A set-up with a known answer.
#[derive(Clone, Copy)]
pub struct Case {
    /// On the command line; unique.
    pub name: &'static str,
    /// The group that it belongs to, such as `simbenchmark`; also on the command line.
    pub group: &'static str,
    /// A sentence for people.
    pub title: &'static str,
    /// Where the answer is from.
    pub source: Source,
    /// Sizes, materials, steps.
    pub setup: &'static str,
    /// The engines that the case says something about.
    pub engines: &'static [EngineName],
    /// Whether it is left out where little time is allowed.
    pub long: bool,
    /// Drives one engine through it.
    pub(crate) run: fn(&Rig) -> Result<Findings, Error>,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "case {}", self.name)
    }
}
