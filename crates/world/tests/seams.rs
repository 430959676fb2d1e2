//! Flat floors made of many parts are flat: nobody feels the seams.
//!
//! After Jolt's test of active edges: a cube of 0.2 m that slides at 3 m/s over triangles for 2 s is where it would be without them,
//! to 1 mm, and as fast, to 2 mm/s.

mod common;

use common::{Stage, frames, rubs};
use rockfall::math::{DVec3, Pose, Quat, Vec2, Vec3, rotation, trig};
use rockfall::shape::{HeightField, Hull, Mesh};
use rockfall::{Body, Settings, Shape};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

/// How far from where it would be on a plane, metres.
const OFF: f64 = 1e-3;

/// How much faster or slower, m/s, and of a point that is as far from the centre as the floor.
const FASTER: f32 = 2e-3;

/// The same for a moment: where one block takes over from another, whose contact has its impulses yet to find, m/s.
const TREMOR: f32 = 2e-2;

/// Sides of the floors around the origin, metres: one to go along, and one to go over in any direction.
const STRIP: [f32; 2] = [16.0, 3.0];
const SQUARE: [f32; 2] = [7.0, 7.0];

/// The top of a part of the floor is z = 0.
type Floor = Vec<(Shape, Pose)>;

fn counts(sides: [f32; 2], cell: f32) -> [u32; 2] {
    sides.map(|side| (side / cell).round() as u32)
}

fn mesh(sides: [f32; 2], cell: f32) -> Floor {
    let [m, n] = counts(sides, cell);
    let place = |i: u32, count: u32| (i as f32 - 0.5 * count as f32) * cell;
    let vertices: Vec<Vec3> = (0..(m + 1) * (n + 1))
        .map(|k| Vec3::new(place(k % (m + 1), m), place(k / (m + 1), n), 0.0))
        .collect();
    let triangles: Vec<[u32; 3]> = (0..m * n)
        .flat_map(|k| {
            let a = k / m * (m + 1) + k % m;
            let [b, d] = [a + 1, a + m + 1];
            if (k % m + k / m) % 2 == 0 { [[a, b, d + 1], [a, d + 1, d]] } else { [[a, b, d], [b, d + 1, d]] }
        })
        .collect();
    let mesh = Mesh::from_triangles(&vertices, &triangles).expect("a floor");
    vec![(Shape::Mesh(Arc::new(mesh)), Pose::default())]
}

fn field(sides: [f32; 2], cell: f32) -> Floor {
    let [m, n] = counts(sides, cell).map(|count| count + 1);
    let field = HeightField::new(m, n, Vec2::splat(cell), vec![0.0; (m * n) as usize]).expect("a field");
    vec![(Shape::HeightField(Arc::new(field)), Pose::default())]
}

/// Blocks beside each other, none higher than the next; `turn` is that of the whole floor about z.
fn blocks(side: f32, turn: f32, shape: impl Fn(Vec3) -> Shape) -> Floor {
    let [m, n] = counts(STRIP, side);
    let rotation = rotation::from_rotation_vector(Vec3::Z * turn);
    let place = |i: u32, count: u32| (i as f32 - 0.5 * (count - 1) as f32) * side;
    (0..m * n)
        .map(|k| {
            let depth = 0.2 + 0.1 * (k % 3) as f32;
            let middle = Vec3::new(place(k % m, m), place(k / m, n), -depth);
            let position = rotation::rotate(rotation, middle).as_dvec3();
            (shape(Vec3::new(0.5 * side, 0.5 * side, depth)), Pose { position, rotation })
        })
        .collect()
}

fn cuboid(half: Vec3) -> Shape {
    Shape::Box { half }
}

fn cuboid_hull(half: Vec3) -> Shape {
    Shape::Hull(Arc::new(Hull::cuboid(half)))
}

fn plane() -> Floor {
    vec![(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, Pose::default())]
}

/// What slides or rolls: its shape, its rotation when it goes along x, the height of its centre, and whether it rolls.
struct Runner {
    name: &'static str,
    shape: Shape,
    turn: Quat,
    height: f32,
    rolls: bool,
}

/// All of them, with a radius or half an edge of so many metres.
fn runners(size: f32) -> Vec<Runner> {
    let lying = rotation::between(Vec3::Z, Vec3::Y);
    let upright = Quat::IDENTITY;
    let ball = Shape::Sphere { radius: size };
    let cylinder = Shape::Cylinder { half_length: size, radius: size };
    let capsule = Shape::Capsule { half_length: size, radius: size };
    let along = rotation::between(Vec3::Z, Vec3::X);
    let runner =
        |name, shape: &Shape, turn, rolls| Runner { name, shape: shape.clone(), turn, height: size, rolls };
    vec![
        runner("ball that slides", &ball, upright, false),
        runner("ball that rolls", &ball, upright, true),
        runner("box that slides", &cuboid(Vec3::splat(size)), upright, false),
        runner("hull that slides", &cuboid_hull(Vec3::splat(size)), upright, false),
        runner("cylinder that slides on its end", &cylinder, upright, false),
        runner("cylinder that slides along its axis", &cylinder, along, false),
        runner("cylinder that rolls", &cylinder, lying, true),
        runner("capsule that slides along its axis", &capsule, along, false),
        runner("capsule that slides across its axis", &capsule, lying, false),
        runner("capsule that rolls", &capsule, lying, true),
    ]
}

