//! The promises of compounds: they are their parts.

use parry3d::math::{Pose as ParryPose, Rotation};
use parry3d::shape::SharedShape;
use rockfall_collide::{
    Cache, INSIDE, Manifold, Motion, Ray, Sweep, cast_ray, cast_shape, collide, distance, nearest_point,
    overlaps, penetration, time_of_impact,
};
use rockfall_math::{DVec3, Isometry, Mat3, Pose, Quat, Vec2, Vec3, hash, rotation};
use rockfall_shape::{Compound, HeightField, Hull, Mesh, Shape};
use std::sync::Arc;

/// A stream of numbers.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        low + (high - low) * ((hash::mix(self.0) >> 40) as f32 / (1_u64 << 24) as f32)
    }

    fn point(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    fn turn(&mut self) -> Quat {
        let v = self.point(1.0);
        rotation::normalize(Quat::from_xyzw(v.x, v.y, v.z, self.between(-1.0, 1.0)))
    }

    fn place(&mut self, reach: f32) -> Isometry {
        Isometry { rotation: Mat3::from_quat(self.turn()), translation: self.point(reach) }
    }

    fn pose(&mut self, reach: f32) -> Pose {
        Pose { position: self.point(reach).as_dvec3(), rotation: self.turn() }
    }
}

fn boulder(seed: u64, size: f32) -> Shape {
    let mut random = Random(seed);
    let points: Vec<Vec3> =
        (0..24).map(|_| random.point(1.0).normalize_or(Vec3::X) * random.between(0.5 * size, size)).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).expect("a boulder")))
}

/// Small shapes of the kinds that `parry3d` has too.
fn small(i: usize) -> Shape {
    match i % 4 {
        0 => Shape::Sphere { radius: 0.3 },
        1 => Shape::Box { half: Vec3::new(0.2, 0.4, 0.3) },
        2 => Shape::Capsule { half_length: 0.3, radius: 0.15 },
        _ => boulder(i as u64, 0.4),
    }
}

fn heap(seed: u64, parts: usize) -> Compound {
    let mut random = Random(seed);
    Compound::new((0..parts).map(|i| (small(i), random.pose(1.0)))).expect("the parts make sense")
}

fn compound(parts: Vec<(Shape, Pose)>) -> Shape {
    Shape::Compound(Arc::new(Compound::new(parts).expect("the parts make sense")))
}

fn wrap(compound: &Compound) -> Shape {
    Shape::Compound(Arc::new(compound.clone()))
}

fn floor() -> Shape {
    let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    Shape::Mesh(Arc::new(Mesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).expect("a square")))
}

/// What a compound may meet.
fn others() -> Vec<Shape> {
    vec![
        Shape::Sphere { radius: 0.6 },
        Shape::Box { half: Vec3::new(1.5, 0.5, 0.4) },
        boulder(9, 0.8),
        Shape::Cylinder { half_length: 0.5, radius: 0.5 },
        Shape::HalfSpace { normal: Vec3::Z, offset: -1.0 },
        floor(),
        Shape::HeightField(Arc::new(HeightField::new(9, 9, Vec2::ONE, vec![0.0; 81]).expect("a plain"))),
    ]
}

fn manifolds(a: &Shape, b: &Shape, b_in_a: &Isometry, margin: f32) -> (Vec<Manifold>, f32) {
    let mut out = Vec::new();
    let apart = collide(a, b, b_in_a, margin, &mut Cache::default(), &mut out);
    (out, apart)
}

/// Promise: the manifolds of a compound are those of its parts, or several of them in one: each point is a point of a part, each manifold
/// of a part has its like, which shows what is deepest.
#[test]
fn manifolds_are_those_of_the_parts() {
    let mut random = Random(3);
    let (mut found, mut merged) = (0, 0);
    for a in others() {
        for seed in 0..100 {
            let parts = heap(seed, 1 + seed as usize % 12);
            let b_in_a = random.place(1.5);
            let margin = 0.05;
            let (ours, _) = manifolds(&a, &wrap(&parts), &b_in_a, margin);
            let singles: Vec<Manifold> = (parts.parts().iter())
                .flat_map(|p| manifolds(&a, &p.shape, &b_in_a.then_after(&p.place), margin).0)
                .collect();
            assert_eq!(ours.is_empty(), singles.is_empty(), "{}", a.name());
            found += singles.len();
            merged += singles.len() - ours.len();
            for manifold in &ours {
                for point in manifold.points() {
                    let of = |m: &&Manifold| {
                        m.points()
                            .iter()
                            .any(|p| p.position == point.position && p.distance == point.distance)
                    };
                    assert!(
                        singles.iter().any(|m| of(&m) && m.normal.dot(manifold.normal) > 0.999),
                        "{}",
                        a.name()
                    );
                }
            }
            for single in &singles {
                let shown = ours.iter().filter(|m| m.normal.dot(single.normal) > 0.999);
                let deepest = shown.map(Manifold::deepest).fold(f32::INFINITY, f32::min);
                assert!(deepest <= single.deepest() + 1e-3, "{}: {deepest} {}", a.name(), single.deepest());
            }
        }
    }
    println!("{found} manifolds of parts, {merged} fewer of compounds");
    assert!(found > 1000 && merged > 200);
}

