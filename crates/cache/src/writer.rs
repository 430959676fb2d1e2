//! Writing a run while the simulation goes on.
//!
//! The simulation hands frames over through a queue of a few places and goes on; a thread of its own compresses
//! and writes them, or leaves compressing to the simulation's threads ([`RunWriter::encode_on`]). When the disk is slower than the simulation the queue fills and [`RunWriter::push`] waits: memory
//! stays bounded and no frame is dropped. The buffers travel back, so that a run allocates them once. A program that
//! is killed loses what is in the queue, and the frames that have not filled their chunk: some, of few bodies those of a quarter of a second.

use crate::store::write_whole;
use crate::trajectory::TrajectoryWriter;
use crate::{
    BodyTable, Contents, Error, FRAMES, Frame, Poses, RunFolder, RunReader, SCENE, SUMMARY, Summary,
    TRAJECTORY, Velocities, csv,
};
use rayon::ThreadPool;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Frames that wait to be written, at most. A million bodies take 28 MB each.
const QUEUE: usize = 4;

/// The least that a frame waits for others to fill its chunk,
const FLUSH: Duration = Duration::from_millis(250);

/// and how many times as long as it takes to write the chunk. Many chunks that are not full would be written many times; so that costs
/// a hundredth of a thread at most.
const PATIENCE: u32 = 100;

/// Writes a run from a thread of its own.
#[derive(Debug)]
pub struct RunWriter {
    /// Nobody else writes into it meanwhile.
    folder: RunFolder,
    frames: Option<SyncSender<Message>>,
    back: Receiver<(Poses, Velocities)>,
    thread: Option<JoinHandle<Result<(u64, u64), Error>>>,
    waited: Duration,
}

/// What a finished [`RunWriter`] has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Frames in the trajectory.
    pub frames: u64,
    /// Poses that were farther from the origin than numbers in steps reach, and are absent; see [`TrajectoryWriter::too_far`].
    pub too_far: u64,
    /// Time that [`RunWriter::push`] waited for a place in the queue.
    pub waited: Duration,
}

impl RunWriter {
    /// Starts a run: writes the scene, the table of bodies and a first `summary`, and starts the thread. `contents` may be
    /// an origin alone, metres: all that is written then are poses, as they are.
    ///
    /// # Errors
    /// [`Error::Precision`], [`Error::Io`].
    pub fn create(
        folder: &RunFolder,
        scene: &str,
        summary: &Summary,
        table: &BodyTable,
        contents: impl Into<Contents>,
    ) -> Result<Self, Error> {
        let path = folder.path();
        summary.write(&path.join(SUMMARY))?;
        write_whole(&path.join(SCENE), scene.as_bytes())?;
        let rows_path = path.join(FRAMES);
        let mut rows = File::create(&rows_path).map_err(|error| Error::io("create", &rows_path, &error))?;
        rows.write_all(csv::header().as_bytes()).map_err(|error| Error::io("write", &rows_path, &error))?;
        let trajectory_path = path.join(TRAJECTORY);
        fs::create_dir(&trajectory_path).map_err(|error| Error::io("create", &trajectory_path, &error))?;
        let trajectory =
            TrajectoryWriter::create(&trajectory_path, table, &contents.into(), summary.frames_per_second)?;
        Self::start(folder, Parts { rows, rows_path, trajectory, frame: 0 })
    }

    /// Goes on with a run after the frame `frame`, whose state has the hash `hash`. Frames and rows behind it are dropped; what is before
    /// it stays to the byte.
    ///
    /// # Errors
    /// Before anything is touched: [`Error::Damaged`] where frames or rows up to there are missing, or are those of another run. [`Error::Io`].
    pub fn resume(
        folder: &RunFolder,
        summary: &Summary,
        table: &BodyTable,
        frame: u64,
        hash: u64,
    ) -> Result<Self, Error> {
        let path = folder.path();
        let rows_path = path.join(FRAMES);
        let kept = csv::kept_bytes(&rows_path, frame, hash)?;
        let reader = RunReader::open(path)?;
        let trajectory_path = path.join(TRAJECTORY);
        if reader.bodies()? != *table {
            return Err(Error::damaged(&trajectory_path, "it has other bodies than the scene"));
        }
        let frames = reader.frames()?;
        if frames <= frame {
            return Err(Error::damaged(
                &trajectory_path,
                format!("it has {frames} frames, and not frame {frame}"),
            ));
        }
        let trajectory = TrajectoryWriter::resume(&trajectory_path, &reader, frame + 1)?;
        summary.write(&path.join(SUMMARY))?;
        let rows = File::options().append(true).open(&rows_path);
        let rows = rows.and_then(|rows| rows.set_len(kept).map(|()| rows));
        let rows = rows.map_err(|error| Error::io("write", &rows_path, &error))?;
        Self::start(folder, Parts { rows, rows_path, trajectory, frame: frame + 1 })
    }

