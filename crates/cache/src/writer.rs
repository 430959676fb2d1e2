//! Writing a run while the simulation goes on.
//!
//! The simulation hands frames over through a queue of a few places and goes on; a thread of its own compresses
//! and writes them. When the disk is slower than the simulation the queue fills and [`RunWriter::push`] waits: memory
//! stays bounded and no frame is dropped. The buffers travel back, so that a run allocates them once. A program that
//! is killed loses what is in the queue and, where a chunk holds several frames, the last quarter of a second.

use crate::trajectory::TrajectoryWriter;
use crate::{BodyTable, Error, FRAMES, Frame, Poses, RunFolder, SCENE, SUMMARY, Summary, TRAJECTORY, csv};
use rockfall_math::DVec3;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, channel, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Frames that wait to be written, at most. A million bodies take 28 MB each.
const QUEUE: usize = 4;

/// The longest that a frame waits for others to fill its chunk.
const FLUSH: Duration = Duration::from_millis(250);

/// Writes a run from a thread of its own.
#[derive(Debug)]
pub struct RunWriter {
    folder: PathBuf,
    frames: Option<SyncSender<Frame>>,
    back: Receiver<Poses>,
    thread: Option<JoinHandle<Result<u64, Error>>>,
    waited: Duration,
}

/// What a finished [`RunWriter`] has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Frames in the trajectory.
    pub frames: u64,
    /// Time that [`RunWriter::push`] waited for a place in the queue.
    pub waited: Duration,
}

impl RunWriter {
    /// Starts a run: writes the scene, the table of bodies and a first `summary`, and starts the thread. Positions
    /// are relative to `origin`, metres.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn create(
        folder: &RunFolder,
        scene: &str,
        summary: &Summary,
        table: &BodyTable,
        origin: DVec3,
    ) -> Result<Self, Error> {
        let path = folder.path().to_owned();
        summary.write(&path.join(SUMMARY))?;
        let scene_path = path.join(SCENE);
        fs::write(&scene_path, scene).map_err(|error| Error::io("write", &scene_path, &error))?;
        let rows_path = path.join(FRAMES);
        let rows = File::create(&rows_path).map_err(|error| Error::io("create", &rows_path, &error))?;
        let trajectory_path = path.join(TRAJECTORY);
        fs::create_dir(&trajectory_path).map_err(|error| Error::io("create", &trajectory_path, &error))?;
        let trajectory =
            TrajectoryWriter::create(&trajectory_path, table, origin, summary.frames_per_second)?;

        let (frames, queue) = sync_channel(QUEUE);
        let (give_back, back) = channel();
        let thread = thread::Builder::new()
            .name("run writer".into())
            .spawn(move || {
                let mut parts = Parts { rows, rows_path, trajectory, frame: 0 };
                parts.write_row(&csv::header())?;
                let mut flushed = Instant::now();
                loop {
                    match queue.recv_timeout(FLUSH) {
                        Ok(frame) => {
                            parts.write(&frame)?;
                            // Nobody wants the buffer any more when the simulation has ended.
                            let _ = give_back.send(frame.poses);
                        }
                        Err(RecvTimeoutError::Timeout) => {}
                        Err(RecvTimeoutError::Disconnected) => break,
                    }
                    if flushed.elapsed() >= FLUSH {
                        parts.trajectory.flush()?;
                        flushed = Instant::now();
                    }
                }
                parts.trajectory.flush()?;
                Ok(parts.trajectory.stored())
            })
            .map_err(|error| Error::io("start the thread that writes", &path, &error))?;
        Ok(RunWriter {
            folder: path,
            frames: Some(frames),
            back,
            thread: Some(thread),
            waited: Duration::ZERO,
        })
    }

    /// A buffer for the next frame: a former one where it has come back.
    pub fn buffer(&self) -> Poses {
        self.back.try_recv().unwrap_or_default()
    }

    /// Hands a frame over; waits while the queue is full. The first frame is the start, without a report.
    ///
    /// # Errors
    /// The one that ended the writing, of this frame or of one before.
    pub fn push(&mut self, frame: Frame) -> Result<(), Error> {
        let Some(frames) = &self.frames else { return Err(Error::WriterGone(self.folder.clone())) };
        let sent = match frames.try_send(frame) {
            Ok(()) => true,
            Err(TrySendError::Disconnected(_)) => false,
            Err(TrySendError::Full(frame)) => {
                let start = Instant::now();
                let sent = frames.send(frame).is_ok();
                self.waited += start.elapsed();
                sent
            }
        };
        if sent { Ok(()) } else { Err(self.join().err().unwrap_or(Error::WriterGone(self.folder.clone()))) }
    }

    /// Writes what is in the queue and ends the thread. The run is complete when its last [`Summary`] is written
    /// after this.
    ///
    /// # Errors
    /// The one that ended the writing.
    pub fn finish(mut self) -> Result<Written, Error> {
        let frames = self.join()?;
        Ok(Written { frames, waited: self.waited })
    }

    /// The folder of the run.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Closes the queue and waits for the thread.
    fn join(&mut self) -> Result<u64, Error> {
        self.frames = None;
        let gone = || Error::WriterGone(self.folder.clone());
        self.thread.take().ok_or_else(gone)?.join().map_err(|_| gone())?
    }
}

impl Drop for RunWriter {
    /// Writes what is in the queue.
    fn drop(&mut self) {
        self.frames = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread writes to.
struct Parts {
    rows: File,
    rows_path: PathBuf,
    trajectory: TrajectoryWriter,
    /// The next one.
    frame: u64,
}

impl Parts {
    fn write(&mut self, frame: &Frame) -> Result<(), Error> {
        if let Some(report) = &frame.report {
            self.write_row(&csv::row(self.frame, frame.time, report, frame.hash))?;
        }
        self.frame += 1;
        self.trajectory.append(frame.time, &frame.poses)
    }

    /// One call for one row: a run that is killed has whole rows.
    fn write_row(&mut self, row: &str) -> Result<(), Error> {
        self.rows.write_all(row.as_bytes()).map_err(|error| Error::io("write", &self.rows_path, &error))
    }
}
