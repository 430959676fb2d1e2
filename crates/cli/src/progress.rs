//! What a person sees while a run or an export goes on: a bar on a terminal, plain lines now and then elsewhere.

use crate::{say, units};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rockfall::StepReport;
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Time between two plain lines.
const LINES: Duration = Duration::from_secs(3);

/// Share of the newest step in the mean that is shown; the last twenty or so matter.
const NEWEST: f64 = 0.1;

/// Shows how far it is.
#[derive(Debug)]
pub(crate) struct Progress {
    look: Look,
    frames: u64,
    /// Frames that were done before.
    before: u64,
    done: u64,
    start: Instant,
    /// Mean of the last steps, seconds; zero before the first.
    step: f64,
}

#[derive(Debug)]
enum Look {
    Bar(ProgressBar),
    Lines { last: Instant },
    Quiet,
}

impl Progress {
    /// For a run of so many frames, some of which were done `before`.
    pub(crate) fn new(frames: u64, before: u64, quiet: bool) -> Self {
        let look = if quiet {
            Look::Quiet
        } else if stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(Some(frames), ProgressDrawTarget::stderr());
            // Two lines, so that all of it fits a terminal of 80 columns.
            let template = "{bar:40} {human_pos}/{human_len}  ETA {eta}\n{wide_msg}";
            // The template is a constant; were it wrong, the default style would do.
            bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
            Look::Bar(bar)
        } else {
            Look::Lines { last: Instant::now() }
        };
        Progress { look, frames, before, done: before, start: Instant::now(), step: 0.0 }
    }

    /// A step is done; it took `time`.
    pub(crate) fn step(&mut self, report: &StepReport, time: Duration) {
        self.done += 1;
        let time = time.as_secs_f64();
        self.step = if self.done == self.before + 1 { time } else { self.step + NEWEST * (time - self.step) };
        let step = self.step;
        self.show(|| figures(report, step));
    }

    /// So many more frames are done, of work that has no steps.
    pub(crate) fn frames(&mut self, frames: u64) {
        self.done += frames;
        let rate = (self.done - self.before) as f64 / self.start.elapsed().as_secs_f64();
        self.show(|| format!("{rate:.1} frames/s"));
    }

    /// Shows how far it is, with figures that are made only where somebody sees them.
    fn show(&mut self, figures: impl FnOnce() -> String) {
        match &mut self.look {
            Look::Bar(bar) => {
                bar.set_position(self.done);
                bar.set_message(figures());
            }
            Look::Lines { last } if last.elapsed() >= LINES => {
                *last = Instant::now();
                let elapsed = self.start.elapsed().as_secs_f64();
                let left = elapsed / (self.done - self.before) as f64
                    * (self.frames - self.done.min(self.frames)) as f64;
                let eta = units::time(Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX));
                say::error(&format!("{}/{}  ETA {eta}  {}", self.done, self.frames, figures()));
            }
            Look::Lines { .. } | Look::Quiet => {}
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Look::Bar(bar) = &self.look {
            bar.finish_and_clear();
        }
    }
}

/// Bodies awake, contacts, time and throughput; `step` in seconds.
fn figures(report: &StepReport, step: f64) -> String {
    let rate = if step > 0.0 { report.bodies as f64 / step } else { 0.0 };
    format!(
        "awake {}  contacts {}  {:.1} ms/step  {}",
        units::count(report.awake as u64),
        units::count(report.contacts as u64),
        step * 1e3,
        units::si(rate, "body·steps/s"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_of_the_step() {
        let report = StepReport { bodies: 20_000, awake: 19_000, contacts: 61_204, ..StepReport::default() };
        assert_eq!(
            figures(&report, 0.4),
            "awake 19,000  contacts 61,204  400.0 ms/step  50.00 kbody·steps/s"
        );
        assert_eq!(figures(&report, 0.0), "awake 19,000  contacts 61,204  0.0 ms/step  0 body·steps/s");
    }
}