    /// Starts the thread.
    fn start(folder: &RunFolder, mut parts: Parts) -> Result<Self, Error> {
        let (frames, queue) = sync_channel(QUEUE);
        let (give_back, back) = channel();
        let thread = thread::Builder::new()
            .name("run writer".into())
            .spawn(move || {
                let (mut flushed, mut took) = (Instant::now(), Duration::ZERO);
                loop {
                    match queue.recv_timeout(FLUSH) {
                        Ok(Message::Sync(done)) => {
                            parts.sync()?;
                            // Nobody waits for it when the simulation has ended.
                            let _ = done.send(());
                        }
                        Ok(Message::Threads(threads)) => parts.trajectory.encode_on(threads)?,
                        Ok(Message::Frame(frame)) => {
                            parts.write(&frame)?;
                            // Nobody wants the buffer any more when the simulation has ended.
                            let _ = give_back.send((frame.poses, frame.velocities));
                        }
                        Err(RecvTimeoutError::Timeout) => {}
                        Err(RecvTimeoutError::Disconnected) => break,
                    }
                    if flushed.elapsed() >= FLUSH.max(PATIENCE * took) {
                        let start = Instant::now();
                        parts.trajectory.flush()?;
                        flushed = Instant::now();
                        took = flushed - start;
                    }
                }
                parts.trajectory.flush()?;
                Ok((parts.trajectory.stored(), parts.trajectory.too_far()))
            })
            .map_err(|error| Error::io("start the thread that writes", folder.path(), &error))?;
        Ok(RunWriter {
            folder: folder.clone(),
            frames: Some(frames),
            back,
            thread: Some(thread),
            waited: Duration::ZERO,
        })
    }

    /// From now on these threads compress, those of the simulation best ([`rockfall::World::threads`]): a thread of its own takes processors
    /// from one of them at a time, and the others wait for that one. Where they have nothing to do in a step they take what is to be
    /// compressed, all of them together.
    ///
    /// # Errors
    /// As [`RunWriter::push`].
    pub fn encode_on(&mut self, threads: Arc<ThreadPool>) -> Result<(), Error> {
        self.send(Message::Threads(threads))
    }

    /// A buffer for the poses of the next frame: a former one where it has come back.
    pub fn buffer(&self) -> Poses {
        self.buffers().0
    }

    /// The same for poses and velocities.
    pub fn buffers(&self) -> (Poses, Velocities) {
        self.back.try_recv().unwrap_or_default()
    }

    /// Hands a frame over; waits while the queue is full. The first frame is the start, without a report.
    ///
    /// # Errors
    /// The one that ended the writing, of this frame or of one before.
    pub fn push(&mut self, frame: Frame) -> Result<(), Error> {
        self.send(Message::Frame(Box::new(frame)))
    }

    /// Waits until all frames that were pushed are on the disk, whatever happens to the machine.
    ///
    /// # Errors
    /// As [`RunWriter::push`].
    pub fn sync(&mut self) -> Result<(), Error> {
        let (done, synced) = channel();
        self.send(Message::Sync(done))?;
        let start = Instant::now();
        let synced = synced.recv().is_ok();
        self.waited += start.elapsed();
        if synced {
            Ok(())
        } else {
            Err(self.join().err().unwrap_or(Error::WriterGone(self.folder.path().to_owned())))
        }
    }

    fn send(&mut self, message: Message) -> Result<(), Error> {
        let Some(frames) = &self.frames else { return Err(Error::WriterGone(self.folder.path().to_owned())) };
        let sent = match frames.try_send(message) {
            Ok(()) => true,
            Err(TrySendError::Disconnected(_)) => false,
            Err(TrySendError::Full(message)) => {
                let start = Instant::now();
                let sent = frames.send(message).is_ok();
                self.waited += start.elapsed();
                sent
            }
        };
        if sent {
            Ok(())
        } else {
            Err(self.join().err().unwrap_or(Error::WriterGone(self.folder.path().to_owned())))
        }
    }

    /// Writes what is in the queue and ends the thread. The run is complete when its last [`Summary`] is written
    /// after this.
    ///
    /// # Errors
    /// The one that ended the writing.
    pub fn finish(mut self) -> Result<Written, Error> {
        let (frames, too_far) = self.join()?;
        Ok(Written { frames, too_far, waited: self.waited })
    }

    /// Time that the simulation waited for this so far.
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// The folder of the run.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Closes the queue and waits for the thread.
    fn join(&mut self) -> Result<(u64, u64), Error> {
        self.frames = None;
        let gone = || Error::WriterGone(self.folder.path().to_owned());
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

/// What the thread is told.
#[derive(Debug)]
enum Message {
    /// To be used from now on.
    Threads(Arc<ThreadPool>),
    /// To be written.
    Frame(Box<Frame>),
    /// All frames before are to be handed to the disk; then it says so.
    Sync(Sender<()>),
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
            self.write_row(&csv::row(self.frame, frame.time, report, frame.memory, frame.hash))?;
        }
        self.frame += 1;
        self.trajectory.append(frame)
    }

    fn sync(&mut self) -> Result<(), Error> {
        self.trajectory.sync()?;
        self.rows.sync_all().map_err(|error| Error::io("write", &self.rows_path, &error))
    }

    /// One call for one row: a run that is killed has whole rows.
    fn write_row(&mut self, row: &str) -> Result<(), Error> {
        self.rows.write_all(row.as_bytes()).map_err(|error| Error::io("write", &self.rows_path, &error))
    }
}
