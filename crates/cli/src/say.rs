//! Printing that does not mind when nobody listens any more: `rockfall … | head` is no reason to fail.

use std::io::{self, Write};

/// One or more lines on standard output.
pub(crate) fn out(text: &str) {
    let mut stdout = io::stdout().lock();
    let _ = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
}

/// One or more lines on standard error.
pub(crate) fn error(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// The readers of other programs' files are libraries that may panic on a damaged one; it becomes an error that names the file, and what the library says of itself
/// helps nobody. Panics of our own are told as ever.
pub(crate) fn hush_readers() {
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !rockfall_import::is_reading() {
            tell(panic);
        }
    }));
}
