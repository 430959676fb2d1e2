//! A scene that is simulated, and what was seen of it.

use crate::Error;
use crate::history::{History, MOST};
use crate::scenery::{Row, Scenery};
use crate::source::Range;
use crate::toys::Toys;
use crate::wire::{Grid, Moment};
use rockfall::{BodyId, Settings, Shape, Solver, Spring};
use rockfall_math::{DVec3, Pose, Vec3};
use rockfall_picture::Sight;
use rockfall_scene::{BodyRow, Running, Scene, SceneCamera};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A hand pulls as a spring of so many hertz, which follows without swinging much.
const HERTZ: f32 = 4.0;
const DAMPING: f32 = 0.8;

/// The most that a hand pulls, in weights of the body at 9.81 m/s²: it lifts a body out of a heap and not the heap.
const STRENGTH: f32 = 60.0;

/// A simulation.
#[derive(Debug)]
pub(crate) struct Live {
    path: PathBuf,
    pub(crate) scene: Scene,
    cameras: Vec<SceneCamera>,
    pub(crate) running: Running,
    /// Steps done.
    pub(crate) frame: u64,
    grid: Grid,
    scenery: Arc<Scenery>,
    history: History,
    pub(crate) toys: Toys,
    /// What each viewer holds.
    grabs: BTreeMap<u64, (BodyId, Spring)>,
    /// How long the last step took.
    pub(crate) step_time: Duration,
}

impl Live {
    /// Builds a scene.
    pub(crate) fn open(path: &Path, threads: usize) -> Result<Self, Error> {
        let mut scene = Scene::load(path)?;
        scene.settings.threads = threads;
        Self::build(path, scene, 0)
    }

    fn build(path: &Path, scene: Scene, epoch: u32) -> Result<Self, Error> {
        let running = scene.build()?;
        let scenery = Arc::new(lay_out(&running, epoch));
        let mut live = Live {
            path: path.to_owned(),
            cameras: scene.cameras(),
            scene,
            running,
            frame: 0,
            grid: scenery.grid,
            scenery,
            history: History::default(),
            toys: Toys::default(),
            grabs: BTreeMap::new(),
            step_time: Duration::ZERO,
        };
        let first = live.seen();
        live.history.push(first, MOST);
        Ok(live)
    }

    /// The same scene from its start.
    pub(crate) fn reset(&mut self) -> Result<(), Error> {
        let epoch = self.scenery.epoch + 1;
        *self = Self::build(&self.path, self.scene.clone(), epoch)?;
        Ok(())
    }

    pub(crate) fn title(&self) -> String {
        self.path.file_stem().map_or_else(|| "scene".into(), |name| name.to_string_lossy().into_owned())
    }

    pub(crate) fn scenery(&self) -> &Arc<Scenery> {
        &self.scenery
    }

    pub(crate) fn cameras(&self) -> &[SceneCamera] {
        &self.cameras
    }

    pub(crate) fn range(&self) -> Range {
        let (first, last) = self.history.frames().unwrap_or_default();
        Range { first, last, planned: self.scene.frames, grows: true }
    }

    pub(crate) fn rate(&self) -> f64 {
        f64::from(self.running.world.settings().rate)
    }

    /// Bytes of history, and how many there may be.
    pub(crate) fn history(&self) -> (usize, usize) {
        (self.history.bytes(), MOST)
    }

    /// One step.
    pub(crate) fn advance(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        self.running.before_step(self.frame)?;
        for (body, spring) in self.grabs.values() {
            self.running.world.pull(*body, spring)?;
        }
        self.running.world.step();
        self.step_time = start.elapsed();
        self.frame += 1;
        let moment = self.seen();
        self.history.push(moment, MOST);
        Ok(())
    }

