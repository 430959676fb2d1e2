//! Scenes that begin with a frame of a run.

use rockfall::{BodyId, Kind};
use rockfall_cache::{
    BodyTable, Contents, FORMAT, Frame, RunFolder, RunWriter, START, STATE, SUMMARY, State, Status, Summary,
    VERSION,
};
use rockfall_math::{DVec3, Vec3};
use rockfall_scene::{Running, Scene};
use std::path::Path;
use tempfile::TempDir;

/// A wedge, whose centre of mass is not its origin, tumbles through empty space; walls stand around, and a ball comes late.
const TUMBLE: &str = r#"
[world]
gravity = [0, 0, 0]
frames = 12

[materials.ice]
density = 917
friction = 0.03

[shapes.wedge]
kind = "hull"
points = [[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]]
[shapes.wall]
kind = "box"
size = [1, 20, 20]
[shapes.ball]
kind = "sphere"
radius = 0.25

[[bodies]]
name = "left"
shape = "wall"
kind = "static"
position = [-10, 0, 0]
[[bodies]]
name = "right"
shape = "wall"
kind = "static"
material = "ice"
position = [10, 0, 0]
[[bodies]]
name = "wedge"
id = 7
shape = "wedge"
material = "ice"
velocity = [1, 2, -1]
angular_velocity = [3, -1, 2]
[[generators]]
kind = "pour"
name = "rain"
shape = "ball"
count = 5
rate = 30
region = { min = [-2, -2, 6], max = [2, 2, 7] }
"#;

fn parse(text: &str, folder: &Path) -> Scene {
    Scene::parse(text, "scene.toml", folder).unwrap_or_else(|error| panic!("{}", error.render(false)))
}

/// Runs a scene into a folder. Returns the velocities after each frame.
fn run(text: &str, path: &Path) -> Vec<State> {
    let scene = parse(text, path);
    let mut running = scene.build().unwrap();
    let mut rows = running.body_table().to_vec();
    rows.sort_by_key(|row| row.id);
    let table = BodyTable {
        ids: rows.iter().map(|row| row.id).collect(),
        names: rows.iter().map(|row| row.name.clone().unwrap_or_default()).collect(),
        shapes: rows.iter().map(|row| row.shape as u32).collect(),
        scales: rows.iter().map(|row| row.scale).collect(),
    };
    let summary = Summary { format: FORMAT.into(), format_version: VERSION, ..Summary::default() };
    let folder = RunFolder::at(path, false).unwrap();
    let text = scene.to_toml_filled();
    let mut writer = RunWriter::create(&folder, &text, &summary, &table, Contents::default()).unwrap();
    let mut states = Vec::new();
    for frame in 0..=scene.frames {
        if frame > 0 {
            running.before_step(frame - 1).unwrap();
            running.world.step();
        }
        let mut poses = writer.buffer();
        poses.gather(&table, DVec3::ZERO, &running.world.ids(), &running.world.poses()).unwrap();
        let (time, report) = (frame as f64 / 60.0, (frame > 0).then(|| running.world.report().clone()));
        let hash = Some(running.world.hash());
        writer.push(Frame { time, poses, report, hash, ..Frame::default() }).unwrap();
        states.push(State::of(&running.world, frame));
    }
    writer.finish().unwrap();
    Summary { status: Status::Finished, ..summary }.write(&path.join(SUMMARY)).unwrap();
    states
}

fn place() -> (TempDir, Vec<State>) {
    let folder = tempfile::tempdir().unwrap();
    let states = run(TUMBLE, &folder.path().join("run"));
    (folder, states)
}

fn build(text: &str, folder: &TempDir) -> Running {
    let scene = parse(text, folder.path());
    let running = scene.build().unwrap();
    assert_eq!(scene.body_count() as usize, running.body_table().len());
    running
}

/// Visuals are numbered anew, since those of bodies that are left out are not taken over.
#[test]
fn what_bodies_look_like_goes_on_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let corner = folder.path().join("corner.obj");
    std::fs::write(&corner, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\nf 1 3 2\n").unwrap();
    let visual = |scale: u32| format!("visual = {{ file = \"{}\", scale = {scale} }}\n", corner.display());
    let text = TUMBLE
        .replace("name = \"left\"\n", &format!("name = \"left\"\n{}", visual(2)))
        .replace("name = \"wedge\"\n", &format!("name = \"wedge\"\ncolor = \"#102030\"\n{}", visual(3)))
        .replace("friction = 0.03", "friction = 0.03\ncolor = \"#a0b0c0\"");
    run(&text, &folder.path().join("run"));
    let text = "[start]\nrun = \"run\"\nwithout = [\"left\"]\n[materials.default]\ncolor = \"#ffffff\"\n\
                [shapes.box]\nkind = \"box\"\nsize = [1, 1, 1]\nvisual = { file = \"corner.obj\" }\n[[bodies]]\nshape = \"box\"\n";
    let inventory = parse(text, folder.path()).inventory().unwrap();
    let found = |name: &str| inventory.bodies.iter().find(|body| body.name.as_deref() == Some(name));
    let wedge = found("wedge").unwrap();
    assert_eq!(wedge.look.color, Some([0x10, 0x20, 0x30]));
    let size = |look: rockfall_scene::Look| inventory.visuals[look.visual.unwrap() as usize].bounds().max.x;
    assert_eq!(size(wedge.look), 3.0);
    assert_eq!(size(inventory.bodies.last().unwrap().look), 1.0);
    assert_eq!(inventory.visuals.len(), 2);
    let ice = inventory.materials.iter().position(|name| name == "ice").unwrap();
    assert_eq!(inventory.colors[ice], Some([0xa0, 0xb0, 0xc0]));
    assert_eq!(inventory.colors[0], Some([255; 3]));
    assert_eq!(inventory.colors.len(), inventory.materials.len());
}

