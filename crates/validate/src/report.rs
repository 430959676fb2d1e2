//! Runs cases, and holds what came out.

use crate::case::Case;
use crate::engine::EngineName;
use crate::finding::{Check, Figure, Findings};
use crate::stage::Rig;
use crate::{Error, cases, page, table};
use serde::Serialize;
use std::time::Instant;

/// What is to be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Names of cases or groups; all where it is empty.
    pub only: Vec<String>,
    /// Fewer steps and bodies, and no long cases.
    pub quick: bool,
    /// Engines; of a case those that it is for.
    pub engines: Vec<EngineName>,
}

impl Default for Choice {
    fn default() -> Self {
        Choice { only: Vec::new(), quick: false, engines: EngineName::built() }
    }
}

impl Choice {
    /// The cases that are to be run.
    ///
    /// # Errors
    /// [`Error::NoCase`] for a name that nothing has.
    pub fn cases(&self) -> Result<Vec<Case>, Error> {
        let all = cases();
        let has = |case: &Case, name: &String| case.name == name || case.group == name;
        for name in &self.only {
            if !all.iter().any(|case| has(case, name)) {
                let mut known: Vec<&str> = Vec::new();
                for name in all.iter().flat_map(|case| [case.group, case.name]) {
                    if !known.contains(&name) {
                        known.push(name);
                    }
                }
                return Err(Error::NoCase { name: name.clone(), known: known.join(", ") });
            }
        }
        // Who asks for a case by its name gets it, however long it is.
        let chosen = |case: &Case| match self.only.is_empty() {
            true => !(self.quick && case.long),
            false => self
                .only
                .iter()
                .any(|name| case.name == name || (case.group == name && !(self.quick && case.long))),
        };
        Ok(all.into_iter().filter(chosen).collect())
    }
}

/// What came out of a case in one engine.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Name of the case.
    pub case: &'static str,
    /// Its group.
    pub group: &'static str,
    /// A sentence.
    pub title: &'static str,
    /// Where the answer is from.
    pub source: String,
    /// Sizes, materials, steps.
    pub setup: &'static str,
    /// Who was driven through it.
    pub engine: EngineName,
    /// Whether all checks pass.
    pub passed: bool,
    /// Whether it was left out: the engine has no such shape.
    pub left_out: bool,
    /// Figures; none where the engine could not do it.
    pub checks: Vec<Check>,
    /// Pictures.
    pub figures: Vec<Figure>,
    /// Wall-clock time, s.
    pub seconds: f64,
    /// Why the engine could not do it.
    pub error: Option<String>,
}

/// All outcomes, case by case.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Of Rockfall.
    pub version: &'static str,
    /// Whether it is the quick form.
    pub quick: bool,
    /// Wall-clock time of all, s.
    pub seconds: f64,
    /// In the order of the cases, and within a case of the engines.
    pub outcomes: Vec<Outcome>,
}

/// Drives the chosen engines through the chosen cases, one after the other. `tell` hears of each outcome when it is there.
///
/// # Errors
/// [`Error::NoCase`]. What goes wrong within a case is in its outcome.
pub fn run(choice: &Choice, mut tell: impl FnMut(&Outcome)) -> Result<Report, Error> {
    let start = Instant::now();
    let mut outcomes = Vec::new();
    for case in choice.cases()? {
        for &engine in choice.engines.iter().filter(|engine| case.engines.contains(engine)) {
            let outcome = outcome(&case, Rig { engine, quick: choice.quick });
            tell(&outcome);
            outcomes.push(outcome);
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    Ok(Report { version: env!("CARGO_PKG_VERSION"), quick: choice.quick, seconds, outcomes })
}

fn outcome(case: &Case, rig: Rig) -> Outcome {
    let start = Instant::now();
    let done = (case.run)(&rig);
    let seconds = start.elapsed().as_secs_f64();
    let left_out = matches!(done, Err(Error::NoShape { .. }));
    let (Findings { checks, figures }, error) = match done {
        Ok(findings) => (findings, None),
        Err(error) => (Findings::default(), Some(error.to_string())),
    };
    Outcome {
        case: case.name,
        group: case.group,
        title: case.title,
        source: case.source.text(),
        setup: case.setup,
        engine: rig.engine,
        passed: error.is_none() && checks.iter().all(Check::passes),
        left_out,
        checks,
        figures,
        seconds,
        error,
    }
}

impl Report {
    /// A table for terminals and Markdown, a row for each check.
    pub fn table(&self) -> String {
        table::table(self)
    }

    /// How many checks of each engine pass and fail, and how long it took.
    pub fn summary(&self) -> String {
        table::summary(self)
    }

    /// Everything, as JSON.
    ///
    /// # Errors
    /// [`Error::Json`].
    pub fn json(&self) -> Result<String, Error> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// Everything, as one page that needs nothing else.
    pub fn html(&self) -> String {
        page::html(self)
    }

    /// Cases that an engine was driven through and did not pass.
    pub fn failed(&self, engine: EngineName) -> Vec<&'static str> {
        let failed = self.outcomes.iter().filter(|o| o.engine == engine && !o.passed && !o.left_out);
        failed.map(|outcome| outcome.case).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A report of two engines on one case, one check failed, with a picture.
    pub(crate) fn sample() -> Report {
        let of = |engine: EngineName, got: f64| {
            let mut findings = Findings::default();
            findings.near("speed <1 s>", "m/s", got, (2.0, 0.1), "because").beside(&[("ODE", 2.5)]);
            let figure = Figure::linear("speed", "time, s", "speed, m/s").ours("", [(0.0, 0.0), (1.0, got)]);
            findings.draw(figure.expected("formula", [(0.0, 0.0), (1.0, 2.0)]));
            let Findings { checks, figures } = findings;
            Outcome {
                case: "falling",
                group: "closed",
                title: "A stone falls",
                source: "closed form: Galilei".to_owned(),
                setup: "A stone.",
                engine,
                passed: checks.iter().all(Check::passes),
                left_out: false,
                checks,
                figures,
                seconds: 0.25,
                error: None,
            }
        };
        let outcomes = vec![of(EngineName::SoftStep, 2.05), of(EngineName::Reflect, 3.0)];
        Report { version: "0.0.0", quick: true, seconds: 0.5, outcomes }
    }

    #[test]
    fn names_of_cases_and_groups_choose_and_unknown_ones_are_refused() {
        let of = |only: &[&str], quick| {
            let only = only.iter().map(|&name| name.to_owned()).collect();
            Choice { only, quick, ..Choice::default() }.cases()
        };
        let all = of(&[], false).expect("all");
        assert_eq!(all.len(), cases().len());
        let group = of(&[all[0].group], false).expect("a group");
        assert!(group.len() < all.len() && group.iter().all(|case| case.group == all[0].group));
        assert_eq!(of(&[all[3].name], true).expect("a case").len(), 1);
        let error = of(&["nonsense"], false).expect_err("no such case").to_string();
        assert!(error.contains("`nonsense`") && error.contains(all[0].name), "{error}");
        assert!(of(&[], true).expect("quick").iter().all(|case| !case.long));
    }

    #[test]
    fn what_fails_is_named_by_its_engine() {
        let report = sample();
        assert!(report.failed(EngineName::SoftStep).is_empty());
        assert_eq!(report.failed(EngineName::Reflect), ["falling"]);
        assert!(report.json().expect("JSON").contains("\"got\": 2.05"));
    }
}
