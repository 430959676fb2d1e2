//! Scenes of other programs as parts of scenes, and as scenes by themselves.

use rockfall::Kind;
use rockfall_scene::Scene;
use std::path::PathBuf;

const STAGE: &str = r#"#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
)
def PhysicsScene "Moon"
{
    float physics:gravityMagnitude = 162
}
def Material "Ice" (
    prepend apiSchemas = ["PhysicsMaterialAPI"]
)
{
    float physics:dynamicFriction = 0.03
}
def Plane "Ground" (
    prepend apiSchemas = ["PhysicsCollisionAPI"]
)
{
    uniform token axis = "Y"
}
def Cube "Crate" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"]
)
{
    double size = 100
    rel material:binding = </Ice>
    double xformOp:translateY = 50
    uniform token[] xformOpOrder = ["xformOp:translateY"]
}
def PhysicsFixedJoint "Joint"
{
}
def Xform "Hammer" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{
    float physics:mass = 3
    double3 xformOp:translate = (300, 80, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "Head" (
        prepend apiSchemas = ["PhysicsCollisionAPI"]
    )
    {
        double size = 20
        double xformOp:translateX = 40
        uniform token[] xformOpOrder = ["xformOp:translateX"]
    }
    def Capsule "Handle" (
        prepend apiSchemas = ["PhysicsCollisionAPI"]
    )
    {
        uniform token axis = "X"
        double radius = 3
        double height = 60
    }
}
"#;

/// A folder with the stage.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.usda");
    std::fs::write(&path, STAGE).unwrap();
    (folder, path)
}

fn rendered<T>(result: Result<T, rockfall_scene::SceneError>) -> T {
    result.unwrap_or_else(|error| panic!("{}", error.render(false)))
}

#[test]
fn a_stage_is_a_scene_by_itself() {
    let (_folder, path) = folder();
    let scene = rendered(Scene::load(&path));
    assert_eq!((scene.body_count(), scene.settings.gravity.to_array()), (3, [0.0, 0.0, -1.62]));
    assert_eq!(scene.notes(), ["stage.usda: PhysicsFixedJoint is not supported (/Joint)"]);
    let mut running = rendered(scene.build());
    let names: Vec<_> = running.body_table().iter().map(|row| row.name.clone().unwrap()).collect();
    assert_eq!(names, ["/Ground", "/Crate", "/Hammer"]);
    let kinds: Vec<Kind> = running.body_table().iter().map(|row| row.kind).collect();
    assert_eq!(kinds, [Kind::Static, Kind::Dynamic, Kind::Dynamic]);
    for _ in 0..120 {
        running.world.step();
    }
    let poses = running.world.poses();
    // The crate stands on the ground, the hammer fell onto it.
    assert!((poses[1].position.z - 0.5).abs() < 2e-3, "{:?}", poses[1]);
    assert!(poses[2].position.z < 0.2, "{:?}", poses[2]);
}

#[test]
fn the_filled_scene_of_a_stage_is_the_same_scene() {
    let (_folder, path) = folder();
    let scene = rendered(Scene::load(&path));
    let text = scene.to_toml_filled();
    let again = rendered(Scene::parse(&text, "scene.toml", "/nowhere"));
    assert_eq!(again, scene);
    assert_eq!(rendered(again.body_table()), rendered(scene.body_table()));
    assert_eq!(again.settings, scene.settings);
    // A file that has changed since is another one.
    std::fs::write(&path, STAGE.replace("double size = 100", "double size = 101")).unwrap();
    let error = Scene::parse(&text, "scene.toml", "/nowhere").unwrap_err().to_string();
    assert!(error.contains("stage.usda has the checksum") && error.contains("it was changed"), "{error}");
}