#[test]
fn bodies_go_on_from_where_they_were_and_new_ones_are_counted_behind_them() {
    let (folder, states) = place();
    states[12].write(&folder.path().join("run").join(STATE)).unwrap();
    let text = "[start]\nrun = \"run\"\n[shapes.box]\nkind = \"box\"\nsize = [1, 1, 1]\n[[bodies]]\nshape = \"box\"\n";
    let running = build(text, &folder);
    // The pour had the ids 3 to 6 and 8; one of its bodies was still to come, and does not.
    let ids: Vec<u64> = running.world.ids().iter().map(|id| id.0).collect();
    let mut expected = states[12].ids.clone();
    assert!(expected.len() == 8 || expected.len() == 9, "{expected:?}");
    expected.push(9);
    assert_eq!(ids, expected);
    let now = State::of(&running.world, 12);
    let last = states[12].ids.len();
    assert_eq!(now.poses[..last], states[12].poses);
    assert_eq!(now.velocities[..last], states[12].velocities);
    assert_eq!(running.world.name(BodyId(7)), Some("wedge"));
    assert_eq!(running.waiting(), 0);
}

#[test]
fn velocities_are_those_of_centres_of_mass_also_where_poses_alone_are_known() {
    let (folder, states) = place();
    let running = build("[start]\nrun = \"run\"\nframe = 5\nkinds = [\"dynamic\"]\n", &folder);
    let (v, w) = running.world.velocity(BodyId(7)).unwrap();
    let row = states[5].ids.iter().position(|&id| id == 7).unwrap();
    let (exact, spin) = states[5].velocities[row];
    // Means over a step are half a step old; the origin of the shape is some 2 m/s faster than the centre of mass.
    assert!((v - exact).length() < 0.05 && (w - spin).length() < 0.1, "{v} {exact} {w} {spin}");
    assert!(running.world.kinds().iter().all(|&kind| kind == Kind::Dynamic));
    let (start, rest) = (
        build("[start]\nrun = \"run\"\nframe = 0\n", &folder),
        build("[start]\nrun = \"run\"\nvelocities = false\n", &folder),
    );
    let (v, _) = start.world.velocity(BodyId(7)).unwrap();
    assert!((v - Vec3::new(1.0, 2.0, -1.0)).length() < 0.05, "{v}");
    assert_eq!(rest.world.velocity(BodyId(7)).unwrap(), (Vec3::ZERO, Vec3::ZERO));
}

#[test]
fn bodies_and_generators_are_left_out_by_their_names() {
    let (folder, _) = place();
    let running = build("[start]\nrun = \"run\"\nwithout = [\"left\", \"rain\"]\n", &folder);
    let names: Vec<_> = running.body_table().iter().map(|row| row.name.as_deref()).collect();
    assert_eq!(names, [Some("right"), Some("wedge")]);
}

#[test]
fn materials_are_those_of_the_run_or_of_the_same_name_here() {
    let (folder, _) = place();
    let density = "[materials.ice]\ndensity = 100\n";
    let weigh = |materials: &str| {
        let text = format!("{density}[start]\nrun = \"run\"\nmaterials = \"{materials}\"\n");
        build(&text, &folder).world.mass(BodyId(7)).unwrap()
    };
    let (theirs, ours) = (weigh("run"), weigh("scene"));
    assert!((theirs / ours - 9.17).abs() < 1e-4, "{theirs} {ours}");
    let inventory = parse("[start]\nrun = \"run\"\n", folder.path()).inventory().unwrap();
    // The first `default` is this scene's, whom nothing is made of.
    assert_eq!(inventory.materials, ["default", "default", "ice"]);
    let wedge = inventory.bodies.iter().position(|body| body.id == 7).unwrap();
    assert_eq!(inventory.bodies[wedge].material, 2);
    assert!((inventory.centers[wedge] - Vec3::new(0.5, 0.25, 0.25)).length() < 1e-6);
}

