//! What a solver needs of a manifold: it stays as it is while the bodies tremble, and odd places do it no harm.

use crate::brute_force::{manifold, size};
use crate::common::{Random, at_size};
use rockfall_collide::{Cache, Manifold, collide, distance};
use rockfall_math::{DVec3, Isometry, Mat3, Pose, Quat, Vec3, rotation, trig};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;

fn cuboid(half: Vec3) -> Shape {
    Shape::Box { half }
}

fn cuboid_hull(half: Vec3) -> Shape {
    Shape::Hull(Arc::new(Hull::cuboid(half)))
}

fn turned(axis: Vec3, angle: f32) -> Quat {
    rotation::from_rotation_vector(axis.normalize() * angle)
}

fn at(translation: Vec3, turn: Quat) -> Isometry {
    Isometry { rotation: Mat3::from_quat(turn), translation }
}

fn ids(m: &Manifold) -> Vec<u32> {
    let mut ids: Vec<u32> = m.points().iter().map(|p| p.feature).collect();
    ids.sort_unstable();
    ids
}

/// MuJoCo's `NearAlignedManifold`.
#[test]
fn a_cube_on_a_cube_keeps_its_face_and_four_points() {
    let half = Vec3::splat(0.05);
    for (a, b) in [
        (cuboid(half), cuboid(half)),
        (cuboid_hull(half), cuboid_hull(half)),
        (cuboid(half), cuboid_hull(half)),
    ] {
        let mut names = None;
        for power in 2..=9 {
            let tilt = 10.0_f32.powi(-power);
            let pose = at(Vec3::new(0.0, 0.0, 0.1 - 1e-5), turned(Vec3::new(1.0, 0.5, 3.0), tilt));
            let m = manifold(&a, &b, &pose, 1e-3).unwrap();
            assert!((m.normal - Vec3::Z).length() < 1.1 * tilt + 1e-6, "{tilt} {m:?}");
            if tilt <= 1.1e-4 {
                assert_eq!(m.count, 4, "{tilt} {m:?}");
                assert_eq!(*names.get_or_insert(ids(&m)), ids(&m), "{tilt} {m:?}");
            }
        }
    }
}

/// Coins with round rims, one a centimetre deep in the other and a little askew: the way out is that of a small face of a rim, and held there alone they would turn about
/// it into each other.
#[test]
fn a_deep_overlap_is_held_all_over() {
    let rim = (0..39).flat_map(|i| (0..64).map(move |k| (i, k))).map(|(i, k)| {
        let (up, out) = trig::sin_cos(std::f32::consts::TAU * i as f32 / 39.0);
        let (y, x) = trig::sin_cos(std::f32::consts::TAU * k as f32 / 64.0);
        let radius = 0.035 + 0.015 * out;
        Vec3::new(radius * x, radius * y, 0.015 * up)
    });
    let coin = Shape::Hull(Arc::new(Hull::from_points_at_most(&rim.collect::<Vec<_>>(), 32).unwrap()));
    let mut random = Random(11);
    for _ in 0..200 {
        let spin = turned(Vec3::Z, random.between(-3.0, 3.0));
        let askew = turned(Vec3::new(random.between(-1.0, 1.0), 1.0, 0.0), random.between(-0.1, 0.1));
        let aside = Vec3::new(random.between(-0.01, 0.01), random.between(-0.01, 0.01), 0.02);
        let pose = at(aside, rotation::compose(askew, spin));
        let m = manifold(&coin, &coin, &pose, 1e-3).unwrap();
        let depth = -distance(&coin, &coin, &pose).unwrap().distance;
        assert!((m.deepest() + depth).abs() < 0.01 * (depth + coin.inner_radius()) + 1e-6, "{depth} {m:?}");
        let span = m.points().iter().flat_map(|p| m.points().iter().map(|q| p.position.distance(q.position)));
        let span = span.fold(0.0, f32::max);
        assert!(m.count >= 3 && span > 0.03, "{span} {m:?}");
        // Along the normal each is as deep as that corner is, or a little deeper.
        assert!(m.points().iter().all(|p| p.distance < 0.0), "{m:?}");
    }
}

