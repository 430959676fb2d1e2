//! Continuous detection: nothing is missed, nothing is late.

mod common;

use common::Random;
use rockfall_collide::{Motion, Sweep, Toi, distance, time_of_impact};
use rockfall_math::{Isometry, Mat3, Quat, Vec2, Vec3, rotation, trig};
use rockfall_shape::{HeightField, Hull, Mesh, Shape};
use std::sync::Arc;

fn at(position: Vec3, turn: Quat) -> Isometry {
    Isometry { rotation: Mat3::from_quat(turn), translation: position }
}

fn moving(start: Isometry, translation: Vec3, rotation: Vec3) -> Motion {
    Motion { translation, rotation, ..Motion::at_rest(start) }
}

/// A closed box as a mesh.
fn slab(half: Vec3) -> Mesh {
    let hull = Hull::cuboid(half);
    let mut triangles = Vec::new();
    for f in 0..hull.normals.len() {
        let face = hull.face(f);
        triangles.extend((2..face.len()).map(|k| [face[0], face[k - 1], face[k]]));
    }
    Mesh::from_triangles(&hull.vertices, &triangles).expect("a slab")
}

fn walls() -> Vec<Shape> {
    let half = Vec3::new(2.0, 2.0, 0.0005);
    vec![
        Shape::Box { half },
        Shape::Hull(Arc::new(Hull::cuboid(half))),
        Shape::Mesh(Arc::new(slab(half))),
        Shape::HalfSpace { normal: Vec3::Z, offset: 0.0005 },
        Shape::HeightField(Arc::new(
            HeightField::new(5, 5, Vec2::ONE, vec![0.0005; 25]).expect("a flat field"),
        )),
    ]
}

/// Shoots bullets, the first of which is a ball, at walls of all kinds. The normal may lean by `leans` at the seam of two
/// triangles.
fn shoot(bullets: &[Shape], seed: u64, leans: f32) {
    let mut random = Random(seed);
    let target = 1e-4;
    for wall in &walls() {
        for speed in [10.0_f32, 100.0, 1000.0, 5000.0] {
            for (k, bullet) in bullets.iter().enumerate() {
                for _ in 0..20 {
                    let way = speed / 60.0;
                    let over = Vec3::new(random.between(-0.9, 0.9), random.between(-0.9, 0.9), 0.0);
                    let height = random.between(0.02, 0.95 * way.min(60.0));
                    // Not square to the wall, and through a place on it.
                    let lean =
                        Vec3::new(random.between(-0.01, 0.01), random.between(-0.01, 0.01), -1.0).normalize();
                    let start = over - lean * height;
                    let turn = if k == 0 { Quat::IDENTITY } else { random.turn() };
                    let sweep = Sweep {
                        a: moving(at(start, turn), lean * way, Vec3::ZERO),
                        b: Motion::at_rest(Isometry::IDENTITY),
                    };
                    let toi = time_of_impact(bullet, wall, &sweep, target).expect("an impact");
                    // The lowest point of the bullet is the target above the wall, by closed form.
                    let low = match bullet {
                        Shape::Sphere { radius } => *radius,
                        Shape::Box { half } => {
                            half.x * sweep.a.start.rotation.transpose().z_axis.abs().element_sum()
                        }
                        Shape::Capsule { half_length, radius } => {
                            radius + half_length * sweep.a.start.rotation.z_axis.z.abs()
                        }
                        _ => {
                            let down = sweep.a.start.inverse_vector(Vec3::NEG_Z);
                            bullet.support(down).expect("a bounded shape").dot(down)
                        }
                    };
                    let exact = (start.z - low - 0.0005) / -(lean.z * way);
                    let tolerance = (2.0 * target + 2e-6 * way) / way;
                    assert!(
                        toi.time <= exact,
                        "{} at {speed}: {} is later than {exact}",
                        wall.name(),
                        toi.time
                    );
                    assert!(
                        toi.time >= exact - tolerance,
                        "{} at {speed}: {} is before {exact}",
                        wall.name(),
                        toi.time
                    );
                    let seams = matches!(wall, Shape::Mesh(_) | Shape::HeightField(_));
                    let leans = if seams { leans } else { 1e-3 };
                    assert!((toi.normal + Vec3::Z).length() < leans, "{toi:?}");
                }
            }
        }
    }
}

