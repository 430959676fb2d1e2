//! A small run with everything that exports have to cope with.

use rockfall::BodyId;
use rockfall_cache::{
    BodyTable, Column, Contents, FORMAT, Frame, NumberType, Poses, RunFolder, RunWriter, SUMMARY, Status,
    Summary, VERSION, Values,
};
use rockfall_export::{Done, Error, Format, Frames, Options, Run, Watch, export};
use rockfall_math::{DVec3, Pose, Vec3};
use rockfall_scene::Scene;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use tempfile::TempDir;

/// Bodies of every shape, static, kinematic and dynamic, of two materials and several sizes, of which some come later and some never; an id far from the
/// others, and a name that wants quotes. `{x}` is how far away along x all of it is.
const SCENE: &str = r#"
[world]
frames = 20

[materials.wood]
density = 700
[materials.iron]
density = 7800

[shapes]
floor = { kind = "half-space" }
ramp = { kind = "height-field", heights = [2, 1, 0, 2, 1, 0], columns = 3, spacing = [5, 5] }
ball = { kind = "sphere", radius = 0.25 }
crate = { kind = "box", size = [0.5, 0.4, 0.3] }
pill = { kind = "capsule", radius = 0.15, length = 0.4 }
barrel = { kind = "cylinder", radius = 0.2, length = 0.6 }
cone = { kind = "cone", radius = 0.3, length = 0.6 }
pebble = { kind = "ellipsoid", size = [0.7, 0.5, 0.3] }
die = { kind = "rounded-box", size = [0.3, 0.3, 0.3], radius = 0.07 }
rocks = { kind = "boulders", radius = [0.2, 0.3], count = 3 }
soap = { kind = "rounded-hull", points = [[0, 0, 0], [0.4, 0, 0], [0, 0.3, 0], [0.1, 0.1, 0.2]], radius = 0.08 }

[[bodies]]
shape = "floor"
position = [{x}, 0, 0]
[[bodies]]
shape = "ramp"
position = [{x}, 12, 0]
[[bodies]]
name = "post"
shape = "barrel"
kind = "static"
material = "iron"
position = [{x}, 0, 0.3]
rotation = [20, 30, 40]
[[bodies]]
name = "wiper, \"slow\""
shape = "crate"
kind = "kinematic"
position = [{x}, -3, 0.5]
velocity = [0.5, 0, 0]
angular_velocity = [0, 0, 3]
[[bodies]]
id = 5000
shape = "ball"
material = "iron"
position = [{x}, -3, 0.25]
velocity = [-1, 0, 0]

[[generators]]
kind = "pour"
shape = ["ball", "crate", "pill", "barrel", "cone", "pebble", "die", "rocks", "soap"]
size = { min = 0.5, max = 1.5, classes = 3 }
material = "wood"
count = 60
rate = 120
velocity = [0, 0, -5]
angular_velocity = [2, -1, 4]
region = { min = [{from}, -2, 1], max = [{to}, 2, 3] }
"#;

/// A mesh, as the scene finds it.
pub(crate) const HARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/meshes/hare.obj");

/// Frames of the run, the start included.
pub(crate) const FRAMES: u64 = 21;

/// A folder with a run in it.
pub(crate) struct Sample {
    pub(crate) folder: TempDir,
    /// Velocity, at the origin of the shape, and angular velocity of each body by its id, frame by frame.
    pub(crate) motion: Vec<BTreeMap<u64, (Vec3, Vec3)>>,
}

impl Sample {
    /// The run `away` metres from the world's origin, of which so many frames have been written.
    pub(crate) fn new(away: f64, frames: u64) -> Self {
        Self::of(SCENE, away, frames, false)
    }

    /// The same with velocities and columns.
    pub(crate) fn with_motion(away: f64) -> Self {
        Self::of(SCENE, away, FRAMES, true)
    }

    /// The same with static bodies that look alike, in four looks; their ids begin at 6000. One of them has a name and another one a shape of its own.
    pub(crate) fn with_crowd(away: f64, frames: u64) -> Self {
        let body = |k: u32| {
            let (shape, material) =
                (["crate", "pebble"][k as usize % 2], ["wood", "iron"][k as usize / 2 % 2]);
            let place = format!("[{{x}}, {}, {}]", 20 + k % 7, k / 7);
            format!(
                "[[bodies]]\nid = {}\nshape = \"{shape}\"\nkind = \"static\"\nmaterial = \"{material}\"\nposition = {place}\nrotation = [{}, {}, 0]\n",
                6000 + k,
                7 * k,
                11 * k
            )
        };
        let crowd: String = (0..80).map(body).collect();
        let named = crowd.replacen("id = 6003\n", "id = 6003\nname = \"Instances\"\n", 1);
        Self::of(&format!("{SCENE}{}", named.replacen("\"pebble\"", "\"cone\"", 1)), away, frames, false)
    }

