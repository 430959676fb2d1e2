//! The moments of a run, one after the other, prepared by many threads.
//!
//! Frames are read a window at a time, encoded all of a window in parallel, and handed over in their order: so what is written does not depend on
//! threads, and memory on the window alone.

use crate::moment::Timed;
use crate::{Error, Ids, Inventory, Moment, Run};
use rayon::prelude::*;
use rockfall_cache::Poses;
use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

/// Poses in a window, about: with 84 bytes for a pose and its motion some 40 MB.
const WINDOW: usize = 1 << 19;

/// Frames in a window, at most.
const WINDOW_FRAMES: usize = 256;

/// Whether a format wants to know how bodies move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Velocities, which take the neighbours of a frame.
    Wanted,
    /// Poses alone.
    Unwanted,
}

/// Somebody who sees how far an export is and may stop it.
pub trait Watch: Sync {
    /// So many more frames have been written.
    fn wrote(&self, frames: u64);

    /// Whether to stop.
    fn stopped(&self) -> bool;
}

/// What is to be exported.
pub struct Job<'a> {
    run: &'a Run,
    frames: &'a [u64],
    watch: &'a dyn Watch,
}

impl<'a> Job<'a> {
    pub(crate) fn new(run: &'a Run, frames: &'a [u64], watch: &'a dyn Watch) -> Self {
        Job { run, frames, watch }
    }

    /// The run.
    pub fn run(&self) -> &'a Run {
        self.run
    }

    /// Numbers of the frames, ascending; at least one.
    pub fn frames(&self) -> &'a [u64] {
        self.frames
    }

    /// Rows of the bodies that were asked for; of all where nobody asked.
    ///
    /// # Errors
    /// Those of [`Ids::rows`].
    pub fn rows(&self, bodies: Option<&Ids>) -> Result<Vec<u32>, Error> {
        let table = self.run.bodies();
        bodies.map_or_else(|| Ok((0..table.len() as u32).collect()), |ids| ids.rows(table))
    }

    /// What the bodies look like.
    ///
    /// # Errors
    /// Those of [`Run::inventory`].
    pub fn inventory(&self) -> Result<&'a Inventory, Error> {
        self.run.inventory()
    }

    /// Where the bodies `rows` are at one frame, without motion.
    ///
    /// # Errors
    /// Those of [`Run::poses`].
    pub fn at(&self, frame: u64, rows: &[u32]) -> Result<Moment, Error> {
        let time = self.run.times().get(frame as usize).copied().unwrap_or(f64::NAN);
        Ok(Moment::still(frame, (time, &self.run.poses(frame)?), rows))
    }

    /// Calls `encode` for the bodies `rows` of each frame, for many frames at once, and `write` with what comes out, in the order of the frames.
    /// Frames count as written when `write` has returned.
    ///
    /// # Errors
    /// What the run, `encode` and `write` say, the first frame's first; [`Error::Stopped`].
    pub fn stream<T: Send>(
        &self,
        rows: &[u32],
        motion: Motion,
        encode: impl Fn(Moment) -> Result<T, Error> + Sync,
        mut write: impl FnMut(T) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut poses = BTreeMap::new();
        for window in self.frames.chunks(self.window()) {
            self.read(window, motion, &mut poses)?;
            let timed = |frame: u64| -> Option<Timed<'_>> {
                Some((*self.run.times().get(frame as usize)?, poses.get(&frame)?))
            };
            let encoded: Vec<Result<T, Error>> = window
                .par_iter()
                .filter_map(|&frame| {
                    let mut moment = Moment::still(frame, timed(frame)?, rows);
                    if motion == Motion::Wanted {
                        moment.move_by(frame.checked_sub(1).and_then(timed), timed(frame + 1));
                    }
                    Some(encode(moment))
                })
                .collect();
            for one in encoded {
                write(one?)?;
                self.watch.wrote(1);
            }
            if self.watch.stopped() {
                return Err(Error::Stopped);
            }
        }
        Ok(())
    }

    /// Frames of a window.
    fn window(&self) -> usize {
        let fit = WINDOW / self.run.bodies().len().max(1);
        fit.clamp(rayon::current_num_threads(), WINDOW_FRAMES.max(rayon::current_num_threads()))
    }

    /// Makes `poses` those of some frames, and of their neighbours where motion is wanted. Frames are read in their order, which is what costs the store
    /// least, and no frame is read twice.
    fn read(&self, frames: &[u64], motion: Motion, poses: &mut BTreeMap<u64, Poses>) -> Result<(), Error> {
        let around = |frame: u64| match motion {
            Motion::Unwanted => frame..=frame,
            Motion::Wanted => frame.saturating_sub(1)..=frame + 1,
        };
        let there = |frame: &u64| *frame < self.run.frames();
        let needed: BTreeSet<u64> = frames.iter().flat_map(|&frame| around(frame)).filter(there).collect();
        poses.retain(|frame, _| needed.contains(frame));
        for frame in needed {
            if let Entry::Vacant(place) = poses.entry(frame) {
                place.insert(self.run.poses(frame)?);
            }
        }
        Ok(())
    }
}