#[test]
fn a_stage_is_part_of_a_scene_with_what_the_scene_has() {
    let (folder, _) = folder();
    let text = "[world]\ngravity = [0, 0, -9]\n[materials.rock]\ndensity = 3000\n[shapes.ball]\nkind = \"sphere\"\nradius = 0.1\n\
        [[bodies]]\nshape = \"ball\"\nname = \"ball\"\nposition = [0, 0, 20]\n\
        [[imports]]\nfile = \"stage.usda\"\nposition = [0, 0, 5]\nscale = 2\nmaterial = \"rock\"\n\
        [[imports]]\nfile = \"stage.usda\"\nposition = [100, 0, 5]\nrotation = [0, 0, 90]\n\
        [[generators]]\nkind = \"grid\"\nshape = \"ball\"\ncount = [1, 1, 1]\nspacing = [1, 1, 1]\n";
    let scene = rendered(Scene::parse(text, "scene.toml", folder.path()));
    assert_eq!((scene.body_count(), scene.settings.gravity.to_array()), (8, [0.0, 0.0, -9.0]));
    let running = rendered(scene.build());
    let names: Vec<_> = running.body_table().iter().map(|row| row.name.clone().unwrap_or_default()).collect();
    assert_eq!(names, ["ball", "/Ground", "/Crate", "/Hammer", "/Ground", "/Crate", "/Hammer", ""]);
    let poses = running.world.poses();
    assert_eq!(poses[2].position.to_array(), [0.0, 0.0, 6.0]);
    assert!((poses[6].position - rockfall_math::DVec3::new(100.0, 3.0, 5.8)).length() < 1e-6);
    let materials = rendered(scene.inventory()).materials;
    assert_eq!(
        materials,
        ["rock", "default", "stage.usda:/Ice", "stage.usda:", "stage.usda:/Ice", "stage.usda:"]
    );
    // One cubic metre, eight of them in the first: of rock where that was asked for, else of what UsdPhysics takes.
    let mass = |row: usize| running.world.mass(rockfall::BodyId(row as u64 + 1)).unwrap();
    for (row, expected) in [(2, 24000.0), (5, 1000.0), (3, 3.0), (6, 3.0)] {
        assert!((mass(row) - expected).abs() < 1e-6 * expected, "{row}: {} kg", mass(row));
    }
}

#[test]
fn what_is_wrong_with_a_file_is_said_with_its_place_in_the_scene() {
    let (folder, path) = folder();
    let wrong = |text: &str| Scene::parse(text, "scene.toml", folder.path()).unwrap_err().to_string();
    let missing = wrong("[[imports]]\nfile = \"other.usda\"\n");
    assert!(missing.starts_with("scene.toml:2:8: ") && missing.contains("no such file"), "{missing}");
    let material = wrong("[[imports]]\nfile = \"stage.usda\"\nmaterial = \"rok\"\n");
    assert!(material.contains("no material is called `rok`"), "{material}");
    let open = STAGE.replace("def Cube \"Crate\"", "def Mesh \"Crate\"").replace("\"MaterialBindingAPI\"", "\"PhysicsMeshCollisionAPI\"").replace(
        "    double size = 100\n",
        "    token physics:approximation = \"convexDecomposition\"\n    point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]\n    int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0,1,2]\n",
    );
    std::fs::write(&path, open).unwrap();
    let scene = rendered(Scene::load(&path));
    let error = scene.build().unwrap_err().to_string();
    assert!(error.contains("/Crate: "), "{error}");
}

#[test]
fn the_stage_that_ships_runs_down_its_chute() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stages/chute.usda");
    let scene = rendered(Scene::load(path));
    assert_eq!((scene.body_count(), scene.notes()), (124, Vec::new()));
    let mut running = rendered(scene.build());
    // Steel and wood, as heavy as they are.
    let mallet = running.world.mass(rockfall::BodyId(3)).unwrap();
    let expected = 7800.0 * 0.4 * 0.2 * 0.2 + 700.0 * std::f32::consts::PI * 0.035 * 0.035 * 0.8;
    assert!((mallet - expected).abs() < 1e-3 * expected, "{mallet}, expected {expected}");
    for _ in 0..240 {
        running.world.step();
    }
    assert!(running.world.frozen().is_empty());
    let poses = running.world.poses();
    let down = poses[2..].iter().filter(|pose| pose.position.z < 1.0).count();
    assert!(down > 100, "{down} of 122 are down");
    assert!(poses[2..].iter().all(|pose| pose.position.z > 0.0), "none fell through the ground");
}