#[test]
fn concentric_boxes_part_along_their_thinnest_side() {
    for turn in [Quat::IDENTITY, turned(Vec3::Z, std::f32::consts::FRAC_PI_2), turned(Vec3::X, 1e-5)] {
        for (a, b) in
            [(cuboid(Vec3::ONE), cuboid(Vec3::ONE)), (cuboid_hull(Vec3::ONE), cuboid_hull(Vec3::ONE))]
        {
            let m = manifold(&a, &b, &at(Vec3::ZERO, turn), 0.01).unwrap();
            assert!((m.deepest() + 2.0).abs() < 1e-4, "{m:?}");
            assert!((m.normal.length() - 1.0).abs() < 1e-6 && m.count >= 1);
            assert!((distance(&a, &b, &at(Vec3::ZERO, turn)).unwrap().distance + 2.0).abs() < 3e-5);
        }
    }
    // One inside the other.
    let m = manifold(&cuboid(Vec3::splat(2.0)), &cuboid(Vec3::splat(0.5)), &Isometry::IDENTITY, 0.0).unwrap();
    assert_eq!(m.deepest(), -2.5);
}

/// So far that heights over faces are endless or no numbers: a caller may bring such a place.
#[test]
fn bodies_beyond_all_numbers_end_nothing() {
    let mut random = Random(5);
    for far in [1e18, 3e30, f32::MAX, f32::INFINITY, f32::NAN] {
        for (first, second) in (0..5).flat_map(|first| (0..5).map(move |second| (first, second))) {
            for direction in [Vec3::X, -Vec3::Y, Vec3::ONE, Vec3::new(1.0, 1e-30, -1.0)] {
                let (a, b) = (random.shape(first), random.shape(second));
                let pose = Isometry { rotation: random.rotation(), translation: direction * far };
                let apart = collide(&a, &b, &pose, 0.01, &mut Cache::default(), &mut Vec::new());
                assert!(apart >= 0.0, "{apart} {a:?}\n{b:?}\n{pose:?}");
            }
        }
    }
}

#[test]
fn balls_that_are_nearly_concentric_part_along_a_unit_normal() {
    let ball = Shape::Sphere { radius: 1.0 };
    let capsule = Shape::Capsule { half_length: 0.5, radius: 0.2 };
    for power in 15..45 {
        let pose = at(Vec3::new(-1e-4, 1.0, 0.0) * 10.0_f32.powi(-power), Quat::IDENTITY);
        for other in [&ball, &capsule] {
            let m = manifold(other, &ball, &pose, 0.0).unwrap();
            assert!((m.normal.length() - 1.0).abs() < 1e-5, "{power} {m:?}");
        }
    }
}

#[test]
fn every_pair_at_the_same_place_has_a_finite_manifold() {
    let mut random = Random(3);
    for first in 0..5 {
        for second in 0..5 {
            for _ in 0..200 {
                let (a, b) = (random.shape(first), random.shape(second));
                let pose = Isometry { rotation: random.rotation(), translation: Vec3::ZERO };
                let Some(m) = manifold(&a, &b, &pose, 10.0) else {
                    assert!(first == 4 && second == 4);
                    continue;
                };
                assert!((m.normal.length() - 1.0).abs() < 1e-5, "{a:?} {b:?} {m:?}");
                assert!(m.points().iter().all(|p| p.position.is_finite() && p.distance.is_finite()));
            }
        }
    }
}

