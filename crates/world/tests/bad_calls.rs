//! Every error of the library, with its exact words; the world is left as it was.

mod common;

use common::{Stage, at, frames, rubs};
use rockfall::math::{DVec3, Mat3, Pose, Quat, Vec3};
use rockfall::{Body, BodyId, Error, Locks, MassOverride, Material, Settings, Shape, World};

fn stage() -> Stage {
    Stage::new(frames(), rubs(0.5, 0.0))
}

/// Promise: every setting out of its range is refused with its name, its value, and what it may be.
#[test]
fn settings_out_of_range() {
    let good = frames();
    let nan = f32::NAN;
    let table: Vec<(Settings, &str)> = vec![
        (
            Settings { gravity: Vec3::new(0.0, nan, 0.0), ..good },
            "setting `gravity` is [0, NaN, 0], expected three finite numbers",
        ),
        (Settings { rate: 0.0, ..good }, "setting `rate` is 0, expected a positive number"),
        (Settings { rate: -60.0, ..good }, "setting `rate` is -60, expected a positive number"),
        (Settings { rate: f32::INFINITY, ..good }, "setting `rate` is inf, expected a positive number"),
        (Settings { substeps: 0, ..good }, "setting `substeps` is 0, expected 1 to 10000"),
        (Settings { substeps: 10_001, ..good }, "setting `substeps` is 10001, expected 1 to 10000"),
        (Settings { contact_hertz: 0.0, ..good }, "setting `contact_hertz` is 0, expected a positive number"),
        (
            Settings { contact_damping: -1.0, ..good },
            "setting `contact_damping` is -1, expected a finite number, 0 or larger",
        ),
        (Settings { push_speed: nan, ..good }, "setting `push_speed` is NaN, expected a positive number"),
        (
            Settings { restitution_threshold: -0.5, ..good },
            "setting `restitution_threshold` is -0.5, expected a finite number, 0 or larger",
        ),
        (
            Settings { sleep_speed: nan, ..good },
            "setting `sleep_speed` is NaN, expected a finite number, 0 or larger",
        ),
        (
            Settings { sleep_time: -1.0, ..good },
            "setting `sleep_time` is -1, expected a finite number, 0 or larger",
        ),
        (Settings { threads: 5000, ..good }, "setting `threads` is 5000, expected 0 (all) to 4096"),
        (Settings { lanes: 3, ..good }, "setting `lanes` is 3, expected 0 (widest), 1, 4, 8 or 16"),
    ];
    for (settings, message) in table {
        assert_eq!(World::new(settings).expect_err(message).to_string(), message);
    }
}

/// Promise: so is every number of a material.
#[test]
fn materials_out_of_range() {
    let good = Material::default();
    let table: Vec<(Material, &str)> = vec![
        (Material { density: 0.0, ..good }, "density is 0, expected a positive number"),
        (Material { density: f32::NAN, ..good }, "density is NaN, expected a positive number"),
        (Material { restitution: 1.5, ..good }, "restitution is 1.5, expected a number from 0 to 1"),
        (Material { restitution: -0.1, ..good }, "restitution is -0.1, expected a number from 0 to 1"),
        (Material { friction: -1.0, ..good }, "friction is -1, expected a finite number, 0 or larger"),
        (
            Material { rolling_friction: f32::INFINITY, ..good },
            "rolling friction is inf, expected a finite number, 0 or larger",
        ),
        (
            Material { twisting_friction: -0.25, ..good },
            "twisting friction is -0.25, expected a finite number, 0 or larger",
        ),
    ];
    for (material, message) in table {
        assert_eq!(stage().world.add_material(material).expect_err(message).to_string(), message);
    }
}

