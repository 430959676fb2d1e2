//! Mass properties against closed forms and against parry3d.

use super::*;
use crate::{Compound, Hull, Mesh};
use parry3d::mass_properties::MassProperties as ParryMass;
use parry3d::shape::{Shape as _, TriMesh};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use rockfall_math::Pose;
use std::sync::Arc;

/// Largest difference of the two, as a part of the largest moment (or of mass and size).
fn error(a: &MassProperties, b: &MassProperties, size: f32) -> f32 {
    let entries = |m: &Mat3| m.to_cols_array();
    let largest = entries(&b.inertia).into_iter().fold(0.0, |l: f32, x| l.max(x.abs()));
    let inertia = entries(&(a.inertia - b.inertia)).into_iter().fold(0.0, |l: f32, x| l.max(x.abs()));
    let mass = (a.mass - b.mass).abs() / b.mass;
    (inertia / largest).max(mass).max((a.center - b.center).length() / size)
}

fn properties(mass: f32, center: Vec3, moments: Vec3) -> MassProperties {
    MassProperties { mass, center, inertia: Mat3::from_diagonal(moments) }
}

fn hull(points: &[Vec3]) -> Shape {
    Shape::Hull(Arc::new(Hull::from_points(points).unwrap()))
}

/// The triangles of a hull as a mesh.
fn mesh(hull: &Hull) -> Shape {
    let vertices: Vec<Vec3> = hull.triangles().flatten().map(|p| p.as_vec3()).collect();
    let triangles: Vec<[u32; 3]> =
        (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Shape::Mesh(Arc::new(Mesh::from_triangles(&vertices, &triangles).unwrap()))
}

fn random_points(seed: u64, count: usize) -> Vec<Vec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut next = move || (rng.next_u32() >> 8) as f32 / (1 << 23) as f32 - 1.0;
    (0..count).map(|_| Vec3::new(next(), next(), next())).collect()
}

#[test]
fn a_box_weighs_the_same_as_box_hull_and_mesh() {
    let half = Vec3::new(0.5, 1.0, 2.0);
    // m = 8, m/3 (b² + c²) and so on.
    let expected = properties(800.0, Vec3::ZERO, Vec3::new(5.0, 4.25, 1.25) * (800.0 / 3.0));
    let cooked = Hull::cuboid(half);
    for shape in [Shape::Box { half }, Shape::Hull(Arc::new(cooked.clone())), mesh(&cooked)] {
        let found = shape.mass_properties(100.0).unwrap();
        assert!(error(&found, &expected, 1.0) < 1e-6, "{}: {found:?}", shape.name());
    }
}

#[test]
fn a_tetrahedron_matches_its_closed_form() {
    // Corner at the origin, legs 1: volume 1/6, centre 1/4, second moments about the origin 1/60 (squares)
    // and 1/120 (products), thus about the centre 1/60 - 1/96 = 1/160 and 1/120 - 1/96 = -1/480.
    let found = hull(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).mass_properties(1.0).unwrap();
    let (d, p) = (1.0 / 80.0, 1.0 / 480.0);
    let inertia = Mat3::from_cols(Vec3::new(d, p, p), Vec3::new(p, d, p), Vec3::new(p, p, d));
    let expected = MassProperties { mass: 1.0 / 6.0, center: Vec3::splat(0.25), inertia };
    assert!(error(&found, &expected, 1.0) < 1e-6, "{found:?}");
}

#[test]
fn a_body_off_the_origin_has_the_same_inertia_about_its_own_centre() {
    let points = random_points(1, 50);
    let here = hull(&points).mass_properties(1000.0).unwrap();
    for shift in [Vec3::new(8.0, -4.0, 2.0), Vec3::new(-128.0, 64.0, 256.0)] {
        let there =
            hull(&points.iter().map(|p| *p + shift).collect::<Vec<_>>()).mass_properties(1000.0).unwrap();
        let back = MassProperties { center: there.center - shift, ..there };
        assert!(error(&back, &here, 1.0) < 1e-7 * shift.length() + 1e-6, "{back:?} {here:?}");
    }
}

