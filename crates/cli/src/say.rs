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
