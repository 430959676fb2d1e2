//! What the program promises of scenes of other programs.

mod common;

use common::{Place, error, expect, out};
use std::fs;

/// A ball of a kilogram falls on the ground; a joint is not supported.
const STAGE: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Plane "Ground" (
    prepend apiSchemas = ["PhysicsCollisionAPI"]
)
{
}
def Sphere "Ball" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]
)
{
    double radius = 0.5
    float physics:mass = 1
    double3 xformOp:translate = (0, 0, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def PhysicsFixedJoint "Joint"
{
}
"#;

const NOTE: &str = "ball.usda: PhysicsFixedJoint is not supported (/Joint)";

#[test]
fn a_stage_runs_says_what_it_lacks_and_is_exported_and_comes_back() {
    let place = Place::with("ball.usda", STAGE);
    let info = place.rockfall("info ball.usda --json");
    expect(&info, 0);
    let json: serde_json::Value = serde_json::from_str(&out(&info)).unwrap();
    assert_eq!((json["bodies"].as_u64(), &json["notes"]), (Some(2), &serde_json::json!([NOTE])));

    let run = place.rockfall("run ball.usda --frames 20 --out run --hash");
    expect(&run, 0);
    assert!(error(&run).contains(&format!("Note: {NOTE}")), "{}", error(&run));
    // The scene that the run holds is the same scene, wherever it is read.
    let again = place.rockfall("run run/scene.toml --no-output --quiet --hash");
    expect(&again, 0);
    assert_eq!(out(&again), out(&run));

    let csv = place.rockfall("export run --to csv --bodies 2 --frames 20");
    expect(&csv, 0);
    let text = fs::read_to_string(place.path("run.csv")).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");

    // A still of the run is a scene by itself: a hull for the ball, and the ground, which is flat.
    expect(&place.rockfall("export run --to glb --frames 0"), 0);
    let back = place.rockfall("info run.glb --json");
    expect(&back, 0);
    let json: serde_json::Value = serde_json::from_str(&out(&back)).unwrap();
    assert_eq!(json["bodies"].as_u64(), Some(2), "{json}");

    // With another stage in its place the run can't be exported any more.
    fs::write(place.path("ball.usda"), STAGE.replace("radius = 0.5", "radius = 0.4")).unwrap();
    let other = place.rockfall("export run --to vtp");
    assert_ne!(other.status.code(), Some(0));
    assert!(error(&other).contains("it was changed"), "{}", error(&other));
}

#[test]
fn a_file_that_is_no_scene_is_refused() {
    let place = Place::with("bad.usdc", "PXR-USDC and no more");
    let bad = place.rockfall("run bad.usdc --dry-run");
    expect(&bad, 3);
    assert!(error(&bad).contains("bad.usdc") && error(&bad).contains("usdc"), "{}", error(&bad));
    place.refuses("info missing.glb", 3, "no such file");
}
