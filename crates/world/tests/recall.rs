//! What a pair recalls instead of looking again is true.

mod common;

use common::{Stage, frames, rubs};
use rockfall::math::hash::mix;
use rockfall::math::{DVec3, Isometry, Pose, Quat, Vec3};
use rockfall::{Body, BodyId, Kind, Shape, shape};
use rockfall_collide::distance;
use std::collections::HashMap;
use std::sync::Arc;

/// Boxes and hulls, and among them, where `round`, balls and capsules, all about half a metre in size, dropped between four walls.
fn pile(count: usize, round: bool) -> Stage {
    let mut stage = Stage::on_ground(frames(), rubs(0.6, 0.0));
    let random = |i: usize, k: u64| (mix(i as u64 * 16 + k) >> 40) as f32 / (1 << 24) as f32 - 0.5;
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
        let wall = stage.shape(Shape::HalfSpace { normal, offset: -2.0 });
        let body = Body::fixed(wall, stage.material, Pose::default());
        stage.put(body);
    }
    for i in 0..count {
        let shape = if round && i % 4 == 0 {
            stage.ball(0.3 + 0.1 * random(i, 1))
        } else if round && i % 4 == 1 {
            let (radius, half_length) = (0.2 + 0.1 * random(i, 1), 0.2 + 0.1 * random(i, 2));
            stage.shape(Shape::Capsule { half_length, radius })
        } else if i % 2 == 0 {
            stage.cuboid(0.3 + 0.1 * random(i, 1), 0.3 + 0.1 * random(i, 2), 0.3 + 0.1 * random(i, 3))
        } else {
            let corner = |k: u64| {
                0.35 * Vec3::new(random(i, k), random(i, k + 100), random(i, k + 200)).normalize_or(Vec3::X)
            };
            let corners: Vec<Vec3> = (10..26).map(corner).collect();
            stage.shape(Shape::Hull(Arc::new(shape::Hull::from_points(&corners).expect("a hull"))))
        };
        let place = |n: usize| (n % 4) as f64 - 1.5;
        let position = DVec3::new(0.9 * place(i), 0.9 * place(i / 4), 0.6 + 0.8 * (i / 16) as f64);
        let turn = Quat::from_xyzw(random(i, 4), random(i, 5), random(i, 6), random(i, 7) + 0.6);
        stage.put(stage.body(shape, Pose { position, rotation: turn.normalize() }));
    }
    stage
}

/// Promise: at every step of a pile, from its fall to its rest, the contacts of a pair go as deep as the two shapes do, within 0.2 mm and a
/// hundredth of the depth; and no pair that overlaps by more than that is without contact.
#[test]
fn contacts_are_as_deep_as_the_shapes() {
    [false, true].into_iter().for_each(as_deep_as_the_shapes);
}

fn as_deep_as_the_shapes(round: bool) {
    let mut stage = pile(96, round);
    let mut judged = 0;
    for step in 0..400 {
        let poses = stage.world.poses();
        stage.steps(1);
        if step % 8 != 0 {
            continue;
        }
        let mut deepest: HashMap<(u64, u64), f32> = HashMap::new();
        for contact in stage.world.contacts() {
            let depth =
                deepest.entry((contact.a.0.min(contact.b.0), contact.a.0.max(contact.b.0))).or_insert(9.0);
            *depth = depth.min(contact.distance);
        }
        let (ids, kinds) = (stage.world.ids(), stage.world.kinds());
        for i in 0..ids.len() {
            for j in 0..i {
                if kinds[i] == Kind::Static && kinds[j] == Kind::Static {
                    continue;
                }
                let [a, b] = [i, j].map(|k| stage.world.shape(ids[k]).expect("a body of the world"));
                let seen: Isometry = poses[i].see(&poses[j]);
                let Some(exact) = distance(a, b, &seen).map(|d| d.distance) else { continue };
                let allowed = 2e-4 + 0.01 * exact.abs();
                if exact > -allowed {
                    continue;
                }
                judged += 1;
                let found = deepest.get(&(ids[i].0.min(ids[j].0), ids[i].0.max(ids[j].0)));
                let depth = *found.unwrap_or_else(|| panic!("step {step}: {exact} without contact"));
                assert!((depth - exact).abs() < allowed, "step {step}: {depth} for {exact}, {a:?} {b:?}");
            }
        }
    }
    println!("{judged} pairs judged");
    assert!(judged > 1000, "{judged}");
}

/// Promise: a body that is put somewhere else has no contact left where it was, and finds those where it is.
#[test]
fn a_body_put_elsewhere_forgets() {
    let mut stage = Stage::on_ground(frames(), rubs(0.6, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let under = stage.put(stage.body(cube, common::at(0.0, 0.0, 0.5)));
    let on_top = stage.put(stage.body(cube, common::at(0.0, 0.0, 1.5)));
    stage.steps(60);
    // So little aside that the boxes of the broad phase still hold both.
    for aside in [0.02, 0.0, 0.02, 0.0, 0.02] {
        stage.world.set_pose(on_top, common::at(0.0, 0.0, 1.5 + aside)).expect("a pose");
        stage.steps(1);
        let contacts =
            stage.world.contacts().filter(|c| c.a == under && c.b == on_top || c.a == on_top && c.b == under);
        let nearest = contacts.map(|c| c.distance).fold(f32::INFINITY, f32::min);
        let expected = if aside == 0.0 { 0.0 } else { 0.02 };
        assert!(
            nearest.is_infinite() && aside > 0.0 || (nearest - expected).abs() < 2e-3,
            "{aside}: {nearest}"
        );
    }
}

/// Promise: a body that comes, or a static one that is put somewhere, is found by what rests there, in the same step.
#[test]
fn what_comes_late_is_found() {
    let mut stage = Stage::on_ground(frames(), rubs(0.6, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let first = stage.put(stage.body(cube, common::at(0.0, 0.0, 0.5)));
    stage.steps(30);
    let touch = |stage: &Stage, other: BodyId| {
        stage.world.contacts().any(|c| (c.a == first && c.b == other) || (c.a == other && c.b == first))
    };
    let on_top = stage.put(stage.body(cube, common::at(0.0, 0.0, 1.5)));
    stage.steps(1);
    assert!(touch(&stage, on_top));
    let wall = stage.put(Body::fixed(cube, stage.material, common::at(1.0, 0.0, 0.5)));
    stage.steps(1);
    assert!(touch(&stage, wall) && touch(&stage, on_top));
    stage.world.set_pose(wall, common::at(9.0, 0.0, 0.5)).expect("a pose");
    stage.steps(1);
    assert!(!touch(&stage, wall));
    stage.world.set_pose(wall, common::at(-1.0, 0.0, 0.5)).expect("a pose");
    stage.steps(1);
    assert!(touch(&stage, wall));
    assert!(stage.position(first).x.abs() < 1e-3, "{}", stage.position(first));
}
