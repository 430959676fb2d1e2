//! Fast bodies on surfaces of triangles: what slides, rolls or turns on one goes on moving, and nothing passes.

mod common;

use common::{Numbers, Slope, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Quat, Vec3, rotation, trig};
use rockfall::shape::{Hull, Mesh};
use rockfall::{Body, BodyId, Settings, Shape};
use std::f32::consts::TAU;
use std::sync::Arc;

fn swept() -> Settings {
    Settings { continuous: true, ..frames() }
}

/// `m` × `n` cells of two triangles each between the places of (i, j); their front is where j is to the left of i.
fn sheet(m: u32, n: u32, place: impl Fn(u32, u32) -> Vec3) -> Shape {
    let across = m + 1;
    let vertices: Vec<Vec3> = (0..across * (n + 1)).map(|k| place(k % across, k / across)).collect();
    let triangles: Vec<[u32; 3]> = (0..m * n)
        .flat_map(|cell| {
            let a = cell / m * across + cell % m;
            [[a, a + 1, a + 1 + across], [a, a + 1 + across, a + across]]
        })
        .collect();
    Shape::Mesh(Arc::new(Mesh::from_triangles(&vertices, &triangles).expect("a sheet")))
}

/// A square of 30 m.
fn flat(cells: u32) -> Shape {
    let place = |i: u32| 30.0 * (i as f32 / cells as f32 - 0.5);
    sheet(cells, cells, |i, j| Vec3::new(place(i), place(j), 0.0))
}

/// Each with the height of its middle when it lies, 0.1 m, which is its inner radius.
fn shapes() -> [Shape; 4] {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        Vec3::new(0.3 * sign(0), 0.2 * sign(1), 0.1 * sign(2))
    };
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    [
        Shape::Sphere { radius: 0.1 },
        Shape::Capsule { half_length: 0.2, radius: 0.1 },
        Shape::Box { half: Vec3::new(0.3, 0.2, 0.1) },
        Shape::Hull(Arc::new(Hull::from_points(&corners).expect("a block"))),
    ]
}

/// Turns a shape so that it lies, a capsule along y.
fn lying(shape: &Shape) -> Quat {
    if matches!(shape, Shape::Capsule { .. }) { rotation::between(Vec3::Z, Vec3::Y) } else { Quat::IDENTITY }
}

/// Way of a body in a step over the way that its velocity would be, and its speed in m/s.
fn follows(stage: &mut Stage, id: BodyId) -> (f64, f64) {
    let before = stage.position(id);
    stage.steps(1);
    let speed = f64::from(stage.velocity(id).0.length());
    ((stage.position(id) - before).length() * f64::from(stage.world.settings().rate) / speed, speed)
}