    /// The same with colours of a material, of shapes and of the body 5000, which is seen as the mesh [`HARE`].
    pub(crate) fn with_looks() -> Self {
        let looks =
            format!("id = 5000\ncolor = \"#ff8001\"\nvisual = {{ file = \"{HARE}\", scale = 0.4 }}\n");
        let scene = SCENE
            .replace("id = 5000\n", &looks)
            .replace("density = 7800", "density = 7800\ncolor = \"#30404C\"")
            .replace("kind = \"rounded-box\",", "kind = \"rounded-box\", color = \"#00ff80\",");
        Self::of(&scene, 0.0, FRAMES, false)
    }

    fn of(scene: &str, away: f64, frames: u64, full: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let text = scene.replace("{x}", &away.to_string());
        let text = text.replace("{from}", &(away - 2.0).to_string());
        let text = text.replace("{to}", &(away + 2.0).to_string());
        let scene =
            Scene::parse(&text, "sample.toml", ".").unwrap_or_else(|error| panic!("{}", error.render(false)));
        let mut running = scene.build().unwrap();
        let mut rows = running.body_table().to_vec();
        rows.sort_by_key(|row| row.id);
        let table = BodyTable {
            ids: rows.iter().map(|row| row.id).collect(),
            names: rows.iter().map(|row| row.name.clone().unwrap_or_default()).collect(),
            shapes: rows.iter().map(|row| row.shape as u32).collect(),
            scales: rows.iter().map(|row| row.scale).collect(),
        };
        let origin = DVec3::new(away, 0.0, 0.0);
        let path = folder.path().join("run");
        let summary = Summary {
            format: FORMAT.into(),
            format_version: VERSION,
            frames_per_second: 60.0,
            bodies: table.len(),
            ..Summary::default()
        };
        let run = RunFolder::at(&path, false).unwrap();
        let column = |name: &str, numbers| Column {
            name: name.into(),
            numbers,
            units: "1".into(),
            description: String::new(),
        };
        let columns = vec![column("contact_count", NumberType::U32), column("size", NumberType::F64)];
        let contents = match full {
            true => Contents { origin, velocities: true, columns, ..Contents::default() },
            false => Contents::from(origin),
        };
        let text = scene.to_toml_filled();
        let mut writer = RunWriter::create(&run, &text, &summary, &table, contents).unwrap();
        let mut motion = Vec::new();
        for frame in 0..frames {
            if frame > 0 {
                running.before_step(frame - 1).unwrap();
                running.world.step();
            }
            let mut poses = Poses::default();
            let world = &running.world;
            let (ids, places, speeds) = (world.ids(), world.poses(), world.velocities());
            poses.gather(&table, origin, &ids, &places).unwrap();
            let mut frame_of_run = Frame::default();
            if full {
                frame_of_run.velocities.gather(&table, &ids, &speeds).unwrap();
                let (count, size): (Vec<u32>, Vec<f64>) =
                    ids.iter().map(|id| ((id.0 * (frame + 1)) as u32, id.0 as f64 / 3.0)).unzip();
                frame_of_run.columns = vec![
                    Values::gather(&table, &ids, &count).unwrap(),
                    Values::gather(&table, &ids, &size).unwrap(),
                ];
            }
            let centers: BTreeMap<u64, DVec3> =
                world.row_ids().iter().copied().zip(world.centers_of_mass().iter().copied()).collect();
            let at_origin = |((id, pose), (v, w)): ((&BodyId, &Pose), &(Vec3, Vec3))| {
                (id.0, (*v + w.cross((pose.position - centers[&id.0]).as_vec3()), *w))
            };
            motion.push(ids.iter().zip(&places).zip(&speeds).map(at_origin).collect());
            let report = (frame > 0).then(|| running.world.report().clone());
            let time = report.as_ref().map_or(0.0, |report| report.time);
            writer.push(Frame { time, poses, report, ..frame_of_run }).unwrap();
        }
        writer.finish().unwrap();
        // One that is not whole says that it goes on, as after a kill.
        let status = if frames == FRAMES { Status::Finished } else { Status::Running };
        Summary { status, ..summary }.write(&path.join(SUMMARY)).unwrap();
        Sample { folder, motion }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn run(&self) -> Run {
        Run::open(&self.path("run")).unwrap()
    }

    /// Exports some frames to `name`.
    pub(crate) fn export(&self, format: &dyn Format, frames: &str, name: &str) -> Result<Done, Error> {
        let options = Options {
            frames: if frames.is_empty() { Frames::default() } else { frames.parse().unwrap() },
            to: Some(self.path(name)),
            threads: Some(2),
            ..Options::default()
        };
        export(&self.run(), format, &options, &Counter::default())
    }
}

/// Counts frames, and stops the export at one of them.
pub(crate) struct Counter {
    pub(crate) seen: AtomicU64,
    pub(crate) stop_at: u64,
}

impl Default for Counter {
    fn default() -> Self {
        Counter { seen: AtomicU64::new(0), stop_at: u64::MAX }
    }
}

impl Watch for Counter {
    fn wrote(&self, frames: u64) {
        self.seen.fetch_add(frames, Ordering::Relaxed);
    }

    fn stopped(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.stop_at
    }
}
