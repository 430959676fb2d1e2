//! `rockfall view`: the live page of a scene or a run.

use crate::args::ViewArgs;
use crate::exit::Failure;
use crate::{say, units};
use rockfall_cache::RunReader;
use rockfall_view::{Door, Options, Source};

/// Serves the page until somebody ends the program.
pub(crate) fn view(args: &ViewArgs) -> Result<(), Failure> {
    let options = Options { host: args.host, port: args.port, saves: args.saves.clone() };
    // A port that is taken is known before a scene is built.
    let door = Door::open(&options)?;
    let run = RunReader::is_run(&args.path) || args.path.is_dir();
    let source = if run {
        Source::run(&args.path)?
    } else {
        Source::scene(&args.path, args.threads.map_or(0, usize::from))?
    };
    let bodies = source.bodies();
    let server = door.serve(source)?;
    say::out(server.url());
    say::error(&format!("{} bodies of {}; Ctrl-C ends it", units::count(bodies as u64), args.path.display()));
    if !args.host.is_loopback() {
        say::error(
            "Note: whoever has this address can watch and touch; what goes over the network is not encrypted",
        );
    }
    if args.open
        && let Err(error) = open::that(server.url())
    {
        say::error(&format!("Warning: cannot open a browser: {error}"));
    }
    server.wait();
    Ok(())
}