/// Promise: what lies on a mesh and is thrown along it, sliding, rolling and turning, is after a second where it would be
/// on a half-space, to 1 cm in 5 to 16 m, however fine the mesh is and however it leans.
#[test]
fn what_is_thrown_along_a_mesh_goes_as_on_a_plane() {
    let throws = [
        (Vec3::new(12.0, 0.0, 0.0), Vec3::ZERO),
        (Vec3::new(12.0, 0.0, 0.0), Vec3::new(0.0, 120.0, 0.0)),
        (Vec3::new(1.0, 12.0, 0.0), Vec3::new(0.0, 0.0, 30.0)),
        (Vec3::new(3.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 60.0)),
    ];
    for (shape, degrees) in shapes().iter().flat_map(|shape| [(shape, 0.0), (shape, 20.0)]) {
        // What is round rolls; a block would tumble.
        let round = matches!(shape, Shape::Sphere { .. } | Shape::Capsule { .. });
        for (velocity, spin) in throws.into_iter().filter(|(_, spin)| round || spin.y == 0.0) {
            let slope = Slope::new(degrees);
            let turned = |v: Vec3| rotation::rotate(slope.rotation, v);
            let run = |ground: Shape| {
                let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
                let ground = stage.shape(ground);
                let lean = Pose { position: DVec3::ZERO, rotation: slope.rotation };
                stage.put(Body::fixed(ground, stage.material, lean));
                let position = turned(Vec3::new(-8.0, 0.3, 0.1)).as_dvec3();
                let rotation = rotation::compose(slope.rotation, lying(shape));
                let shape = stage.shape(shape.clone());
                let body = stage.body(shape, Pose { position, rotation });
                let (velocity, angular_velocity) = (turned(velocity), turned(spin));
                let id = stage.put(Body { velocity, angular_velocity, ..body });
                let mut least = f64::INFINITY;
                for _ in 0..60 {
                    let (share, speed) = follows(&mut stage, id);
                    least = if speed > 0.5 { least.min(share) } else { least };
                }
                (stage.position(id), least)
            };
            let (plane, _) = run(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
            for cells in [8, 64] {
                let (mesh, least) = run(flat(cells));
                let off = (mesh - plane).length();
                let what = format!("{} {velocity} {spin} {degrees}° {cells}", shape.name());
                println!("{what}: {off:.4} m off, follows by {least:.3} at least");
                assert!(off < 0.01 && least > 0.9, "{what}: {off} m off {plane}, follows by {least}");
            }
        }
    }
}

/// Promise: what slides off the rim of a mesh flies on as from the edge of a thick box: to 5 cm after 6 m and a fall of 1 m.
#[test]
fn what_slides_over_the_rim_flies_on() {
    for shape in &shapes() {
        let run = |ground: Shape, low: f64| {
            let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
            let ground = stage.shape(ground);
            stage.put(Body::fixed(ground, stage.material, at(0.0, 0.0, low)));
            let pose = Pose { rotation: lying(shape), ..at(12.0, 0.3, 0.1) };
            let shape = stage.shape(shape.clone());
            let (velocity, angular_velocity) = (Vec3::X * 10.0, Vec3::Z * 20.0);
            let id = stage.put(Body { velocity, angular_velocity, ..stage.body(shape, pose) });
            let least = (0..45).map(|_| follows(&mut stage, id).0).fold(f64::INFINITY, f64::min);
            (stage.position(id), least)
        };
        let (thick, _) = run(Shape::Box { half: Vec3::new(15.0, 15.0, 5.0) }, -5.0);
        let (thin, least) = run(flat(60), 0.0);
        println!("{}: {thin:.3} {thick:.3}, follows by {least:.3}", shape.name());
        assert!(thin.z < -0.5 && (thin - thick).length() < 0.05 && least > 0.9, "{thin} {thick} {least}");
    }
}

/// Promise: what is thrown into a half-pipe of flat strips, of which it meets others in every step, runs through it: each step takes
/// it a fifth as far as its velocity says at least, also at 60 m/s, where the straight way of a step ends 0.17 m
/// outside; it stays inside, and it gains no energy.
#[test]
fn what_runs_through_a_pipe_is_not_held_up() {
    let radius = 3.0;
    // Four of its strips to a way of 0.25 m in a step.
    let strips = 150;
    let pipe = sheet(20, strips, |i, j| {
        let (sin, cos) = trig::sin_cos(0.5 * TAU * (j as f32 / strips as f32 - 1.0));
        Vec3::new(2.0 * i as f32 - 20.0, radius * cos, radius * sin)
    });
    for (shape, speed) in shapes().iter().flat_map(|shape| [15.0, 30.0, 60.0].map(|speed| (shape, speed))) {
        let mut stage = Stage::new(Settings { gravity: Vec3::ZERO, ..swept() }, rubs(0.0, 0.0));
        let ground = stage.shape(pipe.clone());
        stage.put(Body::fixed(ground, stage.material, Pose::default()));
        let id = stage.shape(shape.clone());
        // Axes along the pipe.
        let round = matches!(shape, Shape::Capsule { .. });
        let rotation = if round { rotation::between(Vec3::Z, Vec3::X) } else { Quat::IDENTITY };
        let pose = Pose { rotation, ..at(0.0, -1.0, -2.5) };
        let id = stage.put(Body { velocity: Vec3::new(1.0, speed, 0.0), ..stage.body(id, pose) });
        let (mut steps, mut least, mut energy) = (0, f64::INFINITY, f64::INFINITY);
        while stage.position(id).z < -0.3 && steps < 60 {
            let (share, _) = follows(&mut stage, id);
            let off = stage.position(id).with_x(0.0).length();
            (steps, least) = (steps + 1, least.min(share));
            assert!(off < f64::from(radius), "{} is {off} m from the axis", shape.name());
            assert!(stage.total_energy() < 1.001 * energy, "{} gains energy", shape.name());
            energy = stage.total_energy();
        }
        println!("{} at {speed} m/s: {steps} steps, follows by {least:.3}", shape.name());
        let what = shape.name();
        assert!(least > 0.2 && steps < 24, "{what} needs {steps} steps, follows by {least}");
    }
}

/// A ring that stands upright, half in the ground: of Box3D's scene `rain`.
fn arch() -> Shape {
    let angle = |i: u32| trig::sin_cos(TAU * (i % 16) as f32 / 16.0);
    sheet(16, 16, |i, j| {
        let ((sin, cos), (rise, out)) = (angle(i), angle(j));
        Vec3::new((3.75 + out) * cos, -rise, (3.75 + out) * sin)
    })
}

/// Promise: of a heap that falls on an arch from 15 m nobody hangs in the air: none that is faster than 1 m/s stays where it is for
/// more than the step in which it meets the arch and one in which it meets the ground or another triangle. And nobody goes through.
#[test]
fn nobody_hangs_on_an_arch() {
    let mut stage = Stage::new(swept(), rubs(0.6, 0.0));
    for shape in [flat(16), arch()] {
        let shape = stage.shape(shape);
        stage.put(Body::fixed(shape, stage.material, Pose::default()));
    }
    let shapes = shapes().map(|shape| (lying(&shape), stage.shape(shape)));
    let mut ids = Vec::new();
    for k in 0..120_usize {
        let (turn, shape) = shapes[k % 4];
        let (x, y, z) = (k % 6, k / 6 % 4, k / 24);
        let pose = at(0.7 * x as f64 - 2.0, 0.5 * y as f64 - 0.7, 20.0 + 0.25 * z as f64);
        ids.push(stage.put(stage.body(shape, Pose { rotation: turn, ..pose })));
    }
    let mut held = vec![0; ids.len()];
    let mut longest = 0;
    for step in 0..180 {
        let before: Vec<DVec3> = ids.iter().map(|&id| stage.position(id)).collect();
        stage.steps(1);
        for (k, &id) in ids.iter().enumerate() {
            let (place, speed) = (stage.position(id), f64::from(stage.velocity(id).0.length()));
            let still = speed > 1.0 && (place - before[k]).length() * 60.0 < 0.1 * speed;
            held[k] = if still { held[k] + 1 } else { 0 };
            longest = longest.max(held[k]);
            let over = place.x.abs() < 15.0 && place.y.abs() < 15.0;
            assert!(place.z > 0.0 || !over, "{k} is under the ground in step {step}: {place}");
        }
    }
    println!("held for {longest} steps");
    assert!(longest <= 2, "{longest} steps");
}

/// Promise: no speed, spin, lean or way of lying takes a body through a sheet of no thickness: a second after it was shot at its front it is
/// still in front of it.
#[test]
fn nothing_is_shot_through_a_sheet() {
    let mut numbers = Numbers(3);
    let bumps: Vec<f32> = (0..31 * 31).map(|_| 0.3 * numbers.next() as f32).collect();
    let rough =
        sheet(30, 30, |i, j| Vec3::new(i as f32 - 15.0, j as f32 - 15.0, bumps[(31 * j + i) as usize]));
    for (ground, floor) in [(flat(8), 0.0), (flat(120), 0.0), (rough, -0.1)] {
        for shape in &shapes() {
            for speed in [5.0, 20.0, 80.0, 300.0, 3000.0] {
                let mut stage = Stage::new(swept(), rubs(0.3, 0.0));
                let ground = stage.shape(ground.clone());
                stage.put(Body::fixed(ground, stage.material, Pose::default()));
                let id = stage.shape(shape.clone());
                let ids: Vec<BodyId> = (0..40)
                    .map(|k| {
                        let aim = numbers.vector() * 1.5;
                        let from =
                            DVec3::new(aim.x + 3.0 * f64::from(k % 6) - 7.5, aim.y, 1.0 + numbers.next());
                        let down = (numbers.vector() * DVec3::new(0.7, 0.7, 0.4) - DVec3::Z).normalize();
                        let body = stage.body(id, Pose { position: from, rotation: numbers.rotation() });
                        let velocity = down.as_vec3() * speed;
                        let angular_velocity = numbers.vector().as_vec3() * (3.0 * speed).min(200.0);
                        stage.put(Body { velocity, angular_velocity, ..body })
                    })
                    .collect();
                stage.steps(60);
                for id in ids {
                    let place = stage.position(id);
                    let over = place.x.abs() < 14.0 && place.y.abs() < 14.0;
                    let what = shape.name();
                    assert!(!over || place.z > floor, "a {what} at {speed} m/s has come to {place}");
                }
            }
        }
    }
}
