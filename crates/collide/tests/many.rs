//! Many pairs at once are what each is alone, to the bit.

use rockfall_collide::{Cache, Manifold, Meeting, collide, collide_all};
use rockfall_math::hash::mix;
use rockfall_math::lanes::Width;
use rockfall_math::{Isometry, Mat3, Quat, Vec3};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;

/// Between -1 and 1.
fn random(i: usize, k: u64) -> f32 {
    (mix(32 * i as u64 + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
}

fn vector(i: usize, k: u64) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

fn shapes() -> Vec<Shape> {
    let corners: Vec<Vec3> = (0..16).map(|i| vector(i, 0).normalize()).collect();
    vec![
        Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) },
        Shape::Box { half: Vec3::splat(0.5) },
        Shape::Sphere { radius: 0.4 },
        Shape::Sphere { radius: 0.6 },
        Shape::Capsule { half_length: 0.5, radius: 0.3 },
        Shape::Hull(Arc::new(Hull::from_points(&corners).expect("points on a ball"))),
        Shape::HalfSpace { normal: Vec3::Z, offset: 0.1 },
    ]
}

#[test]
fn many_pairs_at_once_are_what_each_is_alone() {
    let shapes = shapes();
    let count = 5_000;
    let pick = |i: usize, k: u64| &shapes[mix(64 * i as u64 + k) as usize % shapes.len()];
    let pose = |i: usize, round: usize| {
        let turn = Quat::from_xyzw(random(i, 3), random(i, 4), random(i, 5), 1.0 + random(i, 6)).normalize();
        // Of some the axes are parallel, some are at the same place, some nowhere.
        let rotation = if i.is_multiple_of(7) { Mat3::IDENTITY } else { Mat3::from_quat(turn) };
        let shift = 0.01 * round as f32 * vector(i, 10);
        let translation = match i % 50 {
            0 => Vec3::ZERO,
            1 => Vec3::new(f32::NAN, 0.0, 0.0),
            _ => 1.2 * vector(i, 7) + shift,
        };
        Isometry { rotation, translation }
    };
    let mut alone = vec![Cache::default(); count];
    let mut together: Vec<_> = Width::all().map(|_| alone.clone()).collect();
    // Met again with what they remember, each a little further on.
    for round in 0..3 {
        let poses: Vec<Isometry> = (0..count).map(|i| pose(i, round)).collect();
        let margin = 0.05;
        let meeting = |i: usize| {
            let is_none = i.is_multiple_of(101);
            (!is_none).then(|| Meeting { a: pick(i, 0), b: pick(i, 1), b_in_a: &poses[i], margin })
        };
        let expected: Vec<(f32, Vec<Manifold>)> = (0..count)
            .map(|i| {
                let mut out = Vec::new();
                let apart = meeting(i).map_or(0.0, |Meeting { a, b, b_in_a, margin }| {
                    collide(a, b, b_in_a, margin, &mut alone[i], &mut out)
                });
                (apart, out)
            })
            .collect();
        assert!(expected.iter().filter(|(_, out)| !out.is_empty()).count() > count / 4);
        for (width, caches) in Width::all().zip(&mut together) {
            let (mut mets, mut out) = (Vec::new(), Vec::new());
            collide_all(width, meeting, caches, &mut mets, &mut out);
            assert_eq!(&alone, caches, "{width:?}");
            for (met, (apart, manifolds)) in mets.iter().zip(&expected) {
                assert_eq!((met.apart, &out[met.manifolds.clone()]), (*apart, &manifolds[..]), "{width:?}");
            }
        }
    }
}