#[test]
fn finer_hulls_of_a_ball_converge_to_it() {
    let exact = Shape::Sphere { radius: 2.0 }.mass_properties(1.0).unwrap();
    assert!((exact.mass - 33.510_32).abs() < 1e-4);
    assert!((exact.inertia.x_axis.x - 0.4 * 33.510_32 * 4.0).abs() < 1e-3);
    let mut last = 1.0;
    for count in [50_u16, 200, 800, 3200] {
        // A spiral of equal areas.
        let points: Vec<Vec3> = (0..count)
            .map(|i| {
                let z = 1.0 - (2.0 * f32::from(i) + 1.0) / f32::from(count);
                let (s, c) = rockfall_math::trig::sin_cos(2.399_963 * f32::from(i));
                let r = (1.0 - z * z).sqrt();
                2.0 * Vec3::new(r * c, r * s, z)
            })
            .collect();
        let e = error(&hull(&points).mass_properties(1.0).unwrap(), &exact, 2.0);
        assert!(e < 0.3 * last, "{count} corners: {e}, before {last}");
        last = e;
    }
    assert!(last < 0.01);
}

#[test]
fn a_capsule_agrees_with_its_pieces_and_with_parry() {
    for (half_length, radius) in [(0.0, 1.0), (0.5, 0.2), (3.0, 0.01), (0.1, 2.0)] {
        let found = Shape::Capsule { half_length, radius }.mass_properties(700.0).unwrap();
        let oracle = parry3d::shape::Capsule::new(-half_length * Vec3::Z, half_length * Vec3::Z, radius);
        let expected = from_parry(&oracle.mass_properties(700.0));
        assert!(error(&found, &expected, 1.0) < 2e-6, "{found:?} {expected:?}");
    }
    let ball = Shape::Sphere { radius: 1.5 }.mass_properties(1.0).unwrap();
    let round = Shape::Capsule { half_length: 0.0, radius: 1.5 }.mass_properties(1.0).unwrap();
    assert!(error(&round, &ball, 1.0) < 1e-6);
}

fn from_parry(m: &ParryMass) -> MassProperties {
    MassProperties { mass: m.mass(), center: m.local_com, inertia: m.reconstruct_inertia_matrix() }
}

#[test]
fn random_hulls_and_meshes_agree_with_parry() {
    for seed in 0..100 {
        let cooked = Hull::from_points(&random_points(seed, 8 + seed as usize)).unwrap();
        // Its `ConvexPolyhedron` merges faces that are a little bent, which costs up to 1e-3 of the mass.
        let (corners, triangles) = parry3d::transformation::try_convex_hull(&cooked.vertices).unwrap();
        let expected = from_parry(&ParryMass::from_convex_polyhedron(1000.0, &corners, &triangles));
        let as_mesh = mesh(&cooked);
        let found = Shape::Hull(Arc::new(cooked)).mass_properties(1000.0).unwrap();
        assert!(error(&found, &expected, 1.0) < 1e-5, "hull {seed}: {found:?} {expected:?}");

        let Shape::Mesh(triangles) = &as_mesh else { unreachable!() };
        let oracle = TriMesh::new(triangles.vertices.clone(), triangles.triangles.clone()).unwrap();
        let expected = from_parry(&oracle.mass_properties(1000.0));
        let found = as_mesh.mass_properties(1000.0).unwrap();
        assert!(error(&found, &expected, 1.0) < 1e-5, "mesh {seed}: {found:?} {expected:?}");
    }
}

#[test]
fn a_concave_mesh_weighs_what_its_parts_weigh() {
    // An L: a box of 2 x 1 x 1 with a box of 1 x 1 x 1 on one end, as the outline pushed along y.
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let at = |i: usize, y: f32| Vec3::new(outline[i][0], y, outline[i][1]);
    let vertices: Vec<Vec3> = (0..12).map(|i| at(i % 6, (i / 6) as f32)).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, b, c], [a + 6, c + 6, b + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, i + 6, j], [j, i + 6, j + 6]]);
    }
    let mesh = Mesh::from_triangles(&vertices, &triangles).unwrap();
    assert!(mesh.closed);
    let found = Shape::Mesh(Arc::new(mesh)).mass_properties(1.0).unwrap();
    let parts = [
        (2.0, Vec3::new(1.0, 0.5, 0.5), Vec3::new(2.0, 1.0, 1.0)),
        (1.0, Vec3::new(0.5, 0.5, 1.5), Vec3::ONE),
    ];
    let center = (2.0 * parts[0].1 + parts[1].1) / 3.0;
    let mut inertia = Mat3::ZERO;
    for (m, c, s) in parts {
        let q = s * s;
        inertia += Mat3::from_diagonal(m / 12.0 * Vec3::new(q.y + q.z, q.z + q.x, q.x + q.y));
        let d = c - center;
        let outer = Mat3::from_cols(d.x * d, d.y * d, d.z * d);
        inertia += m * (d.length_squared() * Mat3::IDENTITY - outer);
    }
    assert!(error(&found, &MassProperties { mass: 3.0, center, inertia }, 1.0) < 1e-6, "{found:?} {inertia}");
}

