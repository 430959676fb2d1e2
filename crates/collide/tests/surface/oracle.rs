//! parry3d as the judge of distances.

use crate::common::Random;
use crate::terrain::{as_mesh, hills};
use crate::{at, shapes, touch};
use parry3d::math::Pose;
use parry3d::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, TriMesh};
use rockfall_collide::{Manifold, convex_mesh};
use rockfall_math::{Isometry, Quat, Vec3};
use rockfall_shape::{Mesh, Shape};

fn parry(shape: &Shape) -> Box<dyn parry3d::shape::Shape> {
    match shape {
        Shape::Sphere { radius } => Box::new(Ball::new(*radius)),
        Shape::Capsule { half_length, radius } => {
            Box::new(Capsule::new(Vec3::Z * -*half_length, Vec3::Z * *half_length, *radius))
        }
        Shape::Box { half } => Box::new(Cuboid::new(*half)),
        Shape::Hull(hull) => Box::new(ConvexPolyhedron::from_convex_hull(&hull.vertices).expect("a hull")),
        _ => unreachable!("not convex"),
    }
}

fn distance(shape: &dyn parry3d::shape::Shape, pose: &Isometry, mesh: &TriMesh) -> f32 {
    let there = Pose::from_parts(pose.translation, Quat::from_mat3(&pose.rotation));
    parry3d::query::distance(&there, shape, &Pose::identity(), mesh).expect("supported").distance
}

/// Somewhere over the terrain, the distance from it not more than `wanted`.
fn lowered(
    shape: &dyn parry3d::shape::Shape,
    mesh: &TriMesh,
    wanted: f32,
    random: &mut Random,
) -> (Isometry, f32) {
    let mut pose = at(random.point(2.0), random.turn());
    pose.translation.z = 3.0;
    for _ in 0..60 {
        let d = distance(shape, &pose, mesh);
        if d <= wanted * 1.001 {
            break;
        }
        pose.translation.z -= d - wanted;
    }
    (pose, distance(shape, &pose, mesh))
}

fn terrains() -> Vec<(f32, Mesh, TriMesh)> {
    [0.2, 0.8, 2.0]
        .into_iter()
        .map(|roughness| {
            let mesh = as_mesh(&hills(16, 0.4, roughness, 6));
            let judge = TriMesh::new(mesh.vertices.clone(), mesh.triangles.clone()).expect("a mesh");
            (roughness, mesh, judge)
        })
        .collect()
}

/// What the caller relies on when it does not ask again for a while.
#[test]
fn what_is_apart_says_so_and_never_by_too_much() {
    let mut random = Random(47);
    let mut known = 0;
    for (_, mesh, judge) in &terrains() {
        for shape in &shapes() {
            let body = parry(shape);
            for _ in 0..100 {
                let (pose, truth) = lowered(&*body, judge, random.between(0.0, 2.0), &mut random);
                let apart = convex_mesh(shape, mesh, &pose.inverse(), 0.03, &mut Vec::new());
                assert!(apart <= truth + 1e-4, "{apart} of {truth}: {shape:?} {pose:?}");
                known += u32::from(apart > 0.1);
            }
        }
    }
    assert!(known > 200, "{known}");
}

/// A contact whenever the surfaces are nearer than the margin, none when they are not. Its distance is exact for
/// round shapes; a polyhedron that is near a corner gets the distance of planes, which differs by a few
/// millimetres in the worst terrain, and never by more than the margin.
#[test]
fn distances_on_rough_terrain_are_those_of_parry() {
    let mut random = Random(41);
    let margin = 0.03;
    for (roughness, mesh, judge) in &terrains() {
        for shape in &shapes() {
            let body = parry(shape);
            let round = matches!(shape, Shape::Sphere { .. } | Shape::Capsule { .. });
            let (mut near, mut off) = (0, 0);
            for _ in 0..120 {
                let wanted = random.between(0.001, 0.05);
                let (pose, truth) = lowered(&*body, judge, wanted, &mut random);
                let manifolds = touch(shape, mesh, &pose, margin);
                let found = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
                let what = format!("{roughness} {} {pose:?}: {found} for {truth}", shape.name());
                if truth > 1.01 * margin {
                    assert!(manifolds.is_empty() || !round, "{what}");
                } else if truth < 0.99 * margin {
                    near += 1;
                    assert!(!manifolds.is_empty(), "{what}");
                    let error = (found - truth).abs();
                    assert!(error < if round { 5e-4 } else { margin }, "{what}");
                    off += i32::from(error > 5e-4);
                }
            }
            assert!(near > 50 && off * 6 < near, "{roughness} {}: {off} of {near} are off", shape.name());
        }
    }
}

#[test]
fn whatever_overlaps_has_a_contact_that_says_so() {
    let mut random = Random(43);
    let (mut wrong, mut total) = (0, 0);
    for (roughness, mesh, judge) in &terrains() {
        for shape in &shapes() {
            let body = parry(shape);
            for _ in 0..120 {
                let (mut pose, _) = lowered(&*body, judge, 1e-4, &mut random);
                let depth = random.between(0.002, 0.03);
                pose.translation.z -= depth;
                let there = Pose::from_parts(pose.translation, Quat::from_mat3(&pose.rotation));
                if !parry3d::query::intersection_test(&there, &*body, &Pose::identity(), judge)
                    .expect("supported")
                    .intersecting
                {
                    continue;
                }
                let manifolds = touch(shape, mesh, &pose, 0.01);
                let deepest = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
                assert!(deepest < 0.0, "{roughness} {} {pose:?}: {deepest}", shape.name());
                // Straight down by `depth` is the way in. Where steep triangles meet, the triangle that a point came
                // in through is a guess; a wrong one must stay rare and shallow.
                assert!(deepest > -0.15, "{roughness} {} {pose:?}: {deepest} after {depth}", shape.name());
                wrong += i32::from(deepest < -1.5 * depth - 1e-3);
                total += 1;
            }
        }
    }
    assert!(total > 1000 && wrong * 100 < total, "{wrong} of {total}");
}
