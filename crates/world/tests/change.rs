//! Settings and materials that change between two steps, and springs that pull. Promise: from the next step on the world is as if it had always been so, sleepers
//! included.

mod common;

use common::{G, Slope, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Vec3};
use rockfall::{Body, Error, Material, Settings, Shape, Spring, World};

#[test]
fn a_body_falls_as_the_new_gravity_wants_it_and_sleepers_wake() {
    let mut stage = Stage::on_ground(Settings { sleeping: true, ..frames() }, rubs(0.5, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let cube = stage.put(stage.body(cube, at(0.0, 0.0, 0.5)));
    stage.steps(120);
    assert_eq!(stage.world.report().awake, 0);
    let up = Settings { gravity: Vec3::new(0.0, 0.0, 2.0), threads: 7, ..*stage.world.settings() };
    stage.world.set_settings(up).unwrap();
    assert_eq!(stage.world.settings().threads, 1, "threads stay what they were");
    stage.steps(60);
    // s = g t² / 2, and half a sub-step of velocity.
    let way = stage.position(cube).z - 0.5;
    assert!((way - 1.0).abs() < 0.02, "{way}");
    let wrong = stage.world.set_settings(Settings { substeps: 0, ..up });
    assert!(matches!(wrong, Err(Error::Setting { name: "substeps", .. })));
    assert_eq!(stage.world.settings().substeps, 4);
}

#[test]
fn a_block_that_slept_on_a_slope_slides_as_the_new_friction_lets_it() {
    for fixed_changes in [false, true] {
        let mut stage = Stage::new(Settings { sleeping: true, ..frames() }, rubs(0.6, 0.0));
        let slope = Slope::new(20.0);
        let ground = stage.world.add_material(rubs(0.6, 0.0)).unwrap();
        let plane = stage.shape(Shape::HalfSpace { normal: slope.normal, offset: 0.0 });
        stage.put(Body::fixed(plane, ground, at(0.0, 0.0, 0.0)));
        let block = stage.cuboid(0.5, 0.5, 0.25);
        let block = stage.put(stage.body(block, slope.pose(0.25)));
        stage.steps(120);
        assert_eq!(stage.world.report().awake, 0);
        let changed = if fixed_changes { ground } else { stage.material };
        // The mean of two materials: √(0.6 · 0.6 / 36) = 0.1.
        let old = stage.world.material(changed).unwrap();
        stage.world.set_material(changed, Material { friction: 0.6 / 36.0, ..old }).unwrap();
        stage.steps(60);
        let speed = stage.velocity(block).0.dot(slope.down);
        let (sin, cos) = 20_f32.to_radians().sin_cos();
        let expected = G * (sin - 0.1 * cos);
        assert!((speed / expected - 1.0).abs() < 0.02, "{speed} m/s for {expected}");
    }
    let mut other = World::new(frames()).unwrap();
    other.add_material(Material::default()).unwrap();
    let last = other.add_material(Material::default()).unwrap();
    let mut world = World::new(frames()).unwrap();
    assert!(matches!(world.set_material(last, Material::default()), Err(Error::Unknown { index: 1, .. })));
    let wrong = Material { friction: -1.0, ..Material::default() };
    assert!(matches!(other.set_material(last, wrong), Err(Error::Value { what: "friction", .. })));
}

/// A spring without gravity.
fn pulled(half: f32, at_point: Vec3, hertz: f32, steps: usize) -> Vec<DVec3> {
    let mut stage = Stage::new(Settings { gravity: Vec3::ZERO, ..frames() }, rubs(0.5, 0.0));
    let cube = stage.cuboid(half, half, half);
    // What is pulled at its side would spin around the point for ever, and stretch the spring.
    let body = Body { angular_damping: 3.0, ..stage.body(cube, at(0.0, 0.0, 0.0)) };
    let cube = stage.put(body);
    let spring =
        Spring { at: at_point * half, to: DVec3::new(3.0, 0.0, 0.0), hertz, damping: 1.0, most: 1e12 };
    (0..steps)
        .map(|_| {
            stage.world.pull(cube, &spring).unwrap();
            stage.world.step();
            stage.world.pose(cube).unwrap().point(spring.at)
        })
        .collect()
}

#[test]
fn a_spring_is_the_same_for_any_mass_and_follows_the_curve_of_critical_damping() {
    let (light, heavy) = (pulled(0.05, Vec3::ZERO, 1.0, 120), pulled(2.0, Vec3::ZERO, 1.0, 120));
    for (k, (a, b)) in light.iter().zip(&heavy).enumerate() {
        assert!((*a - *b).length() < 1e-4, "step {k}: {a} and {b}");
        // x = 3 - 3 (1 + ω t) e^(-ω t); an implicit step is of first order.
        let t = std::f64::consts::TAU * (k + 1) as f64 / 60.0;
        let exact = 3.0 - 3.0 * (1.0 + t) * (-t).exp();
        assert!((a.x - exact).abs() < 0.15, "step {k}: {} for {exact}", a.x);
    }
    assert!((light[119].x - 3.0).abs() < 1e-3);
}

#[test]
fn a_corner_that_is_pulled_arrives_and_stays_however_stiff_the_spring() {
    let way = pulled(0.5, Vec3::new(1.0, 1.0, 0.2), 4.0, 240);
    assert!((way[239] - DVec3::new(3.0, 0.0, 0.0)).length() < 0.01, "{}", way[239]);
    let stiff = pulled(0.5, Vec3::ZERO, 1e5, 60);
    assert!(stiff.iter().all(|p| (*p - DVec3::new(3.0, 0.0, 0.0)).length() < 1e-3), "{stiff:?}");
}

#[test]
fn a_force_has_its_limit_and_wrong_springs_are_refused() {
    let mut stage = Stage::new(Settings { gravity: Vec3::ZERO, ..frames() }, rubs(0.5, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let cube = stage.put(stage.body(cube, at(0.0, 0.0, 0.0)));
    let spring =
        Spring { at: Vec3::ZERO, to: DVec3::new(100.0, 0.0, 0.0), hertz: 5.0, damping: 1.0, most: 600.0 };
    stage.world.pull(cube, &spring).unwrap();
    // 600 N for a 60th of a second on 1000 kg.
    assert!((stage.velocity(cube).0.x - 0.01).abs() < 1e-6);
    for wrong in [
        Spring { to: DVec3::NAN, ..spring },
        Spring { at: Vec3::INFINITY, ..spring },
        Spring { hertz: 0.0, ..spring },
        Spring { damping: -1.0, ..spring },
        Spring { most: f32::NAN, ..spring },
    ] {
        assert!(matches!(stage.world.pull(cube, &wrong), Err(Error::Value { .. })), "{wrong:?}");
    }
    assert!((stage.velocity(cube).0.x - 0.01).abs() < 1e-6);
}

#[test]
fn changes_give_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let mut stage = Stage::on_ground(Settings { threads, ..frames() }, rubs(0.6, 0.0));
        let cube = stage.cuboid(0.5, 0.5, 0.5);
        let ids: Vec<_> = (0..100)
            .map(|k| {
                let (x, y, z) = (f64::from(k % 5), f64::from(k / 5 % 5), f64::from(k / 25));
                stage.put(stage.body(cube, at(1.2 * x, 1.2 * y, 0.5 + z)))
            })
            .collect();
        stage.steps(30);
        stage.world.set_material(stage.material, rubs(0.1, 0.3)).unwrap();
        let settings =
            Settings { gravity: Vec3::new(3.0, 0.0, -9.0), substeps: 2, ..*stage.world.settings() };
        stage.world.set_settings(settings).unwrap();
        let spring = Spring {
            at: Vec3::new(0.5, 0.0, 0.5),
            to: DVec3::new(0.0, 0.0, 4.0),
            hertz: 3.0,
            damping: 0.8,
            most: 1e6,
        };
        for _ in 0..60 {
            stage.world.pull(ids[12], &spring).unwrap();
            stage.world.step();
        }
        stage.world.hash()
    };
    assert_eq!(run(1), run(3));
}
