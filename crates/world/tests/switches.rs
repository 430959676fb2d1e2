//! Reusing what pairs know, and solving in tiles, save time. Promise: what comes out differs by less than a twentieth.

mod common;

use common::{Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, Settings, Shape};

/// The settings that most worlds of this size have, and each switch the other way. All scenes have more bodies than a tile.
fn ways() -> [(&'static str, Settings); 3] {
    let usual = Settings { threads: 0, ..frames() };
    [
        ("as usual", usual),
        ("without reuse", Settings { reuse: false, ..usual }),
        ("in tiles", Settings { tiles_from: 1, ..usual }),
    ]
}

/// Steps a stage, and returns the mean penetration over the last of them, metres.
fn settle(stage: &mut Stage, steps: usize, last: usize) -> f64 {
    stage.steps(steps - last);
    let depths = (0..last).map(|_| f64::from(stage.world.step().mean_penetration));
    depths.sum::<f64>() / last as f64
}

fn same(what: &str, results: &[(&str, f64)]) {
    let (_, usual) = results[0];
    for (name, x) in results {
        println!("{what}, {name}: {x:.4e} m, {:+.2} %", 100.0 * (x / usual - 1.0));
        assert!((x / usual - 1.0).abs() < 0.05, "{what}, {name}: {x} for {usual}");
    }
}

/// 130 pyramids of 36 cubes: how deep the contacts are, and how far cubes have gone from where they were built.
#[test]
fn pyramids_stand_alike() {
    let results = ways().map(|(name, settings)| {
        let mut stage = Stage::on_ground(settings, rubs(0.6, 0.0));
        let cube = stage.cuboid(0.5, 0.5, 0.5);
        for pyramid in 0..130 {
            let (x, y) = (10.0 * f64::from(pyramid % 13), 2.0 * f64::from(pyramid / 13));
            for row in 0..8 {
                for i in 0..8 - row {
                    let beside = 1.02 * (f64::from(i) + 0.5 * f64::from(row));
                    stage.put(stage.body(cube, at(x + beside, y, 0.5 + f64::from(row))));
                }
            }
        }
        let start = stage.world.poses();
        let depth = settle(&mut stage, 180, 30);
        let way = |(a, b): (&Pose, &Pose)| (b.position - a.position).length();
        let drift = start.iter().zip(&stage.world.poses()).map(way).sum::<f64>() / start.len() as f64;
        (name, depth, drift)
    });
    same("penetration of pyramids", &results.map(|(name, depth, _)| (name, depth)));
    same("drift of pyramids", &results.map(|(name, _, drift)| (name, drift)));
}

/// 4,500 boxes and balls fall into a heap between walls: how deep the contacts are while it comes to rest, and how high it lies.
#[test]
fn a_heap_comes_to_rest_alike() {
    let results = ways().map(|(name, settings)| {
        let mut stage = Stage::on_ground(settings, rubs(0.6, 0.0));
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            let wall = stage.shape(Shape::HalfSpace { normal, offset: -7.5 });
            stage.put(Body::fixed(wall, stage.material, Pose::default()));
        }
        let mut numbers = Numbers(7);
        for i in 0..4500 {
            let size = 0.3 + 0.2 * numbers.next() as f32;
            let shape =
                if i % 2 == 0 { stage.ball(size) } else { stage.cuboid(size, 0.8 * size, 0.7 * size) };
            let place = |n: i32| f64::from(n % 13) - 6.0;
            let position = DVec3::new(place(i), place(i / 13), 0.6 + f64::from(i / 169));
            let rotation = numbers.rotation();
            stage.put(stage.body(shape, Pose { position, rotation }));
        }
        let depth = settle(&mut stage, 240, 60);
        let heights = stage.world.poses().iter().map(|pose| pose.position.z).sum::<f64>();
        (name, depth, heights / stage.world.len() as f64)
    });
    same("penetration of a heap", &results.map(|(name, depth, _)| (name, depth)));
    same("height of a heap", &results.map(|(name, _, height)| (name, height)));
}
