//! A run on disk, finished or still being written.

use crate::Error;
use crate::scenery::{Row, Scenery};
use crate::source::Range;
use crate::wire::{Grid, Moment};
use rockfall_cache::{SCENE, Status};
use rockfall_export::Run;
use rockfall_math::{Pose, Vec3};
use rockfall_picture::{Recorded, Sight};
use rockfall_scene::{Scene, SceneCamera};
use std::path::Path;
use std::sync::Arc;

/// The frames of a run.
#[derive(Debug)]
pub(crate) struct Recording {
    run: Run,
    cameras: Vec<SceneCamera>,
    rate: f64,
    grid: Grid,
    scenery: Arc<Scenery>,
    /// From the scenery's origin to that of the run, metres.
    shift: Vec3,
}

impl Recording {
    /// Opens a run.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let run = Run::open(path)?;
        let scene = Scene::load(path.join(SCENE))?;
        let (inventory, bodies) = (run.inventory()?, run.bodies());
        let rows: Vec<Row> = (0..bodies.len())
            .map(|k| Row {
                id: bodies.ids[k],
                shown: inventory.shown_of[k] as usize,
                kind: inventory.kinds[k],
                sensor: inventory.sensors[k],
            })
            .collect();
        // Where it begins and where it ends so far.
        let mut places = Vec::new();
        for frame in [0, run.frames().saturating_sub(1)] {
            let poses = run.poses(frame)?;
            let place = |k: usize| {
                let (position, rotation) = poses.at(k)?;
                let pose = Pose { position: run.origin() + position.as_dvec3(), rotation };
                Some((inventory.shown_of[k] as usize, pose))
            };
            places.extend((0..bodies.len()).filter_map(place));
        }
        let scenery = Scenery::new(&inventory.shapes, &rows, &places);
        Ok(Recording {
            cameras: scene.cameras(),
            rate: f64::from(scene.settings.rate),
            grid: scenery.grid,
            shift: (run.origin() - scenery.origin).as_vec3(),
            scenery: Arc::new(scenery),
            run,
        })
    }

    pub(crate) fn title(&self) -> String {
        let path = self.run.path();
        path.file_name()
            .map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    pub(crate) fn path(&self) -> &Path {
        self.run.path()
    }

    pub(crate) fn scenery(&self) -> &Arc<Scenery> {
        &self.scenery
    }

    pub(crate) fn cameras(&self) -> &[SceneCamera] {
        &self.cameras
    }

    pub(crate) fn range(&self) -> Range {
        let summary = self.run.summary();
        let last = self.run.frames().saturating_sub(1);
        let grows = summary.status == Status::Running && last < summary.frames_planned;
        Range { first: 0, last, planned: summary.frames_planned.max(last), grows }
    }

    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    pub(crate) fn follow(&mut self) -> Result<bool, Error> {
        Ok(self.run.refresh()?)
    }

    pub(crate) fn moment(&mut self, frame: u64) -> Result<Arc<Moment>, Error> {
        let mut poses = self.run.poses(frame)?;
        for position in poses.positions.as_chunks_mut::<3>().0 {
            *position = (Vec3::from_array(*position) + self.shift).to_array();
        }
        let (records, far) = self.scenery.records(&mut self.grid, &poses.positions, &poses.orientations, &[]);
        let time = self.run.times().get(frame as usize).copied().unwrap_or(f64::NAN);
        let scenery = Arc::clone(&self.scenery);
        Ok(Arc::new(Moment { frame, time, step: self.grid.step, records: Arc::new(records), far, scenery }))
    }

    pub(crate) fn sight(&self, frame: u64) -> Result<Sight, Error> {
        Ok(Recorded::new(&self.run)?.at(frame)?)
    }
}
