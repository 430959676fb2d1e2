//! `rockfall bench`: engines side by side on the same scenes, where it is built.

use crate::exit::Failure;

/// Measures; the engines run in processes of this program, which come back here.
#[cfg(feature = "bench")]
pub(crate) fn bench(options: &rockfall_bench::Options) -> Result<(), Failure> {
    rockfall_bench::run(options, Some("bench")).map_err(|error| Failure::Run(error.to_string()))
}

/// Says how to get it.
#[cfg(not(feature = "bench"))]
pub(crate) fn bench(_: &crate::args::NoBenchArgs) -> Result<(), Failure> {
    let text = "this build has no bench. Build it with `cargo build --release -p rockfall-cli --features bench`, or with \
                `--features peers` to have other engines to compare with; docs/performance.md has the rest";
    Err(Failure::Usage(text.to_owned()))
}
