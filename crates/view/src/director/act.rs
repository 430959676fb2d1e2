//! What viewers ask for.

use super::{Director, SOLVERS};
use crate::command::{Command, point, vector};
use crate::{Error, save};
use std::ops::RangeInclusive;
use std::time::Instant;

/// Steps that can be asked for at once.
const MOST_STEPS: i64 = 100;

/// Speeds of time that can be asked for.
const SPEEDS: RangeInclusive<f64> = 0.001..=100.0;

impl Director {
    /// Does what a viewer asks for; what is to be said of it.
    pub(super) fn act(&mut self, id: u64, command: Command) -> Result<Option<String>, Error> {
        match command {
            Command::Play { on } => {
                let range = self.source.range();
                // At the end of a run, to play is to begin again.
                if on && !self.playing && !range.grows && self.shown >= range.last {
                    self.show(range.first);
                }
                self.playing = on;
                (self.credit, self.clock, self.paced) = (0.0, Instant::now(), (Instant::now(), 0));
            }
            Command::Step { by } => {
                self.playing = false;
                let range = self.source.range();
                if by > 0 && self.shown.saturating_add_signed(by) > range.last && self.source.live().is_some()
                {
                    if by > MOST_STEPS {
                        let why = format!("{by} steps at once: expected {MOST_STEPS} at most");
                        return Err(Error::Refused(why));
                    }
                    (0..by).try_for_each(|_| self.go(1))?;
                } else {
                    self.show(self.shown.saturating_add_signed(by));
                }
            }
            Command::Seek { frame } => {
                self.show(frame);
                if frame > self.source.range().last {
                    return Ok(Some("so far it has not come yet: this is the newest frame".into()));
                }
            }
            Command::Speed { of } => {
                if !SPEEDS.contains(&of) {
                    let (least, most) = (SPEEDS.start(), SPEEDS.end());
                    return Err(Error::Refused(format!("a speed of {of}: expected {least} to {most}")));
                }
                (self.speed, self.credit) = (of, 0.0);
            }
            Command::Loop { on } => self.looping = on,
            Command::Show { color, mut overlays, pick } => {
                overlays.sort_unstable();
                overlays.dedup();
                if let Some(viewer) = self.viewers.get_mut(&id) {
                    viewer.marked |= !viewer.marks.is_empty();
                    (viewer.color, viewer.marks, viewer.pick) = (color, overlays, pick);
                    viewer.painted = None;
                }
                (self.details_stale, self.details_due) = (true, Instant::now());
            }
            Command::Save => {
                let path = save::save(&self.source, self.shown, &self.saves)?;
                return Ok(Some(path));
            }
            other => return self.touch(id, other).map(|()| None),
        }
        Ok(None)
    }

    /// What changes a simulation.
    fn touch(&mut self, id: u64, command: Command) -> Result<(), Error> {
        let shown = self.shown;
        let Some(live) = self.source.live() else {
            let why = "a run is only to be looked at: open its scene, or save this frame as one, to touch it";
            return Err(Error::Refused(why.into()));
        };
        match command {
            Command::Reset => live.reset()?,
            Command::Grab { row, at } => {
                if shown != live.frame {
                    return Err(Error::Refused(
                        "what has been can't be touched: go to the newest frame".into(),
                    ));
                }
                live.grab(id, row as usize, point(at))?;
                // It moves only while time does.
                self.playing = true;
            }
            Command::Pull { to } => live.pull(id, point(to))?,
            Command::Release => live.release(id),
            Command::Throw { from, velocity, radius } => live.throw(point(from), vector(velocity), radius)?,
            Command::Pile { over, size, count } => live.pile(point(over), size, count)?,
            Command::Set { gravity, solver, substeps } => {
                let solver = match solver {
                    None => None,
                    Some(name) => {
                        let found =
                            SOLVERS.iter().find(|(known, _)| *known == name).map(|(_, solver)| *solver);
                        let expected = SOLVERS.map(|(name, _)| name).join(", ");
                        let wrong = || {
                            Error::Refused(format!("there is no solver {name}, expected one of {expected}"))
                        };
                        Some(found.ok_or_else(wrong)?)
                    }
                };
                live.set(gravity.map(vector), solver, substeps)?;
                return Ok(());
            }
            Command::Material { index, friction, restitution } => {
                live.set_material(index, friction, restitution)?;
                return Ok(());
            }
            _ => return Ok(()),
        }
        // All of these are of the present.
        self.shown = live.frame;
        self.stale = true;
        Ok(())
    }

    /// Shows the frame that is nearest to this one.
    fn show(&mut self, frame: u64) {
        let range = self.source.range();
        self.shown = frame.clamp(range.first, range.last);
        (self.stale, self.credit) = (true, 0.0);
    }
}