/// Promise: so is every number of a body, alone or among others; no body is added.
#[test]
fn bodies_out_of_range() {
    let mut stage = stage();
    let ball = stage.ball(0.5);
    let good = stage.body(ball, Pose::default());
    let pose = |position, rotation| Pose { position, rotation };
    let mass = |mass| Some(MassOverride { mass, center: None, inertia: None });
    let inertia = |m| Some(MassOverride { mass: 1.0, center: None, inertia: Some(m) });
    let center = Some(MassOverride { mass: 1.0, center: Some(Vec3::NAN), inertia: None });
    let three = "expected three finite numbers";
    let table: Vec<(Body, String)> = vec![
        (
            Body { pose: pose(DVec3::new(f64::NAN, 0.0, 0.0), Quat::IDENTITY), ..good.clone() },
            "position is [NaN, 0, 0], expected three numbers within 1e12 m of the origin".into(),
        ),
        (
            Body { pose: at(0.0, 2e12, 0.0), ..good.clone() },
            "position is [0, 2000000000000, 0], expected three numbers within 1e12 m of the origin".into(),
        ),
        (
            Body { pose: pose(DVec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 2.0)), ..good.clone() },
            "rotation is [0, 0, 0, 2], expected a quaternion of length 1".into(),
        ),
        (
            Body { pose: pose(DVec3::ZERO, Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)), ..good.clone() },
            "rotation is [NaN, 0, 0, 1], expected a quaternion of length 1".into(),
        ),
        (Body { velocity: Vec3::INFINITY, ..good.clone() }, format!("velocity is [inf, inf, inf], {three}")),
        (
            Body { angular_velocity: Vec3::NAN, ..good.clone() },
            format!("angular velocity is [NaN, NaN, NaN], {three}"),
        ),
        (
            Body { gravity_scale: f32::NAN, ..good.clone() },
            "gravity scale is NaN, expected a finite number".into(),
        ),
        (
            Body { linear_damping: -1.0, ..good.clone() },
            "linear damping is -1, expected a finite number, 0 or larger".into(),
        ),
        (
            Body { angular_damping: f32::INFINITY, ..good.clone() },
            "angular damping is inf, expected a finite number, 0 or larger".into(),
        ),
        (Body { mass: mass(0.0), ..good.clone() }, "mass is 0, expected a positive number".into()),
        (Body { mass: mass(-1.0), ..good.clone() }, "mass is -1, expected a positive number".into()),
        (Body { mass: mass(f32::NAN), ..good.clone() }, "mass is NaN, expected a positive number".into()),
        (Body { mass: center, ..good.clone() }, format!("centre of mass is [NaN, NaN, NaN], {three}")),
        (
            Body { mass: inertia(Mat3::ZERO), ..good.clone() },
            "inertia is [[0, 0, 0], [0, 0, 0], [0, 0, 0]], expected a symmetric positive definite matrix"
                .into(),
        ),
        (
            Body { mass: inertia(Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0))), ..good.clone() },
            "inertia is [[1, 0, 0], [0, -1, 0], [0, 0, 1]], expected a symmetric positive definite matrix"
                .into(),
        ),
        (
            Body { id: Some(BodyId(u64::MAX)), ..good.clone() },
            "id is 18446744073709551615, expected 0 to 2^64 - 2".into(),
        ),
    ];
    for (body, message) in table {
        assert_eq!(stage.world.spawn(body.clone()).expect_err(&message).to_string(), message);
        let all = stage.world.spawn_all([good.clone(), body]).expect_err(&message);
        assert_eq!(all.to_string(), message);
        assert!(stage.world.is_empty(), "{message}");
    }
}

/// Promise: an id is given once: to one body of the world, and to one of a bulk.
#[test]
fn ids_are_given_once() {
    let mut stage = stage();
    let ball = stage.ball(0.5);
    let body = Body { id: Some(BodyId(7)), ..stage.body(ball, Pose::default()) };
    let message = "body 7 exists already";
    let twice = [body.clone(), body.clone()];
    assert_eq!(stage.world.spawn_all(twice).expect_err(message).to_string(), message);
    assert!(stage.world.is_empty());
    stage.put(body.clone());
    assert_eq!(stage.world.spawn(body.clone()).expect_err(message), Error::Duplicate(BodyId(7)));
    assert_eq!(stage.world.spawn_all([body]).expect_err(message).to_string(), message);
    assert_eq!(stage.world.len(), 1);
    // The next free id is above the largest.
    assert_eq!(stage.put(stage.body(ball, Pose::default())), BodyId(8));
}

/// Promise: ids of another world are refused where this one has none such.
#[test]
fn ids_of_another_world() {
    let mut other = stage();
    let (one, two) = (other.ball(1.0), other.ball(2.0));
    let wood = other.world.add_material(Material::default()).expect("a material");
    let mut stage = stage();
    stage.ball(1.0);
    let message = "unknown shape 1";
    let body = Body::new(two, stage.material, Pose::default());
    assert_eq!(stage.world.spawn(body).expect_err(message).to_string(), message);
    let message = "unknown material 1";
    let body = Body::new(one, wood, Pose::default());
    assert_eq!(stage.world.spawn(body).expect_err(message).to_string(), message);
}

/// Promise: calls about a body that is not there say so.
#[test]
fn no_such_body() {
    let mut stage = stage();
    let ball = stage.ball(0.5);
    let id = stage.put(stage.body(ball, Pose::default()));
    stage.world.remove(id).expect("the body is there");
    let world = &mut stage.world;
    let errors = [
        world.remove(id),
        world.set_velocity(id, Vec3::X, Vec3::ZERO),
        world.set_pose(id, Pose::default()),
        world.push(id, Vec3::X, DVec3::ZERO),
        world.pose(id).map(drop),
        world.velocity(id).map(drop),
        world.mass(id).map(drop),
    ];
    for error in errors {
        let error = error.expect_err("the body is gone");
        assert_eq!(error, Error::NoBody(id));
        assert_eq!(error.to_string(), "no body 1");
    }
}

