//! What pictures cost: three stages of 1280 × 720 pixels, or frames of a run.
//!
//!     cargo run --release -p rockfall-picture --example speed [RUN FRAME..]
//!
//! Times are those of the clock and, on Linux, of all processors together, which does not count what others do on the machine.

use rockfall_export::Run;
use rockfall_math::hash::mix;
use rockfall_math::{DVec3, Pose, Quat, Vec3, rotation};
use rockfall_picture::{
    Actor, Air, Camera, ColorBy, Quality, Recorded, Shot, Sight, Stage, render, stone, tone,
};
use rockfall_scene::Scene;
use rockfall_shape::Shape;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Boulders on a mountain side, as they wait in the shipped scene.
const SLIDE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/rockslide.toml");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let Some((run, frames)) = args.split_first() {
        let run = Run::open(Path::new(run))?;
        let recorded = Recorded::new(&run)?;
        for frame in frames {
            let sight = recorded.at(frame.parse()?)?;
            let (colors, _) = ColorBy::Body.paint(&sight, None)?;
            report(&format!("frame {frame}"), &sight.stage(&colors), None);
        }
        return Ok(());
    }
    let scene = Scene::load(Path::new(SLIDE))?;
    let sight = Sight::of_world(&scene, &scene.build()?, 0);
    let (colors, _) = ColorBy::Body.paint(&sight, None)?;
    report("20,000 boulders on a mountain", &sight.stage(&colors), None);
    report("100,000 boxes", &heap(100_000, Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) }), None);
    report("1,000,000 balls", &heap(1_000_000, Shape::Sphere { radius: 0.5 }), None);
    Ok(())
}

/// A heap of one shape on the ground, turned anyhow.
fn heap(count: u32, shape: Shape) -> Stage {
    let side = (count as f32 / 10.0).sqrt().ceil() as u32;
    let share = |k: u32| (mix(k.into()) >> 40) as f32 / (1 << 24) as f32 - 0.5;
    let actor = |k: u32| {
        let [i, j, layer] = [k % side, k / side % side, k / side / side].map(f64::from);
        let turn = Quat::from_xyzw(share(4 * k), share(4 * k + 1), share(4 * k + 2), 0.6);
        let off = DVec3::new(share(5 * k).into(), share(5 * k + 1).into(), 0.0) * 0.3;
        let position = DVec3::new(1.2 * i, 1.2 * j, 0.6 + 0.9 * layer) + off;
        let pose = Pose { position, rotation: rotation::normalize(turn) };
        Actor { shape: 0, pose, color: stone(k.into()).to_array(), moves: true }
    };
    let ground = Actor { shape: 1, pose: Pose::default(), color: [0.4; 3], moves: false };
    let actors = (0..count).map(actor).chain([ground]).collect();
    Stage { shapes: vec![shape, Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }], actors }
}

/// Takes pictures of a stage and says how long they took, the best of three.
fn report(name: &str, stage: &Stage, camera: Option<Camera>) {
    let camera = camera.unwrap_or_else(|| Camera::fitting(stage, &stage.balls(), 16.0 / 9.0));
    let air = Air::beyond((camera.target - camera.eye).length());
    for quality in [Quality::Draft, Quality::Standard] {
        let shot = Shot { width: 1280, height: 720, quality, air };
        let time = |_| {
            let (start, before) = (Instant::now(), processors());
            let picture = tone(&render(stage, &camera, &shot));
            (processors() - before, start.elapsed().as_secs_f64(), picture.hash())
        };
        let (cpu, clock, hash) = (0..3).map(time).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        println!("{name}, {quality:?}: {clock:.3} s, processors {cpu:.3} s, {hash:016x}");
    }
}

/// Seconds that the threads of this program have spent on processors; zero where the system does not tell.
fn processors() -> f64 {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let time = |task: fs::DirEntry| {
        let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    1e-9 * tasks.filter_map(time).sum::<f64>()
}
