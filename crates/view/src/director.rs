//! The stage: one thread owns what is shown. It lets time go on, obeys what viewers ask for, and puts what is newest into their outboxes; it never waits for any of them.

use crate::command::{Color, Command, Mark, point, vector};
use crate::outbox::Outbox;
use crate::source::Source;
use crate::wire::{ABSENT, Colors, Moment};
use crate::{Error, details, save, told};
use rockfall::{STAGES, Solver};
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

/// Words are sent at most so often, and at least so often: a viewer that hears nothing for longer knows that it is cut off.
const STATUS: Duration = Duration::from_millis(60);
const HEARTBEAT: Duration = Duration::from_secs(1);

/// In one go the simulation runs for so long at most: viewers want to be heard.
const PATIENCE: Duration = Duration::from_millis(25);

/// What is worked out for viewers takes at most one in so many parts of the time.
const SHARE: u32 = 4;

/// Steps that can be asked for at once.
const MOST_STEPS: i64 = 100;

/// Speeds of time that can be asked for.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.001..=100.0;

const SOLVERS: [(&str, Solver); 3] =
    [("soft-step", Solver::SoftStep), ("impulse", Solver::Impulse), ("reflect", Solver::Reflect)];

/// Lines of overlays as a message, and what is to be said of them.
type Marked = Result<(Arc<[u8]>, Option<String>), String>;

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
    color: Color,
    marks: Vec<Mark>,
    pick: Option<u32>,
    /// What its colours were made of: mode and number of bodies that are there.
    painted: Option<(Color, usize, usize)>,
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
                    color: Color::default(),
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

    /// Does what a viewer asks for; what is to be said of it.
    fn act(&mut self, id: u64, command: Command) -> Result<Option<String>, Error> {
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

    fn publish(&mut self) {
        if self.stale {
            self.stale = false;
            let range = self.source.range();
            self.shown = self.shown.clamp(range.first, range.last);
            match self.source.moment(self.shown) {
                Ok(moment) => {
                    self.viewers.values().for_each(|viewer| viewer.outbox.show(&moment));
                    self.moment = Some(moment);
                    (self.details_stale, self.status_stale) = (true, true);
                }
                Err(error) => {
                    self.playing = false;
                    self.tell_all(&error);
                }
            }
        }
        if self.details_stale && Instant::now() >= self.details_due {
            let start = Instant::now();
            self.details_stale = false;
            self.details();
            self.details_due = Instant::now() + SHARE * start.elapsed();
        }
        let since = self.status_sent.elapsed();
        if (self.status_stale && since >= STATUS) || since >= HEARTBEAT {
            (self.status_stale, self.status_sent) = (false, Instant::now());
            let status: Arc<str> = self.status().to_string().into();
            self.viewers.values().for_each(|viewer| viewer.outbox.status(&status));
        }
    }

    /// Colours, overlays and what is told of bodies, for those who want them.
    fn details(&mut self) {
        let Some(moment) = self.moment.clone() else { return };
        let there = moment.records.iter().filter(|record| **record != ABSENT).count();
        let key = |color: Color| {
            let frame = if color.moves() { moment.frame as usize } else { 0 };
            (color, there, frame)
        };
        let wants = |viewer: &Viewer| {
            viewer.painted != Some(key(viewer.color)) || !viewer.marks.is_empty() || viewer.pick.is_some()
        };
        let nothing: Arc<[u8]> = crate::wire::lines(&[]).into();
        for viewer in self.viewers.values_mut().filter(|viewer| viewer.marked && viewer.marks.is_empty()) {
            viewer.marked = false;
            viewer.outbox.mark(&nothing);
        }
        if !self.viewers.values().any(wants) {
            return;
        }
        let sight = self.source.sight(moment.frame);
        // What stays the same is known also of what has been.
        let newest = if sight.is_err() { Some(self.source.sight(self.source.range().last)) } else { None };
        let mut painted: BTreeMap<Color, Result<Arc<Colors>, String>> = BTreeMap::new();
        let mut marked: BTreeMap<Vec<Mark>, Marked> = BTreeMap::new();
        let (source, scenery) = (&self.source, &moment.scenery);
        for viewer in self.viewers.values_mut() {
            let outbox = &viewer.outbox;
            let complain = |what: &str, why: &str| {
                outbox.answer(json!({"is": "unknown", "what": what, "why": why}).to_string().into());
            };
            if viewer.painted != Some(key(viewer.color)) {
                let made = painted.entry(viewer.color).or_insert_with(|| {
                    let sight = newest.as_ref().filter(|_| !viewer.color.moves()).unwrap_or(&sight);
                    let sight = sight.as_ref().map_err(ToString::to_string)?;
                    details::colors(sight, viewer.color, scenery)
                        .map(Arc::new)
                        .map_err(|error| error.to_string())
                });
                match made {
                    Ok(colors) => outbox.paint(colors),
                    Err(why) => complain("color", why),
                }
                viewer.painted = Some(key(viewer.color));
            }
            if !viewer.marks.is_empty() {
                let made = marked.entry(viewer.marks.clone()).or_insert_with(|| {
                    let sight = sight.as_ref().map_err(ToString::to_string)?;
                    let made = details::overlays(sight, &viewer.marks, scenery);
                    made.map(|(bytes, note)| (bytes.into(), note)).map_err(|error| error.to_string())
                });
                match made {
                    Ok((bytes, note)) => {
                        outbox.mark(bytes);
                        if let Some(note) = note {
                            complain("overlays", note);
                        }
                    }
                    Err(why) => {
                        outbox.mark(&nothing);
                        complain("overlays", why);
                    }
                }
                viewer.marked = true;
            }
            if let Some(row) = viewer.pick {
                let value = match &sight {
                    Ok(sight) => told::told(source, sight, scenery, row),
                    Err(error) => json!({"is": "picked", "row": row, "why": error.to_string()}),
                };
                outbox.tell_of_body(value.to_string().into());
            }
        }
    }

    /// What a viewer is told once.
    fn hello(&mut self) -> Value {
        if self.cameras.is_none() {
            let cameras = self.source.cameras().into_iter().map(|(name, camera)| {
                let (eye, target) = (camera.eye.to_array(), camera.target.to_array());
                json!({"name": name, "eye": eye, "target": target, "fov": camera.fov})
            });
            self.cameras = Some(cameras.collect());
        }
        json!({
            "is": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "title": self.source.title(),
            "live": self.source.live().is_some(),
            "rate": self.source.rate(),
            "origin": self.source.scenery().origin.to_array(),
            "cameras": self.cameras,
            "stages": STAGES,
            "solvers": SOLVERS.map(|(name, _)| name),
            "colors": Color::NAMES,
            "overlays": Mark::NAMES,
        })
    }

    /// How it stands.
    fn status(&mut self) -> Value {
        let range = self.source.range();
        let moment = self.moment.as_ref();
        let mut status = json!({
            "is": "status",
            "frame": self.shown,
            "time": moment.map(|moment| moment.time),
            "first": range.first,
            "last": range.last,
            "planned": range.planned,
            "grows": range.grows,
            "playing": self.playing,
            "loop": self.looping,
            "speed": self.speed,
            "rate": self.source.rate(),
            "pace": self.pace,
            "viewers": self.viewers.len(),
            "bodies": moment.map(|moment| moment.records.iter().filter(|record| **record != ABSENT).count()),
            "far": moment.map(|moment| moment.far),
            "step": moment.map(|moment| moment.step),
        });
        if let Some(live) = self.source.live() {
            let (bytes, most) = live.history();
            let (world, names) = (&live.running.world, live.scene.materials());
            let settings = world.settings();
            let report = world.report();
            let solver = SOLVERS.iter().find(|(_, solver)| *solver == settings.solver).map(|(name, _)| *name);
            let materials: Vec<Value> = names
                .iter()
                .zip(live.running.materials())
                .filter_map(|(name, id)| {
                    let material = world.material(*id).ok()?;
                    Some(json!({"name": name, "friction": material.friction, "restitution": material.restitution}))
                })
                .collect();
            status["present"] = json!(live.frame);
            status["history"] = json!({"bytes": bytes, "most": most});
            status["held"] = json!(live.is_held());
            status["settings"] = json!({"gravity": settings.gravity.to_array(), "solver": solver, "substeps": settings.substeps});
            status["materials"] = json!(materials);
            status["figures"] = json!({
                "awake": report.awake,
                "touching": report.touching,
                "contacts": report.contacts,
                "deepest": report.deepest_penetration,
                "kinetic": report.kinetic_energy,
                "frozen": report.frozen,
                "step_ms": 1e3 * live.step_time.as_secs_f64(),
                "stages_ms": report.times.map(|time| 1e3 * time.as_secs_f64()),
            });
        }
        status
    }
}