/// The course of a runner on a floor, from −6.5 m on, at `speed` in a direction of `angle` to x.
fn run(runner: &Runner, floor: &Floor, speed: f32, angle: f32) -> Vec<(DVec3, Vec3, Vec3)> {
    let settings = Settings { continuous: true, ..frames() };
    let mut stage = Stage::new(settings, rubs(if runner.rolls { 0.5 } else { 0.0 }, 0.0));
    for (shape, pose) in floor {
        let shape = stage.shape(shape.clone());
        stage.put(Body::fixed(shape, stage.material, *pose));
    }
    let shape = stage.shape(runner.shape.clone());
    let (sin, cos) = trig::sin_cos(angle);
    let towards = Vec3::new(cos, sin, 0.0);
    let turn = rotation::from_rotation_vector(Vec3::Z * angle);
    let position = (Vec3::Z * runner.height - towards * 0.5 * 2.0 * speed).as_dvec3();
    let pose = Pose { position, rotation: rotation::compose(turn, runner.turn) };
    let spin = if runner.rolls { Vec3::Z.cross(towards) * (speed / runner.height) } else { Vec3::ZERO };
    let id = stage.put(Body { velocity: towards * speed, angular_velocity: spin, ..stage.body(shape, pose) });
    (0..120)
        .map(|_| {
            stage.steps(1);
            let (v, w) = stage.velocity(id);
            (stage.position(id), v, w)
        })
        .collect()
}

/// Compares a floor of parts with a plane. Returns what is wrong.
fn compare(what: &str, floor: &Floor, runners: &[Runner], speed: f32, angle: f32) -> Vec<String> {
    let mut wrong = Vec::new();
    for runner in runners {
        let (parts, whole) = (run(runner, floor, speed, angle), run(runner, &plane(), speed, angle));
        let (mut off, mut most, mut last) = (0.0_f64, 0.0_f32, 0.0_f32);
        for ((p, v, w), (q, u, o)) in parts.iter().zip(&whole) {
            off = off.max((*p - *q).length());
            last = (*v - *u).length().max(runner.height * (*w - *o).length());
            most = most.max(last);
        }
        let line = format!(
            "{} of {} m at {angle} over {what}: {off:.1e} m, {most:.1e} m/s, {last:.1e} m/s in the end",
            runner.name, runner.height
        );
        println!("{line}");
        if off > OFF || last > FASTER || most > TREMOR {
            wrong.push(line);
        }
    }
    wrong
}

/// Compares runners on floors in these directions.
fn check_in(floors: &[(&str, Floor)], runners: &[Runner], angles: &[f32]) {
    let wrong: Vec<String> = floors
        .iter()
        .flat_map(|(what, floor)| angles.iter().map(move |&angle| compare(what, floor, runners, 3.0, angle)))
        .flatten()
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Compares all runners with a radius of `size` but for some.
fn check(floors: &[(&str, Floor)], size: f32, but: &[&str]) {
    let runners: Vec<Runner> =
        runners(size).into_iter().filter(|runner| !but.contains(&runner.name)).collect();
    check_in(floors, &runners, &[0.0, 0.13]);
}

/// Promise: at 3 m/s what slides or rolls goes over a mesh as over a plane, whether its triangles are larger or much smaller than
/// itself.
#[test]
fn a_mesh_has_no_bumps() {
    check(&[("a mesh of 0.5 m", mesh(STRIP, 0.5)), ("a mesh of 0.1 m", mesh(STRIP, 0.1))], 0.1, &[]);
}

/// Promise: the same where a body lies on hundreds of triangles at once.
#[test]
fn a_fine_mesh_has_no_bumps() {
    check(&[("a mesh of 0.04 m", mesh(STRIP, 0.04))], 0.3, &[]);
}

/// Promise: the same of height fields.
#[test]
fn a_height_field_has_no_bumps() {
    check(&[("a field of 0.5 m", field(STRIP, 0.5)), ("a field of 0.1 m", field(STRIP, 0.1))], 0.1, &[]);
    check(&[("a field of 0.04 m", field(STRIP, 0.04))], 0.3, &[]);
}

/// Promise: a cylinder rolls straight on whichever way it goes over the triangles: along their sides, along their diagonals, and across.
#[test]
#[ignore = "known to fail: up to 1.4 mm off after 6 m, where 1 mm is wanted"]
fn a_cylinder_rolls_straight_in_every_direction() {
    let angles = [0.3, FRAC_PI_4, 1.3, FRAC_PI_2];
    for (size, cells) in [(0.1, &[0.5, 0.1][..]), (0.3, &[0.04])] {
        let mut rolls = runners(size);
        rolls.retain(|runner| runner.name == "cylinder that rolls");
        let floors: Vec<(String, Floor)> = cells
            .iter()
            .flat_map(|&cell| {
                [
                    (format!("a mesh of {cell} m"), mesh(SQUARE, cell)),
                    (format!("a field of {cell} m"), field(SQUARE, cell)),
                ]
            })
            .collect();
        let floors: Vec<(&str, Floor)> =
            floors.iter().map(|(what, floor)| (&**what, floor.clone())).collect();
        check_in(&floors, &rolls, &angles);
    }
}

/// Promise: the same of blocks that are bodies of their own, laid side by side, turned as a whole, and given as hulls.
#[test]
fn blocks_side_by_side_have_no_bumps() {
    let floors = [
        ("blocks of 1 m", blocks(1.0, 0.0, cuboid)),
        ("blocks of 1 m, turned", blocks(1.0, 0.02, cuboid)),
        ("hulls of 0.5 m", blocks(0.5, 0.0, cuboid_hull)),
    ];
    check(&floors, 0.1, &[]);
}

/// Promise: the same of blocks that are smaller than what goes over them, but for what lies on several along a line: that they throw aside.
#[test]
fn small_blocks_side_by_side_have_no_bumps() {
    let but = ["cylinder that rolls", "cylinder that slides along its axis", "capsule that rolls"];
    check(&[("blocks of 0.15 m", blocks(0.15, 0.0, cuboid))], 0.1, &but);
}