/// Resting places: A, B, and B's pose over A.
fn resting() -> Vec<(&'static str, Shape, Shape, Isometry)> {
    let unit = Vec3::splat(0.5);
    let ground = || Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
    let capsule = || Shape::Capsule { half_length: 0.4, radius: 0.2 };
    let drum = || Shape::Cylinder { half_length: 0.3, radius: 0.4 };
    let rod = || Shape::Cylinder { half_length: 0.4, radius: 0.2 };
    let egg = || Shape::Ellipsoid { half: Vec3::new(0.4, 0.3, 0.2) };
    let die = || Shape::RoundedBox { half: Vec3::splat(0.2), radius: 0.1 };
    let lying = turned(Vec3::Y, std::f32::consts::FRAC_PI_2);
    let on = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let quarter = std::f32::consts::FRAC_PI_4;
    let mut all = vec![
        ("half on half", cuboid(unit), cuboid(unit), at(on(0.3, 0.2, 1.0), Quat::IDENTITY)),
        ("cube on its like", cuboid(unit), cuboid(unit), at(on(0.0, 0.0, 1.0), Quat::IDENTITY)),
        (
            "brick over a joint",
            cuboid(on(1.0, 0.5, 0.25)),
            cuboid(on(1.0, 0.5, 0.25)),
            at(on(1.0, 0.0, 0.5), Quat::IDENTITY),
        ),
        ("turned by 45 degrees", cuboid(unit), cuboid(unit), at(on(0.0, 0.0, 1.0), turned(Vec3::Z, quarter))),
        (
            "turned by 20 degrees",
            cuboid(unit),
            cuboid(0.8 * unit),
            at(on(0.1, 0.2, 0.9), turned(Vec3::Z, 0.35)),
        ),
        (
            "on a slab",
            cuboid(on(50.0, 50.0, 1.0)),
            cuboid(unit),
            at(on(20.0, -7.0, 1.5), turned(Vec3::Z, 0.3)),
        ),
        ("box on the ground", ground(), cuboid(unit), at(on(3.0, 0.0, 0.5), turned(Vec3::Z, 0.3))),
        ("capsule on the ground", ground(), capsule(), at(on(3.0, 0.0, 0.2), lying)),
        (
            "ball on the ground",
            ground(),
            Shape::Sphere { radius: 0.3 },
            at(on(0.0, 0.0, 0.3), Quat::IDENTITY),
        ),
        ("capsule on a box", cuboid(unit), capsule(), at(on(0.0, 0.1, 0.7), lying)),
        ("long capsule over a box", cuboid(0.5 * unit), capsule(), at(on(0.0, 0.1, 0.45), lying)),
        ("capsule on a hull", cuboid_hull(unit), capsule(), at(on(0.0, 0.1, 0.7), lying)),
        ("capsule by capsule", capsule(), capsule(), at(on(0.4, 0.0, 0.1), Quat::IDENTITY)),
        ("ball on a box", cuboid(unit), Shape::Sphere { radius: 0.3 }, at(on(0.1, 0.1, 0.8), Quat::IDENTITY)),
        ("drum on the ground", ground(), drum(), at(on(3.0, 0.0, 0.3), turned(Vec3::Z, 0.3))),
        ("drum on a box", cuboid(unit), drum(), at(on(0.1, 0.1, 0.8), turned(Vec3::Z, 0.3))),
        ("drum on a drum", drum(), drum(), at(on(0.05, 0.1, 0.6), turned(Vec3::Z, 0.3))),
        ("small box on a drum", drum(), cuboid(0.2 * unit), at(on(0.05, 0.1, 0.4), Quat::IDENTITY)),
        ("log on the ground", ground(), rod(), at(on(3.0, 0.0, 0.2), lying)),
        ("log on a box", cuboid(unit), rod(), at(on(0.0, 0.1, 0.7), lying)),
        ("log by log", rod(), rod(), at(on(0.4, 0.0, 0.1), Quat::IDENTITY)),
        ("egg on a box", cuboid(unit), egg(), at(on(0.1, 0.1, 0.7), Quat::IDENTITY)),
        ("die on a box", cuboid(unit), die(), at(on(0.1, 0.1, 0.8), turned(Vec3::Z, 0.3))),
        ("die on a die", die(), die(), at(on(0.1, 0.1, 0.6), Quat::IDENTITY)),
        ("edge on edge", cuboid(unit), cuboid(unit), {
            let turn = rotation::compose(turned(Vec3::Z, 0.9), turned(Vec3::X, quarter));
            let lean = rotation::compose(turned(Vec3::Y, quarter), turn);
            at(rotation::rotate(turned(Vec3::Y, quarter), on(0.0, 0.0, 2.0_f32.sqrt())), lean)
        }),
    ];
    for k in 0..6 {
        let (name, a, b, pose) = all[k].clone();
        let hull = |shape: &Shape| match shape {
            Shape::Box { half } => cuboid_hull(*half),
            other => other.clone(),
        };
        all.push((name, hull(&a), hull(&b), pose));
    }
    all
}

