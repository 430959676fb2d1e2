//! Hulls of good, bad and nasty points.

use super::*;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Uniform in [-1, 1).
fn unit(rng: &mut ChaCha8Rng) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn point(rng: &mut ChaCha8Rng) -> Vec3 {
    Vec3::new(unit(rng), unit(rng), unit(rng))
}

/// A point on the unit sphere.
fn direction(rng: &mut ChaCha8Rng) -> Vec3 {
    loop {
        let p = point(rng);
        if p.length_squared() < 1.0 && p.length_squared() > 0.01 {
            return p.normalize();
        }
    }
}

/// Cooks, checks, and makes sure that no point is outside by more than the slack.
fn cook(points: &[Vec3]) -> Hull {
    let hull = Hull::from_points(points).unwrap();
    hull.check().unwrap();
    let slack = slack(points);
    for p in points {
        for (n, o) in hull.normals.iter().zip(&hull.offsets) {
            let out = n.as_dvec3().dot(p.as_dvec3()) - f64::from(*o);
            assert!(out <= slack, "a point is {out} outside, allowed {slack}");
        }
    }
    hull
}

fn counts(hull: &Hull) -> [usize; 3] {
    [hull.vertices.len(), hull.edges.len(), hull.normals.len()]
}

#[test]
fn a_cuboid_has_eight_corners_twelve_edges_and_six_faces() {
    let half = Vec3::new(0.5, 1.0, 2.0);
    let hull = Hull::cuboid(half);
    hull.check().unwrap();
    assert_eq!(counts(&hull), [8, 12, 6]);
    assert_eq!(hull.center, Vec3::ZERO);
    assert_eq!(hull.inner_radius, 0.5);
    assert_eq!(hull, Hull::from_points(&hull.vertices).unwrap());
}

#[test]
fn points_on_a_sphere_keep_all_their_corners() {
    for seed in 0..25 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let points: Vec<Vec3> = (0..400).map(|_| direction(&mut rng)).collect();
        let hull = cook(&points);
        assert!(hull.vertices.len() >= 390, "{} corners", hull.vertices.len());
    }
}

#[test]
fn a_noisy_grid_on_a_cube_is_a_cube() {
    for seed in 0..25 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut points = Vec::new();
        for i in 0..216 {
            let p = Vec3::new((i % 6) as f32, (i / 6 % 6) as f32, (i / 36) as f32) * 0.4 - Vec3::ONE;
            if p.abs().max_element() > 0.99 {
                points.push(p + 1e-7 * point(&mut rng));
            }
        }
        assert_eq!(counts(&cook(&points)), [8, 12, 6], "seed {seed}");
    }
}

#[test]
fn nearly_coplanar_sets_make_valid_hulls_or_say_that_they_are_flat() {
    let mut solid = 0;
    for seed in 0..50 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let thickness = 0.5_f32.powi(seed as i32 / 2);
        let turn = rockfall_math::rotation::normalize(rockfall_math::Quat::from_xyzw(0.3, 0.1, -0.7, 0.4));
        let points: Vec<Vec3> = (0..400)
            .map(|_| rockfall_math::rotation::rotate(turn, point(&mut rng) * Vec3::new(1.0, 1.0, thickness)))
            .collect();
        match Hull::from_points(&points) {
            Ok(_) => {
                cook(&points);
                solid += 1;
            }
            Err(e) => assert_eq!(e, HullError::Coplanar),
        }
    }
    assert!((30..40).contains(&solid), "{solid} of 50 thicknesses down to 2^-24 are solid");
}

#[test]
fn duplicates_change_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let points: Vec<Vec3> = (0..60).map(|_| point(&mut rng)).collect();
    let mut twice = points.clone();
    twice.extend_from_slice(&points);
    assert_eq!(cook(&points), cook(&twice));
}

#[test]
fn the_order_of_the_points_changes_only_the_order_of_the_corners() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut points: Vec<Vec3> = (0..100).map(|_| point(&mut rng)).collect();
    let sorted = |hull: Hull| {
        let mut bits: Vec<_> = hull.vertices.iter().map(|v| v.to_array().map(f32::to_bits)).collect();
        bits.sort_unstable();
        bits
    };
    let before = sorted(cook(&points));
    points.reverse();
    assert_eq!(before, sorted(cook(&points)));
}

