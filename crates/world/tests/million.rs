//! A million bodies are what the engine is for.

mod common;

use common::{Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, BodyId, Settings, ShapeId};
use std::collections::HashSet;

/// `n`³ bodies of eight sizes, dropped as a cube into a walled square as wide as the cube, after so many steps: nobody is lost or broken, nobody is beyond the
/// ground or the walls, and the report's counts are those of the contacts that the world hands out.
fn poured(n: usize, steps: usize, shape: impl Fn(&mut Stage, f32) -> ShapeId) {
    let mut stage = Stage::new(Settings { threads: 0, ..frames() }, rubs(0.6, 0.0));
    let half = 0.5 * n as f64;
    let wall = stage.cuboid(half as f32 + 2.0, half as f32 + 2.0, 1.0);
    stage.put(Body::fixed(wall, stage.material, at(0.0, 0.0, -1.0)));
    for axis in 0..2 {
        for side in [-1.0, 1.0] {
            let mut sizes = Vec3::splat(half as f32 + 2.0);
            sizes[axis] = 1.0;
            sizes.z = n as f32;
            let mut position = DVec3::ZERO;
            position[axis] = side * (half + 1.0);
            let shape = stage.cuboid(sizes.x, sizes.y, sizes.z);
            stage.put(Body::fixed(shape, stage.material, Pose::at(position)));
        }
    }
    let shapes: Vec<ShapeId> = (0..8).map(|i| shape(&mut stage, 0.25 + 0.03 * i as f32)).collect();
    let mut random = Numbers(7);
    let bodies: Vec<Body> = (0..n * n * n)
        .map(|i| {
            let place = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
            let position = place + DVec3::new(0.5 - half, 0.5 - half, 0.5) + random.vector() * 0.02;
            stage.body(shapes[i % shapes.len()], Pose { position, rotation: random.rotation() })
        })
        .collect();
    let count = bodies.len();
    stage.world.spawn_all(bodies).expect("the bodies make sense");
    for _ in 0..steps {
        let report = stage.world.step();
        assert_eq!((report.bodies, report.frozen, report.serial), (count + 5, 0, 0));
    }
    let report = stage.world.report();
    println!("{report:?}, {} MB", stage.world.memory() >> 20);
    assert!(stage.all_finite());
    let outside = |p: DVec3| p.z < 0.0 || p.x.abs() > half || p.y.abs() > half;
    let escaped = stage.world.poses().iter().skip(5).filter(|pose| outside(pose.position)).count();
    assert_eq!(escaped, 0);
    let (mut points, mut pairs) = (0, HashSet::<(BodyId, BodyId)>::new());
    for contact in stage.world.contacts() {
        points += 1;
        pairs.insert((contact.a, contact.b));
    }
    assert_eq!((report.contacts, report.manifolds), (points, pairs.len()));
    assert!(pairs.len() > count / 100 && report.pairs >= pairs.len());
}

/// Promise: the short form, with 8,000 bodies.
#[test]
fn thousands_are_poured() {
    poured(20, 60, |stage, size| stage.ball(size));
    poured(20, 60, |stage, size| stage.cuboid(size, size, 0.8 * size));
}

/// Promise: the same with a million balls and a million boxes. Minutes and 3 GB; run it with
/// `cargo test --release -p rockfall --test million -- --ignored`.
#[test]
#[ignore = "minutes, 3 GB: cargo test --release -p rockfall --test million -- --ignored"]
fn a_million_are_poured() {
    poured(100, 60, |stage, size| stage.ball(size));
    poured(100, 60, |stage, size| stage.cuboid(size, size, 0.8 * size));
}