    /// The world as it is.
    fn seen(&mut self) -> Moment {
        let (world, scenery) = (&self.running.world, Arc::clone(&self.scenery));
        let ids = world.ids();
        let mut positions = vec![f32::NAN; 3 * ids.len()];
        let mut rotations = vec![f32::NAN; 4 * ids.len()];
        world.single_poses(scenery.origin, &mut positions, &mut rotations);
        let mut asleep = world.sleeping();
        if !ids.iter().map(|id| &id.0).eq(&scenery.ids) {
            // Some are yet to come.
            let n = scenery.ids.len();
            let (mut p, mut q, mut s) = (vec![f32::NAN; 3 * n], vec![f32::NAN; 4 * n], vec![false; n]);
            for (k, row) in ids.iter().enumerate().filter_map(|(k, id)| Some((k, scenery.row(id.0)?))) {
                p[3 * row..3 * row + 3].copy_from_slice(&positions[3 * k..3 * k + 3]);
                q[4 * row..4 * row + 4].copy_from_slice(&rotations[4 * k..4 * k + 4]);
                s[row] = asleep[k];
            }
            (positions, rotations, asleep) = (p, q, s);
        }
        let (records, far) = scenery.records(&mut self.grid, &positions, &rotations, &asleep);
        let time = self.frame as f64 / self.rate();
        Moment { frame: self.frame, time, step: self.grid.step, records: Arc::new(records), far, scenery }
    }

    pub(crate) fn moment(&self, frame: u64) -> Result<Arc<Moment>, Error> {
        let found = self.history.at(frame).cloned();
        found.ok_or_else(|| Error::Refused(format!("frame {frame} is not kept any more")))
    }

    pub(crate) fn sight(&self, frame: u64) -> Result<Sight, Error> {
        if frame != self.frame {
            let why = "of what has been, places alone are kept; go to the newest frame";
            return Err(Error::Refused(why.into()));
        }
        Ok(Sight::of_world(&self.scene, &self.running, frame))
    }

    /// A viewer takes hold of the body in a row at a point of the world.
    pub(crate) fn grab(&mut self, viewer: u64, row: usize, at: DVec3) -> Result<(), Error> {
        let id = self.body(row)?;
        let world = &self.running.world;
        if !at.is_finite() {
            return Err(Error::Refused("the point is no point".into()));
        }
        let mass = world.mass(id)?;
        if !mass.is_finite() {
            return Err(Error::Refused("nobody moves this body".into()));
        }
        let at_body = world.pose(id)?.inverse_point(at);
        let most = STRENGTH * 9.81 * mass;
        let spring = Spring { at: at_body, to: at, hertz: HERTZ, damping: DAMPING, most };
        self.grabs.insert(viewer, (id, spring));
        Ok(())
    }

    /// Pulls what the viewer holds.
    pub(crate) fn pull(&mut self, viewer: u64, to: DVec3) -> Result<(), Error> {
        if !to.is_finite() {
            return Err(Error::Refused("the point is no point".into()));
        }
        if let Some((_, spring)) = self.grabs.get_mut(&viewer) {
            spring.to = to;
        }
        Ok(())
    }

    pub(crate) fn release(&mut self, viewer: u64) {
        self.grabs.remove(&viewer);
    }

    /// Whether anybody holds a body.
    pub(crate) fn is_held(&self) -> bool {
        !self.grabs.is_empty()
    }

    /// Throws a ball.
    pub(crate) fn throw(&mut self, from: DVec3, velocity: Vec3, radius: f32) -> Result<(), Error> {
        let thrown = self.toys.throw(&mut self.running, from, velocity, radius);
        self.take_in();
        thrown
    }

    /// Drops boxes.
    pub(crate) fn pile(&mut self, over: DVec3, size: f32, count: u32) -> Result<(), Error> {
        let dropped = self.toys.pile(&mut self.running, over, size, count);
        self.take_in();
        dropped
    }

    /// The table learns of bodies that were added.
    fn take_in(&mut self) {
        let (known, rows) = (self.scenery.ids.len(), self.running.body_table());
        if rows.len() == known {
            return;
        }
        // What was added stands behind all others, with larger ids.
        let added: Vec<Row> = rows[known..].iter().map(|body| row(&self.running, body)).collect();
        let (scenery, shapes) = (Arc::make_mut(&mut self.scenery), shown(&self.running));
        added.iter().for_each(|row| scenery.add(&shapes, *row));
        let moment = self.seen();
        self.history.replace_last(moment, MOST);
    }

