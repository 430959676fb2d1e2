//! Shape casts and overlaps.

use super::*;
use parry3d::query::{ShapeCastOptions, cast_shapes, intersection_test};
use rockfall_collide::{cast_shape, distance, overlaps, penetration};

fn others() -> Vec<Shape> {
    let mut all = convex();
    all.extend([
        Shape::Mesh(Arc::new(star())),
        Shape::HeightField(Arc::new(terrain(9, 14, 0.4))),
        Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 },
    ]);
    all
}

/// Distance by `parry3d`, 0 where the shapes overlap.
fn apart(a: &SharedShape, place: &Isometry, b: &SharedShape) -> f32 {
    parry3d::query::distance(&parry_pose(place), &**a, &Pose::identity(), &**b).expect("supported").distance
}

#[test]
fn a_cast_ends_where_the_shapes_touch_and_not_later() {
    let mut random = Random(47);
    for a in convex() {
        for b in others() {
            let (judge_a, judge_b) = (parry(&a), parry(&b));
            let (mut hits, mut early) = (0, 0);
            for _ in 0..150 {
                let start = Isometry {
                    translation: random.point(1.0).normalize_or(Vec3::Z) * 5.0,
                    ..random.place(0.0)
                };
                let way = 2.0 * (random.point(1.0) - start.translation);
                // What starts below a field is in it, but not in a mesh of it.
                if apart(&judge_a, &start, &judge_b) < 1e-3 || overlaps(&a, &b, &start.inverse()) {
                    continue;
                }
                let at = |time: f32| Isometry { translation: start.translation + way * time, ..start };
                let hit = cast_shape(&a, &b, &start, way);
                let options = ShapeCastOptions::with_max_time_of_impact(1.0);
                let theirs = cast_shapes(
                    &parry_pose(&start),
                    way,
                    &*judge_a,
                    &Pose::identity(),
                    Vec3::ZERO,
                    &*judge_b,
                    options,
                )
                .expect("supported");
                let Some(hit) = hit else {
                    // What grazes may be missed by either.
                    early += usize::from(theirs.is_some());
                    continue;
                };
                hits += 1;
                // Of two polyhedra parry3d errs by up to a thousandth; our distance has brute force as its judge.
                let there = at(hit.time);
                let exact = distance(&a, &b, &there.inverse()).map(|d| d.distance);
                let gap = exact.unwrap_or_else(|| apart(&judge_a, &there, &judge_b));
                assert!(gap < 2e-4, "{} on {}: {gap} apart at {hit:?}", a.name(), b.name());
                let before = (hit.time - 2e-4).max(0.0);
                let inside = |time: f32| {
                    distance(&a, &b, &at(time).inverse())
                        .map_or(apart(&judge_a, &at(time), &judge_b) == 0.0, |d| d.distance < -1e-5)
                };
                assert!(!inside(before), "{} on {}: late at {hit:?}", a.name(), b.name());
                match theirs {
                    Some(theirs) => early += usize::from((theirs.time_of_impact - hit.time).abs() > 2e-3),
                    None => early += 1,
                }
            }
            assert!(hits > 25 && early <= 4, "{} on {}: {hits} hits, {early} differ", a.name(), b.name());
        }
    }
}

#[test]
fn what_overlaps_from_the_start_hits_at_once_and_what_leaves_does_not() {
    let cube = Shape::Box { half: Vec3::ONE };
    let ball = Shape::Sphere { radius: 0.5 };
    let at = |x: f32| Isometry { translation: Vec3::new(x, 0.0, 0.0), ..Isometry::IDENTITY };
    let hit = cast_shape(&ball, &cube, &at(-1.25), Vec3::NEG_X).expect("it overlaps");
    assert_eq!((hit.time, hit.distance, hit.normal), (0.0, -0.25, Vec3::X));
    assert_eq!(cast_shape(&ball, &cube, &at(-1.5), Vec3::NEG_X), None, "touches and leaves");
    assert_eq!(
        cast_shape(&ball, &cube, &at(-1.5), Vec3::X).map(|hit| hit.time),
        Some(0.0),
        "touches and goes on"
    );
    assert_eq!(cast_shape(&ball, &cube, &at(-9.0), Vec3::ZERO), None, "goes nowhere");
    let floor = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
    assert_eq!(cast_shape(&floor, &cube, &at(0.0), Vec3::X), None, "a half-space can't be cast");
    assert_eq!(cast_shape(&ball, &cube, &at(f32::NAN), Vec3::X), None);
    assert_eq!(cast_shape(&ball, &cube, &at(-9.0), Vec3::INFINITY), None);
    // A thin closed wall is met from either side, however obliquely.
    let wall = Shape::Mesh(Arc::new(mesh_of(&Hull::cuboid(Vec3::new(0.01, 2.0, 2.0)))));
    for side in [-1.0, 1.0] {
        let hit =
            cast_shape(&ball, &wall, &at(3.0 * side), Vec3::new(-4.0 * side, 0.3, 0.0)).expect("a wall");
        assert!((hit.time - (3.0 - 0.51) / 4.0).abs() < 1e-5, "{hit:?}");
        assert!((hit.normal + side * Vec3::X).length() < 1e-3);
    }
}

#[test]
fn overlaps_are_those_of_parry() {
    let mut random = Random(53);
    for a in convex() {
        for b in others() {
            let (judge_a, judge_b) = (parry(&a), parry(&b));
            let (mut yes, mut odd) = (0, 0);
            for _ in 0..300 {
                let place = random.place(1.5);
                let ours = overlaps(&a, &b, &place.inverse());
                let theirs = intersection_test(&parry_pose(&place), &*judge_a, &Pose::identity(), &*judge_b)
                    .expect("supported")
                    .intersecting;
                // A field is solid below; theirs is a mesh without an inside.
                let buried = match &b {
                    Shape::HeightField(field) => field
                        .height_at(place.translation.x, place.translation.y)
                        .is_some_and(|h| place.translation.z < h),
                    _ => false,
                };
                yes += usize::from(ours);
                odd += usize::from(ours != theirs && !(buried && ours));
                let deep = penetration(&a, &b, &place.inverse());
                assert_eq!(deep.is_some(), ours, "{} in {}", a.name(), b.name());
                if let Some(deep) = deep {
                    assert!(deep.distance <= 0.0 && (deep.normal.length() - 1.0).abs() < 1e-5);
                }
            }
            assert!(yes > 15 && odd <= 3, "{} in {}: {yes} overlap, {odd} differ", a.name(), b.name());
        }
    }
}

/// Promise: moved by what the penetration says, convex shapes touch.
#[test]
fn a_penetration_parts_the_shapes() {
    let mut random = Random(59);
    for a in convex() {
        for b in convex() {
            for _ in 0..40 {
                let place = random.place(0.8);
                let Some(deep) = penetration(&a, &b, &place) else { continue };
                let out = Isometry { translation: place.translation - deep.distance * deep.normal, ..place };
                let left = distance(&a, &b, &out).expect("convex").distance;
                assert!(left.abs() < 1e-4, "{} and {}: {left}", a.name(), b.name());
            }
        }
    }
}