/// Promise: seen from the other shape, contacts are the same.
#[test]
fn swapping_the_shapes_changes_nothing() {
    let mut random = Random(4);
    let mut met = 0;
    for seed in 0..100 {
        let (a, b) = (wrap(&heap(seed, 5)), wrap(&heap(seed + 1000, 4)));
        let b_in_a = random.place(1.5);
        let (here, _) = manifolds(&a, &b, &b_in_a, 0.02);
        let (there, _) = manifolds(&b, &a, &b_in_a.inverse(), 0.02);
        let deepest = |all: &[Manifold]| all.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
        assert_eq!(here.is_empty(), there.is_empty());
        if !here.is_empty() {
            met += 1;
            assert!(
                (deepest(&here) - deepest(&there)).abs() < 1e-4,
                "{} {}",
                deepest(&here),
                deepest(&there)
            );
        }
    }
    assert!(met > 30);
}

/// Promise: two compounds are as far apart as their nearest parts, and `collide` never says further.
#[test]
fn what_is_apart_is_not_said_to_be_further() {
    let mut random = Random(5);
    let mut apart = 0;
    for seed in 0..300 {
        let (first, second) = (heap(seed, 1 + seed as usize % 4), heap(seed + 500, 3));
        let b_in_a = Isometry {
            translation: random.point(1.0).normalize() * random.between(1.5, 5.0),
            ..random.place(0.0)
        };
        let each = first.parts().iter().flat_map(|p| second.parts().iter().map(move |q| (p, q)));
        let exact = each
            .filter_map(|(p, q)| {
                let q_in_p = p.place.inverse().then_after(&b_in_a).then_after(&q.place);
                distance(&p.shape, &q.shape, &q_in_p).map(|d| d.distance)
            })
            .fold(f32::INFINITY, f32::min);
        let ours = distance(&wrap(&first), &wrap(&second), &b_in_a).expect("they have one");
        assert!((ours.distance - exact).abs() < 1e-5, "{} {exact}", ours.distance);
        assert!((ours.on_b - ours.on_a - ours.distance * ours.normal).length() < 1e-5);
        let (found, said) = manifolds(&wrap(&first), &wrap(&second), &b_in_a, 0.1);
        if found.is_empty() {
            apart += 1;
            assert!(exact > 0.1 - 1e-5 && said <= exact + 1e-5, "{said} of {exact}");
            assert!(said > 0.1, "it would be looked at again at once");
        } else {
            assert!(exact <= 0.1 + 1e-5);
        }
    }
    assert!(apart > 100);
}

/// Promise: points have names of their own, which stay while the body moves a little.
#[test]
fn names_are_distinct_and_stay() {
    let leg = Shape::Box { half: Vec3::new(0.05, 0.05, 0.4) };
    let sides = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let legs = sides.map(|(x, y)| (leg.clone(), Pose::at(DVec3::new(0.5 * x, 0.4 * y, 0.4))));
    let table = compound(
        legs.into_iter()
            .chain([(Shape::Box { half: Vec3::new(0.6, 0.5, 0.05) }, Pose::at(DVec3::new(0.0, 0.0, 0.85)))])
            .collect(),
    );
    let names = |height: f32, tilt: f32| -> Vec<u32> {
        let turn = rotation::from_rotation_vector(Vec3::new(tilt, 0.7 * tilt, 0.3));
        let place = Isometry { rotation: Mat3::from_quat(turn), translation: Vec3::Z * height };
        let (found, _) = manifolds(&Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, &table, &place, 0.01);
        assert_eq!((found.len(), found[0].count), (1, 4), "a table stands on one manifold");
        found[0].points().iter().map(|p| p.feature).collect()
    };
    let first = names(0.0, 0.0);
    assert!((0..4).all(|i| !first[..i].contains(&first[i])), "{first:?}");
    for (height, tilt) in [(-1e-3, 1e-4), (1e-3, -1e-4), (0.0, 2e-4)] {
        assert_eq!(names(height, tilt), first);
    }
}

