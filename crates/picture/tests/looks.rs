//! What the scene says of looks is what a picture shows: a mesh in place of a shape, and its colours.

use rockfall::Shape;
use rockfall_cache::{BodyTable, Contents, FORMAT, Frame, RunFolder, RunWriter, Summary, VERSION};
use rockfall_export::{Run, linear};
use rockfall_math::{DVec3, Vec3};
use rockfall_picture::{Air, Camera, ColorBy, Quality, Recorded, Seen, Shot, Sight, Stage, render};
use rockfall_scene::Scene;
use rockfall_shape::Mesh;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const ROOF: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

const SCENE: &str = r##"
[materials.oak]
color = "#804000"
[materials.default]

[shapes.ball]
kind = "sphere"
radius = 0.4

[[bodies]]
shape = "ball"
position = [0, 0, 3]
rotation = [20, 30, 40]
color = "#ff8001"
visual = { file = "roof.obj", scale = 0.5, position = [0, 0, -0.25] }

[[bodies]]
shape = "ball"
material = "oak"
position = [2, 0, 3]

[[bodies]]
shape = "ball"
position = [4, 0, 3]
"##;

fn scene(name: &str) -> (Scene, PathBuf) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("roof.obj"), ROOF).unwrap();
    let scene = Scene::parse(SCENE, "looks.toml", &folder).unwrap_or_else(|e| panic!("{e}"));
    (scene, folder)
}

fn sight(name: &str) -> Sight {
    let (scene, _) = scene(name);
    let mut running = scene.build().unwrap();
    for _ in 0..5 {
        running.world.step();
    }
    Sight::of_world(&scene, &running, 5)
}

#[test]
fn a_run_looks_like_the_scene_that_was_run() {
    let (scene, folder) = scene("looks-run");
    let path = folder.join("run");
    let _ = std::fs::remove_dir_all(&path);
    let running = scene.build().unwrap();
    let rows = running.body_table();
    let table = BodyTable {
        ids: rows.iter().map(|row| row.id).collect(),
        names: vec![String::new(); rows.len()],
        shapes: rows.iter().map(|row| row.shape as u32).collect(),
        scales: rows.iter().map(|row| row.scale).collect(),
    };
    let summary = Summary { format: FORMAT.into(), format_version: VERSION, ..Summary::default() };
    let run = RunFolder::at(&path, false).unwrap();
    let text = scene.to_toml_filled();
    let mut writer = RunWriter::create(&run, &text, &summary, &table, Contents::default()).unwrap();
    let mut poses = writer.buffer();
    poses.gather(&table, DVec3::ZERO, &running.world.ids(), &running.world.poses()).unwrap();
    writer.push(Frame { poses, ..Frame::default() }).unwrap();
    writer.finish().unwrap();
    let run = Run::open(&path).unwrap();
    let recorded = Recorded::new(&run).unwrap().at(0).unwrap();
    let live = Sight::of_world(&scene, &running, 0);
    for by in [ColorBy::Body, ColorBy::Material] {
        let [one, other] = [&recorded, &live].map(|sight| by.paint(sight, None).unwrap().0);
        assert_eq!(one, other, "{by:?}");
    }
    let shown = |sight: &Sight| -> Vec<(&str, f32)> {
        let of = |body: &Seen| &sight.shapes[body.shown as usize];
        sight.bodies.iter().map(|body| (of(body).name(), of(body).radius_about(Vec3::ZERO))).collect()
    };
    assert_eq!(shown(&recorded), shown(&live));
    assert_eq!(shown(&live)[0].0, "mesh");
    assert_eq!(recorded.bodies[0].shape, live.bodies[0].shape);
}

#[test]
fn a_mesh_in_place_of_a_ball_is_drawn_where_the_ball_is_and_nothing_of_the_ball() {
    let sight = sight("looks-drawn");
    let stage = sight.stage(&[[0.5; 3]; 3]);
    let corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]];
    let corners =
        corners.map(|[x, y, z]| Vec3::new(x as f32, y as f32, z as f32) * 0.5 - Vec3::new(0.0, 0.0, 0.25));
    let roof = Mesh::from_triangles(&corners, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]).unwrap();
    let mut actors = stage.actors.clone();
    actors[0].shape = 1;
    let by_hand = Stage { shapes: vec![Shape::Sphere { radius: 0.4 }, Shape::Mesh(Arc::new(roof))], actors };
    let mut shown = 0;
    // From above, and from below, where it is open.
    for eye in [DVec3::new(2.0, -7.0, 6.0), DVec3::new(1.0, -4.0, -2.0)] {
        let camera = Camera { eye, target: DVec3::new(2.0, 0.0, 3.0), up: DVec3::Z, fov: 40.0, lens: None };
        let shot = Shot { width: 160, height: 90, quality: Quality::Draft, air: Air::NONE };
        let [found, expected] = [&stage, &by_hand].map(|stage| render(stage, &camera, &shot));
        assert_eq!(found.depth, expected.depth);
        assert_eq!(found.light, expected.light);
        shown += found.depth.iter().filter(|depth| depth.is_finite()).count();
    }
    assert!(shown > 400, "{shown} pixels");
}

#[test]
fn colours_are_those_of_body_and_material_where_they_tell_nothing_else() {
    let sight = sight("looks-colours");
    let paint = |by: ColorBy| by.paint(&sight, None).unwrap_or_else(|error| panic!("{error}")).0;
    let [orange, oak] = [[255, 128, 1], [128, 64, 0]].map(linear);
    let bodies = paint(ColorBy::Body);
    assert_eq!(bodies[..2], [orange, oak]);
    assert!(bodies[2] != orange && bodies[2] != oak, "a stone");
    let materials = paint(ColorBy::Material);
    assert_eq!(materials[1], oak);
    assert_eq!(materials[0], materials[2], "of one material, whatever their own colours");
    let speeds = paint(ColorBy::Speed);
    assert!(speeds.iter().all(|color| *color == speeds[0]), "equally fast: {speeds:?}");
}
