//! A scene as the command line wants it.

use crate::args::RunArgs;
use crate::exit::Failure;
use rockfall::math::lanes::Width;
use rockfall_scene::Scene;
use std::path::Path;
use std::thread::available_parallelism;

/// Reads the scene at `path` and puts the options in place of what it says. Threads and lanes become the numbers that are used.
pub(crate) fn open(path: &Path, args: &RunArgs) -> Result<Scene, Failure> {
    let mut scene = Scene::load(path)?;
    if let Some(frames) = args.frames {
        scene.override_frames(frames);
    }
    if let Some(solver) = args.solver {
        scene.override_solver(solver.into());
    }
    if let Some(substeps) = args.substeps {
        scene.override_substeps(substeps);
    }
    if let Some(seed) = args.seed {
        scene.override_seed(seed);
    }
    if let Some(bound) = args.position_error {
        scene.override_position_error(bound);
    }
    if let Some(bound) = args.rotation_error {
        scene.override_rotation_error(bound);
    }
    let all = || available_parallelism().map_or(1, usize::from);
    scene.settings.threads = args.threads.map_or_else(all, usize::from);
    scene.settings.lanes = Width::new(args.lanes.unwrap_or(0)).lanes();
    Ok(scene)
}

/// The scene's file without folder and extension.
pub(crate) fn name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
}
