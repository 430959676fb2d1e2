//! `rockfall-bench`: Rockfall and its peers side by side on the same scenes.
//!
//! Each engine runs in a process of its own that holds the scene. The processes take turns of a few steps, so that
//! whatever else goes on in the machine hits all of them alike; compare ratios, not times of different runs. How
//! good the result is, is computed from poses and shapes alone, by one function for all.

// Engines in C and C++ are called from their own files under `engine`, and nothing else is unsafe.
#![deny(unsafe_code)]

mod child;
mod compare;
mod engine;
mod motion;
mod neighbours;
mod options;
mod page;
mod plot;
mod process;
mod quality;
mod scene;
mod table;

use clap::Parser;
use options::Options;
use std::process::ExitCode;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error(
        "this build has no {engine}; build it with `cargo build --release -p rockfall-bench --features {feature}`, \
         or choose `--engines rockfall`"
    )]
    NotBuilt { engine: &'static str, feature: &'static str },
    #[error("{engine}: {reason}")]
    Engine { engine: &'static str, reason: String },
    #[error("expected one scene with one number of bodies and threads, not {0}")]
    Cases(usize),
    #[error("rockfall: {0}")]
    World(#[from] rockfall::Error),
    #[error("{0}")]
    Hull(#[from] rockfall::shape::HullError),
    #[error("{0}")]
    HeightField(#[from] rockfall::shape::HeightFieldError),
    #[error("{0}")]
    Mesh(#[from] rockfall::shape::MeshError),
    #[error("{0}")]
    Io(#[from] std::io::Error),
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    #[error("{0}")]
    Csv(#[from] csv::Error),
}

fn main() -> ExitCode {
    // As the program `rockfall` does, and for all engines alike.
    rockfall::math::room::map_large_blocks();
    let options = Options::parse();
    let result = match options.child {
        Some(kind) => child::serve(&options, kind, std::io::stdin().lock(), std::io::stdout().lock()),
        None => run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Error> {
    if let Some(missing) = options.engines.iter().find(|kind| !kind.is_built()) {
        return Err(missing.missing());
    }
    let mut lines = Vec::new();
    let mut measure = || -> Result<(), Error> {
        for case in options.cases() {
            lines.extend(compare::compare(options, case, |progress| eprintln!("{progress}"))?);
        }
        Ok(())
    };
    // What is there when something fails took hours, perhaps: it is shown and written all the same.
    let measured = measure();
    println!("{}, medians of {} runs\n", process::machine(), options.repeats);
    println!("{}\n{}{}", table::markdown(&lines), table::stages(&lines), table::serial(&lines));
    if let Some(folder) = &options.out {
        table::write(folder, options, &lines)?;
    }
    measured
}
