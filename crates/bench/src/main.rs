//! The bench as a program of its own; as a verb, it is `rockfall bench`.
#![forbid(unsafe_code)]

use clap::Parser;
use rockfall_bench::Options;
use std::process::ExitCode;

/// Runs the same scene in several engines, turn by turn, and compares time, memory and quality.
#[derive(Debug, Parser)]
#[command(name = "rockfall-bench", version, max_term_width = 100)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> ExitCode {
    // As the program `rockfall` does, and for all engines alike.
    rockfall::math::room::map_large_blocks();
    match rockfall_bench::run(&Cli::parse().options, None) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
