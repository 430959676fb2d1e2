//! Stage 12, **sweep**: continuous detection.
//!
//! Reads drift, poses, the tree of static bodies and the manifolds; writes poses. A body that moves further in a step than
//! contacts can see ahead is taken along its way from the start of the step, and stopped where it first comes near a body
//! that contacts can't move. What is left of its way it goes along that body, so that nothing that is fast stands still; its
//! velocity is left to the contact that the next step finds there.
//!
//! Where the solver already had a contact with a solid, it has kept the two apart; only a mesh, which may be thin anywhere, and a
//! compound, whose parts have contacts of their own, are looked at again. Bodies that move are not stopped at each other: one that is held back within a stream is run into
//! by those behind it (boulders of the rock slide overlapped by 50 mm on average with such stops, by 2 mm without).

use crate::bodies::Bodies;
use crate::index::Index;
use crate::touches::Touches;
use crate::{Kind, Shape};
use rayon::prelude::*;
use rockfall_collide::{Motion, Sweep, Toi, time_of_impact};
use rockfall_math::{Aabb, DVec3, Isometry, Mat3, Vec3, rotation};
use rockfall_solve::FIXED;
use rockfall_solve::line::Role;

/// A body is fast when a point of it moves by more than this share of its inner radius in a step: what its reach, which
/// grows with its speed up to the same share, may not see.
const FAST: f32 = 0.5;

/// Distance at which a fast body is stopped, as a share of its inner radius: within its reach at rest.
const STOP: f32 = 0.01;

/// How often in a step a body that was stopped goes on along what stopped it: into the corner of three walls.
const SLIDES: usize = 3;

/// What stands in the way: the contacts of the step, and the tree.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) shapes: &'a [Shape],
    pub(crate) trees: &'a Index,
    pub(crate) touches: &'a Touches,
}

/// Stops fast bodies at what they would pass through.
pub(crate) fn sweep(bodies: &mut Bodies, around: Surroundings<'_>) {
    let stopped: Vec<(usize, Motion)> = (1..bodies.rows())
        .into_par_iter()
        .with_min_len(512)
        .filter_map(|row| {
            if !is_fast(bodies, row) {
                return None;
            }
            let shape = around.shapes.get(bodies.shapes[row] as usize)?;
            Some((row, course(bodies, around, row, shape)?))
        })
        .collect();
    for (row, Motion { translation, rotation, .. }) in stopped {
        let drift = &mut bodies.drifts[row];
        let back = rotation::from_rotation_vector(-drift.rotation());
        let start = rotation::compose(back, bodies.rotations[row]);
        let turn = rotation::from_rotation_vector(rotation);
        bodies.positions[row] += (translation - drift.translation()).as_dvec3();
        bodies.rotations[row] = rotation::normalize(rotation::compose(turn, start));
        drift.set(translation, rotation);
    }
}

fn is_fast(bodies: &Bodies, row: usize) -> bool {
    let drift = &bodies.drifts[row];
    let far = drift.translation().length() + drift.rotation().length() * bodies.radii[row];
    bodies.roles[row] == Role::Free && far > FAST * bodies.inners[row]
}

/// How the body of `row` moves in the step, if something immovable is in its way: up to that, and then along it, without
/// turning on: that would take its ends further in at each stop.
fn course(bodies: &Bodies, around: Surroundings<'_>, row: usize, shape: &Shape) -> Option<Motion> {
    let origin = bodies.positions[row] - bodies.drifts[row].translation().as_dvec3();
    let whole = motion(bodies, row, origin);
    let way = |left: &Motion| left.start.point(left.center) - whole.start.point(whole.center);
    let (first, other) = first_impact(bodies, around, (row, shape), &whole, origin, 0.0)?;
    let rotation = whole.rotation * first.time;
    let (mut left, mut gone, mut next) = (whole, 0.0, Some((first, other)));
    for _ in 0..SLIDES {
        let Some((hit, other)) = next else { break };
        left = Motion { rotation: Vec3::ZERO, ..left.after(hit.time) };
        gone += (1.0 - gone) * hit.time;
        let into = (left.translation - other * (1.0 - gone)).dot(hit.normal);
        left.translation -= hit.normal * into.max(0.0);
        next = first_impact(bodies, around, (row, shape), &left, origin, gone);
    }
    let time = next.map_or(1.0, |(hit, _)| hit.time);
    Some(Motion { translation: way(&left) + left.translation * time, rotation, ..whole })
}

/// Where a body that has `left` to go meets an immovable one, with the way of that one in the step. `gone` is the share of
/// the step that has passed.
fn first_impact(
    bodies: &Bodies,
    around: Surroundings<'_>,
    (row, shape): (usize, &Shape),
    left: &Motion,
    origin: DVec3,
    gone: f32,
) -> Option<(Toi, Vec3)> {
    let Surroundings { shapes, trees, touches } = around;
    let start = origin + left.start.point(left.center).as_dvec3();
    let end = start + left.translation.as_dvec3();
    // Boxes date from the start of the step; they have room for slow motion.
    let room = bodies.radii[row] + FAST * bodies.inners[row];
    let area = Aabb::around(start.min(end), start.max(end)).grown(room);
    let [group, mask] = bodies.filters[row];
    let mut near = Vec::new();
    let mut meet = |other: u32| {
        let [others, other_mask] = bodies.filters[other as usize];
        let meets = group & other_mask != 0 && others & mask != 0;
        if meets && bodies.kinds[other as usize] != Kind::Dynamic {
            near.push(other);
        }
    };
    trees.movers.query(&area, &mut meet);
    trees.fixed.query(&area, &mut meet);
    let target = STOP * bodies.inners[row];
    near.into_iter()
        .filter_map(|other| {
            let b = shapes.get(bodies.shapes[other as usize] as usize)?;
            let key = (row as u64) << 32 | u64::from(other | FIXED);
            if touches.has_manifold(key) && holds(shape, b) {
                return None;
            }
            let motion = motion(bodies, other as usize, origin);
            let sweep = Sweep { a: *left, b: motion.after(gone) };
            Some((time_of_impact(shape, b, &sweep, target)?, motion.translation, other))
        })
        .min_by(|(a, _, m), (b, _, n)| {
            a.time.total_cmp(&b.time).then_with(|| bodies.ids[*m as usize].cmp(&bodies.ids[*n as usize]))
        })
        .map(|(hit, way, _)| (hit, way))
}

/// Whether a contact that two shapes have keeps all of the first from going through the second: no other place of it can.
fn holds(a: &Shape, b: &Shape) -> bool {
    let many = |shape: &Shape| matches!(shape, Shape::Mesh(_) | Shape::Compound(_));
    matches!(b, Shape::HalfSpace { .. }) || !many(a) && !many(b)
}

/// How the body of a row moved in this step, seen from `origin`.
fn motion(bodies: &Bodies, row: usize, origin: DVec3) -> Motion {
    let (way, turn) = match bodies.roles[row] {
        Role::Still => (Vec3::ZERO, Vec3::ZERO),
        _ => (bodies.drifts[row].translation(), bodies.drifts[row].rotation()),
    };
    let back = rotation::from_rotation_vector(-turn);
    let rotation = Mat3::from_quat(rotation::normalize(rotation::compose(back, bodies.rotations[row])));
    let center = bodies.centers[row];
    let place = (bodies.positions[row] - way.as_dvec3() - origin).as_vec3();
    Motion {
        start: Isometry { rotation, translation: place - rotation * center },
        center,
        translation: way,
        rotation: turn,
    }
}