#[test]
fn no_bullet_passes_a_wall_of_a_millimetre() {
    let bullets = [
        Shape::Sphere { radius: 0.005 },
        Shape::Box { half: Vec3::splat(0.005) },
        Shape::Capsule { half_length: 0.01, radius: 0.005 },
    ];
    shoot(&bullets, 1, 1e-3);
}

#[test]
fn no_round_bullet_passes_a_wall_of_a_millimetre() {
    let bullets = [
        Shape::Sphere { radius: 0.005 },
        Shape::Cylinder { half_length: 0.01, radius: 0.005 },
        Shape::Cone { half_length: 0.01, lower: 0.005, upper: 0.0 },
        Shape::Ellipsoid { half: Vec3::new(0.01, 0.005, 0.005) },
        Shape::RoundedBox { half: Vec3::splat(0.003), radius: 0.002 },
    ];
    // What is nearest to a triangle from beside it by a hundredth of a millimetre is nearest to its edge.
    shoot(&bullets, 2, 0.1);
}

#[test]
fn what_starts_behind_a_surface_may_leave_it() {
    let wall = Shape::Mesh(Arc::new(slab(Vec3::new(2.0, 2.0, 0.5))));
    let sweep = Sweep {
        a: moving(Isometry::IDENTITY, Vec3::Z * 5.0, Vec3::ZERO),
        b: Motion::at_rest(Isometry::IDENTITY),
    };
    assert_eq!(time_of_impact(&Shape::Sphere { radius: 0.1 }, &wall, &sweep, 1e-3), None);
}

#[test]
fn what_slides_over_a_floor_is_not_stopped_by_its_seams() {
    let field = HeightField::new(41, 41, Vec2::splat(0.25), vec![0.0; 1681]).expect("a floor");
    let floor = Shape::HeightField(Arc::new(field));
    for (shape, height) in
        [(Shape::Sphere { radius: 0.1 }, 0.1), (Shape::Box { half: Vec3::splat(0.1) }, 0.1)]
    {
        for sunk in [-0.002, 0.0, 0.002, 0.01] {
            let start = at(Vec3::new(-3.0, 0.013, height - sunk), Quat::IDENTITY);
            let sweep =
                Sweep { a: moving(start, Vec3::X * 6.0, Vec3::ZERO), b: Motion::at_rest(Isometry::IDENTITY) };
            assert_eq!(time_of_impact(&shape, &floor, &sweep, 1e-3), None, "{} sunk {sunk}", shape.name());
        }
    }
}

/// Distances along the way, in many steps.
fn check_by_sampling(what: &str, a: &Shape, b: &Shape, sweep: &Sweep, target: f32, toi: Option<Toi>) -> bool {
    let gap = |t: f32| {
        let b_in_a = sweep.a.at(t).inverse().then_after(&sweep.b.at(t));
        distance(a, b, &b_in_a).expect("a convex pair").distance
    };
    if gap(0.0) <= 1.1 * target {
        return false;
    }
    let end = toi.map_or(1.0, |toi| toi.time);
    for k in 0..200 {
        let t = end * k as f32 / 200.0;
        assert!(gap(t) > 0.9 * target, "{what}: {} apart at {t} before {toi:?}", gap(t));
    }
    if let Some(toi) = toi {
        let there = gap(toi.time);
        assert!(there > 0.9 * target && there < 1.1 * target + 1e-5, "{what}: {there} apart at {toi:?}");
        assert!((there - toi.distance).abs() < 1e-5);
    }
    toi.is_some()
}