#[test]
fn names_stay_while_a_resting_body_trembles() {
    let mut random = Random(11);
    for (name, a, b, rest) in resting() {
        // Sunk in a little, and apart by less than the margin.
        for lift in [-1e-3, 1e-3] {
            let up = if matches!(name, "capsule by capsule" | "log by log") {
                Vec3::X
            } else {
                rest.translation.normalize()
            };
            let up = if matches!(name, "edge on edge" | "capsule by capsule" | "log by log") {
                up
            } else {
                Vec3::Z
            };
            let rest = Isometry { translation: rest.translation + lift * up, ..rest };
            let still = manifold(&a, &b, &rest, 0.01).unwrap_or_else(|| panic!("{name} does not touch"));
            // Of eight corners, the one that is deepest by a hair takes the place of another.
            let exchanged = usize::from(name.starts_with("turned"));
            for _ in 0..200 {
                let turn = Mat3::from_quat(turned(random.direction(), 1e-4));
                let moved = Isometry {
                    rotation: turn * rest.rotation,
                    translation: rest.translation + 1e-4 * random.direction(),
                };
                let m = manifold(&a, &b, &moved, 0.01).unwrap();
                let same = ids(&m).iter().filter(|id| ids(&still).contains(id)).count();
                assert_eq!(m.count, still.count, "{name} {lift}: {still:?}\n{m:?}");
                assert!(same + exchanged >= m.points().len(), "{name} {lift}: {still:?}\n{m:?}");
                assert!((m.normal - still.normal).length() < 3e-3, "{name} {lift}: {still:?}\n{m:?}");
            }
        }
    }
}

#[test]
fn flat_contacts_have_four_points_and_lines_two() {
    for (name, a, b, rest) in resting() {
        let m = manifold(&a, &b, &rest, 0.01).unwrap();
        let round = |s: &Shape| matches!(s, Shape::Sphere { .. } | Shape::Ellipsoid { .. });
        let long = |s: &Shape| matches!(s, Shape::Capsule { .. }) || name.starts_with("log");
        let wanted = match (&a, &b) {
            _ if name == "edge on edge" || round(&a) || round(&b) => 1,
            _ if long(&a) || long(&b) => 2,
            _ => 4,
        };
        assert_eq!(m.count, wanted, "{name}: {m:?}");
    }
}

/// Classes of bounded shapes that are not thin.
const BOUNDED: [usize; 9] = [0, 1, 2, 3, 7, 8, 9, 10, 11];

/// Two manifolds of the same pair, the second `by` times as large: both are there, and as deep. Of faces and edges that are as good, which
/// may differ by the share that manifolds prefer a face by, rounding may choose another.
fn same_manifold([m, n]: [Option<Manifold>; 2], by: f32, distance: f32, scale: f32, tie: f32) {
    if (distance - 0.05 * scale).abs() < 1e-5 * scale {
        return;
    }
    let (Some(m), Some(n)) = (&m, &n) else {
        assert!(m.is_none() && n.is_none(), "{m:?}\n{n:?}");
        return;
    };
    let preferred = if distance > 0.0 { 0.0 } else { 2e-3 * scale + 0.01 * distance.abs() };
    let off = (m.deepest() - n.deepest() / by).abs();
    assert!(off < 5e-6 * scale + tie + preferred + 1e-4 * scale, "{off} of {distance}\n{m:?}\n{n:?}");
}