#[test]
fn a_finely_divided_cylinder_keeps_its_shape() {
    let ring = (0..500).map(|i| {
        let (s, c) = rockfall_math::trig::sin_cos(i as f32 * (std::f32::consts::TAU / 500.0));
        Vec3::new(c, s, 0.0)
    });
    let points: Vec<Vec3> = ring.flat_map(|p| [p, p + 0.3 * Vec3::Z]).collect();
    let hull = cook(&points);
    assert!(hull.vertices.len() > 400);
    assert!(hull.normals.contains(&Vec3::Z) && hull.normals.contains(&-Vec3::Z));
}

#[test]
fn tiny_huge_and_far_away_hulls_are_valid_or_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let points: Vec<Vec3> = (0..100).map(|_| point(&mut rng)).collect();
    for scale in [1e-5_f32, 1e-3, 1e3, 1e5] {
        cook(&points.iter().map(|p| scale * *p).collect::<Vec<_>>());
    }
    for far in [10.0, 1e3, 1e4] {
        cook(&points.iter().map(|p| *p + Vec3::splat(far)).collect::<Vec<_>>());
    }
    let scaled = |s: f32| Hull::from_points(&points.iter().map(|p| s * *p).collect::<Vec<_>>());
    assert_eq!(scaled(1e-8), Err(HullError::Coincident));
    assert_eq!(scaled(1e-40), Err(HullError::Coincident));
    assert_eq!(scaled(1e30), Err(HullError::TooFar(0)));
}

#[test]
fn points_without_volume_are_refused() {
    let line: Vec<Vec3> = (0..10).map(|i| i as f32 * Vec3::new(1.0, 2.0, 3.0)).collect();
    let plane: Vec<Vec3> = (0..20).map(|i| Vec3::new((i % 4) as f32, (i / 4) as f32, 1.0)).collect();
    assert_eq!(Hull::from_points(&[]), Err(HullError::TooFew(0)));
    assert_eq!(Hull::from_points(&[Vec3::ONE]), Err(HullError::TooFew(1)));
    assert_eq!(Hull::from_points(&[Vec3::ONE; 50]), Err(HullError::Coincident));
    assert_eq!(Hull::from_points(&line), Err(HullError::Collinear));
    assert_eq!(Hull::from_points(&plane), Err(HullError::Coplanar));
}

#[test]
fn points_that_are_not_finite_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut points = Hull::cuboid(Vec3::ONE).vertices;
        points[5].y = bad;
        assert_eq!(Hull::from_points(&points), Err(HullError::NotFinite(5)));
    }
}

#[test]
fn a_simplified_hull_is_smaller_and_inside() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    let points: Vec<Vec3> = (0..300).map(|_| direction(&mut rng)).collect();
    let full = cook(&points);
    let mut volume = 0.0;
    for most in [4, 5, 8, 16, 32, 64, 128, 1000] {
        let small = full.simplified(most).unwrap();
        small.check().unwrap();
        assert!(small.vertices.len() <= most);
        assert!(small.vertices.iter().all(|v| full.vertices.contains(v)));
        let grown = moments(small.triangles()).volume;
        assert!(grown >= volume);
        volume = grown;
    }
    assert_eq!(volume, moments(full.triangles()).volume);
    let sixteen = moments(full.simplified(16).unwrap().triangles()).volume;
    assert!(sixteen > 0.6 * volume, "16 corners keep {sixteen} of {volume}");
}

#[test]
fn agrees_with_parry_on_random_hulls() {
    for seed in 0..50 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let count = 4 + seed as usize * 4;
        let points: Vec<Vec3> = (0..count).map(|_| point(&mut rng)).collect();
        let (corners, _) = parry3d::transformation::try_convex_hull(&points).unwrap();
        let sorted = |points: &[Vec3]| {
            let mut bits: Vec<_> = points.iter().map(|v| v.to_array().map(f32::to_bits)).collect();
            bits.sort_unstable();
            bits
        };
        assert_eq!(sorted(&cook(&points).vertices), sorted(&corners), "seed {seed}");
    }
}

