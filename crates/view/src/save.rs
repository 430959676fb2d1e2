//! What is shown, as a scene that begins with it.

use crate::Error;
use crate::live::Live;
use crate::recorded::Recording;
use crate::source::{Kind, Source};
use rockfall::{Settings, Shape};
use rockfall_cache::{SCENE, START, Start, State};
use rockfall_scene::{Scene, material_table, world_table};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes the frame that is shown as a scene in a new folder within `folder`, and says where it is and what is not in it.
pub(crate) fn save(source: &Source, frame: u64, folder: &Path) -> Result<String, Error> {
    let place = new_folder(folder, &format!("{}-{frame}", source.title()))?;
    let left_out = match &source.0 {
        Kind::Live(live) => of_live(live, frame, &place)?,
        Kind::Recorded(run) => {
            of_run(run, frame, &place)?;
            None
        }
    };
    let file = place.join(SCENE);
    Ok(format!("saved as {}{}", file.display(), left_out.map(|text| format!("; {text}")).unwrap_or_default()))
}

/// The state to the bit, with what was changed of settings and materials, and the bodies that viewers have added.
fn of_live(live: &Live, frame: u64, place: &Path) -> Result<Option<String>, Error> {
    if frame != live.frame {
        let why = "of what has been, places alone are kept: go to the newest frame to save it";
        return Err(Error::Refused(why.into()));
    }
    let world = &live.running.world;
    let toys: BTreeSet<u64> = live.toys.bodies.iter().map(|id| id.0).collect();
    let mut state = State::of(world, frame);
    let kept: Vec<usize> = (0..state.ids.len()).filter(|&k| !toys.contains(&state.ids[k])).collect();
    state.ids = kept.iter().map(|&k| state.ids[k]).collect();
    state.poses = kept.iter().map(|&k| state.poses[k]).collect();
    state.velocities = kept.iter().map(|&k| state.velocities[k]).collect();
    if !toys.is_empty() {
        // The hash is that of all of them.
        state.hash = 0;
    }
    let rows = live.running.body_table();
    let last_id = rows.iter().map(|row| row.id).filter(|id| !toys.contains(id)).max().unwrap_or_default();
    let start = Start {
        run: place.to_owned(),
        scene: live.scene.to_toml_filled(),
        last_id,
        state,
        start: live.scene.start().cloned().map(Box::new),
    };
    let names = live.scene.materials();
    let distinct = names.iter().collect::<BTreeSet<_>>().len() == names.len();
    let mut text = begin(world.settings(), live.scene.frames, live.scene.seed);
    let of_scene = if distinct { "scene" } else { "run" };
    let _ = write!(
        text,
        "\n[start]\nrun = {}\nframe = {frame}\nmaterials = \"{of_scene}\"\n",
        quoted(&place.display().to_string())
    );
    if distinct {
        for ((name, id), color) in names.iter().zip(live.running.materials()).zip(live.running.colors()) {
            let _ = write!(text, "\n{}", material_table(name, &world.material(*id)?, *color));
        }
    }
    added(live, &names, &mut text)?;
    start.write(&place.join(START))?;
    write(&place.join(SCENE), &text)?;
    let mut left_out = Vec::new();
    if live.running.waiting() > 0 {
        left_out.push(format!("{} bodies that are yet to come are not in it", live.running.waiting()));
    }
    if !distinct {
        left_out.push("two materials have one name: changes of materials are not in it".to_owned());
    }
    Ok((!left_out.is_empty()).then(|| left_out.join("; ")))
}

/// The bodies that viewers have added, and their shapes.
fn added(live: &Live, names: &[String], text: &mut String) -> Result<(), Error> {
    let world = &live.running.world;
    let mut shapes = BTreeSet::new();
    for id in &live.toys.bodies {
        let (pose, (v, w)) = (world.pose(*id)?, world.velocity(*id)?);
        let (name, keys) = match world.shape(*id)? {
            Shape::Sphere { radius } => {
                (format!("added ball {radius}"), format!("kind = \"sphere\"\nradius = {radius}"))
            }
            Shape::Box { half } => {
                let size = half.map(|x| 2.0 * x);
                (
                    format!("added box {}", size.x),
                    format!("kind = \"box\"\nsize = [{}, {}, {}]", size.x, size.y, size.z),
                )
            }
            _ => continue,
        };
        if shapes.insert(name.clone()) {
            let _ = write!(text, "\n[shapes.{}]\n{keys}\n", quoted(&name));
        }
        let material =
            live.running.body_table().iter().find(|row| row.id == id.0).map_or(0, |row| row.material);
        let (p, q) = (pose.position, pose.rotation);
        let _ = write!(
            text,
            "\n[[bodies]]\nid = {}\nshape = {}\nmaterial = {}\nposition = [{}, {}, {}]\nrotation = [{}, {}, {}, {}]\n\
             velocity = [{}, {}, {}]\nangular_velocity = [{}, {}, {}]\n",
            id.0,
            quoted(&name),
            quoted(names.get(material).map_or("default", String::as_str)),
            p.x,
            p.y,
            p.z,
            q.x,
            q.y,
            q.z,
            q.w,
            v.x,
            v.y,
            v.z,
            w.x,
            w.y,
            w.z
        );
    }
    Ok(())
}