#[test]
fn the_place_in_the_world_does_not_matter() {
    let mut random = Random(5);
    for first in BOUNDED {
        for second in BOUNDED {
            for _ in 0..100 {
                let (a, b) = (random.shape(first), random.shape(second));
                let scale = size(&a) + size(&b);
                let place = |random: &mut Random, reach: f32| Pose {
                    position: (reach * random.direction()).as_dvec3(),
                    rotation: turned(random.direction(), random.between(0.0, 3.0)),
                };
                let (of_a, of_b) = (place(&mut random, 0.0), place(&mut random, 0.8 * scale));
                let turn = turned(random.direction(), random.between(0.0, 3.0));
                let shift = DVec3::new(4.0e5, -1.0e6, 3.0e4);
                let moved = |p: &Pose| Pose {
                    position: (turn.as_dquat() * p.position) + shift,
                    rotation: rotation::normalize(rotation::compose(turn, p.rotation)),
                };
                let here = distance(&a, &b, &of_a.see(&of_b)).unwrap();
                let there = distance(&a, &b, &moved(&of_a).see(&moved(&of_b))).unwrap();
                // Of two ways out that are as long to half a percent, rounding may choose another one for round shapes.
                let tie = if first.max(second) > 6 { 5e-3 * here.distance.min(0.0).abs() } else { 0.0 };
                assert!(
                    (here.distance - there.distance).abs() < 5e-6 * scale + tie,
                    "{a:?}\n{b:?}\n{here:?}\n{there:?}"
                );
                let found = [of_a.see(&of_b), moved(&of_a).see(&moved(&of_b))]
                    .map(|pose| manifold(&a, &b, &pose, 0.05 * scale));
                same_manifold(found, 1.0, here.distance, scale, tie);
            }
        }
    }
}

#[test]
fn a_scene_a_thousand_times_larger_or_smaller_has_the_same_contacts() {
    let mut random = Random(15);
    for first in BOUNDED {
        for second in BOUNDED {
            for k in 0..40 {
                let (a, b) = (random.shape(first), random.shape(second));
                let scale = size(&a) + size(&b);
                let pose = Isometry {
                    rotation: random.rotation(),
                    translation: random.between(0.3, 1.0) * scale * random.direction(),
                };
                let here = distance(&a, &b, &pose).unwrap();
                let by = if k % 2 == 0 { 1e3 } else { 1e-3 };
                let moved = Isometry { translation: by * pose.translation, ..pose };
                let there = distance(&at_size(&a, by), &at_size(&b, by), &moved).unwrap();
                let tie = if first.max(second) > 6 { 5e-3 * here.distance.min(0.0).abs() } else { 0.0 };
                let off = (there.distance / by - here.distance).abs();
                assert!(off < 5e-6 * scale + tie, "{a:?}\n{b:?}\n{pose:?}\n{here:?}\n{there:?}");
                let [m, n] = [(&a, &b, &pose, 1.0), (&at_size(&a, by), &at_size(&b, by), &moved, by)]
                    .map(|(a, b, pose, by)| manifold(a, b, pose, by * 0.05 * scale));
                same_manifold([m, n], by, here.distance, scale, tie);
            }
        }
    }
}

#[test]
fn concentric_bodies_part_along_their_thinnest_side() {
    let drum = Shape::Cylinder { half_length: 0.3, radius: 1.0 };
    let rod = Shape::Cylinder { half_length: 2.0, radius: 0.25 };
    let egg = Shape::Ellipsoid { half: Vec3::new(1.0, 0.5, 2.0) };
    let die = Shape::RoundedBox { half: Vec3::new(0.5, 0.4, 0.6), radius: 0.1 };
    let cube = Shape::Box { half: Vec3::ONE };
    let ball = Shape::Sphere { radius: 0.5 };
    // The sum of both reaches along the direction that is the shortest way out.
    for (a, b, depth) in [
        (&drum, &drum, 0.6),
        (&rod, &rod, 0.5),
        (&egg, &egg, 1.0),
        (&die, &die, 1.0),
        (&cube, &drum, 1.3),
        (&cube, &egg, 1.5),
        (&die, &cube, 1.5),
        (&drum, &ball, 0.8),
        (&egg, &ball, 1.0),
        (&rod, &ball, 0.75),
    ] {
        for (a, b) in [(a, b), (b, a)] {
            let d = distance(a, b, &Isometry::IDENTITY).unwrap();
            let m = manifold(a, b, &Isometry::IDENTITY, 0.01).unwrap();
            assert!((d.distance + depth).abs() < 5e-3 * depth, "{a:?} {b:?} {d:?}");
            assert!((m.deepest() + depth).abs() < 1e-2 * depth, "{a:?} {b:?} {m:?}");
        }
    }
}