#[test]
fn random_casts_agree_with_dense_sampling() {
    let mut random = Random(5);
    let points: Vec<Vec3> = (0..20).map(|_| random.point(1.0).normalize_or(Vec3::X) * 0.5).collect();
    let shapes = [
        Shape::Sphere { radius: 0.3 },
        Shape::Box { half: Vec3::new(0.5, 0.1, 0.3) },
        Shape::Capsule { half_length: 0.6, radius: 0.05 },
        Shape::Hull(Arc::new(Hull::from_points(&points).expect("a hull"))),
        Shape::Cylinder { half_length: 0.1, radius: 0.5 },
        Shape::Cone { half_length: 0.4, lower: 0.3, upper: 0.0 },
        Shape::Ellipsoid { half: Vec3::new(0.5, 0.2, 0.3) },
        Shape::RoundedBox { half: Vec3::new(0.3, 0.1, 0.2), radius: 0.1 },
        Shape::HalfSpace { normal: Vec3::Z, offset: -0.5 },
    ];
    let ground = shapes.len() - 1;
    let mut hits = 0;
    for (i, a) in shapes[..ground].iter().enumerate() {
        for (j, b) in shapes.iter().enumerate() {
            for round in 0..30 {
                let start = random.point(1.0).normalize_or(Vec3::Z) * 3.0;
                let start = if j == ground { Vec3::new(start.x, start.y, start.z.abs()) } else { start };
                let way = -start * random.between(0.5, 2.0) + random.point(0.6);
                let spin = random.point(4.0);
                let other = if j == ground { Vec3::ZERO } else { random.point(3.0) };
                let sweep = Sweep {
                    a: Motion { center: random.point(0.2), ..moving(at(start, random.turn()), way, spin) },
                    b: moving(
                        at(Vec3::ZERO, if j == ground { Quat::IDENTITY } else { random.turn() }),
                        random.point(0.3) * (other * 0.3),
                        other,
                    ),
                };
                let toi = time_of_impact(a, b, &sweep, 1e-3);
                hits +=
                    usize::from(check_by_sampling(&format!("{i} on {j}, {round}"), a, b, &sweep, 1e-3, toi));
            }
        }
    }
    assert!(hits > 800, "{hits} hits");
}

#[test]
fn a_spinning_rod_does_not_pass_a_plate() {
    let mut random = Random(7);
    let rod = Shape::Capsule { half_length: 1.0, radius: 0.01 };
    let half = Vec3::new(0.5, 0.5, 0.0005);
    let plate = Shape::Box { half };
    let as_mesh = Shape::Mesh(Arc::new(slab(half)));
    let mut hits = 0;
    for round in 0..60 {
        // The centre stays beside the plate, the ends sweep through it.
        let start = at(
            Vec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), random.between(0.1, 0.6)),
            rotation::between(Vec3::Z, Vec3::X),
        );
        let spin = Vec3::new(random.between(-0.3, 0.3), random.between(1.0, 6.0), random.between(-0.3, 0.3));
        let sweep =
            Sweep { a: moving(start, random.point(0.05), spin), b: Motion::at_rest(Isometry::IDENTITY) };
        let toi = time_of_impact(&rod, &plate, &sweep, 1e-3);
        hits += usize::from(check_by_sampling(&format!("round {round}"), &rod, &plate, &sweep, 1e-3, toi));
        let by_mesh = time_of_impact(&rod, &as_mesh, &sweep, 1e-3);
        let (toi, by_mesh) = (toi.map(|t| t.time), by_mesh.map(|t| t.time));
        assert!(toi.is_some() == by_mesh.is_some(), "{toi:?} {by_mesh:?}");
        if let (Some(toi), Some(by_mesh)) = (toi, by_mesh) {
            assert!((toi - by_mesh).abs() < 1e-3, "{toi} {by_mesh}");
        }
    }
    assert!(hits > 30, "{hits} hits");
}

/// Promise: of a ring that flies and tumbles it is the ball in its tube that is stopped, far from what the ring turns around: at the target from the triangle that it would go
/// through; up to there it sinks in nowhere by more than contacts push out.
#[test]
fn the_ball_in_a_tumbling_ring_is_stopped() {
    let mut random = Random(11);
    let around: Vec<Vec2> = (0..12)
        .map(|k| {
            let (sin, cos) = trig::sin_cos(std::f32::consts::TAU * k as f32 / 12.0);
            Vec2::new(0.35 + 0.1 * cos, 0.1 * sin)
        })
        .collect();
    let ring = Shape::Mesh(Arc::new(Mesh::turned(&around, 24).expect("a ring")));
    let (center, radius) = (ring.inner_center(), ring.inner_radius());
    assert!(center.length() > 0.3 && radius > 0.08, "{center} {radius}");
    let mesh = Arc::new(slab(Vec3::new(0.5, 0.4, 0.1)));
    let block = Shape::Mesh(mesh.clone());
    let target = 1e-3;
    let (mut hits, mut exact) = (0, 0);
    for round in 0..400 {
        let start = random.point(1.0).normalize_or(Vec3::Z) * 1.5;
        let way = -start * random.between(0.5, 2.0) + random.point(0.6);
        let sweep = Sweep {
            a: moving(at(start, random.turn()), way, random.point(4.0)),
            b: moving(at(Vec3::ZERO, random.turn()), random.point(0.3), random.point(2.0)),
        };
        let gap = |t: f32| {
            let seen = sweep.b.at(t).inverse_point(sweep.a.at(t).point(center));
            mesh.nearest(seen.as_dvec3(), f64::INFINITY).expect("a mesh").distance as f32 - radius
        };
        let toi = time_of_impact(&ring, &block, &sweep, target);
        let end = toi.map_or(1.0, |toi| toi.time);
        for k in 0..=500 {
            let t = end * k as f32 / 500.0;
            assert!(gap(t) > -0.3 * radius, "round {round}: {} apart at {t} before {toi:?}", gap(t));
        }
        if let Some(toi) = toi {
            // Another triangle may be nearer, of which the ball only comes into the way a little.
            let there = gap(end);
            assert!(there < 1.1 * target + 1e-5, "round {round}: {there} apart at {toi:?}");
            hits += 1;
            exact += usize::from((there - toi.distance).abs() < 1e-5);
        }
    }
    assert!(exact > hits / 2, "{exact} of {hits}");
    assert!(hits > 80, "{hits} hits");
}

