//! The main job: boulders come down the mountain and stay above it.

use rockfall::{BodyId, Shape};
use rockfall_scene::Scene;
use std::path::Path;

/// Promise: at no frame is the middle of a boulder below the ground straight under it; at the end contacts overlap by less than
/// 10 mm on average, and no body was frozen or lost.
fn slide(count: usize, frames: u64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/rockslide.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let fewer = text.replace("count = 20000", &format!("count = {count}"));
    let scene = Scene::parse(&fewer, "rockslide.toml", path.parent().unwrap()).unwrap();
    let mut running = scene.build().unwrap();
    let Shape::HeightField(ground) = running.world.shape(BodyId(1)).unwrap().clone() else {
        panic!("the first body is the mountain")
    };
    let mut hits = 0;
    for frame in 0..frames {
        running.before_step(frame).unwrap();
        running.world.step();
        hits = hits.max(running.world.report().touching);
        for (id, pose) in running.world.ids().iter().zip(running.world.poses()).skip(1) {
            let p = pose.position.as_vec3();
            let height = ground.height_at(p.x, p.y).unwrap_or(f32::NEG_INFINITY);
            assert!(p.z > height, "frame {frame}: boulder {} is {} m under ground", id.0, height - p.z);
        }
    }
    let report = running.world.report();
    assert!(hits > count / 4, "{hits} contacts: nothing came down");
    assert_eq!((report.frozen, report.bodies), (0, count + 1));
    assert!(report.mean_penetration < 0.01, "{} m", report.mean_penetration);
}

#[test]
fn no_boulder_goes_through_the_ground() {
    slide(1_000, 150);
}

#[test]
#[ignore = "a minute and more: cargo test --release -p rockfall-scene --test rockslide -- --ignored"]
fn none_of_twenty_thousand_goes_through_the_ground() {
    slide(20_000, 300);
}