#[test]
fn mass_scales_with_density_and_can_be_set() {
    let shape = hull(&random_points(5, 30));
    let one = shape.mass_properties(1.0).unwrap();
    let many = shape.mass_properties(2500.0).unwrap();
    assert!(error(&one.with_mass(many.mass), &many, 1.0) < 1e-6);
}

#[test]
fn cylinders_and_cones_agree_with_parry() {
    for (half_length, radius) in [(1.0, 0.5), (0.01, 2.0), (3.0, 0.02)] {
        let expected = parry3d::shape::Cylinder::new(half_length, radius).mass_properties(700.0);
        let found = Shape::Cylinder { half_length, radius }.mass_properties(700.0).unwrap();
        // parry3d's axis is y.
        let inertia = from_parry(&expected).inertia.to_cols_array_2d();
        let moments = Vec3::new(inertia[0][0], inertia[2][2], inertia[1][1]);
        assert!(error(&found, &properties(expected.mass(), Vec3::ZERO, moments), 1.0) < 2e-6, "{found:?}");
        let truncated =
            Shape::Cone { half_length, lower: radius, upper: radius }.mass_properties(700.0).unwrap();
        assert_eq!(found, truncated);

        // m = π r² 2h / 3; the centre a quarter of the height up; 3/10 m r², 3/20 m r² + 3/80 m (2h)².
        let found = Shape::Cone { half_length, lower: radius, upper: 0.0 }.mass_properties(700.0).unwrap();
        let mass = 700.0 * std::f32::consts::PI * radius * radius * 2.0 * half_length / 3.0;
        let across = mass * (0.15 * radius * radius + 0.15 * half_length * half_length);
        let moments = Vec3::new(across, across, 0.3 * mass * radius * radius);
        let expected = properties(mass, Vec3::Z * (-0.5 * half_length), moments);
        assert!(error(&found, &expected, 1.0) < 2e-6, "{found:?} {expected:?}");
    }
}

/// The convex hull of a shape's support points in many directions, a spiral of equal areas.
fn outline(shape: &Shape, count: u16) -> Shape {
    let points: Vec<Vec3> = (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f32::from(i) + 1.0) / f32::from(count);
            let (s, c) = rockfall_math::trig::sin_cos(2.399_963 * f32::from(i));
            let r = (1.0 - z * z).sqrt();
            shape.support(Vec3::new(r * c, r * s, z)).unwrap()
        })
        .collect();
    hull(&points)
}

#[test]
fn finer_outlines_of_round_shapes_converge_to_them() {
    let wedge = [Vec3::ZERO, Vec3::X, Vec3::new(0.2, 1.0, 0.0), Vec3::new(0.1, 0.3, 0.8), Vec3::ONE];
    let wedge = Arc::new(Hull::from_points(&wedge).unwrap());
    let shapes = [
        Shape::Ellipsoid { half: Vec3::new(0.5, 1.0, 1.5) },
        Shape::Cone { half_length: 0.7, lower: 0.5, upper: 1.2 },
        Shape::RoundedBox { half: Vec3::new(0.5, 0.2, 0.3), radius: 0.5 },
        Shape::RoundedHull { hull: wedge, radius: 0.6 },
    ];
    for shape in shapes {
        let exact = shape.mass_properties(1000.0).unwrap();
        let off = |count| error(&outline(&shape, count).mass_properties(1000.0).unwrap(), &exact, 1.0);
        let (coarse, fine) = (off(1000), off(8000));
        // Errors go with one over the count, and an outline is never larger.
        assert!(fine < 0.25 * coarse && fine < 4e-3, "{}: {coarse} {fine}", shape.name());
    }
}

