//! Casts rays into a heap of balls, boxes, capsules and hulls, beside `parry3d` with a compound of the same bodies, and asks for nearest points and
//! overlaps.
//!
//! `cargo run --release -p rockfall --example queries -- 100000 1000000 240`: bodies, rays, steps in which the heap falls together.

use parry3d::math::{Pose as Place, Rotation};
use parry3d::query::RayCast;
use parry3d::shape::{Compound, SharedShape};
use rayon::prelude::*;
use rockfall::math::{DVec3, Pose, Quat, Vec3, hash::mix, rotation};
use rockfall::shape::Hull;
use rockfall::{Body, Error, Filter, Material, Movers, Ray, Settings, Shape, World};
use std::sync::Arc;
use std::time::Instant;

/// Rounds of all measurements, one after the other; the best of each counts.
const ROUNDS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| args.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (count, rays, steps) = (number(0, 100_000), number(1, 1_000_000), number(2, 240));

    let poses = settled(count, steps)?;
    // One more step gives all bodies their boxes; results are the same for any number of threads.
    let mut worlds = [world(1, &poses)?, world(2, &poses)?];
    worlds.iter_mut().for_each(|world| {
        world.step();
    });
    let [one, two] = &worlds;
    assert_eq!(one.hash(), two.hash());
    let compound = compound(one);
    let pools = [1, 2].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
    let bodies = Filter { movers: Movers::Only, ..Filter::default() };

    let begin = Instant::now();
    one.cast_ray(&Ray::new(DVec3::ZERO, Vec3::Z), &bodies);
    println!(
        "{count} bodies; the first query after a step took {:.2} ms",
        1e3 * begin.elapsed().as_secs_f64()
    );
    for (name, rays) in [("strewn", strewn(one, rays)), ("a camera's", camera(one, rays))] {
        let theirs: Vec<parry3d::query::Ray> = rays
            .iter()
            .map(|ray| parry3d::query::Ray::new(ray.origin.as_vec3(), ray.direction.normalize()))
            .collect();
        let cast = |ray: &parry3d::query::Ray| compound.cast_local_ray_and_get_normal(ray, 1e6, true);
        let mut best = [[f64::INFINITY; 3]; 2];
        let mut hits = [0; 2];
        for _ in 0..ROUNDS {
            for (k, world) in worlds.iter().enumerate() {
                let pool = pools[k].as_ref().map_err(ToString::to_string)?;
                best[k][0] = best[k][0].min(seconds(|| hits[0] = some(&world.cast_rays(&rays, &bodies))));
                best[k][1] = best[k][1].min(seconds(|| {
                    let met =
                        pool.install(|| theirs.par_iter().with_min_len(64).map(cast).collect::<Vec<_>>());
                    hits[1] = some(&met);
                }));
                best[k][2] = best[k][2].min(seconds(|| drop(world.test_rays(&rays, &bodies))));
            }
        }
        println!(
            "{} {name} rays, {} meet a body ({} with parry3d); million a second:",
            rays.len(),
            hits[0],
            hits[1]
        );
        for (k, times) in best.iter().enumerate() {
            let [first, parry, any] = times.map(|time| 1e-6 * rays.len() as f64 / time);
            println!("  {} threads: first {first:.3}, parry3d {parry:.3}, any {any:.3}", k + 1);
        }
    }

    let half = 0.5 * side(count) as f32;
    let spread = |i: usize, k: u64| 2.0 * random(i, k) - 1.0;
    let place =
        |i: usize| Vec3::new(half * spread(i, 1), half * spread(i, 2), 15.0 * random(i, 3)).as_dvec3();
    let points: Vec<DVec3> = (0..100_000).map(place).collect();
    let at: Vec<Pose> = points.iter().map(|&point| Pose::at(point)).collect();
    let ball = Shape::Sphere { radius: 0.5 };
    println!("100000 points and balls in the heap; million a second:");
    for (k, world) in worlds.iter().enumerate() {
        let rate = |time: f64| 0.1 / time;
        let near = rate(seconds(|| drop(world.nearest_points(&points, f32::INFINITY, &bodies))));
        let overlaps = rate(seconds(|| drop(world.overlaps(&ball, &at, &bodies))));
        println!("  {} threads: nearest point {near:.3}, overlaps {overlaps:.3}", k + 1);
    }
    Ok(())
}

fn seconds(f: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    f();
    begin.elapsed().as_secs_f64()
}

fn some<T>(answers: &[Option<T>]) -> usize {
    answers.iter().filter(|answer| answer.is_some()).count()
}

fn random(i: usize, k: u64) -> f32 {
    (mix(i as u64 * 16 + k) >> 40) as f32 / (1 << 24) as f32
}

