//! What a person can ask for.

use clap::{Args, Parser, Subcommand, ValueEnum};
use rockfall::Solver;
use std::path::PathBuf;

/// Simulates very many rigid bodies in hard contact.
#[derive(Debug, Parser)]
#[command(name = "rockfall", version, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 done, 1 the run failed, 2 wrong usage, 3 wrong scene, 4 another hash than \
expected, 130 interrupted."
)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Run a scene and write its output.
    Run(Box<RunArgs>),
    /// Say what is in a scene file or in the output of a run.
    Info(InfoArgs),
    /// Run the same scene in several engines, turn by turn, and compare time, memory and quality.
    #[cfg(feature = "bench")]
    Bench(Box<rockfall_bench::Options>),
    /// What a build without the feature says of it: how to get it.
    #[cfg(not(feature = "bench"))]
    #[command(hide = true, disable_help_flag = true, disable_version_flag = true)]
    Bench(NoBenchArgs),
}

/// `rockfall bench` where it is not built: whatever is asked of it.
#[cfg(not(feature = "bench"))]
#[derive(Debug, Args)]
pub(crate) struct NoBenchArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<std::ffi::OsString>,
}

/// `rockfall run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Scene file.
    pub(crate) scene: PathBuf,
    /// Folder for the output, made where it is missing [default: the next free runs/SCENE-NUMBER].
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    pub(crate) out: Option<PathBuf>,
    /// Replace the run that is in the output folder.
    #[arg(long, requires = "out")]
    pub(crate) overwrite: bool,
    /// Write nothing to disk.
    #[arg(long)]
    pub(crate) no_output: bool,
    /// Steps to simulate [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) frames: Option<u64>,
    /// Threads [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// SIMD lanes [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = lanes)]
    pub(crate) lanes: Option<usize>,
    /// How contacts are answered [default: the scene's].
    #[arg(long, value_name = "NAME")]
    pub(crate) solver: Option<SolverName>,
    /// Sub-steps in a step [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) substeps: Option<u32>,
    /// Seed of everything random [default: the scene's].
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Print the summary as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the hash of the last state, and nothing else, on standard output.
    #[arg(long, conflicts_with = "json")]
    pub(crate) hash: bool,
    /// Fail with exit code 4 when the hash of the last state is another one.
    #[arg(long, value_name = "HASH", value_parser = hash)]
    pub(crate) expect_hash: Option<u64>,
    /// Read the scene, count its bodies, estimate memory and disk, and stop there.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// `rockfall info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene file, or folder of a run.
    pub(crate) path: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// The solvers by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverName {
    /// Soft contacts in sub-steps; carries large piles.
    SoftStep,
    /// One impulse per contact point, with restitution and friction.
    Impulse,
    /// The velocity is mirrored at the contact, without friction.
    Reflect,
}

impl From<SolverName> for Solver {
    fn from(name: SolverName) -> Self {
        match name {
            SolverName::SoftStep => Solver::SoftStep,
            SolverName::Impulse => Solver::Impulse,
            SolverName::Reflect => Solver::Reflect,
        }
    }
}

/// The name of a solver.
pub(crate) fn solver_name(solver: Solver) -> &'static str {
    match solver {
        Solver::SoftStep => "soft-step",
        Solver::Impulse => "impulse",
        Solver::Reflect => "reflect",
    }
}

/// A number of lanes that there is.
fn lanes(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(lanes @ (1 | 4 | 8 | 16)) => Ok(lanes),
        _ => Err("expected 1, 4, 8 or 16".into()),
    }
}

/// A hash as the program prints it.
fn hash(text: &str) -> Result<u64, String> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    let value = u64::from_str_radix(digits, 16).ok();
    // A sign is no digit, though the parser takes one.
    let well_formed = digits.len() == 16 && digits.chars().all(|c| c.is_ascii_hexdigit());
    value.filter(|_| well_formed).ok_or_else(|| "expected 16 hexadecimal digits".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_hash_has_sixteen_digits() {
        assert_eq!(hash("00000000000000ff"), Ok(255));
        assert_eq!(hash("0xABCDEF0123456789"), Ok(0xabcd_ef01_2345_6789));
        for wrong in ["", "ff", "+0000000000000ff", "00000000000000zz", "00000000000000000"] {
            assert!(hash(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn solvers_have_one_name_everywhere() {
        for name in SolverName::value_variants() {
            let value = name.to_possible_value().unwrap();
            assert_eq!(value.get_name(), solver_name((*name).into()));
        }
    }
}
