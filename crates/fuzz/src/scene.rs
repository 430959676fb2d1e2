//! Scene files of any text.

use rockfall_scene::Scene;
use std::path::Path;

/// More bodies than that are not built, only counted.
const BODIES: u64 = 2000;

/// A scene from `bytes`, as far as they are text: there are errors that can be shown, or a scene that takes a step.
pub fn scene(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match Scene::parse(&text, "a scene", Path::new("/nowhere")) {
        Err(error) => assert!(!error.render(false).is_empty() && !error.problems().is_empty()),
        Ok(scene) => {
            scene.to_toml_filled();
            scene.estimate();
            if scene.body_count() > BODIES {
                return;
            }
            match scene.build() {
                Err(error) => assert!(!error.render(false).is_empty()),
                Ok(mut running) => {
                    running.world.step();
                    let poses = running.world.poses();
                    assert!(poses.iter().all(|p| p.position.is_finite() && p.rotation.is_finite()));
                }
            }
        }
    }
}
