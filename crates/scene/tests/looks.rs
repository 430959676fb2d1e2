//! What bodies look like: colours and meshes that are seen in place of shapes. Nothing of it changes how they move.

use rockfall::Shape;
use rockfall_math::Vec3;
use rockfall_scene::{Look, Scene};
use std::fs;
use std::path::Path;

/// A corner of a cube, from the origin along each axis.
const CORNER: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const PLAIN: &str = r#"
[world]
frames = 40

[materials.oak]
[materials.default]
[shapes.ball]
kind = "sphere"
radius = 0.5

[shapes.plate]
kind = "box"
size = [9, 9, 1]

[[bodies]]
shape = "plate"
kind = "static"

[[bodies]]
shape = "ball"
material = "oak"
position = [0.1, 0, 1]

[[bodies]]
shape = "ball"
position = [0.1, 0.2, 2.2]

[[generators]]
kind = "grid"
shape = "ball"
material = "oak"
count = [2, 2, 1]
spacing = [1.5, 1.5, 1.5]
position = [0, 0, 4]
size = { min = 0.5, max = 1, classes = 2 }

[[generators]]
kind = "pour"
shape = "ball"
count = 3
rate = 30
region = { min = [-2, -2, 5], max = [2, 2, 8] }
"#;

/// The same, dressed up.
fn dressed() -> String {
    PLAIN
        .replace("[materials.oak]", "[materials.oak]\ncolor = \"#804000\"")
        .replace("radius = 0.5", "radius = 0.5\ncolor = \"#102030\"\nvisual = { file = \"corner.obj\", scale = 0.5, position = [0, 0, -0.25] }")
        .replace("position = [0.1, 0.2, 2.2]", "position = [0.1, 0.2, 2.2]\ncolor = \"#FFFFFF\"\nvisual = { file = \"corner.obj\", rotation = [0, 0, 90] }")
        .replace("position = [0, 0, 4]", "position = [0, 0, 4]\ncolor = \"#00ff00\"")
        .replace("kind = \"static\"", "kind = \"static\"\nmaterial = \"oak\"")
}

fn folder(name: &str) -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("corner.obj"), CORNER).unwrap();
    folder
}

fn scene(folder: &Path, text: &str) -> Scene {
    Scene::parse(text, "dressed.toml", folder).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

/// The box around a visual.
fn extent(visual: &Shape) -> [Vec3; 2] {
    let bounds = visual.bounds();
    [bounds.min, bounds.max]
}

#[test]
fn a_body_has_its_own_colour_before_that_of_its_shape_and_the_visual_of_its_shape_at_its_size() {
    let folder = folder("looks");
    let inventory = scene(&folder, &dressed()).inventory().unwrap();
    let looks: Vec<Look> = inventory.bodies.iter().map(|body| body.look).collect();
    assert_eq!(inventory.colors, [Some([0x80, 0x40, 0]), None]);
    assert_eq!(looks[0], Look::default(), "the plate has nothing but its material");
    assert_eq!(looks[1], Look { visual: Some(0), color: Some([0x10, 0x20, 0x30]) });
    assert_eq!(looks[2].color, Some([255; 3]));
    assert!(looks[3..7].iter().all(|look| look.color == Some([0, 255, 0])));
    assert!(looks[7..].iter().all(|look| look.color == Some([0x10, 0x20, 0x30])));
    // At the size of the shape, then as the third body has it: turned from x to y, from y to −x.
    assert_eq!(extent(&inventory.visuals[0]), [Vec3::new(0.0, 0.0, -0.25), Vec3::new(0.5, 0.5, 0.25)]);
    let [low, high] = extent(&inventory.visuals[looks[2].visual.unwrap() as usize]);
    assert!((low - Vec3::NEG_X).length() < 1e-6 && (high - Vec3::new(0.0, 1.0, 1.0)).length() < 1e-6);
    for body in &inventory.bodies[3..] {
        let [low, high] = extent(&inventory.visuals[body.look.visual.unwrap() as usize]);
        let expected =
            [Vec3::new(0.0, 0.0, -0.25), Vec3::new(0.5, 0.5, 0.25)].map(|corner| corner * body.scale);
        assert!((low - expected[0]).length() < 1e-6 && (high - expected[1]).length() < 1e-6, "{low} {high}");
    }
    let sizes: Vec<f32> = inventory.bodies[3..7].iter().map(|body| body.scale).collect();
    assert!(sizes.iter().any(|&size| size != 1.0), "{sizes:?}");
    // One at each size, and that of the third body.
    assert!(inventory.visuals.len() <= 4, "{}", inventory.visuals.len());
}

#[test]
fn what_bodies_look_like_changes_no_bit_of_how_they_move() {
    let folder = folder("bits");
    let plain = PLAIN.replace("kind = \"static\"", "kind = \"static\"\nmaterial = \"oak\"");
    let hash = |text: &str| {
        let mut running = scene(&folder, text).build().unwrap();
        for frame in 0..40 {
            running.before_step(frame).unwrap();
            running.world.step();
        }
        running.world.hash()
    };
    assert_eq!(hash(&plain), hash(&dressed()));
}

#[test]
fn a_scene_with_visuals_reads_back_from_its_filled_text_wherever_that_is() {
    let folder = folder("filled");
    let scene = scene(&folder, &dressed());
    let filled = scene.to_toml_filled();
    let again =
        Scene::parse(&filled, "filled", "/").unwrap_or_else(|e| panic!("{}\n{filled}", e.render(false)));
    assert_eq!(scene, again);
    assert_eq!(again.inventory().unwrap().visuals.len(), scene.inventory().unwrap().visuals.len());
    // A file that is included has its own folder.
    let inner = folder.join("inner");
    fs::create_dir_all(&inner).unwrap();
    fs::write(inner.join("dressed.toml"), dressed().replace("corner.obj", "../corner.obj")).unwrap();
    let outer = Scene::parse("include = [\"inner/dressed.toml\"]", "outer", &folder).unwrap();
    assert_eq!(outer.inventory().unwrap().visuals.len(), scene.inventory().unwrap().visuals.len());
}
