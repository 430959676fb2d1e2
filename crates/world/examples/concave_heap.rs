//! A heap of concave bodies as signed distance fields beside the same heap of their convex hulls: what a settled step of each costs, and the memory of the field.
//!
//! `cargo run --release -p rockfall --example concave_heap -- 10000 600 120 2 8`: bodies, steps to settle, timed steps, threads, sub-steps. Both heaps stand in one process, and their
//! timed steps take turns, so that a busy machine slows down both. Where the system tells (Linux), processor time is given beside that of the clock.

use rockfall::math::{DVec3, Pose, Quat, Vec2, Vec3, hash::mix, trig};
use rockfall::shape::{Field, FieldSettings, Hull, Mesh};
use rockfall::{Body, Material, STAGES, Settings, Shape, World};
use std::f32::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

/// A ring of 10 cm with a tube of 3 cm, of 4,992 triangles, with an error of 1 mm.
const RING: f32 = 0.035;
const TUBE: f32 = 0.015;
const PARTS: [u32; 2] = [64, 39];
const ERROR: f32 = 1e-3;

fn ring() -> Result<Mesh, Box<dyn std::error::Error>> {
    let around = (0..PARTS[1]).map(|k| {
        let (sin, cos) = trig::sin_cos(TAU * k as f32 / PARTS[1] as f32);
        Vec2::new(RING + TUBE * cos, TUBE * sin)
    });
    Ok(Mesh::turned(&around.collect::<Vec<_>>(), PARTS[0])?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    rockfall::math::room::map_large_blocks();
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| args.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (count, settle, timed) = (number(0, 10_000), number(1, 600), number(2, 120));
    let (threads, substeps) = (number(3, 0), number(4, 8) as u32);
    // With the four of the default rings come to rest as well, most of them later.
    let settings = Settings { threads, substeps, sleeping: false, ..Settings::default() };
    let mesh = Arc::new(ring()?);
    let start = Instant::now();
    let field = Field::new(mesh.clone(), FieldSettings::with_error(ERROR))?;
    let memory = field.memory();
    println!(
        "field of {} triangles in {:.2} s: {} cells {} kB, {} samples {} kB, mesh {} kB",
        mesh.triangles.len(),
        start.elapsed().as_secs_f64(),
        field.cells(),
        memory.cells / 1000,
        field.samples().points().len(),
        memory.samples / 1000,
        memory.mesh / 1000,
    );
    // Of hulls those that a person would take: 32 corners.
    let hull = Hull::from_points_at_most(&mesh.vertices, 32)?;
    let mut heaps = [
        ("fields", heap(Shape::Field(Arc::new(field)), count, settings)?),
        ("hulls", heap(Shape::Hull(Arc::new(hull)), count, settings)?),
    ];
    for (name, world) in &mut heaps {
        let (start, before) = (Instant::now(), processor_ms());
        for step in 1..=settle {
            let report = world.step();
            if step % 100 == 0 {
                println!("{name}: {:.2e} J after {step} steps", report.kinetic_energy);
            }
        }
        let report = world.report();
        println!(
            "{name}: settled in {:.0} s, {:.0} s of a processor; {} pairs, {} manifolds, {} points, deepest {:.2} mm, mean {:.3} mm, {:.2e} J",
            start.elapsed().as_secs_f64(),
            1e-3 * (processor_ms() - before),
            report.pairs,
            report.manifolds,
            report.contacts,
            1e3 * report.deepest_penetration,
            1e3 * report.mean_penetration,
            report.kinetic_energy,
        );
    }
    let mut times = [vec![], vec![]];
    let mut processor = [0.0; 2];
    let mut stages = [[0.0; STAGES.len()]; 2];
    for _ in 0..timed {
        for (k, (_, world)) in heaps.iter_mut().enumerate() {
            let (start, before) = (Instant::now(), processor_ms());
            let report = world.step();
            times[k].push(1e3 * start.elapsed().as_secs_f64());
            processor[k] += (processor_ms() - before) / timed as f64;
            stages[k].iter_mut().zip(report.times).for_each(|(sum, time)| *sum += 1e3 * time.as_secs_f64());
        }
    }
    let medians = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    for (k, (name, world)) in heaps.iter().enumerate() {
        let parts: Vec<String> = STAGES
            .iter()
            .zip(stages[k])
            .map(|(stage, sum)| (stage, sum / timed.max(1) as f64))
            .filter(|(_, mean)| *mean > 0.01 * medians[k])
            .map(|(stage, mean)| format!("{stage} {mean:.2}"))
            .collect();
        let energy = world.report().kinetic_energy;
        println!(
            "{name}: {energy:.2e} J, {:.2} ms a step, {:.2} of a processor, hash {:016x}; {}",
            medians[k],
            processor[k],
            world.hash(),
            parts.join("  ")
        );
    }
    println!(
        "fields over hulls: {:.2}, of a processor {:.2}",
        medians[0] / medians[1],
        processor[0] / processor[1]
    );
    Ok(())
}

/// What all threads have used, milliseconds; NaN where nobody tells.
fn processor_ms() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let used = threads.filter_map(|thread| {
        let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    1e-6 * used.sum::<f64>()
}

/// Bodies in a walled square, some twenty layers of them.
fn heap(shape: Shape, count: usize, settings: Settings) -> Result<World, rockfall::Error> {
    let mut world = World::new(settings)?;
    let rock = world.add_material(Material::default())?;
    let side = (count as f64 / 20.0).sqrt().ceil();
    let pitch = 0.11;
    let room = (0.5 * side * pitch + 0.02) as f32;
    let ground = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
    let walls = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y];
    let walls = walls.map(|normal| Shape::HalfSpace { normal, offset: -room });
    for wall in std::iter::once(ground).chain(walls) {
        let wall = world.add_shape(wall)?;
        world.spawn(Body::fixed(wall, rock, Pose::default()))?;
    }
    let shape = world.add_shape(shape)?;
    let random = |i: usize, k: u64| (mix(i as u64 * 16 + k) >> 40) as f32 / (1 << 24) as f32 - 0.5;
    let per_layer = (side * side) as usize;
    world.spawn_all((0..count).map(|i| {
        let (layer, place) = (i / per_layer, i % per_layer);
        let (x, y) = (place % side as usize, place / side as usize);
        let at = |n: usize| (n as f64 - 0.5 * (side - 1.0)) * pitch;
        let position = DVec3::new(at(x), at(y), 0.08 + pitch * layer as f64);
        let turn = Quat::from_xyzw(random(i, 1), random(i, 2), random(i, 3), random(i, 4) + 0.6);
        Body::new(shape, rock, Pose { position, rotation: turn.normalize() })
    }))?;
    Ok(world)
}
