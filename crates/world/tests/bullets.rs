//! Nothing passes through anything: fast bodies against thin ones, both moving.

mod common;

use common::{Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec2, Vec3, rotation};
use rockfall::shape::{HeightField, Hull, Mesh};
use rockfall::{Body, BodyId, Kind, Locks, Settings, Shape};
use std::sync::Arc;

fn swept() -> Settings {
    Settings { continuous: true, gravity: Vec3::ZERO, ..frames() }
}

/// 1 cm across.
fn bullets() -> [Shape; 5] {
    let tip = |k: u32| {
        let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::new(0.005 * sign(0), 0.005 * sign(1), 0.005 * sign(2))
    };
    let corners: Vec<Vec3> = (0..8).map(tip).chain([Vec3::Z * 0.01]).collect();
    [
        Shape::Sphere { radius: 0.005 },
        Shape::Box { half: Vec3::splat(0.005) },
        Shape::Capsule { half_length: 0.005, radius: 0.005 },
        Shape::Cylinder { half_length: 0.005, radius: 0.005 },
        Shape::Hull(Arc::new(Hull::from_points(&corners).expect("a bullet"))),
    ]
}

const SPEEDS: [f32; 6] = [10.0, 40.0, 150.0, 600.0, 2000.0, 5000.0];

/// Half edges of a wall of 1 mm.
const WALL: Vec3 = Vec3::new(1.0, 1.0, 5e-4);

fn seen_from(stage: &Stage, wall: BodyId, body: BodyId) -> Vec3 {
    let pose = stage.world.pose(wall).expect("the wall is there");
    let away = (stage.position(body) - pose.position).as_vec3();
    rotation::rotate(rotation::inverse(pose.rotation), away)
}

/// Shoots 600 bullets at a wall from above, and counts those that are seen behind it, step by step, for as long as they are over it.
fn shoot(what: &str, wall: impl Fn(&mut Stage) -> BodyId, numbers: &mut Numbers) -> usize {
    let (mut met, mut missed) = (0, 0);
    for shape in bullets() {
        for speed in SPEEDS {
            let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
            let wall = wall(&mut stage);
            let bullet = stage.shape(shape.clone());
            let ids: Vec<BodyId> = (0..20)
                .map(|k| {
                    let aim = DVec3::new(0.08 * f64::from(k % 5) - 0.2, 0.08 * f64::from(k / 5) - 0.2, 0.0);
                    let lean = numbers.vector() * DVec3::new(0.02, 0.02, 0.0) - DVec3::Z;
                    // One to three steps away.
                    let far = f64::from(speed) / 60.0 * (0.1 + 2.0 * numbers.next()) + 0.02;
                    let pose = Pose { position: aim - lean * far, rotation: numbers.rotation() };
                    let velocity = (lean * f64::from(speed)).as_vec3();
                    let angular_velocity = (numbers.vector() * 100.0).as_vec3();
                    stage.put(Body { velocity, angular_velocity, ..stage.body(bullet, pose) })
                })
                .collect();
            // Who slides off over the rim may come behind it.
            let mut over = vec![true; ids.len()];
            for step in 0..6 {
                stage.steps(1);
                for (over, &id) in over.iter_mut().zip(&ids) {
                    let place = seen_from(&stage, wall, id);
                    *over &= place.x.abs() < WALL.x && place.y.abs() < WALL.y;
                    if *over && place.z <= 0.0 {
                        println!("{}, {speed} m/s, step {step}: {place} behind {what}", shape.name());
                        (*over, missed) = (false, missed + 1);
                    }
                }
            }
            met += over.iter().filter(|over| **over).count();
            assert!(stage.all_finite());
        }
    }
    assert!(met > 100, "only {met} of 600 were over {what} to the end");
    missed
}

fn still(shape: Shape) -> impl Fn(&mut Stage) -> BodyId {
    move |stage| {
        let id = stage.shape(shape.clone());
        stage.put(Body::fixed(id, stage.material, Pose::default()))
    }
}