    /// Other settings.
    pub(crate) fn set(
        &mut self,
        gravity: Option<Vec3>,
        solver: Option<Solver>,
        substeps: Option<u32>,
    ) -> Result<(), Error> {
        let old = *self.running.world.settings();
        let settings = Settings {
            gravity: gravity.unwrap_or(old.gravity),
            solver: solver.unwrap_or(old.solver),
            substeps: substeps.unwrap_or(old.substeps),
            ..old
        };
        Ok(self.running.world.set_settings(settings)?)
    }

    /// Another surface of a material.
    pub(crate) fn set_material(
        &mut self,
        index: usize,
        friction: Option<f32>,
        restitution: Option<f32>,
    ) -> Result<(), Error> {
        let Some(&id) = self.running.materials().get(index) else {
            return Err(Error::Refused(format!("the scene has no material number {index}")));
        };
        let mut material = self.running.world.material(id)?;
        material.friction = friction.unwrap_or(material.friction);
        material.restitution = restitution.unwrap_or(material.restitution);
        Ok(self.running.world.set_material(id, material)?)
    }

    fn body(&self, row: usize) -> Result<BodyId, Error> {
        let id = self.scenery.ids.get(row).copied().map(BodyId);
        id.ok_or_else(|| Error::Refused(format!("there is no body in row {row}")))
    }
}

/// What is to be seen of bodies: meshes in place of shapes, and behind them the shapes, of which there may be more later.
fn shown(running: &Running) -> Vec<Shape> {
    running.visuals().iter().chain(running.world.shapes()).cloned().collect()
}

fn row(running: &Running, body: &BodyRow) -> Row {
    let shape = running.visuals().len() + body.shape;
    let shown = body.look.visual.map_or(shape, |visual| visual as usize);
    Row { id: body.id, shown, kind: body.kind, sensor: body.sensor }
}

