//! Drops a pile of boxes or balls into a walled square and prints what each step costs.
//!
//! `cargo run --release -p rockfall --example pile -- boxes 10000 600 2`

use rockfall::math::{DVec3, Pose, Quat, Vec3, hash::mix};
use rockfall::{Body, Material, STAGES, Settings, Shape, World};

fn main() -> Result<(), rockfall::Error> {
    rockfall::math::room::map_large_blocks();
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| args.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let balls = args.first().is_some_and(|kind| kind == "balls");
    let (count, steps, threads) = (number(1, 10_000), number(2, 600), number(3, 0));
    let settings = Settings { threads, sleeping: false, lanes: number(4, 0), ..Settings::default() };
    let mut world = World::new(settings)?;
    let rock = world.add_material(Material::default())?;
    let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
    world.spawn(Body::fixed(ground, rock, Pose::default()))?;
    let side = (count as f64 / 20.0).sqrt().ceil();
    let room = 0.5 * side * 1.1 + 1.0;
    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let normal = Vec3::new(x, y, 0.0);
        let wall = world.add_shape(Shape::HalfSpace { normal, offset: -room as f32 })?;
        world.spawn(Body::fixed(wall, rock, Pose::default()))?;
    }
    let random = |i: usize, k: u64| (mix(i as u64 * 16 + k) >> 40) as f32 / (1 << 24) as f32;
    let sizes: Vec<_> = (0..16)
        .map(|i| {
            let shape = if balls {
                Shape::Sphere { radius: 0.25 + 0.25 * i as f32 / 15.0 }
            } else {
                let edge = |k: u64| 0.25 + 0.25 * random(i, k);
                Shape::Box { half: Vec3::new(edge(1), edge(2), edge(3)) }
            };
            world.add_shape(shape)
        })
        .collect::<Result<_, _>>()?;
    let per_layer = (side * side) as usize;
    world.spawn_all((0..count).map(|i| {
        let (layer, place) = (i / per_layer, i % per_layer);
        let (x, y) = (place % side as usize, place / side as usize);
        let at = |n: usize| (n as f64 - 0.5 * side) * 1.1;
        let position = DVec3::new(at(x), at(y), 1.0 + 1.4 * layer as f64);
        let turn =
            Quat::from_xyzw(random(i, 4) - 0.5, random(i, 5) - 0.5, random(i, 6) - 0.5, random(i, 7) + 0.1);
        let pose = Pose { position, rotation: turn.normalize() };
        Body::new(sizes[(random(i, 0) * 16.0) as usize % 16], rock, pose)
    }))?;
    let mut sums = [0.0; STAGES.len()];
    let mut last = std::time::Instant::now();
    for step in 1..=steps {
        let report = world.step().clone();
        for (sum, time) in sums.iter_mut().zip(report.times) {
            *sum += 1e3 * time.as_secs_f64();
        }
        if step % 60 == 0 {
            println!(
                "{step:5} {:6.2} ms  pairs {} manifolds {} touching {} points {} colours {} deepest {:.1} mm mean {:.2} mm energy {:.3e} J, {} B/body",
                last.elapsed().as_secs_f64() / 60.0 * 1e3,
                report.pairs,
                report.manifolds,
                report.touching,
                report.contacts,
                report.colors,
                1e3 * report.deepest_penetration,
                1e3 * report.mean_penetration,
                report.kinetic_energy,
                world.memory() / count,
            );
            let stages: Vec<String> = STAGES
                .iter()
                .zip(&sums)
                .filter(|(_, sum)| **sum > 3.0)
                .map(|(stage, sum)| format!("{stage} {:.2}", sum / 60.0))
                .collect();
            println!("      {}", stages.join("  "));
            sums = [0.0; STAGES.len()];
            last = std::time::Instant::now();
        }
    }
    println!("hash {:016x}", world.hash());
    Ok(())
}