/// Promise: no bullet of 1 cm passes a wall of 1 mm that stands, from 10 to 5000 m/s: box, hull, mesh or height field.
#[test]
fn no_bullet_passes_a_wall_that_stands() {
    let hull = Hull::cuboid(WALL);
    let triangles: Vec<[u32; 3]> = (0..hull.normals.len())
        .flat_map(|f| {
            let face = hull.face(f);
            (2..face.len()).map(|k| [face[0], face[k - 1], face[k]]).collect::<Vec<_>>()
        })
        .collect();
    let mesh = Mesh::from_triangles(&hull.vertices, &triangles).expect("a wall");
    let field = HeightField::new(9, 9, Vec2::splat(0.25), vec![0.0; 81]).expect("a field");
    let walls = [
        Shape::Box { half: WALL },
        Shape::Hull(Arc::new(hull)),
        Shape::Mesh(Arc::new(mesh)),
        Shape::HeightField(Arc::new(field)),
    ];
    for (k, wall) in walls.into_iter().enumerate() {
        let missed = shoot(&format!("a {}", wall.name()), still(wall), &mut Numbers(100 * k as u64));
        assert_eq!(missed, 0);
    }
}

/// Promise: none passes one that moves, slowly or fast, whether contacts move it or not, though twenty others hit it in the same step.
#[test]
fn no_bullet_passes_a_wall_that_moves() {
    let mut missed = 0;
    let shapes = [Shape::Box { half: WALL }, Shape::Hull(Arc::new(Hull::cuboid(WALL)))];
    for (k, shape) in shapes.iter().enumerate() {
        for kind in [Kind::Kinematic, Kind::Dynamic] {
            for climb in [-5.0, 0.0, 1.0, 30.0, 200.0] {
                let wall = |stage: &mut Stage| {
                    let id = stage.shape(shape.clone());
                    let velocity = Vec3::new(0.1, 0.0, climb);
                    let locks = Locks { linear: [false; 3], angular: [kind == Kind::Dynamic; 3] };
                    stage.put(Body { velocity, kind, locks, ..stage.body(id, Pose::default()) })
                };
                let what = format!("a {kind:?} {} at {climb} m/s", shape.name());
                missed += shoot(&what, wall, &mut Numbers(7000 + 10 * k as u64));
            }
        }
    }
    assert_eq!(missed, 0, "of 12000");
}

/// Promise: a fast wall takes along what lies in its way, at rest or asleep.
#[test]
fn a_fast_wall_passes_nobody() {
    for kind in [Kind::Kinematic, Kind::Dynamic] {
        for speed in [3.0_f32, 30.0, 300.0] {
            let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
            let plate = stage.cuboid(WALL.x, WALL.y, WALL.z);
            let velocity = Vec3::Z * speed;
            let locks = Locks { linear: [false; 3], angular: [kind == Kind::Dynamic; 3] };
            let pose = at(0.0, 0.0, -0.5);
            let wall = stage.put(Body { velocity, kind, locks, ..stage.body(plate, pose) });
            let ids: Vec<BodyId> = bullets()
                .into_iter()
                .enumerate()
                .map(|(k, shape)| {
                    let id = stage.shape(shape);
                    stage.put(stage.body(id, at(0.1 * k as f64 - 0.2, 0.0, 0.0)))
                })
                .collect();
            for step in 0..40 {
                stage.steps(1);
                for (k, &id) in ids.iter().enumerate() {
                    let place = seen_from(&stage, wall, id);
                    assert!(place.z > 0.0, "{kind:?} at {speed} m/s, bullet {k}, step {step}: {place}");
                }
            }
        }
    }
}