/// Share of a box of points that is inside of a shape, by moments: an estimate that knows nothing of formulas.
#[test]
fn a_rounded_hull_agrees_with_random_points() {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let mut next = move || f64::from(rng.next_u32()) / f64::from(u32::MAX);
    let points = [Vec3::ZERO, Vec3::X, Vec3::new(0.2, 1.0, 0.0), Vec3::new(0.1, 0.3, 0.8)];
    let radius = 0.3_f32;
    let cooked = Hull::from_points(&points).unwrap();
    let tetrahedron = parry3d::shape::ConvexPolyhedron::from_convex_hull(&cooked.vertices).unwrap();
    let shape = Shape::RoundedHull { hull: Arc::new(cooked), radius };
    let exact = shape.mass_properties(1.0).unwrap();
    let bounds = shape.bounds();
    let size = (bounds.max - bounds.min).as_dvec3();
    let count = 400_000_u32;
    let (mut inside, mut first, mut squares, mut products) = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for _ in 0..count {
        let p = bounds.min.as_dvec3() + size * DVec3::new(next(), next(), next());
        use parry3d::query::PointQuery;
        if tetrahedron.distance_to_local_point(p.as_vec3(), true) <= radius {
            inside += 1.0;
            first += p;
            squares += p * p;
            products += DVec3::new(p.y * p.z, p.z * p.x, p.x * p.y);
        }
    }
    let cell = size.x * size.y * size.z / f64::from(count);
    let center = first / inside;
    let volume = inside * cell;
    let s = squares * cell - volume * center * center;
    let p =
        products * cell - volume * DVec3::new(center.y * center.z, center.z * center.x, center.x * center.y);
    let diagonal = DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
    let found = MassProperties::new(volume, center, diagonal, -p);
    // 400,000 points know a share of a half to 0.08 %.
    assert!(error(&found, &exact, 1.0) < 4e-3, "{found:?} {exact:?}");
}

#[test]
fn a_rounded_box_weighs_the_same_as_the_rounded_hull_of_a_box() {
    for (half, radius) in
        [(Vec3::new(0.5, 1.0, 2.0), 0.25), (Vec3::splat(0.1), 1.0), (Vec3::new(1.0, 0.001, 0.5), 0.01)]
    {
        let by_formula = Shape::RoundedBox { half, radius }.mass_properties(100.0).unwrap();
        let hull = Shape::RoundedHull { hull: Arc::new(Hull::cuboid(half)), radius };
        let by_pieces = hull.mass_properties(100.0).unwrap();
        assert!(error(&by_pieces, &by_formula, 1.0) < 1e-6, "{by_pieces:?} {by_formula:?}");
        // A body off its origin is the same body.
        let moved: Vec<Vec3> =
            Hull::cuboid(half).vertices.iter().map(|v| *v + Vec3::new(64.0, -8.0, 16.0)).collect();
        let moved = Shape::RoundedHull { hull: Arc::new(Hull::from_points(&moved).unwrap()), radius };
        let there = moved.mass_properties(100.0).unwrap();
        let back = MassProperties { center: there.center - Vec3::new(64.0, -8.0, 16.0), ..there };
        // Coordinates near 64 m are rounded to 4e-6 m, which is a share of the thinnest side.
        let rounding = 1e-5 / half.min_element() + 1e-5;
        assert!(error(&back, &by_formula, 1.0) < rounding, "{back:?} {by_formula:?}");
    }
    // What is left of a tiny box is the ball.
    let ball = Shape::Sphere { radius: 1.0 }.mass_properties(1.0).unwrap();
    let grain = Shape::RoundedBox { half: Vec3::splat(1e-6), radius: 1.0 }.mass_properties(1.0).unwrap();
    assert!(error(&grain, &ball, 1.0) < 1e-5);
}

#[test]
fn an_ellipsoid_is_a_stretched_ball() {
    // m = 4/3 π abc, m/5 (b² + c²) and so on.
    let found = Shape::Ellipsoid { half: Vec3::new(1.0, 2.0, 3.0) }.mass_properties(1.0).unwrap();
    let mass = 8.0 * std::f32::consts::PI;
    let expected = properties(mass, Vec3::ZERO, Vec3::new(13.0, 10.0, 5.0) * (mass / 5.0));
    assert!(error(&found, &expected, 1.0) < 1e-6, "{found:?}");
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::at(DVec3::new(x, y, z))
}

fn compound(parts: Vec<(Shape, Pose)>) -> Shape {
    Shape::Compound(Arc::new(Compound::new(parts).unwrap()))
}

