//! What viewers are told in words: once, and then again and again.

use super::{Director, SOLVERS};
use crate::wire::ABSENT;
use rockfall::STAGES;
use rockfall_picture::{ColorBy, Overlay};
use serde_json::{Value, json};

impl Director {
    /// What a viewer is told once.
    pub(super) fn hello(&mut self) -> Value {
        if self.cameras.is_none() {
            let cameras = self.source.cameras().into_iter().map(|(name, camera)| {
                let (eye, target) = (camera.eye.to_array(), camera.target.to_array());
                json!({"name": name, "eye": eye, "target": target, "fov": camera.fov})
            });
            self.cameras = Some(cameras.collect());
        }
        json!({
            "is": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "title": self.source.title(),
            "live": self.source.live().is_some(),
            "rate": self.source.rate(),
            "origin": self.source.scenery().origin.to_array(),
            "cameras": self.cameras,
            "stages": STAGES,
            "solvers": SOLVERS.map(|(name, _)| name),
            "colors": ColorBy::WORDS.map(|(word, _)| word),
            "overlays": Overlay::WORDS.map(|(word, _)| word),
        })
    }

    /// How it stands.
    pub(super) fn status(&mut self) -> Value {
        let range = self.source.range();
        let moment = self.moment.as_ref();
        let mut status = json!({
            "is": "status",
            "frame": self.shown,
            "time": moment.map(|moment| moment.time),
            "first": range.first,
            "last": range.last,
            "planned": range.planned,
            "grows": range.grows,
            "playing": self.playing,
            "loop": self.looping,
            "speed": self.speed,
            "rate": self.source.rate(),
            "pace": self.pace,
            "viewers": self.viewers.len(),
            "bodies": moment.map(|moment| moment.records.iter().filter(|record| **record != ABSENT).count()),
            "far": moment.map(|moment| moment.far),
            "step": moment.map(|moment| moment.step),
        });
        if let Some(live) = self.source.live() {
            let (bytes, most) = live.history();
            let (world, names) = (&live.running.world, live.scene.materials());
            let settings = world.settings();
            let report = world.report();
            let solver = SOLVERS.iter().find(|(_, solver)| *solver == settings.solver).map(|(name, _)| *name);
            let materials: Vec<Value> = names
                .iter()
                .zip(live.running.materials())
                .filter_map(|(name, id)| {
                    let material = world.material(*id).ok()?;
                    Some(json!({"name": name, "friction": material.friction, "restitution": material.restitution}))
                })
                .collect();
            status["present"] = json!(live.frame);
            status["history"] = json!({"bytes": bytes, "most": most});
            status["held"] = json!(live.is_held());
            status["settings"] = json!({"gravity": settings.gravity.to_array(), "solver": solver, "substeps": settings.substeps});
            status["materials"] = json!(materials);
            status["figures"] = json!({
                "awake": report.awake,
                "touching": report.touching,
                "contacts": report.contacts,
                "deepest": report.deepest_penetration,
                "kinetic": report.kinetic_energy,
                "frozen": report.frozen,
                "step_ms": 1e3 * live.step_time.as_secs_f64(),
                "stages_ms": report.times.map(|time| 1e3 * time.as_secs_f64()),
            });
        }
        status
    }
}
