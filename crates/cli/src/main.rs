//! The rockfall program: runs a scene file to a folder of results, and says what is in either.
//!
//! One file per verb: [`run`], [`info`], [`verify`], [`diff`], [`export`], [`render`], [`report`], [`view`], [`validate`] and [`bench`]; what they share lies beside
//! them.
#![forbid(unsafe_code)]

mod args;
mod bench;
mod diff;
mod exit;
mod export;
mod extras;
mod film;
mod info;
mod open;
mod output;
mod plan;
mod progress;
mod render;
mod report;
mod run;
mod say;
mod shots;
mod stop;
mod summary;
mod units;
mod validate;
mod verify;
mod view;

use args::{Cli, Verb};
use clap::Parser;
use rockfall::math::room::map_large_blocks;
use std::process::ExitCode;

fn main() -> ExitCode {
    map_large_blocks();
    say::hush_readers();
    let done = match Cli::parse().verb {
        Verb::Run(args) => run::run(&args),
        Verb::Info(args) => info::info(&args),
        Verb::Verify(args) => verify::verify(&args),
        Verb::Diff(args) => diff::diff(&args),
        Verb::Export(args) => export::export(&args),
        Verb::Validate(args) => validate::validate(&args),
        Verb::Render(args) => render::render(&args),
        Verb::View(args) => view::view(&args),
        Verb::Report(args) => report::report(&args),
        Verb::Bench(args) => bench::bench(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