#[test]
fn a_copy_serves_when_the_run_is_gone_and_runs_begin_with_runs() {
    let (folder, states) = place();
    let at = |name: &str| folder.path().join(name);
    let text = "[world]\nframes = 3\ngravity = [0, 0, 0]\n[start]\nrun = \"../run\"\nwithout = [\"left\"]\n";
    std::fs::create_dir(at("second")).unwrap();
    let scene = parse(text, &at("second"));
    assert_eq!(scene.start().unwrap().state.frame, 12);
    run(&scene.to_toml_filled(), &at("second"));
    scene.start().unwrap().write(&at("second").join(START)).unwrap();
    let third = "[start]\nrun = \"second\"\n";
    let before = build(third, &folder);
    std::fs::rename(at("run"), at("elsewhere")).unwrap();

    let again = Scene::load(at("second/scene.toml")).unwrap();
    assert!(again == scene && again.start() == scene.start());
    assert_eq!(again.to_toml_filled(), scene.to_toml_filled());
    assert_eq!(State::of(&again.build().unwrap().world, 12).poses.len(), states[12].poses.len() - 1);
    let after = build(third, &folder);
    assert_eq!(State::of(&before.world, 0), State::of(&after.world, 0));
    assert_eq!(before.body_table(), after.body_table());
    let copied = parse(third, folder.path());
    let start = copied.start().unwrap();
    assert_eq!((start.state.frame, start.start.as_ref().unwrap().state.frame), (3, 12));

    // Another frame than that of the copy is wanted of the run itself, which is gone.
    let other = std::fs::read_to_string(at("second/scene.toml")).unwrap().replace("frame = 12", "frame = 11");
    let error = Scene::parse(&other, "other", at("second")).unwrap_err();
    assert!(error.to_string().contains("run is not a run"), "{error}");
    std::fs::remove_dir_all(at("second").join(START)).unwrap();
    let error = Scene::parse(third, "third", folder.path()).unwrap_err();
    assert!(error.to_string().contains("`start.zarr` is missing"), "{error}");
}

/// Promise: the filled text is the same scene, also where the table comes from one of several files.
#[test]
fn a_start_may_stand_in_any_of_the_files() {
    let (folder, _) = place();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("below")).unwrap();
    let shapes = "[shapes.b]\nkind = \"box\"\nsize = [1, 1, 1]\n";
    let body = "[[bodies]]\nshape = \"b\"\nposition = [0, 0, 90]\n";
    for (main, included) in [
        (format!("include = [\"below/it.toml\"]\n[start]\nrun = \"run\"\n{body}"), shapes.to_owned()),
        (
            format!("include = [\"below/it.toml\"]\n[start]\nrun = \"run\"\n{body}"),
            format!("{shapes}[start]\nrun = \"gone\"\nframe = 3\n"),
        ),
        (format!("include = [\"below/it.toml\"]\n{body}"), format!("{shapes}[start]\nrun = \"../run\"\n")),
    ] {
        std::fs::write(at("main.toml"), main).unwrap();
        std::fs::write(at("below/it.toml"), included).unwrap();
        let scene = Scene::load(at("main.toml")).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let again = parse(&scene.to_toml_filled(), Path::new("/nowhere"));
        assert!(again == scene);
        assert_eq!(again.to_toml_filled(), scene.to_toml_filled());
        assert_eq!(again.body_table().unwrap(), scene.body_table().unwrap());
    }
}

#[test]
fn what_does_not_fit_is_told_with_its_place() {
    let (folder, _) = place();
    let body = "[shapes.b]\nkind = \"box\"\nsize = [1, 1, 1]\n[[bodies]]\nshape = \"b\"\n";
    for (text, said) in [
        (
            "[start]\nrun = \"gone\"\n".to_owned(),
            "t.toml:2:7: FOLDER/gone is not a run: it has no summary.json, expected the folder of a run that can be read",
        ),
        (
            "[start]\nrun = \"run\"\nframe = 13\n".to_owned(),
            "t.toml:3:9: frame 13 is not in the run, which has 13, expected a frame before 13",
        ),
        (
            "[start]\nrun = \"run\"\nwithout = [\"wedgs\"]\n".to_owned(),
            "t.toml:3:12: the run has no body and no generator that is called `wedgs`, expected a name of the run's scene; did you mean `wedge`?",
        ),
        (
            "[start]\nrun = \"run\"\nmaterials = \"scene\"\n".to_owned(),
            "t.toml:3:13: the run has bodies of a material `ice`, expected `[materials.ice]`",
        ),
        (
            format!("[start]\nrun = \"run\"\n{body}id = 7\n"),
            "t.toml:8:6: `bodies.1.id` is that of a body of the run in `[start]`, expected another id",
        ),
        (
            format!("[start]\nrun = \"run\"\n{body}name = \"left\"\n"),
            "t.toml:8:8: `bodies.1.name` is that of a body of the run in `[start]`, expected another name",
        ),
    ] {
        let error = Scene::parse(&text, "t.toml", folder.path()).unwrap_err().to_string();
        assert_eq!(error.replace(&folder.path().display().to_string(), "FOLDER"), said);
    }
    let summary = folder.path().join("run").join(SUMMARY);
    std::fs::write(&summary, r#"{"format": "rockfall-run", "format_version": 99}"#).unwrap();
    let error = Scene::parse("[start]\nrun = \"run\"\n", "t.toml", folder.path()).unwrap_err().to_string();
    assert!(error.contains("summary.json has format version 99, this program reads up to 1"), "{error}");
}
