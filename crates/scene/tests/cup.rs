//! Concave bodies in a scene file: a hare and rings that fall into a cup.

use rockfall::{BodyId, Shape};
use rockfall_math::Vec3;
use rockfall_scene::Scene;
use std::path::Path;

/// Promise: the hare, which is wider than the hole that a hull of the cup would leave it, comes to lie within the cup, and nothing is pressed through a wall.
#[test]
fn the_hare_rests_in_the_cup() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cup.toml");
    let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{}", e.render(false)));
    let mut running = scene.build().unwrap();
    for frame in 0..240 {
        running.before_step(frame).unwrap();
        running.world.step();
    }
    let world = &running.world;
    let (cup, hare) = (BodyId(2), BodyId(3));
    assert!(matches!(world.shape(cup), Ok(Shape::Field(_))));
    let (cup, hare_pose) = (world.pose(cup).unwrap(), world.pose(hare).unwrap());
    // The middle of the hare's body.
    let middle = hare_pose.point(Vec3::new(0.0, 0.0, 0.26)) - cup.position;
    assert!(middle.truncate().length() < 0.5 && middle.z > 0.1 && middle.z < 0.9, "{middle}");
    assert!(cup.position.length() < 0.2, "{}", cup.position);
    let report = world.report();
    assert_eq!(report.frozen, 0);
    assert!(report.deepest_penetration < 0.02, "{} m", report.deepest_penetration);
    let (velocity, _) = world.velocity(hare).unwrap();
    assert!(velocity.length() < 0.05, "{velocity}");
}
