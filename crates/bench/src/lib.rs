//! Rockfall and its peers side by side on the same scenes: what `rockfall-bench` and `rockfall bench` do.
//!
//! Each engine runs in a process of its own that holds the scene. The processes take turns of a few steps, so that
//! whatever else goes on in the machine hits all of them alike; compare ratios, not times of different runs. How
//! good the result is, is computed from poses and shapes alone, by one function for all.

// Engines in C and C++ are called from their own files under `engine`, and nothing else is unsafe.
#![deny(unsafe_code)]

mod bandwidth;
mod child;
mod compare;
mod engine;
mod motion;
mod neighbours;
mod options;
mod page;
mod process;
mod quality;
mod roofline;
mod scene;
mod table;

pub use options::Options;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An engine that was asked for is not in this build.
    #[error(
        "this build has no {engine}; build it with the cargo feature `{feature}`, or choose `--engines rockfall`"
    )]
    NotBuilt {
        /// Which.
        engine: &'static str,
        /// The cargo feature that brings it.
        feature: &'static str,
    },
    /// An engine can't go on.
    #[error("{engine}: {reason}")]
    Engine {
        /// Which.
        engine: &'static str,
        /// As far as it tells.
        reason: String,
    },
    /// The process of an engine has other than one scene.
    #[error("expected one scene with one number of bodies and threads, not {0}")]
    Cases(usize),
    /// Rockfall refuses the scene.
    #[error("rockfall: {0}")]
    World(#[from] rockfall::Error),
    /// No hull.
    #[error("{0}")]
    Hull(#[from] rockfall::shape::HullError),
    /// No terrain.
    #[error("{0}")]
    HeightField(#[from] rockfall::shape::HeightFieldError),
    /// No mesh.
    #[error("{0}")]
    Mesh(#[from] rockfall::shape::MeshError),
    /// Files, pipes or processes.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// No JSON.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// No CSV.
    #[error("{0}")]
    Csv(#[from] csv::Error),
}

/// Runs what is asked for, prints the tables, and writes the files; or serves one engine, where the options are those of a child.
///
/// The engines run in processes of this same program. `verb` is the word of its command line that leads here, if any: the
/// children are started with it.
///
/// # Errors
/// An engine that is not built or fails, and files that can't be written. What was measured until then is shown all the same.
pub fn run(options: &Options, verb: Option<&str>) -> Result<(), Error> {
    if let Some(kind) = options.child {
        return child::serve(options, kind, std::io::stdin().lock(), std::io::stdout().lock());
    }
    if let Some(missing) = options.engines.iter().find(|kind| !kind.is_built()) {
        return Err(missing.missing());
    }
    // First, while nothing else of ours runs.
    let roofs = bandwidth::measure(&options.threads)?;
    eprintln!("{}", table::streaming(&roofs));
    let mut lines = Vec::new();
    let mut measure = || -> Result<(), Error> {
        for case in options.cases() {
            lines.extend(compare::compare(options, verb, &roofs, case, |progress| eprintln!("{progress}"))?);
        }
        Ok(())
    };
    // What is there when something fails took hours, perhaps: it is shown and written all the same.
    let measured = measure();
    compare::beside_one_thread(&mut lines);
    println!("{}, medians of {} runs\n", process::machine(), options.repeats);
    println!("{}", table::all(&roofs, &lines));
    if let Some(folder) = &options.out {
        table::write(folder, options, &roofs, &lines)?;
    }
    measured
}