fn shapes() -> Result<Vec<Shape>, Box<dyn std::error::Error>> {
    let corner = |k: usize| {
        0.5 * Vec3::new(random(k, 1) - 0.5, random(k, 2) - 0.5, random(k, 3) - 0.5).normalize_or(Vec3::X)
    };
    let corners: Vec<Vec3> = (0..24).map(corner).collect();
    Ok(vec![
        Shape::Sphere { radius: 0.4 },
        Shape::Box { half: Vec3::new(0.3, 0.35, 0.4) },
        Shape::Capsule { half_length: 0.25, radius: 0.25 },
        Shape::Hull(Arc::new(Hull::from_points(&corners)?)),
    ])
}

/// The ground, walls, and bodies at these poses.
fn world(threads: usize, poses: &[Pose]) -> Result<World, Box<dyn std::error::Error>> {
    let mut world = World::new(Settings { threads, sleeping: false, ..Settings::default() })?;
    let rock = world.add_material(Material::default())?;
    let room = 0.5 * side(poses.len()) + 1.0;
    for normal in [Vec3::Z, Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y] {
        let offset = if normal == Vec3::Z { 0.0 } else { -room as f32 };
        let plane = world.add_shape(Shape::HalfSpace { normal, offset })?;
        world.spawn(Body::fixed(plane, rock, Pose::default()))?;
    }
    let kinds =
        shapes()?.into_iter().map(|shape| world.add_shape(shape)).collect::<Result<Vec<_>, Error>>()?;
    world.spawn_all(poses.iter().enumerate().map(|(i, &pose)| Body::new(kinds[i % 4], rock, pose)))?;
    Ok(world)
}

/// Length of the heap's sides: it is about twenty bodies high.
fn side(count: usize) -> f64 {
    (count as f64 / 20.0).sqrt().ceil()
}

/// Where bodies that were let go in a loose lattice have come to.
fn settled(count: usize, steps: usize) -> Result<Vec<Pose>, Box<dyn std::error::Error>> {
    let across = side(count) as usize;
    let start: Vec<Pose> = (0..count)
        .map(|i| {
            let at = |n: usize| n as f64 - 0.5 * across as f64 + 0.5;
            let (x, y, z) = (i % across, i / across % across, i / across / across);
            let turn = Quat::from_xyzw(
                random(i, 4) - 0.5,
                random(i, 5) - 0.5,
                random(i, 6) - 0.5,
                random(i, 7) + 0.1,
            );
            let jitter = 0.1 * f64::from(random(i, 8));
            let position = DVec3::new(at(x) + jitter, at(y) - jitter, 0.6 + 1.05 * z as f64);
            Pose { position, rotation: rotation::normalize(turn) }
        })
        .collect();
    let mut world = world(2, &start)?;
    for _ in 0..steps {
        world.step();
    }
    Ok(world.poses().split_off(5))
}

/// From a sphere around the heap to places all over it, in no order.
fn strewn(world: &World, count: usize) -> Vec<Ray> {
    let half = 0.5 * side(world.len()) as f32;
    let ray = |i: usize| {
        let spread = |k: u64| 2.0 * random(i, k) - 1.0;
        let from = 1.5 * half * Vec3::new(spread(1), spread(2), 0.1 + random(i, 3)).normalize_or(Vec3::Z);
        let to = Vec3::new(half * spread(4), half * spread(5), 15.0 * random(i, 6));
        Ray::new(from.as_dvec3(), to - from)
    };
    (0..count).map(ray).collect()
}

/// Pixel by pixel of a picture of the heap.
fn camera(world: &World, count: usize) -> Vec<Ray> {
    let half = 0.5 * side(world.len()) as f32;
    let width = (count as f32).sqrt() as usize;
    let eye = Vec3::new(0.0, -1.8 * half, 1.2 * half);
    let pixel = |i: usize| {
        let at = |n: usize| 2.0 * n as f32 / width as f32 - 1.0;
        let to = Vec3::new(half * at(i % width), half * at(i / width), 10.0);
        Ray::new(eye.as_dvec3(), to - eye)
    };
    (0..width * width).map(pixel).collect()
}

/// The same bodies as one shape of `parry3d`, which builds its tree over them.
fn compound(world: &World) -> Compound {
    let theirs = |shape: &Shape| match shape {
        Shape::Sphere { radius } => Some(SharedShape::ball(*radius)),
        Shape::Box { half } => Some(SharedShape::cuboid(half.x, half.y, half.z)),
        Shape::Capsule { half_length, radius } => Some(SharedShape::capsule_z(*half_length, *radius)),
        Shape::Hull(hull) => SharedShape::convex_hull(&hull.vertices),
        _ => None,
    };
    let shared: Vec<Option<SharedShape>> =
        world.ids().iter().take(9).map(|&id| world.shape(id).ok().and_then(theirs)).collect();
    let parts = world.poses().into_iter().enumerate().skip(5).filter_map(|(i, pose)| {
        let rotation = Rotation::from_array(pose.rotation.to_array());
        let place = Place::from_parts(pose.position.as_vec3(), rotation);
        Some((place, shared[5 + (i - 5) % 4].clone()?))
    });
    Compound::new(parts.collect())
}