/// A scene that begins with a frame of a run, which stays where it is.
fn of_run(run: &Recording, frame: u64, place: &Path) -> Result<(), Error> {
    let path = fs::canonicalize(run.path()).unwrap_or_else(|_| run.path().to_owned());
    let scene = Scene::load(path.join(SCENE))?;
    let mut text = begin(&scene.settings, scene.frames, scene.seed);
    let _ = write!(text, "\n[start]\nrun = {}\nframe = {frame}\n", quoted(&path.display().to_string()));
    write(&place.join(SCENE), &text)
}

fn begin(settings: &Settings, frames: u64, seed: u64) -> String {
    format!("# Saved from the live page.\n\n{}", world_table(settings, frames, seed))
}

/// A folder that is not there yet: the name, or the name and a number. Its path is absolute, since it is that of the run that the scene says it begins with.
fn new_folder(folder: &Path, name: &str) -> Result<PathBuf, Error> {
    let failed = |path: &Path, error: std::io::Error| Error::Write {
        path: path.to_owned(),
        reason: error.to_string(),
    };
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    let folder = fs::canonicalize(folder).map_err(|error| failed(folder, error))?;
    let mut path = folder.join(name);
    for number in 2.. {
        match fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
                path = folder.join(format!("{name}-{number}"));
            }
            Err(error) => return Err(failed(&path, error)),
        }
    }
    Ok(path)
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, text).map_err(|error| Error::Write { path: path.to_owned(), reason: error.to_string() })
}

/// As TOML has it; JSON's escapes are among those of TOML.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall::Solver;
    use rockfall_math::{DVec3, Vec3};

    const SCENE: &str = r#"
[world]
substeps = 3

[materials.default]
[materials."old oak"]
friction = 0.4

[shapes]
floor = { kind = "half-space" }
cube = { kind = "box", size = [1, 1, 1] }

[[bodies]]
shape = "floor"
[[generators]]
kind = "grid"
shape = "cube"
material = "old oak"
count = [3, 3, 3]
spacing = [1.2, 1.2, 1.2]
position = [0, 0, 1]
"#;

    /// What is saved goes on with the state that was shown, with what was changed and added.
    #[test]
    fn a_saved_scene_begins_with_the_state_that_was_shown() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("small.toml");
        fs::write(&path, SCENE).unwrap();
        let mut source = Source::scene(&path, 1).unwrap();
        let live = source.live().unwrap();
        (0..20).for_each(|_| live.advance().unwrap());
        live.set(Some(Vec3::new(0.0, 1.0, -5.0)), Some(Solver::Impulse), Some(6)).unwrap();
        let index = live.scene.materials().iter().position(|name| name == "old oak").unwrap();
        live.set_material(index, Some(0.11), Some(0.25)).unwrap();
        live.throw(DVec3::new(-5.0, 0.0, 3.0), Vec3::new(12.0, 0.0, 0.1), 0.3).unwrap();
        live.pile(DVec3::new(8.0, 0.0, 0.0), 0.5, 8).unwrap();
        (0..20).for_each(|_| live.advance().unwrap());
        let saves = folder.path().join("saved");
        for place in ["small-40", "small-40-2"] {
            let said = save(&source, 40, &saves).unwrap();
            assert!(said.ends_with("scene.toml") && said.contains(place), "{said}");
        }
        let file = saves.join("small-40").join(SCENE_FILE);
        let scene = Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
        let again = scene.build().unwrap();
        let live = source.live().unwrap();
        assert_eq!(again.world.ids(), live.running.world.ids());
        assert_eq!(again.world.velocities(), live.running.world.velocities());
        // The scene's bodies are there to the bit. A text may round the rotation of the ball that was added.
        let (poses, before) = (again.world.poses(), live.running.world.poses());
        assert_eq!(poses[..28], before[..28]);
        assert_eq!(poses[29..], before[29..]);
        assert_eq!(poses[28].position, before[28].position);
        assert!(poses[28].rotation.dot(before[28].rotation) > 1.0 - 1e-6);
        assert_eq!(again.world.settings().gravity, Vec3::new(0.0, 1.0, -5.0));
        assert_eq!((scene.settings.solver, scene.settings.substeps), (Solver::Impulse, 6));
        let oak = scene.materials().iter().position(|name| name == "old oak").unwrap();
        let oak = again.world.material(again.materials()[oak]).unwrap();
        assert_eq!((oak.friction, oak.restitution), (0.11, 0.25));
        // What was saved can be shown, and saved again.
        let mut third = Source::scene(&file, 1).unwrap();
        third.live().unwrap().advance().unwrap();
        save(&third, 1, &saves).unwrap();
        Source::scene(&saves.join("scene-1").join(SCENE_FILE), 1).unwrap();
        assert!(save(&source, 3, &saves).unwrap_err().to_string().contains("go to the newest frame"));
    }

    const SCENE_FILE: &str = rockfall_cache::SCENE;
}