#[test]
fn strange_numbers_have_no_impact() {
    let ball = Shape::Sphere { radius: 1.0 };
    let rest = Motion::at_rest(Isometry::IDENTITY);
    let start = at(Vec3::Z * 5.0, Quat::IDENTITY);
    for bad in [f32::NAN, f32::INFINITY] {
        for motion in
            [moving(start, Vec3::splat(bad), Vec3::ZERO), moving(start, Vec3::ZERO, Vec3::splat(bad))]
        {
            for other in walls() {
                assert_eq!(time_of_impact(&ball, &other, &Sweep { a: motion, b: rest }, 1e-3), None);
            }
        }
    }
    let sweep = Sweep { a: moving(start, Vec3::Z * -9.0, Vec3::ZERO), b: rest };
    assert_eq!(time_of_impact(&ball, &ball, &sweep, f32::NAN), None);
    assert_eq!(time_of_impact(&walls()[4], &ball, &sweep, 1e-3), None);
    assert!(time_of_impact(&ball, &ball, &sweep, 1e-3).is_some());
}

#[test]
fn a_bullet_stops_on_rough_terrain_where_parry_sees_it_touch() {
    use parry3d::math::Pose;
    use parry3d::shape::{Ball, TriMesh};
    let mut random = Random(11);
    let heights: Vec<f32> = (0..400).map(|_| random.between(-0.4, 0.4)).collect();
    let field = HeightField::new(20, 20, Vec2::splat(0.5), heights).expect("hills");
    let triangles: Vec<[u32; 3]> = (0..19 * 19)
        .flat_map(|c| {
            let a = c / 19 * 20 + c % 19;
            [[a, a + 1, a + 21], [a, a + 21, a + 20]]
        })
        .collect();
    let vertices: Vec<Vec3> = field.samples().collect();
    let mesh = Mesh::from_triangles(&vertices, &triangles).expect("hills");
    let judge = TriMesh::new(vertices, triangles).expect("hills");
    let grounds = [Shape::HeightField(Arc::new(field)), Shape::Mesh(Arc::new(mesh))];
    let bullet = Shape::Sphere { radius: 0.02 };
    let target = 1e-3;
    for round in 0..60 {
        let from = random.point(3.0).with_z(1.5);
        let to = random.point(3.0).with_z(-1.5);
        let sweep = Sweep {
            a: moving(at(from, Quat::IDENTITY), to - from, Vec3::ZERO),
            b: Motion::at_rest(Isometry::IDENTITY),
        };
        let gap = |t: f32| {
            let pose = Pose::from_translation(from + (to - from) * t);
            parry3d::query::distance(&pose, &Ball::new(0.02), &Pose::identity(), &judge)
                .expect("supported")
                .distance
        };
        for ground in &grounds {
            let toi = time_of_impact(&bullet, ground, &sweep, target).expect("the way ends below the ground");
            let there = gap(toi.time);
            // A little deeper where it grazes a triangle that it hardly sinks into.
            assert!(
                there > 0.9 * target - 0.25 * 0.02 && there < 1.2 * target,
                "{round} {}: {there}",
                ground.name()
            );
            for k in 0..50 {
                let there = gap(toi.time * k as f32 / 50.0);
                assert!(there > 0.9 * target - 0.25 * 0.02, "{round} {}: {there} before", ground.name());
            }
        }
    }
}
