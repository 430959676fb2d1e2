//! `state.zarr`: where bodies are at one moment and how fast, to the bit.
//!
//! | array | type | shape | what |
//! |---|---|---|---|
//! | `id` | uint64 | body | stable id, ascending |
//! | `position` | float64 | body, 3 | metres, in the world |
//! | `orientation` | float32 | body, 4 | unit quaternion x, y, z, w, body to world |
//! | `velocity` | float32 | body, 3 | metres per second, of the centre of mass |
//! | `angular_velocity` | float32 | body, 3 | radians per second |
//!
//! A run that ends leaves that of its last frame, since a trajectory may have no velocities, and poses within a bound. Another run can begin with it.

use crate::group::Group;
use crate::store::{WholeFiles, absent_is_fine, part_of, sync_folder};
use crate::trajectory::{CHUNK_BODIES, Layout, attributes};
use crate::{Error, RunReader, mean_velocities};
use rockfall::World;
use rockfall_math::{DVec3, Pose, Quat, Vec3};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use zarrs::array::data_type;
use zarrs::group::GroupBuilder;

/// The version of this layout, the group's attribute `rockfall_state`.
const LAYOUT: u64 = 1;

/// What is said of a group.
type Attributes = Map<String, Value>;

/// Bodies at one frame. All columns have a row for each that is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Number of the frame in its run.
    pub frame: u64,
    /// Hash of the state; 0 where it is not known.
    pub hash: u64,
    /// Ascending.
    pub ids: Vec<u64>,
    /// Poses of the frames of the shapes.
    pub poses: Vec<Pose>,
    /// Linear (m/s) and angular (rad/s) velocities.
    pub velocities: Vec<(Vec3, Vec3)>,
    /// Of which point the linear ones are.
    pub velocity_of: VelocityOf,
}

/// The point of a body whose velocity is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VelocityOf {
    /// The centre of mass, at that very moment.
    #[default]
    CenterOfMass,
    /// The origin of the shape's frame, as a mean over a step.
    ShapeFrame,
}

impl VelocityOf {
    fn word(self) -> &'static str {
        match self {
            VelocityOf::CenterOfMass => "center of mass",
            VelocityOf::ShapeFrame => "frame of the shape, mean over a step",
        }
    }
}

impl State {
    /// That of a world after the frame `frame`.
    pub fn of(world: &World, frame: u64) -> Self {
        State {
            frame,
            hash: world.hash(),
            ids: world.ids().iter().map(|id| id.0).collect(),
            poses: world.poses(),
            velocities: world.velocities(),
            velocity_of: VelocityOf::CenterOfMass,
        }
    }

