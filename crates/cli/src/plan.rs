//! What a scene will need, without running it.

use crate::args::solver_name;
use crate::units;
use rockfall_scene::{Cut, Scene};
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::time::Duration;

/// A pose on disk before compression: seven single-precision numbers.
const POSE_BYTES: u64 = 28;
/// Velocities, where they are written: six of them.
const VELOCITY_BYTES: u64 = 24;
/// A number of a further column, at most.
const COLUMN_BYTES: u64 = 4;
/// A row of `frames.csv`, about.
const ROW_BYTES: u64 = 500;
/// Id, shape, scale, a short name, and the state at the end.
const BODY_BYTES: u64 = 96;

/// What `--dry-run` and `info` say of a scene.
#[derive(Debug, Serialize)]
pub(crate) struct Plan {
    scene: String,
    bodies: u64,
    shapes: u64,
    frames: u64,
    frames_per_second: f64,
    simulated_s: f64,
    solver: &'static str,
    substeps: u32,
    seed: u64,
    memory_bytes: u64,
    disk_bytes: u64,
    /// Contacts, of which nobody knows how many there will be, are not among them.
    #[serde(skip)]
    contacts: bool,
    /// What files of other programs hold and the scene can't have, and what was taken for something else.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
    /// Meshes that are cut into hulls; `info` alone cuts them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    cuts: Vec<CutRow>,
}

/// How a mesh was cut into hulls.
#[derive(Debug, Serialize)]
struct CutRow {
    shape: String,
    hulls: usize,
    /// The farthest that the mesh is from the hulls, and the hulls from the mesh, at points so far apart.
    missing_m: f32,
    filled_m: f32,
    spacing_m: f32,
}

impl Plan {
    /// Of the scene that was read from `path`.
    pub(crate) fn new(path: &Path, scene: &Scene) -> Self {
        let estimate = scene.estimate();
        let rate = f64::from(scene.settings.rate);
        let poses = (scene.frames + 1).saturating_mul(estimate.bodies);
        let velocities = if scene.output.velocities { VELOCITY_BYTES } else { 0 };
        let columns = COLUMN_BYTES * scene.output.columns.len() as u64;
        let disk = poses
            .saturating_mul(POSE_BYTES + velocities + columns)
            .saturating_add(scene.frames.saturating_mul(ROW_BYTES))
            .saturating_add(estimate.bodies.saturating_mul(BODY_BYTES));
        Plan {
            scene: path.display().to_string(),
            bodies: estimate.bodies,
            shapes: estimate.shapes,
            frames: scene.frames,
            frames_per_second: rate,
            simulated_s: scene.frames as f64 / rate,
            solver: solver_name(scene.settings.solver),
            substeps: scene.settings.substeps,
            seed: scene.seed,
            memory_bytes: estimate.memory,
            disk_bytes: disk,
            contacts: scene.output.contacts.is_some(),
            notes: scene.notes(),
            cuts: Vec::new(),
        }
    }

    /// The same with what is known of meshes that were cut into hulls.
    pub(crate) fn with_cuts(self, cuts: Vec<Cut>) -> Self {
        let row = |cut: Cut| CutRow {
            shape: cut.shape,
            hulls: cut.hulls,
            missing_m: cut.misfit.missing,
            filled_m: cut.misfit.filled,
            spacing_m: cut.misfit.spacing,
        };
        Plan { cuts: cuts.into_iter().map(row).collect(), ..self }
    }

    /// As JSON.
    pub(crate) fn to_json(&self) -> String {
        // Only maps with keys that are not text can fail to become JSON, and there is none.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = units::time(Duration::try_from_secs_f64(self.simulated_s).unwrap_or(Duration::MAX));
        writeln!(f, "{}", self.scene)?;
        writeln!(f, "  bodies   {}", units::count(self.bodies))?;
        writeln!(f, "  shapes   {}", units::count(self.shapes))?;
        writeln!(
            f,
            "  frames   {}, {time} at {} per second",
            units::count(self.frames),
            self.frames_per_second
        )?;
        writeln!(f, "  solver   {}, {} sub-steps", self.solver, self.substeps)?;
        writeln!(f, "  seed     {}", self.seed)?;
        writeln!(f, "  memory   about {}", units::bytes(self.memory_bytes))?;
        write!(f, "  disk     at most {}", units::bytes(self.disk_bytes))?;
        if self.contacts {
            write!(f, ", and contacts")?;
        }
        for note in &self.notes {
            write!(f, "\n  note     {note}")?;
        }
        for cut in &self.cuts {
            let millimetres = [cut.missing_m, cut.filled_m, cut.spacing_m].map(|x| 1e3 * x);
            let [missing, filled, spacing] = millimetres;
            write!(
                f,
                "\n  {}: {} hulls, {missing:.3} mm missing and {filled:.3} mm filled at most, at points every {spacing:.3} mm",
                cut.shape, cut.hulls
            )?;
        }
        Ok(())
    }
}
