//! Concave bodies in scene files: rings and a hare that fall into a cup.

use rockfall::{BodyId, Shape, World};
use rockfall_math::Vec3;
use rockfall_scene::Scene;
use std::path::Path;

/// The world of a scene of the repository after so many frames.
fn after(frames: u64, name: &str) -> World {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
    let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{}", e.render(false)));
    let mut running = scene.build().unwrap();
    for frame in 0..frames {
        running.before_step(frame).unwrap();
        running.world.step();
        if frame % 40 == 39 {
            let fast = (3..15)
                .filter_map(|id| running.world.velocity(BodyId(id)).ok())
                .map(|(v, w)| v.length() + 0.1 * w.length())
                .fold(0.0f32, f32::max);
            println!(
                "{name} {frame} deepest {:.5} mean {:.6} fastest {fast:.4}",
                running.world.report().deepest_penetration,
                running.world.report().mean_penetration
            );
        }
    }
    assert!(matches!(running.world.shape(BodyId(2)), Ok(Shape::Field(_))));
    running.world
}

/// Promise: twelve rings that fall into a cup, or beside it, come to rest, and none is pressed through another or through a wall.
#[test]
fn rings_come_to_rest_in_and_around_the_cup() {
    let world = after(240, "cup.toml");
    let report = world.report();
    assert_eq!(report.frozen, 0);
    assert!(report.deepest_penetration < 2e-3, "{} m", report.deepest_penetration);
    for id in 3..15 {
        let (velocity, _) = world.velocity(BodyId(id)).unwrap();
        assert!(velocity.length() < 0.01, "{velocity}");
        assert!(world.pose(BodyId(id)).unwrap().position.z > 0.0);
    }
}

/// Promise: the hare, which is wider than the hole that a hull of the cup would leave it, comes to rest within the cup.
#[test]
fn the_hare_rests_in_the_cup() {
    let world = after(240, "hare-in-cup.toml");
    let (cup, hare) = (BodyId(2), BodyId(3));
    let (cup, hare_pose) = (world.pose(cup).unwrap(), world.pose(hare).unwrap());
    // The middle of the hare's body.
    let middle = hare_pose.point(Vec3::new(0.0, 0.0, 0.26)) - cup.position;
    assert!(middle.truncate().length() < 0.5 && middle.z > 0.1 && middle.z < 0.9, "{middle}");
    assert!(cup.position.length() < 0.2, "{}", cup.position);
    let report = world.report();
    assert_eq!(report.frozen, 0);
    assert!(report.deepest_penetration < 2e-3, "{} m", report.deepest_penetration);
    let (velocity, _) = world.velocity(hare).unwrap();
    assert!(velocity.length() < 0.01, "{velocity}");
}