/// Promise: points are as far from a compound as `parry3d` says, outside; inside by the deepest part.
#[test]
fn nearest_points_are_those_of_the_nearest_part() {
    let mut random = Random(6);
    for seed in 0..20 {
        // Without hulls: it takes those by GJK, with a tolerance of its own.
        let poses = heap(seed, 40);
        let parts = poses.parts().iter().enumerate().map(|(i, part)| (small(i % 3), part.pose));
        let parts = Compound::new(parts).expect("the parts make sense");
        let shape = wrap(&parts);
        let judge = parry(&parts);
        for _ in 0..200 {
            let p = random.point(2.5);
            let ours = nearest_point(&shape, p.as_dvec3(), f32::INFINITY).expect("no limit");
            assert!((p - ours.point - ours.distance * ours.normal).length() < 1e-4, "{ours:?}");
            let theirs = judge.project_local_point(p, true);
            let away = theirs.point.distance(p);
            if ours.distance > 0.0 {
                assert!((ours.distance - away).abs() < 1e-4, "{} {away}", ours.distance);
                assert_eq!(nearest_point(&shape, p.as_dvec3(), 0.5 * ours.distance), None);
            } else {
                let back = |q: Vec3| q.as_dvec3();
                let depth = (parts.parts().iter())
                    .filter_map(|part| nearest_point(&part.shape, back(part.place.inverse_point(p)), 0.0))
                    .fold(f32::INFINITY, |least, near| least.min(near.distance));
                assert!((ours.distance - depth).abs() < 1e-5 && away < 1e-4);
            }
        }
    }
}

fn parry(parts: &Compound) -> SharedShape {
    let part = |shape: &Shape| match shape {
        Shape::Sphere { radius } => SharedShape::ball(*radius),
        Shape::Capsule { half_length, radius } => SharedShape::capsule_z(*half_length, *radius),
        Shape::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
        Shape::Hull(hull) => SharedShape::convex_hull(&hull.vertices).expect("a hull"),
        _ => panic!("not asked about a {}", shape.name()),
    };
    let pose =
        |place: &Isometry| ParryPose::from_parts(place.translation, Rotation::from_mat3(&place.rotation));
    SharedShape::compound(parts.parts().iter().map(|p| (pose(&p.place), part(&p.shape))).collect())
}

/// Promise: rays meet a compound where they meet the first of its parts, where `parry3d` says.
#[test]
fn rays_meet_the_first_part() {
    let mut random = Random(7);
    let (mut hits, mut inside, mut odd) = (0, 0, 0);
    for seed in 0..20 {
        let parts = heap(seed, 30);
        let shape = wrap(&parts);
        let judge = parry(&parts);
        for _ in 0..200 {
            let (origin, to) = (random.point(3.0), random.point(0.8));
            let ray = Ray {
                origin: origin.as_dvec3(),
                direction: (to - origin).normalize().as_dvec3(),
                max: f64::from(random.between(1.0, 9.0)),
            };
            let ours = cast_ray(&shape, &ray, true);
            let direction = ray.direction.as_vec3();
            let theirs =
                judge.cast_local_ray(&parry3d::query::Ray::new(origin, direction), ray.max as f32, true);
            match (ours, theirs) {
                (Some(ours), Some(theirs)) if (ours.t - f64::from(theirs)).abs() < 3e-4 => {
                    hits += 1;
                    if ours.part == INSIDE {
                        inside += 1;
                        continue;
                    }
                    let part = &parts.parts()[ours.part as usize];
                    let at = part.place.inverse_point(ray.at(ours.t).as_vec3());
                    let near = nearest_point(&part.shape, at.as_dvec3(), f32::INFINITY).expect("no limit");
                    assert!(near.distance.abs() < 1e-4, "{near:?}");
                }
                (None, None) => {}
                _ => odd += 1,
            }
        }
    }
    println!("{hits} hits, {inside} from inside, {odd} odd");
    assert!(hits > 1500 && inside > 50 && odd < 20);
}

