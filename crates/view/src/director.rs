//! The stage: one thread owns what is shown. It lets time go on, obeys what viewers ask for, and puts what is newest into their outboxes; it never waits for any of them.

mod act;
mod publish;
mod words;

use crate::Error;
use crate::command::Command;
use crate::outbox::Outbox;
use crate::source::Source;
use crate::wire::Moment;
use publish::STATUS;
use rockfall::Solver;
use rockfall_picture::{ColorBy, Overlay};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// The longest that the stage waits without looking around.
const IDLE: Duration = Duration::from_millis(250);

/// A run that is still being written is looked at so often.
const FOLLOW: Duration = Duration::from_millis(400);

/// In one go the simulation runs for so long at most: viewers want to be heard.
const PATIENCE: Duration = Duration::from_millis(25);

/// The solvers by name.
const SOLVERS: [(&str, Solver); 3] =
    [("soft-step", Solver::SoftStep), ("impulse", Solver::Impulse), ("reflect", Solver::Reflect)];

/// What comes to the stage.
#[derive(Debug)]
pub(crate) enum Order {
    /// A viewer has come.
    Join(u64, Arc<Outbox>),
    /// It has gone.
    Leave(u64),
    /// It asks for something.
    Say(u64, Command),
    /// The end.
    Quit,
}

/// What one viewer wants to see.
#[derive(Debug)]
struct Viewer {
    outbox: Arc<Outbox>,
    color: ColorBy,
    marks: Vec<Overlay>,
    pick: Option<u32>,
    /// What its colours were made of: mode and number of bodies that are there.
    painted: Option<(ColorBy, usize, usize)>,
    marked: bool,
}

/// The stage.
#[derive(Debug)]
pub(crate) struct Director {
    source: Source,
    saves: PathBuf,
    viewers: BTreeMap<u64, Viewer>,
    shown: u64,
    moment: Option<Arc<Moment>>,
    playing: bool,
    looping: bool,
    speed: f64,
    /// Frames that are due, the started one included.
    credit: f64,
    clock: Instant,
    /// Simulated seconds per second of late.
    pace: f64,
    paced: (Instant, u64),
    followed: Instant,
    stale: bool,
    cameras: Option<Value>,
    details_stale: bool,
    details_due: Instant,
    status_stale: bool,
    status_sent: Instant,
}

impl Director {
    pub(crate) fn new(source: Source, saves: PathBuf) -> Self {
        let now = Instant::now();
        let range = source.range();
        Director {
            // A run that is being written is followed.
            shown: if range.grows { range.last } else { range.first },
            source,
            saves,
            viewers: BTreeMap::new(),
            moment: None,
            playing: true,
            looping: false,
            speed: 1.0,
            credit: 0.0,
            clock: now,
            pace: 0.0,
            paced: (now, 0),
            followed: now,
            stale: true,
            cameras: None,
            details_stale: true,
            details_due: now,
            status_stale: true,
            status_sent: now,
        }
    }

    /// Goes on until it is told to end.
    pub(crate) fn run(mut self, orders: &Receiver<Order>) {
        loop {
            let mut next = match orders.recv_timeout(self.wait()) {
                Ok(order) => Some(order),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            while let Some(order) = next {
                if matches!(order, Order::Quit) {
                    self.viewers.values().for_each(|viewer| viewer.outbox.close("the program has ended"));
                    return;
                }
                self.obey(order);
                next = orders.try_recv().ok();
            }
            if let Err(error) = self.tick() {
                self.playing = false;
                self.status_stale = true;
                self.tell_all(&error);
            }
            self.publish();
        }
    }

    /// Until something is to be done by itself.
    fn wait(&self) -> Duration {
        let mut wait = IDLE;
        if self.playing && !self.viewers.is_empty() {
            let frames = (1.0 - self.credit).max(0.0) / (self.source.rate() * self.speed);
            let passed = self.clock.elapsed().as_secs_f64();
            wait = wait.min(Duration::from_secs_f64((frames - passed).clamp(0.0, 1.0)));
        }
        if self.status_stale {
            wait = wait.min(STATUS.saturating_sub(self.status_sent.elapsed()));
        }
        if self.details_stale {
            wait = wait.min(self.details_due.saturating_duration_since(Instant::now()));
        }
        wait
    }

    /// Lets time go on as far as it is due. Nobody looks: it stands.
    fn tick(&mut self) -> Result<(), Error> {
        let passed = self.clock.elapsed().as_secs_f64().min(0.1);
        self.clock = Instant::now();
        if !self.viewers.is_empty() && self.source.range().grows && self.followed.elapsed() >= FOLLOW {
            self.followed = Instant::now();
            if self.source.follow()? {
                self.status_stale = true;
            }
        }
        if !self.playing || self.viewers.is_empty() {
            self.credit = 0.0;
            return Ok(());
        }
        self.credit += passed * self.source.rate() * self.speed;
        let due = self.credit.floor();
        if due < 1.0 {
            return Ok(());
        }
        self.credit -= due;
        self.go(due as u64)
    }

    /// So many frames on.
    fn go(&mut self, frames: u64) -> Result<(), Error> {
        let start = Instant::now();
        for _ in 0..frames {
            let range = self.source.range();
            let at_end = self.shown >= range.last;
            if self.looping && at_end && self.shown >= range.planned {
                self.shown = range.first;
            } else if !at_end {
                self.shown += 1;
            } else if let Some(live) = self.source.live() {
                live.advance()?;
                self.shown = live.frame;
            } else {
                if !range.grows {
                    self.playing = false;
                    self.status_stale = true;
                }
                break;
            }
            self.stale = true;
            self.paced.1 += 1;
            if start.elapsed() > PATIENCE {
                break;
            }
        }
        let (since, done) = self.paced;
        let span = since.elapsed().as_secs_f64();
        if span > 0.5 {
            self.pace = done as f64 / self.source.rate() / span;
            self.paced = (Instant::now(), 0);
        }
        Ok(())
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Join(id, outbox) => {
                outbox.answer(self.hello().to_string().into());
                let viewer = Viewer {
                    outbox,
                    color: ColorBy::default(),
                    marks: Vec::new(),
                    pick: None,
                    painted: None,
                    marked: false,
                };
                if let Some(moment) = &self.moment {
                    viewer.outbox.show(moment);
                }
                self.viewers.insert(id, viewer);
                self.clock = Instant::now();
                (self.details_stale, self.status_stale) = (true, true);
            }
            Order::Leave(id) => {
                self.viewers.remove(&id);
                if let Some(live) = self.source.live() {
                    live.release(id);
                }
                self.status_stale = true;
            }
            Order::Say(id, command) => {
                self.status_stale = true;
                match self.act(id, command) {
                    Ok(None) => {}
                    Ok(Some(note)) => self.answer(id, &json!({"is": "note", "text": note})),
                    Err(error) => self.answer(id, &json!({"is": "error", "text": error.to_string()})),
                }
            }
            Order::Quit => {}
        }
    }

    fn answer(&self, id: u64, answer: &Value) {
        if let Some(viewer) = self.viewers.get(&id) {
            viewer.outbox.answer(answer.to_string().into());
        }
    }

    fn tell_all(&self, error: &Error) {
        let text = json!({"is": "error", "text": error.to_string()}).to_string();
        self.viewers.values().for_each(|viewer| viewer.outbox.answer(text.as_str().into()));
    }
}
