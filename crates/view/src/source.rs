//! What is shown: a scene that is simulated, or a run.

use crate::Error;
use crate::live::Live;
use crate::recorded::Recording;
use crate::scenery::Scenery;
use crate::wire::Moment;
use rockfall_picture::{Camera, Sight};
use rockfall_scene::SceneCamera;
use std::path::Path;
use std::sync::Arc;

/// A scene that is simulated as one looks, or a run on disk.
#[derive(Debug)]
pub struct Source(pub(crate) Kind);

#[derive(Debug)]
pub(crate) enum Kind {
    Live(Box<Live>),
    Recorded(Box<Recording>),
}

/// Frames that can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    pub(crate) first: u64,
    pub(crate) last: u64,
    /// Where it is meant to end.
    pub(crate) planned: u64,
    /// Whether there will be more.
    pub(crate) grows: bool,
}

impl Source {
    /// The scene in a file, with so many threads; 0 for as many as the machine has.
    ///
    /// # Errors
    /// [`Error::Scene`] for all that is wrong with it.
    pub fn scene(path: &Path, threads: usize) -> Result<Self, Error> {
        Ok(Source(Kind::Live(Box::new(Live::open(path, threads)?))))
    }

    /// The run in a folder, finished or not.
    ///
    /// # Errors
    /// [`Error::Run`].
    pub fn run(path: &Path) -> Result<Self, Error> {
        Ok(Source(Kind::Recorded(Box::new(Recording::open(path)?))))
    }

    /// Number of bodies, those included that will come.
    pub fn bodies(&self) -> usize {
        match &self.0 {
            Kind::Live(live) => live.scenery().bodies.len(),
            Kind::Recorded(run) => run.scenery().bodies.len(),
        }
    }

    pub(crate) fn live(&mut self) -> Option<&mut Live> {
        match &mut self.0 {
            Kind::Live(live) => Some(live),
            Kind::Recorded(_) => None,
        }
    }

    pub(crate) fn scenery(&self) -> &Arc<Scenery> {
        match &self.0 {
            Kind::Live(live) => live.scenery(),
            Kind::Recorded(run) => run.scenery(),
        }
    }

    pub(crate) fn title(&self) -> String {
        match &self.0 {
            Kind::Live(live) => live.title(),
            Kind::Recorded(run) => run.title(),
        }
    }

    pub(crate) fn range(&self) -> Range {
        match &self.0 {
            Kind::Live(live) => live.range(),
            Kind::Recorded(run) => run.range(),
        }
    }

    /// Frames in a simulated second.
    pub(crate) fn rate(&self) -> f64 {
        match &self.0 {
            Kind::Live(live) => live.rate(),
            Kind::Recorded(run) => run.rate(),
        }
    }

    /// The moment of a frame within the range.
    pub(crate) fn moment(&mut self, frame: u64) -> Result<Arc<Moment>, Error> {
        match &mut self.0 {
            Kind::Live(live) => live.moment(frame),
            Kind::Recorded(run) => run.moment(frame),
        }
    }

    /// All that is known of a frame.
    pub(crate) fn sight(&self, frame: u64) -> Result<Sight, Error> {
        match &self.0 {
            Kind::Live(live) => live.sight(frame),
            Kind::Recorded(run) => run.sight(frame),
        }
    }

    /// Takes in what was written meanwhile; whether that is anything.
    pub(crate) fn follow(&mut self) -> Result<bool, Error> {
        match &mut self.0 {
            Kind::Live(_) => Ok(false),
            Kind::Recorded(run) => run.follow(),
        }
    }

    /// The cameras of the scene, and behind them one that finds its own place.
    pub(crate) fn cameras(&self) -> Vec<(String, Camera)> {
        let (of_scene, known): (&[SceneCamera], _) = match &self.0 {
            Kind::Live(live) => (live.cameras(), live.sight(live.range().last)),
            Kind::Recorded(run) => (run.cameras(), run.sight(0)),
        };
        let Ok(sight) = known else { return Vec::new() };
        // One that follows a body that is yet to come has no place.
        let placed = of_scene
            .iter()
            .filter_map(|camera| Some((camera.name.clone(), Camera::of_scene(camera, &sight).ok()?)));
        let mut cameras: Vec<(String, Camera)> = placed.collect();
        let stage = sight.stage(&vec![[0.0; 3]; sight.bodies.len()]);
        cameras.push(("auto".into(), Camera::fitting(&stage, &stage.balls(), 16.0 / 9.0)));
        cameras
    }
}