/// Promise: eight small cubes that fill a large one weigh the same as that, and so do two halves that are turned.
#[test]
fn a_compound_of_pieces_weighs_the_same_as_the_whole() {
    let whole = Shape::Box { half: Vec3::new(1.0, 0.5, 0.25) }.mass_properties(700.0).unwrap();
    let piece = Shape::Box { half: Vec3::new(0.5, 0.25, 0.125) };
    let eight = (0..8).map(|i: u8| {
        let side = |bit: u8| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
        (piece.clone(), at(side(0), 0.5 * side(1), 0.25 * side(2)))
    });
    let found = compound(eight.collect()).mass_properties(700.0).unwrap();
    assert!(error(&found, &whole, 1.0) < 1e-6, "{found:?}");
    // Half of it is a box with other axes.
    let half = Shape::Box { half: Vec3::new(0.25, 0.5, 0.5) };
    let quarter = rockfall_math::rotation::from_rotation_vector(Vec3::Y * std::f32::consts::FRAC_PI_2);
    let place = |x: f64| Pose { rotation: quarter, ..at(x, 0.0, 0.0) };
    let found =
        compound(vec![(half.clone(), place(-0.5)), (half, place(0.5))]).mass_properties(700.0).unwrap();
    assert!(error(&found, &whole, 1.0) < 1e-6, "{found:?}");
}

/// Promise: the dumbbell of two balls and a rod has its closed form: 2 (2/5 m r² + m d²) + M L²/12 + M R²/4 across.
#[test]
fn a_dumbbell_matches_its_closed_form() {
    let (r, d, rod_radius, length) = (0.3_f64, 0.8_f64, 0.05_f64, 1.0_f64);
    let ball = Shape::Sphere { radius: r as f32 };
    let rod = Shape::Cylinder { half_length: 0.5 * length as f32, radius: rod_radius as f32 };
    let off = DVec3::new(3.0, -2.0, 1.0);
    let part = |shape: &Shape, z: f64| (shape.clone(), Pose::at(off + DVec3::Z * z));
    let shape = compound(vec![part(&ball, d), part(&rod, 0.0), part(&ball, -d)]);
    let found = shape.mass_properties(1000.0).unwrap();
    let m = 1000.0 * 4.0 / 3.0 * PI * r * r * r;
    let rod_mass = 1000.0 * PI * rod_radius * rod_radius * length;
    let across = 2.0 * (0.4 * m * r * r + m * d * d)
        + rod_mass * (length * length / 12.0 + 0.25 * rod_radius * rod_radius);
    let along = 0.8 * m * r * r + 0.5 * rod_mass * rod_radius * rod_radius;
    let moments = DVec3::new(across, across, along).as_vec3();
    let expected = properties((2.0 * m + rod_mass) as f32, off.as_vec3(), moments);
    assert!(error(&found, &expected, 1.0) < 1e-6, "{found:?} {expected:?}");
    // Parts that overlap are counted twice.
    let twice = compound(vec![part(&ball, 0.0), part(&ball, 0.0)]).mass_properties(1000.0).unwrap();
    assert!((twice.mass as f64 / (2.0 * m) - 1.0).abs() < 1e-6);
}

#[test]
fn random_compounds_agree_with_parry() {
    use parry3d::math::Pose as ParryPose;
    use parry3d::shape::{Compound as ParryCompound, SharedShape};
    for seed in 0..100 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut next = move || (rng.next_u32() >> 8) as f32 / (1 << 23) as f32 - 1.0;
        let mut parts = Vec::new();
        let mut oracle = Vec::new();
        for i in 0..2 + seed % 5 {
            let position = Vec3::new(next(), next(), next());
            let rotation = rockfall_math::rotation::normalize(rockfall_math::Quat::from_xyzw(
                next(),
                next(),
                next(),
                next(),
            ));
            let half = Vec3::new(0.6 + 0.5 * next(), 0.6 + 0.5 * next(), 0.6 + 0.5 * next());
            let (shape, other) = match i % 3 {
                0 => (Shape::Box { half }, SharedShape::cuboid(half.x, half.y, half.z)),
                1 => (Shape::Sphere { radius: half.x }, SharedShape::ball(half.x)),
                _ => (
                    Shape::Capsule { half_length: half.x, radius: half.y },
                    SharedShape::capsule(-half.x * Vec3::Z, half.x * Vec3::Z, half.y),
                ),
            };
            parts.push((shape, Pose { position: position.as_dvec3(), rotation }));
            oracle.push((ParryPose::from_parts(position, rotation), other));
        }
        let found = compound(parts).mass_properties(300.0).unwrap();
        let expected = from_parry(&ParryCompound::new(oracle).mass_properties(300.0));
        assert!(error(&found, &expected, 1.0) < 1e-5, "{seed}: {found:?} {expected:?}");
    }
}