/// Promise: casts, overlaps and penetrations are those of the parts, whichever of the two is the compound, or both.
#[test]
fn casts_and_overlaps_are_those_of_the_parts() {
    let mut random = Random(8);
    let (mut hits, mut deep) = (0, 0);
    for seed in 0..60 {
        let (first, second) = (heap(seed, 4), heap(seed + 100, 6));
        let start = Isometry { translation: random.point(1.0).normalize() * 4.0, ..random.place(0.0) };
        let way = 1.5 * (random.point(1.0) - start.translation);
        let of_parts = |way: Vec3, start: &Isometry| {
            let each = first.parts().iter().flat_map(|p| second.parts().iter().map(move |q| (p, q)));
            each.filter_map(|(p, q)| {
                let p_in_q = q.place.inverse().then_after(start).then_after(&p.place);
                cast_shape(&p.shape, &q.shape, &p_in_q, q.place.inverse_vector(way)).map(|toi| toi.time)
            })
            .fold(f32::INFINITY, f32::min)
        };
        let (a, b) = (wrap(&first), wrap(&second));
        let ours = cast_shape(&a, &b, &start, way);
        let exact = of_parts(way, &start);
        assert_eq!(ours.is_some(), exact.is_finite());
        if let Some(toi) = ours {
            hits += 1;
            assert!((toi.time - exact).abs() < 1e-4, "{} {exact}", toi.time);
            let there = Isometry { translation: start.translation + way * toi.time, ..start };
            let gap = distance(&a, &b, &there.inverse()).expect("they have one").distance;
            assert!(gap.abs() < 1e-3, "{gap}");
            let near = nearest_point(&b, toi.point.as_dvec3(), f32::INFINITY).expect("no limit");
            assert!(near.distance.abs() < 1e-3, "{near:?}");
        }
        let place = random.place(1.2);
        let signed = distance(&a, &b, &place).expect("they have one");
        assert_eq!(overlaps(&a, &b, &place), signed.distance <= 0.0);
        let depth = penetration(&a, &b, &place).map(|d| d.distance);
        assert_eq!(depth.is_some(), signed.distance <= 0.0);
        if let Some(depth) = depth {
            deep += 1;
            assert!((depth - signed.distance).abs() < 1e-5);
        }
    }
    assert!(hits > 20 && deep > 20, "{hits} {deep}");
}

/// Promise: no part of a fast compound passes through a thin wall, turning or not, and none of a thin compound is passed through.
#[test]
fn no_part_passes_through_a_wall() {
    let mut random = Random(10);
    let wall = Shape::Box { half: Vec3::new(4.0, 4.0, 0.005) };
    let walls = compound(vec![(wall.clone(), Pose::default()), (wall, Pose::at(DVec3::Z * 2.0))]);
    let jack = heap(11, 5);
    for i in 0..200 {
        let speed = random.between(5.0, 40.0);
        let start = Isometry { translation: Vec3::new(0.0, 0.0, -3.0), ..random.place(0.0) };
        let rotation = if i % 2 == 0 { Vec3::ZERO } else { random.point(3.0) };
        let translation = Vec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), speed);
        let sweep = Sweep {
            a: Motion { start, center: Vec3::ZERO, translation, rotation },
            b: Motion::at_rest(Isometry::IDENTITY),
        };
        let toi = time_of_impact(&wrap(&jack), &walls, &sweep, 0.01).expect("it is aimed at the walls");
        assert!(toi.normal.dot(Vec3::Z) > 0.99, "{toi:?}");
        let gap = distance(&wrap(&jack), &walls, &sweep.a.at(toi.time).inverse()).expect("they have one");
        assert!((gap.distance - 0.01).abs() < 2e-3, "{gap:?}");
        // Seen from the walls, which come.
        let other = Sweep {
            a: Motion { start, center: Vec3::ZERO, translation: Vec3::ZERO, rotation },
            b: Motion { translation: -translation, ..Motion::at_rest(Isometry::IDENTITY) },
        };
        let other = time_of_impact(&wrap(&jack), &walls, &other, 0.01).expect("they are aimed at it");
        assert!((toi.time - other.time).abs() < 2e-3, "{} {}", toi.time, other.time);
    }
}

/// Promise: places that are no places have no contacts and no answers.
#[test]
fn what_is_not_finite_has_no_contact() {
    let (a, b) = (wrap(&heap(1, 3)), wrap(&heap(2, 3)));
    let nowhere = Isometry { translation: Vec3::new(f32::NAN, 0.0, 0.0), ..Isometry::IDENTITY };
    assert!(manifolds(&a, &b, &nowhere, 0.1).0.is_empty());
    assert_eq!(distance(&a, &b, &nowhere), None);
    assert!(!overlaps(&a, &b, &nowhere) && penetration(&a, &b, &nowhere).is_none());
    assert_eq!(cast_shape(&a, &b, &nowhere, Vec3::X), None);
    assert_eq!(nearest_point(&a, DVec3::NAN, 1.0), None);
}