/// Promise: bodies that fly at each other meet, whatever their speed, and end at rest where they met.
#[test]
fn nothing_flies_through_what_comes_towards_it() {
    for speed in SPEEDS {
        for (k, shape) in bullets().into_iter().enumerate() {
            let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
            let id = stage.shape(shape.clone());
            let far = 0.02 + f64::from(speed) / 60.0 * (1.3 + 0.2 * k as f64);
            let [left, right] = [-1.0, 1.0].map(|side: f64| {
                let velocity = Vec3::X * -(side as f32) * speed;
                stage.put(Body { velocity, ..stage.body(id, at(side * far, 0.0, 0.0)) })
            });
            for step in 0..6 {
                stage.steps(1);
                let gap = stage.position(right).x - stage.position(left).x;
                assert!(gap > 0.005, "{} at {speed} m/s, step {step}: {gap} m", shape.name());
            }
            let (v, u) = (stage.velocity(left).0.x, stage.velocity(right).0.x);
            assert!(v <= 1e-3 * speed && u >= -1e-3 * speed, "{} at {speed} m/s: {v} {u}", shape.name());
            let middle = stage.position(right).x + stage.position(left).x;
            assert!(middle.abs() < 1e-3 * far, "they met {middle} m from the middle");
        }
    }
}

/// Promise (Jolt's `LinearCast`): cubes of 1 m that fly at each other with 120 m/s, 2 m in a step each, turn back at that speed with a restitution
/// of 1. With one of 0 they part with a twentieth of that at most: the solver, which goes through their corners one after the other, sets them spinning.
#[test]
fn fast_boxes_bounce_as_slow_ones() {
    for (restitution, after) in [(1.0, 120.0), (0.0, 0.0)] {
        for start in [3.0, 3.7, 4.4] {
            let mut stage = Stage::new(swept(), rubs(0.0, restitution));
            let cube = stage.cuboid(0.5, 0.5, 0.5);
            let [left, right] = [-1.0_f32, 1.0].map(|side| {
                let pose = at(f64::from(side) * start, 0.0, 0.0);
                stage.put(Body { velocity: Vec3::X * -side * 120.0, ..stage.body(cube, pose) })
            });
            stage.steps(5);
            let (v, u) = (stage.velocity(left).0, stage.velocity(right).0);
            println!("{restitution} {start}: {v} {u} at {}", stage.position(right));
            let within = if restitution == 1.0 { 0.1 } else { 6.0 };
            let off = (v + Vec3::X * after).length().max((u - Vec3::X * after).length());
            assert!(off < within, "{v} {u}");
            let gap = stage.position(right).x - stage.position(left).x;
            assert!(gap > 1.0 - 0.02, "{gap}");
        }
    }
}

/// Promise: a rod that spins, its ends at up to 90 m/s, does not sweep through thin plates that float around it.
#[test]
fn a_spinning_rod_passes_no_plate() {
    let rods = [
        Shape::Box { half: Vec3::new(0.5, 0.01, 0.01) },
        Shape::Hull(Arc::new(Hull::cuboid(Vec3::new(0.5, 0.01, 0.01)))),
    ];
    for rod in rods {
        for spin in [20.0_f32, 60.0, 180.0] {
            for phase in 0..8 {
                let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
                let id = stage.shape(rod.clone());
                let turn = rotation::from_rotation_vector(Vec3::Z * (0.15 + 0.05 * phase as f32));
                let pose = Pose { position: DVec3::ZERO, rotation: turn };
                let angular_velocity = Vec3::NEG_Z * spin;
                let hub = Locks { linear: [true; 3], angular: [true, true, false] };
                let rod = stage.put(Body { angular_velocity, locks: hub, ..stage.body(id, pose) });
                // A plate of 1 mm across x, its front towards +y.
                let plate = stage.cuboid(0.2, 5e-4, 0.2);
                let plate = stage.put(stage.body(plate, at(0.3, 0.0, 0.0)));
                for step in 0..4 {
                    stage.steps(1);
                    // Where the rod crosses the plate's place along it, its middle line is in front of the plate.
                    let along = rotation::rotate(stage.rotation(rod), Vec3::X);
                    let pose = stage.world.pose(plate).expect("the plate is there");
                    let back = rotation::inverse(pose.rotation);
                    let reach = pose.position.length() as f32;
                    if reach > 0.45 {
                        break;
                    }
                    let there = rotation::rotate(back, along * reach - pose.position.as_vec3());
                    assert!(there.y > -1e-3, "{spin} rad/s, {phase}, step {step}: {there}");
                }
            }
        }
    }
}

