//! The moments of a run, one after the other, prepared by many threads.
//!
//! Frames are read a window at a time, encoded all of a window in parallel, and handed over in their order: so what is written does not depend on
//! threads, and memory on the window alone.

use crate::moment::Timed;
use crate::{Error, Ids, Inventory, Moment, Run};
use rayon::prelude::*;
use rockfall_cache::{Poses, Values, Velocities};
use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

/// Poses in a window, about: with 84 bytes for a pose and its motion some 40 MB.
const WINDOW: usize = 1 << 19;

/// Frames in a window, at most.
const WINDOW_FRAMES: usize = 256;

/// What a format wants to know of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Where they are.
    Poses,
    /// Also how they move.
    Motion,
    /// Also the columns that the run has of its own.
    All,
}

/// What was read of a frame.
#[derive(Debug)]
struct Read {
    poses: Poses,
    /// Where the run has them and somebody wants them.
    velocities: Option<Velocities>,
    columns: Vec<Values>,
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
        detail: Detail,
        encode: impl Fn(Moment) -> Result<T, Error> + Sync,
        mut write: impl FnMut(T) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut read = BTreeMap::new();
        // The scene alone says where in its shape a body's centre of mass is, of which velocities are stored.
        let stored = detail != Detail::Poses && self.run.has_velocities();
        let centers = if stored { &self.inventory()?.centers[..] } else { &[] };
        for window in self.frames.chunks(self.window()) {
            self.read(window, detail, stored, &mut read)?;
            let timed = |frame: u64| -> Option<Timed<'_>> {
                Some((*self.run.times().get(frame as usize)?, &read.get(&frame)?.poses))
            };
            let encoded: Vec<Result<T, Error>> = window
                .par_iter()
                .filter_map(|&frame| {
                    let mut moment = Moment::still(frame, timed(frame)?, rows);
                    let Read { velocities, columns, .. } = read.get(&frame)?;
                    match velocities {
                        _ if detail == Detail::Poses => {}
                        Some(velocities) => moment.move_with(velocities, centers),
                        None => moment.move_by(frame.checked_sub(1).and_then(timed), timed(frame + 1)),
                    }
                    moment.columns = columns.iter().map(|values| values.of_rows(&moment.rows)).collect();
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

    /// Makes `read` what there is of some frames, and of their neighbours where motion is wanted and not `stored`. Frames are read in their order, which
    /// is what costs the store least, and no frame is read twice.
    fn read(
        &self,
        frames: &[u64],
        detail: Detail,
        stored: bool,
        read: &mut BTreeMap<u64, Read>,
    ) -> Result<(), Error> {
        let alone = detail == Detail::Poses || stored;
        let around = |frame: u64| if alone { frame..=frame } else { frame.saturating_sub(1)..=frame + 1 };
        let there = |frame: &u64| *frame < self.run.frames();
        let needed: BTreeSet<u64> = frames.iter().flat_map(|&frame| around(frame)).filter(there).collect();
        read.retain(|frame, _| needed.contains(frame));
        for frame in needed {
            if let Entry::Vacant(place) = read.entry(frame) {
                let poses = self.run.poses(frame)?;
                let velocities = if stored { self.run.velocities(frame)? } else { None };
                let columns = if detail == Detail::All { self.run.values(frame)? } else { Vec::new() };
                place.insert(Read { poses, velocities, columns });
            }
        }
        Ok(())
    }
}
