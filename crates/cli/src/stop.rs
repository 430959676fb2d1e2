//! Ctrl-C, and the signals by which a system asks a program to end.

use crate::exit::{Failure, INTERRUPTED};
use crate::say;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether somebody asked to stop.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// From now on the first signal asks, and the second ends the program at once. `after` is what is done before it stops.
    pub(crate) fn listen(after: &'static str) -> Result<Self, Failure> {
        let stop = Stop::default();
        let asked = stop.0.clone();
        ctrlc::set_handler(move || {
            if asked.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(INTERRUPTED));
            }
            say::error(&format!("\nstopping after {after}; once more to stop at once"));
        })
        .map_err(|error| Failure::Run(format!("cannot listen for Ctrl-C: {error}")))?;
        Ok(stop)
    }

    /// Whether somebody asked.
    pub(crate) fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