/// So many pairs of a thin plate and a bullet, both with random shapes and motions, the bullet aimed at the plate: how many there are on the other
/// side after three steps, and how many were looked at.
fn casts(count: usize, seed: u64) -> [usize; 2] {
    let mut numbers = Numbers(seed);
    let shapes = bullets();
    let (mut missed, mut seen) = (0, 0);
    for _ in 0..count.div_ceil(500) {
        let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
        let bullet_ids = shapes.clone().map(|shape| stage.shape(shape));
        let thin = 10.0_f64.powf(-4.0 + 2.0 * numbers.next()) as f32;
        let half = Vec3::new(1.0, 0.8, thin);
        let plates = [
            stage.shape(Shape::Box { half }),
            stage.shape(Shape::Hull(Arc::new(Hull::cuboid(half)))),
            stage.shape(Shape::Cylinder { half_length: thin, radius: 1.0 }),
            stage.shape(Shape::RoundedBox { half: half - 0.5 * thin, radius: 0.5 * thin }),
        ];
        let pairs: Vec<(BodyId, BodyId, f32)> = (0..500)
            .map(|k| {
                let cell = DVec3::new(f64::from(k % 8), f64::from(k / 8 % 8), f64::from(k / 64)) * 2000.0;
                let rotation = numbers.rotation();
                let turned = |v: DVec3| rotation::rotate(rotation, v.as_vec3());
                let drift = (numbers.vector() * 10.0_f64.powf(3.0 * numbers.next() - 1.0)).as_vec3();
                let plate = Body {
                    velocity: drift,
                    angular_velocity: (numbers.vector() * 3.0).as_vec3(),
                    ..stage.body(plates[k as usize % 4], Pose { position: cell, rotation })
                };
                let speed = 10.0_f64.powf(1.0 + 2.7 * numbers.next());
                let side = if numbers.next() < 0.5 { -1.0 } else { 1.0 };
                let lean = (numbers.vector() * DVec3::new(0.2, 0.2, 0.0) + DVec3::Z * side).normalize();
                let aim = numbers.vector() * DVec3::new(0.3, 0.3, 0.0);
                let far = 0.02 + speed / 60.0 * (0.02 + 1.5 * numbers.next());
                let position = cell + turned(aim + lean * far).as_dvec3();
                let bullet = Body {
                    velocity: drift - turned(lean) * speed as f32,
                    angular_velocity: (numbers.vector() * 200.0).as_vec3(),
                    ..stage.body(bullet_ids[k as usize % 5], Pose { position, rotation: numbers.rotation() })
                };
                (stage.put(plate), stage.put(bullet), side as f32)
            })
            .collect();
        for step in 0..3 {
            stage.steps(1);
            for &(plate, bullet, side) in &pairs {
                let place = seen_from(&stage, plate, bullet);
                if place.x.abs() < 0.7 && place.y.abs() < 0.6 {
                    seen += usize::from(step == 2);
                    if place.z * side < 0.0 {
                        missed += 1;
                        println!("step {step}: {place} from {side}");
                    }
                }
            }
        }
    }
    [missed, seen]
}

/// Promise: of a hundred thousand bullets that are shot at plates of 0.2 to 20 mm, from 10 to 5000 m/s, both moving and turning, not one passes.
#[test]
fn a_hundred_thousand_bullets_pass_no_plate() {
    let [missed, seen] = casts(100_000, 2);
    assert_eq!(missed, 0, "of {seen}");
    assert!(seen > 40_000, "only {seen} have come to the plate");
}