/// Promise: calls with numbers that are not finite change nothing.
#[test]
fn pushes_that_are_no_numbers() {
    let mut stage = stage();
    let ball = stage.ball(0.5);
    let id = stage.put(stage.body(ball, Pose::default()));
    let hash = stage.world.hash();
    let world = &mut stage.world;
    let nan = DVec3::splat(f64::NAN);
    let three = "is [NaN, NaN, NaN], expected three finite numbers";
    for (result, message) in [
        (world.set_velocity(id, Vec3::NAN, Vec3::ZERO), format!("velocity {three}")),
        (world.set_velocity(id, Vec3::ZERO, Vec3::NAN), format!("angular velocity {three}")),
        (world.push(id, Vec3::NAN, DVec3::ZERO), format!("impulse {three}")),
        (world.push(id, Vec3::X, nan), format!("point {three}")),
        (
            world.set_pose(id, Pose::at(nan)),
            "position is [NaN, NaN, NaN], expected three numbers within 1e12 m of the origin".into(),
        ),
    ] {
        assert_eq!(result.expect_err(&message).to_string(), message);
    }
    assert_eq!(hash, stage.world.hash());
}

/// Promise: shapes that make no sense are refused, and shapes without an inside can't be dynamic.
#[test]
fn shapes_that_make_no_sense() {
    let mut stage = stage();
    let message = "the radius of the sphere is -1, expected a length from 1e-6 m to 1e6 m";
    let error = stage.world.add_shape(Shape::Sphere { radius: -1.0 }).expect_err(message);
    assert!(matches!(error, Error::Shape(_)));
    assert_eq!(error.to_string(), message);
    let plane = stage.shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
    let body = stage.body(plane, Pose::default());
    let message = "a half-space can't be dynamic, only static or kinematic";
    assert_eq!(stage.world.spawn(body).expect_err(message).to_string(), message);
}

/// Promise: an error that only a starved machine can raise still says what was asked for.
#[test]
fn threads_that_do_not_start() {
    let error = Error::Threads { threads: 9, reason: "no more threads".into() };
    assert_eq!(error.to_string(), "could not start 9 threads: no more threads");
}

/// Promise: a push of any finite size leaves a world that goes on: the body that is beyond every bound is frozen and reported, the
/// others are not disturbed.
#[test]
fn a_push_too_hard_freezes_one_body_only() {
    let run = |push: f32| {
        let mut stage = stage();
        let ball = stage.ball(0.5);
        let plain = stage.put(stage.body(ball, at(0.0, 0.0, 0.0)));
        let pushed = stage.put(stage.body(ball, at(10.0, 0.0, 0.0)));
        stage.steps(1);
        stage.world.push(pushed, Vec3::X * push, DVec3::new(10.0, 0.4, 0.0)).expect("the push is finite");
        stage.steps(60);
        assert!(stage.all_finite());
        (stage.world.frozen(), stage.world.report().frozen, stage.world.pose(plain))
    };
    let (frozen, count, calm) = run(0.0);
    assert_eq!((frozen.len(), count), (0, 0));
    for push in [1e12, 1e30, f32::MAX] {
        let (frozen, count, plain) = run(push);
        assert_eq!((frozen, count), (vec![BodyId(2)], 1), "{push}");
        assert_eq!(plain, calm, "{push}");
    }
}

/// Promise: every lock at once and a wild mix of extreme but legal numbers run without a panic.
#[test]
fn extreme_numbers_run() {
    let mut stage = Stage::on_ground(frames(), rubs(1e6, 1.0));
    let (tiny, huge) = (stage.ball(1e-6), stage.cuboid(1e6, 1e6, 1e6));
    let locks = Locks { linear: [true; 3], angular: [true; 3] };
    stage.put(Body { locks, ..stage.body(tiny, at(0.0, 0.0, 1e-6)) });
    stage.put(Body { gravity_scale: 1e9, ..stage.body(tiny, at(1.0, 0.0, 1.0)) });
    stage.put(Body { linear_damping: 1e30, angular_damping: 1e30, ..stage.body(huge, at(0.0, 0.0, 3e6)) });
    stage.put(Body { velocity: Vec3::splat(9e6), ..stage.body(tiny, at(1e12, -1e12, 1e12)) });
    let mass = Some(MassOverride { mass: 1e-20, center: None, inertia: None });
    stage.put(Body { mass, ..stage.body(huge, at(0.0, 5e6, 1e6)) });
    stage.steps(30);
    assert!(stage.all_finite(), "{:?}", stage.world.poses());
}