/// The table of a world that has just been built.
fn lay_out(running: &Running, epoch: u32) -> Scenery {
    let mut rows: Vec<Row> = running.body_table().iter().map(|body| row(running, body)).collect();
    rows.sort_by_key(|row| row.id);
    let world = &running.world;
    let place = |(id, pose): (BodyId, Pose)| {
        let found = rows.binary_search_by_key(&id.0, |row| row.id).ok()?;
        Some((rows[found].shown, pose))
    };
    let places: Vec<_> = world.ids().into_iter().zip(world.poses()).filter_map(place).collect();
    // A scene that is all poured has nobody at first; the sizes of what will come are better than nothing.
    let mut scenery = Scenery::new(&shown(running), &rows, &places);
    scenery.epoch = epoch;
    scenery
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::MeshKind;
    use rockfall::Kind;
    use std::fs;

    const SCENE: &str = r#"
[shapes]
floor = { kind = "half-space" }
cube = { kind = "box", size = [1, 1, 1] }

[[bodies]]
shape = "floor"
[[bodies]]
name = "cube"
shape = "cube"
position = [0, 0, 0.5]

[[generators]]
kind = "pour"
shape = "cube"
count = 5
rate = 10
region = { min = [4, 4, 2], max = [8, 8, 6] }
"#;

    fn live() -> Live {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("small.toml");
        fs::write(&path, SCENE).unwrap();
        Live::open(&path, 1).unwrap()
    }

    #[test]
    fn to_look_changes_no_bit() {
        let (mut live, mut plain) = (live(), live().scene.build().unwrap());
        for frame in 0..60 {
            live.advance().unwrap();
            live.sight(live.frame).unwrap();
            plain.before_step(frame).unwrap();
            plain.world.step();
        }
        assert_eq!(live.running.world.hash(), plain.world.hash());
        assert_eq!(live.range(), Range { first: 0, last: 60, planned: 300, grows: true });
        assert!(live.sight(3).is_err());
    }

    #[test]
    fn what_is_pulled_comes_and_what_is_thrown_is_in_the_table() {
        let mut live = live();
        live.grab(1, 1, DVec3::new(0.0, 0.0, 1.0)).unwrap();
        live.pull(1, DVec3::new(0.0, 3.0, 3.0)).unwrap();
        (0..120).for_each(|_| live.advance().unwrap());
        // It hangs from the point by which it was taken, and swings.
        let held = live.running.world.pose(live.body(1).unwrap()).unwrap().point(Vec3::new(0.0, 0.0, 0.5));
        assert!((held - DVec3::new(0.0, 3.0, 3.0)).length() < 0.1, "{held}");
        live.release(1);
        assert!(live.grab(1, 0, DVec3::ZERO).is_err(), "the ground stays");
        let before = live.scenery.bodies.len();
        live.throw(DVec3::new(0.0, 0.0, 9.0), Vec3::new(5.0, 0.0, 0.0), 0.5).unwrap();
        live.pile(DVec3::new(20.0, 0.0, 0.0), 0.5, 64).unwrap();
        assert_eq!(live.scenery.bodies.len(), before + 65);
        let moment = live.moment(live.frame).unwrap();
        assert!(moment.records[before..].iter().all(|record| *record != crate::wire::ABSENT));
        (0..120).for_each(|_| live.advance().unwrap());
        assert_eq!(live.sight(live.frame).unwrap().bodies.len(), before + 65);
        assert!(live.throw(DVec3::NAN, Vec3::ZERO, 0.5).is_err());
        assert!(live.pile(DVec3::ZERO, 0.5, 100_000).is_err());
    }

    #[test]
    fn a_visual_is_shown_in_place_of_a_shape_also_when_shapes_are_added() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("roof.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 1 4 3\n")
            .unwrap();
        let path = folder.path().join("small.toml");
        let text = SCENE.replace("name = \"cube\"\n", "name = \"cube\"\nvisual = { file = \"roof.obj\" }\n");
        fs::write(&path, text).unwrap();
        let mut live = Live::open(&path, 1).unwrap();
        let mesh = |live: &Live, row: usize| {
            let mesh = &live.scenery.meshes[live.scenery.bodies[row].mesh as usize];
            (mesh.kind, mesh.surface.triangles.len())
        };
        let [roof, cube] = [mesh(&live, 1), mesh(&live, 2)];
        assert_eq!((roof, cube.1), ((MeshKind::Flat, 2), 12));
        assert!(live.scenery.bodies[1].open && !live.scenery.bodies[2].open);
        live.throw(DVec3::new(0.0, 0.0, 9.0), Vec3::X, 0.5).unwrap();
        assert_eq!(mesh(&live, 7).0, MeshKind::Ball);
        assert_eq!([mesh(&live, 1), mesh(&live, 2)], [roof, cube]);
    }

    #[test]
    fn settings_and_materials_change_and_a_reset_brings_them_back() {
        let mut live = live();
        live.set(Some(Vec3::ZERO), Some(Solver::Impulse), Some(7)).unwrap();
        live.set_material(0, Some(0.9), None).unwrap();
        let settings = *live.running.world.settings();
        assert_eq!((settings.gravity, settings.solver, settings.substeps), (Vec3::ZERO, Solver::Impulse, 7));
        assert!(live.set(None, None, Some(0)).is_err());
        assert!(live.set_material(99, None, None).is_err());
        assert!(live.set_material(0, Some(f32::NAN), None).is_err());
        live.advance().unwrap();
        live.reset().unwrap();
        assert_eq!(live.running.world.settings().substeps, 4);
        assert_eq!(live.frame, 0);
        assert_eq!(live.running.world.material(live.running.materials()[0]).unwrap().friction, 0.6);
        assert_eq!(live.running.world.kinds().iter().filter(|kind| **kind == Kind::Dynamic).count(), 1);
    }
}
