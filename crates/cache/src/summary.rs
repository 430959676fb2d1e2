//! `summary.json`: what was run, how it ended, and the figures that matter.

use crate::Error;
use crate::seal::{is_sound, seal};
use crate::store::write_whole;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The value of `format`.
pub const FORMAT: &str = "rockfall-run";

/// The version of the schema; a field that is added does not change it, one that changes its meaning does.
pub const VERSION: u32 = 1;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It goes on, or the program was killed.
    #[default]
    Running,
    /// All frames are there.
    Finished,
    /// Somebody stopped it after a complete frame.
    Interrupted,
    /// An error stopped it after a complete frame.
    Failed,
}

/// A run in figures. Units are part of the names; times are of the wall clock unless said otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub format_version: u32,
    /// Version of the program.
    pub rockfall: String,
    /// How the run ended.
    pub status: Status,
    /// The scene file as it was given.
    pub scene: String,
    /// [`checksum`](crate::checksum) of `scene.toml`; empty in runs of versions that had none.
    #[serde(default)]
    pub scene_checksum: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Name of the solver.
    pub solver: String,
    /// Sub-steps in a step.
    pub substeps: u32,
    /// Steps per simulated second; a step is one frame.
    pub frames_per_second: f64,
    /// Threads of the simulation.
    pub threads: usize,
    /// SIMD lanes.
    pub lanes: usize,
    /// Bodies in the table, those that came later included.
    pub bodies: usize,
    /// Steps that were asked for.
    pub frames_planned: u64,
    /// Steps that are done. The trajectory has one frame more: the start.
    pub frames: u64,
    /// Simulated time, seconds.
    pub simulated_s: f64,
    /// Hash of the last state, 16 hexadecimal digits: ids, poses and velocities of all bodies.
    pub hash: String,
    /// The last step.
    pub last: Final,
    /// All steps.
    pub whole: Whole,
    /// Invariants that were broken in some frame; see `docs/run.md`.
    #[serde(default)]
    pub broken: Vec<Breach>,
}

/// An invariant that was broken.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Breach {
    /// `momentum`, `energy` or `friction`.
    pub invariant: String,
    /// In so many frames.
    pub frames: u64,
    /// The first of them.
    pub first: u64,
    /// The largest error of any frame, in the unit of its column of `frames.csv`.
    pub worst: f64,
}

/// Figures of the last step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Final {
    /// Bodies in the world.
    pub bodies: usize,
    /// Dynamic bodies that are awake.
    pub awake: usize,
    /// Bodies that were frozen because their state was not finite.
    pub frozen: usize,
    /// Pairs of bodies that touch.
    pub touching: usize,
    /// Contact points.
    pub contacts: usize,
    /// Largest overlap, metres.
    pub deepest_penetration_m: f64,
    /// Mean overlap of the points that overlap, metres.
    pub mean_penetration_m: f64,
    /// Joule.
    #[serde(rename = "kinetic_energy_J")]
    pub kinetic_energy: f64,
    /// Joule, zero at the origin.
    #[serde(rename = "potential_energy_J")]
    pub potential_energy: f64,
    /// kg m/s.
    pub momentum_kg_m_s: [f64; 3],
    /// About the origin, kg m²/s.
    pub angular_momentum_kg_m2_s: [f64; 3],
}

/// Figures of the whole run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Whole {
    /// Largest overlap of all steps, metres.
    pub deepest_penetration_m: f64,
    /// Most contact points of a step.
    pub most_contacts: usize,
    /// Reading the scene and building the world, seconds.
    pub load_s: f64,
    /// All of it but loading, seconds.
    pub wall_s: f64,
    /// In `step()`, seconds.
    pub step_s: f64,
    /// That the simulation waited for the disk, seconds.
    pub wait_for_disk_s: f64,
    /// Half of the steps were faster, milliseconds.
    pub median_step_ms: f64,
    /// The slowest step, milliseconds.
    pub slowest_step_ms: f64,
    /// Bodies times steps per second of `step()`.
    pub body_steps_per_s: f64,
    /// Time of each stage, summed over all steps, seconds.
    pub stages_s: BTreeMap<String, f64>,
    /// Bytes that the world held at the end.
    pub world_memory_bytes: u64,
    /// The most memory that the program had at a time, bytes; absent where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

impl Summary {
    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_whole(path, self.to_json().as_bytes())
    }

    /// The text of `summary.json`, with its checksum.
    pub fn to_json(&self) -> String {
        // Only maps with keys that are not text can fail to become JSON, and there is none.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        seal(&mut value, &[]);
        let mut text = serde_json::to_string_pretty(&value).unwrap_or_default();
        text.push('\n');
        text
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Damaged`], [`Error::Version`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        /// What every version has.
        #[derive(Deserialize)]
        struct Head {
            format: String,
            format_version: u32,
        }
        let text = fs::read(path).map_err(|error| Error::io("read", path, &error))?;
        let head: Head = serde_json::from_slice(&text).map_err(|error| Error::damaged(path, error))?;
        if head.format != FORMAT {
            return Err(Error::damaged(path, format!("format is `{}`, expected `{FORMAT}`", head.format)));
        }
        if head.format_version > VERSION {
            return Err(Error::Version { path: path.to_owned(), found: head.format_version });
        }
        let value = serde_json::from_slice(&text).map_err(|error| Error::damaged(path, error))?;
        if !is_sound(value, &[]) {
            return Err(Error::damaged(path, "its checksum is another one"));
        }
        serde_json::from_slice(&text).map_err(|error| Error::damaged(path, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_back_what_it_wrote_and_names_units() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.json");
        let summary = Summary {
            format: FORMAT.into(),
            format_version: VERSION,
            status: Status::Interrupted,
            seed: u64::MAX,
            last: Final { kinetic_energy: 0.1, ..Final::default() },
            whole: Whole { stages_s: [("touch".into(), 1.5)].into(), ..Whole::default() },
            ..Summary::default()
        };
        summary.write(&path).unwrap();
        assert_eq!(Summary::read(&path).unwrap(), summary);
        let text = fs::read_to_string(&path).unwrap();
        for line in ["\"status\": \"interrupted\"", "\"kinetic_energy_J\": 0.1", "\"touch\": 1.5"] {
            assert!(text.contains(line), "{line} in {text}");
        }
        fs::write(&path, text.replace("_J\": 0.1", "_J\": 0.2")).unwrap();
        let error = Summary::read(&path).unwrap_err();
        assert!(error.to_string().ends_with("its checksum is another one"), "{error}");
    }

    #[test]
    fn other_files_and_later_versions_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.json");
        let read = |text: &str| {
            fs::write(&path, text).unwrap();
            Summary::read(&path).unwrap_err()
        };
        assert!(matches!(read("{"), Error::Damaged { .. }));
        assert!(matches!(read(r#"{"format": "x", "format_version": 1}"#), Error::Damaged { .. }));
        assert!(matches!(
            read(r#"{"format": "rockfall-run", "format_version": 2}"#),
            Error::Version { found: 2, .. }
        ));
    }
}