    /// That of a frame of a run: to the bit where the run ended there, else what the trajectory has of it. Where that has no velocities, they are
    /// means over the step that led to the frame; of a body that was not there before it, over the one that follows; else zero.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn of_run(run: &RunReader, frame: u64) -> Result<Self, Error> {
        let frames = run.frames()?;
        if frame >= frames {
            return Err(Error::NoFrame { frame, frames });
        }
        if let Some(end) = run.end()?.filter(|end| end.frame == frame) {
            return Ok(end);
        }
        let (table, poses, origin) = (run.bodies()?, run.poses(frame)?, run.origin()?);
        let hash = run.hashes()?.get(frame as usize).copied().unwrap_or_default();
        let times = run.times()?;
        let timed =
            |frame: u64| Ok((times.get(frame as usize).copied().unwrap_or(f64::NAN), run.poses(frame)?));
        let stored = run.velocities(frame)?;
        let (mut before, mut after) = (None, None);
        if stored.is_none() {
            before = frame.checked_sub(1).map(timed).transpose()?;
            after = Some(frame + 1).filter(|&next| next < times.len() as u64).map(timed).transpose()?;
        }
        let now = (times.get(frame as usize).copied().unwrap_or(f64::NAN), poses);
        let velocity_of = if stored.is_some() { VelocityOf::CenterOfMass } else { VelocityOf::ShapeFrame };
        let mut state = State { frame, hash, velocity_of, ..State::default() };
        for (row, &id) in table.ids.iter().enumerate() {
            let at = |(time, poses): &(f64, crate::Poses)| {
                let (position, rotation) = poses.at(row)?;
                Some((*time, position, rotation))
            };
            let Some(here) = at(&now) else { continue };
            let velocities = match &stored {
                Some(stored) => stored.at(row).unwrap_or_default(),
                None => match (before.as_ref().and_then(at), after.as_ref().and_then(at)) {
                    (Some(before), _) => mean_velocities(before, here),
                    (None, Some(after)) => mean_velocities(here, after),
                    (None, None) => (Vec3::ZERO, Vec3::ZERO),
                },
            };
            state.ids.push(id);
            state.poses.push(Pose { position: origin + here.1.as_dvec3(), rotation: here.2 });
            state.velocities.push(velocities);
        }
        Ok(state)
    }

    /// Writes it as the folder `path`, whole or not at all, in place of a former one.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        self.write_with(path, Map::new(), |_| Ok(()))
    }

    /// The same with more attributes, and more in the folder.
    pub(crate) fn write_with(
        &self,
        path: &Path,
        more: Attributes,
        fill: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (part, old) = (part_of(path), part_of(&part_of(path)));
        let remove = |path: &Path| {
            absent_is_fine(fs::remove_dir_all(path)).map_err(|error| Error::io("remove", path, &error))
        };
        remove(&part)?;
        remove(&old)?;
        fs::create_dir(&part).map_err(|error| Error::io("create", &part, &error))?;
        let written = self.fill(&part, more).and_then(|()| fill(&part));
        let moved = written.and_then(|()| {
            // Out of the way first, so that nobody meets half of it.
            absent_is_fine(fs::rename(path, &old))
                .and_then(|()| fs::rename(&part, path))
                .map_err(|error| Error::io("write", path, &error))
        });
        moved.inspect_err(|_| {
            // What is left takes space that a full disk lacks; that it may fail as well changes nothing.
            let _ = fs::remove_dir_all(&part);
        })?;
        remove(&old)?;
        let parent = path.parent().unwrap_or(path);
        sync_folder(parent).map_err(|error| Error::io("write", parent, &error))
    }

    fn fill(&self, folder: &Path, more: Attributes) -> Result<(), Error> {
        let State { frame, hash, ids, poses, velocities, velocity_of } = self;
        let store = Arc::new(WholeFiles::new(folder.to_owned()));
        let mut group = attributes([
            ("rockfall_state", json!(LAYOUT)),
            ("frame", json!(frame)),
            ("hash", json!(format!("{hash:016x}"))),
            ("velocity_of", json!(velocity_of.word())),
            ("up", json!("z")),
            ("handedness", json!("right")),
        ]);
        group.extend(more);
        let built = GroupBuilder::new().attributes(group).build(store.clone(), "/");
        let group = built.map_err(|error| store.explain(error))?;
        group.store_metadata().map_err(|error| store.explain(error))?;
        let bodies = ids.len() as u64;
        let chunk = bodies.clamp(1, CHUNK_BODIES as u64);
        let layout = |width: u64, names| {
            let (mut shape, mut chunks) = (vec![bodies], vec![chunk]);
            if width > 1 {
                shape.push(width);
                chunks.push(width);
            }
            Layout { store: &store, shape, chunk: chunks, names }
        };
        let id = attributes([("description", json!("stable id of the body"))]);
        layout(1, &["body"]).write_whole("id", data_type::uint64(), 0_u64, id, ids)?;
        let (xyz, xyzw) = (&["body", "xyz"], &["body", "xyzw"]);
        let positions: Vec<f64> = poses.iter().flat_map(|pose| pose.position.to_array()).collect();
        let about = attributes([("units", json!("m")), ("axes", json!(["x", "y", "z"]))]);
        layout(3, xyz).write_whole("position", data_type::float64(), f64::NAN, about, &positions)?;
        let turns: Vec<f32> = poses.iter().flat_map(|pose| pose.rotation.to_array()).collect();
        let about = attributes([
            ("units", json!("1")),
            ("axes", json!(["x", "y", "z", "w"])),
            ("description", json!("unit quaternion, body to world")),
        ]);
        layout(4, xyzw).write_whole("orientation", data_type::float32(), f32::NAN, about, &turns)?;
        let of = |which: fn(&(Vec3, Vec3)) -> Vec3| -> Vec<f32> {
            velocities.iter().flat_map(|both| which(both).to_array()).collect()
        };
        for (name, units, values) in
            [("velocity", "m s-1", of(|both| both.0)), ("angular_velocity", "rad s-1", of(|both| both.1))]
        {
            let about = attributes([("units", json!(units)), ("axes", json!(["x", "y", "z"]))]);
            layout(3, xyz).write_whole(name, data_type::float32(), f32::NAN, about, &values)?;
        }
        store.sync()
    }

    /// Reads the folder `path`; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::Damaged`], [`Error::Version`].
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        Ok(Self::read_with(path)?.map(|(state, _)| state))
    }

    /// The same, with the attributes of the group.
    pub(crate) fn read_with(path: &Path) -> Result<Option<(Self, Attributes)>, Error> {
        if !path.is_dir() {
            return Ok(None);
        }
        let group = Group::open(path)?;
        let about = group.attributes()?;
        let number = |name: &str| about.get(name).and_then(Value::as_u64);
        match number("rockfall_state") {
            Some(LAYOUT) => {}
            Some(later) => {
                let found = u32::try_from(later).unwrap_or(u32::MAX);
                return Err(Error::Version { path: path.to_owned(), found });
            }
            None => return Err(group.damaged("zarr.json", "it has no version")),
        }
        let hash =
            about.get("hash").and_then(Value::as_str).and_then(|hex| u64::from_str_radix(hex, 16).ok());
        let word = about.get("velocity_of").and_then(Value::as_str);
        let velocity_of =
            [VelocityOf::CenterOfMass, VelocityOf::ShapeFrame].into_iter().find(|of| word == Some(of.word()));
        let (Some(frame), Some(hash), Some(velocity_of)) = (number("frame"), hash, velocity_of) else {
            return Err(group.damaged("zarr.json", "its frame, its hash or `velocity_of` makes no sense"));
        };
        let ids: Vec<u64> = group.whole("id")?;
        let positions: Vec<f64> = group.whole("position")?;
        let [turns, linear, angular] =
            [group.whole::<f32>("orientation")?, group.whole("velocity")?, group.whole("angular_velocity")?];
        let n = ids.len();
        if [positions.len(), turns.len(), linear.len(), angular.len()] != [3 * n, 4 * n, 3 * n, 3 * n] {
            return Err(group.damaged("id", "the arrays of the bodies differ in length"));
        }
        if !ids.is_sorted_by(|a, b| a < b) {
            return Err(group.damaged("id", "the ids do not ascend"));
        }
        let pose = |(p, q): (&[f64; 3], &[f32; 4])| Pose {
            position: DVec3::from_array(*p),
            rotation: Quat::from_array(*q),
        };
        let vector = |values: &[f32; 3]| Vec3::from_array(*values);
        let state = State {
            frame,
            hash,
            ids,
            poses: positions.as_chunks().0.iter().zip(turns.as_chunks().0).map(pose).collect(),
            velocities: (linear.as_chunks().0.iter().zip(angular.as_chunks().0))
                .map(|(v, w)| (vector(v), vector(w)))
                .collect(),
            velocity_of,
        };
        let sound = |(pose, (v, w)): (&Pose, &(Vec3, Vec3))| {
            pose.position.is_finite()
                && (pose.rotation.length() - 1.0).abs() < 1e-4
                && v.is_finite()
                && w.is_finite()
        };
        if !state.poses.iter().zip(&state.velocities).all(sound) {
            return Err(group.damaged("position", "a body is in a state that no body can have"));
        }
        Ok(Some((state, about)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        let place = |k: u32| Pose {
            position: DVec3::new(1e6 + f64::from(k) / 3.0, 2.0, -3.0),
            rotation: Quat::from_xyzw(0.6, 0.0, 0.0, 0.8),
        };
        State {
            frame: 7,
            hash: 0xfedc_ba98_7654_3210,
            ids: vec![2, 5, u64::MAX - 1],
            poses: (0..3).map(place).collect(),
            velocities: vec![(Vec3::X / 3.0, Vec3::Y), (Vec3::ZERO, Vec3::ZERO), (-Vec3::Z, Vec3::ONE)],
            velocity_of: VelocityOf::ShapeFrame,
        }
    }

    #[test]
    fn every_bit_comes_back_and_a_former_one_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.zarr");
        assert_eq!(State::read(&path).unwrap(), None);
        State::default().write(&path).unwrap();
        assert_eq!(State::read(&path).unwrap(), Some(State::default()));
        state().write(&path).unwrap();
        assert_eq!(State::read(&path).unwrap(), Some(state()));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_damaged_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.zarr");
        state().write(&path).unwrap();
        for (file, reason) in
            [("zarr.json", "checksum"), ("id/zarr.json", "checksum"), ("velocity/c.0.0", "")]
        {
            let file = path.join(file);
            let good = fs::read(&file).unwrap();
            let mut bad = good.clone();
            let at = bad.iter().rposition(|&byte| byte == b'1' || byte > 127).unwrap();
            bad[at] ^= 2;
            fs::write(&file, &bad).unwrap();
            let error = State::read(&path).unwrap_err().to_string();
            assert!(error.contains("is damaged") && error.contains(reason), "{error}");
            fs::remove_file(&file).unwrap();
            assert!(State::read(&path).is_err());
            fs::write(&file, good).unwrap();
        }
        let json = path.join("zarr.json");
        let later =
            fs::read_to_string(&json).unwrap().replace("\"rockfall_state\":1", "\"rockfall_state\":2");
        let mut later: Value = serde_json::from_str(&later).unwrap();
        crate::seal::seal(&mut later, &crate::store::ATTRIBUTES);
        fs::write(&json, later.to_string()).unwrap();
        assert!(matches!(State::read(&path), Err(Error::Version { found: 2, .. })));
    }
}
