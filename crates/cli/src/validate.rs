//! `rockfall validate`: the solvers against known answers.

use crate::args::{SolverName, ValidateArgs};
use crate::exit::Failure;
use crate::say;
use rockfall_validate::{Choice, EngineName, Error, run};
use std::fs;

/// Runs what was asked for; fails where the default solver does not pass.
pub(crate) fn validate(args: &ValidateArgs) -> Result<(), Failure> {
    let choice = Choice { only: args.only.clone(), quick: args.quick, ..Choice::default() };
    let choice = match args.solver.as_slice() {
        [] => choice,
        names => Choice { engines: names.iter().map(|&name| engine(name)).collect(), ..choice },
    };
    if args.list {
        for case in choice.cases()? {
            say::out(&format!("{}  {}\n    {}. {}", case.name, case.title, case.source.text(), case.setup));
        }
        return Ok(());
    }
    let report = run(&choice, |outcome| {
        let verdict = match (outcome.passed, outcome.left_out) {
            (true, _) => "passed",
            (false, true) => "left out",
            (false, false) => "FAILED",
        };
        say::error(&format!(
            "{} {} {verdict}, {:.1} s",
            outcome.case,
            outcome.engine.name(),
            outcome.seconds
        ));
    })?;
    if let Some(path) = &args.report {
        let write = fs::write(path, report.html());
        write.map_err(|error| Failure::Run(format!("{} can't be written: {error}", path.display())))?;
    }
    if args.json {
        say::out(&report.json()?);
        say::error(&report.summary());
    } else {
        say::out(&format!("{}\n{}", report.table(), report.summary()));
    }
    // The simple solvers are there to be compared; what they can't do is no fault of the build.
    if report.failed(EngineName::SoftStep).is_empty() { Ok(()) } else { Err(Failure::Different) }
}

fn engine(name: SolverName) -> EngineName {
    match name {
        SolverName::SoftStep => EngineName::SoftStep,
        SolverName::Impulse => EngineName::Impulse,
        SolverName::Reflect => EngineName::Reflect,
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::NoCase { .. } => Failure::Usage(error.to_string()),
            other => Failure::Run(other.to_string()),
        }
    }
}