#[test]
fn a_broken_hull_does_not_pass_the_check() {
    let broken = |harm: fn(&mut Hull)| {
        let mut hull = Hull::cuboid(Vec3::ONE);
        harm(&mut hull);
        hull.check().unwrap_err()
    };
    assert_eq!(broken(|h| h.vertices[0].x = f32::NAN), HullDefect::NotFinite);
    assert_eq!(broken(|h| h.loops[0] = 99), HullDefect::Layout);
    assert_eq!(broken(|h| h.offsets.truncate(5)), HullDefect::Layout);
    assert_eq!(broken(|h| h.loops[1] = h.loops[0]), HullDefect::Loop(0));
    assert!(matches!(broken(|h| h.loops[..4].reverse()), HullDefect::Edge(_)));
    assert!(matches!(broken(|h| h.edges[3].faces.swap(0, 1)), HullDefect::Edge(_)));
    assert_eq!(
        broken(|h| h.vertices.push(Vec3::ZERO)),
        HullDefect::Euler { vertices: 9, edges: 12, faces: 6 }
    );
    assert_eq!(broken(|h| h.normals[2] *= 1.01), HullDefect::Normal(2));
    assert_eq!(broken(|h| h.offsets[1] -= 0.01), HullDefect::Plane { face: 1, vertex: 0 });
    assert_eq!(broken(|h| h.offsets[1] += 0.01), HullDefect::Plane { face: 1, vertex: 0 });
    assert_eq!(broken(|h| h.inner_radius = 0.9), HullDefect::Summary);
    assert_eq!(broken(|h| h.blocks.corners[0][1][7] = 0.9), HullDefect::Blocks);
}

#[test]
fn without_a_tolerance_every_face_is_a_triangle_of_the_exact_hull() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut points = Hull::cuboid(Vec3::ONE).vertices;
    for _ in 0..300 {
        let mut p = point(&mut rng);
        p[rng.next_u32() as usize % 3] = 1.0;
        points.push(p + 1e-7 * point(&mut rng));
    }
    let whole = tolerance(&Aabb::from_points(points.iter().copied()));
    let (corners, faces) = polyhedron(&points, usize::MAX, whole, 0.0).unwrap().unwrap();
    assert!(corners.len() > 20 && faces.iter().all(|f| f.len() == 3));
    Hull::assemble(corners, &faces).check().unwrap();
}

#[test]
fn too_many_corners_are_refused_and_can_be_simplified() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let points: Vec<Vec3> = (0..40_000).map(|_| direction(&mut rng)).collect();
    assert_eq!(Hull::from_points(&points), Err(HullError::TooManyCorners));
    let hull = Hull::from_points_at_most(&points, 100).unwrap();
    hull.check().unwrap();
    assert_eq!(hull.vertices.len(), 100);
    assert!(moments(hull.triangles()).volume > 0.9 * 4.0 / 3.0 * std::f64::consts::PI);
}

#[test]
fn a_hull_and_its_mass_have_the_same_bits_everywhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let points: Vec<Vec3> = (0..200).map(|_| point(&mut rng)).collect();
    let hull = cook(&points);
    let floats = hull.vertices.iter().chain(&hull.normals).flat_map(|v| v.to_array());
    let floats = floats.chain(hull.offsets.iter().copied()).map(|x| u64::from(x.to_bits()));
    let words: Vec<u64> = floats.chain(hull.loops.iter().map(|&c| u64::from(c))).collect();
    let mass = crate::Shape::Hull(std::sync::Arc::new(hull)).mass_properties(2600.0).unwrap();
    let (moments, frame) = mass.principal();
    let mass = [[mass.mass, moments.x, moments.y, moments.z], frame.to_array()];
    let mass = mass.as_flattened().iter().map(|x| u64::from(x.to_bits()));
    let hash = words.into_iter().chain(mass).fold(0, rockfall_math::hash::combine);
    assert_eq!(hash, 12_024_146_774_924_908_373);
}
