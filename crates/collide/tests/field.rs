//! Contacts of signed distance fields, against the exact shapes that they were sampled from.

use rockfall_collide::{
    Cache, Manifold, Motion, Sweep, collide, distance, nearest_point, passage, penetration,
};
use rockfall_math::{Isometry, Mat3, Vec2, Vec3, hash, rotation, trig};
use rockfall_shape::{Field, FieldSettings, Frustum, HeightField, Hull, Mesh, Shape};
use std::f32::consts::TAU;
use std::sync::Arc;

const ERROR: f32 = 1e-3;

struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        (hash::mix(self.0) >> 40) as f32 / (1 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::from([0; 3].map(|_| self.between(-1.0, 1.0)))
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    fn rotation(&mut self) -> Mat3 {
        let angle = self.between(0.0, 3.0);
        Mat3::from_quat(rotation::from_rotation_vector(self.direction() * angle))
    }
}

fn field(mesh: Mesh) -> Shape {
    Shape::Field(Arc::new(
        Field::new(Arc::new(mesh), FieldSettings::with_error(ERROR)).expect("a closed mesh"),
    ))
}

fn mesh_of(hull: &Hull) -> Mesh {
    let triangles: Vec<[u32; 3]> = (0..hull.normals.len())
        .flat_map(|f| {
            let face = hull.face(f);
            (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]])
        })
        .collect();
    Mesh::from_triangles(&hull.vertices, &triangles).expect("a hull")
}

fn cuboid(half: Vec3) -> Shape {
    field(mesh_of(&Hull::cuboid(half)))
}

fn torus(ring: f32, tube: f32) -> Mesh {
    let around = (0..32).map(|j| {
        let (sin, cos) = trig::sin_cos(TAU * j as f32 / 32.0);
        Vec2::new(ring + tube * cos, tube * sin)
    });
    Mesh::turned(&around.collect::<Vec<_>>(), 64).expect("a torus")
}

fn contacts(a: &Shape, b: &Shape, b_in_a: &Isometry, margin: f32) -> (Vec<Manifold>, f32) {
    let mut out = Vec::new();
    let apart = collide(a, b, b_in_a, margin, &mut Cache::default(), &mut out);
    (out, apart)
}

fn deepest(manifolds: &[Manifold]) -> Option<(f32, Vec3)> {
    manifolds.iter().map(|m| (m.deepest(), m.normal)).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Convex shapes of about the size of the boxes below.
fn convex() -> Vec<Shape> {
    let boulder: Vec<Vec3> = {
        let mut random = Random(5);
        (0..40).map(|_| 0.04 * random.direction()).collect()
    };
    let hull = Arc::new(Hull::from_points_at_most(&boulder, 24).expect("a boulder"));
    vec![
        Shape::Sphere { radius: 0.03 },
        Shape::Capsule { half_length: 0.03, radius: 0.015 },
        Shape::Box { half: Vec3::new(0.04, 0.03, 0.02) },
        Shape::Cylinder { half_length: 0.03, radius: 0.025 },
        Shape::Cone { half_length: 0.03, lower: 0.03, upper: 0.0 },
        Shape::Ellipsoid { half: Vec3::new(0.04, 0.03, 0.025) },
        Shape::RoundedBox { half: Vec3::new(0.03, 0.02, 0.02), radius: 0.01 },
        Shape::Hull(hull.clone()),
        Shape::RoundedHull { hull, radius: 0.01 },
    ]
}

/// Promise: where two shapes are near each other or overlap a little, the nearest contact of a shape and the field of a box is as far as the exact distance of the shape from the box says, to the error of the field, a quarter of the distance, and what
/// is lost between samples; and there is none, with a bound that holds, where they are apart.
#[test]
fn any_convex_shape_and_the_field_of_a_box_are_as_far_apart_as_it_and_the_box() {
    let half = Vec3::new(0.05, 0.04, 0.03);
    let (exact, sampled) = (Shape::Box { half }, cuboid(half));
    let margin = 0.004;
    for shape in convex() {
        let mut random = Random(11);
        let (mut touching, mut worst, mut turned) = (0, 0.0_f32, 0.0_f32);
        for _ in 0..400 {
            let turn = random.rotation();
            let from = random.direction();
            let far = 0.5 * from;
            let place = |translation| Isometry { rotation: turn, translation };
            let gap = distance(&exact, &shape, &place(far)).expect("convex").distance;
            // Straight to about the distance that is wanted, by halves.
            let (mut near, mut away) = (0.0, 0.5);
            let wanted = random.between(-0.004, 0.008);
            for _ in 0..30 {
                let middle = 0.5 * (near + away);
                match distance(&exact, &shape, &place(middle * from)).expect("convex").distance < wanted {
                    true => near = middle,
                    false => away = middle,
                }
            }
            assert!(gap > 0.008);
            let place = place(near * from);
            let right = distance(&exact, &shape, &place).expect("convex");
            let (manifolds, apart) = contacts(&sampled, &shape, &place, margin);
            match deepest(&manifolds) {
                Some((found, normal)) => {
                    touching += 1;
                    worst = worst.max((found - right.distance).abs() - 0.25 * right.distance.abs());
                    turned = turned.max(trig::acos(normal.dot(right.normal).min(1.0)));
                    assert_eq!(apart, 0.0);
                }
                None => {
                    assert!(right.distance > margin - 2.0 * ERROR, "{} {}", shape.name(), right.distance);
                    assert!(
                        apart <= right.distance + 2.0 * ERROR,
                        "{} {apart} {}",
                        shape.name(),
                        right.distance
                    );
                }
            }
        }
        println!("{:16} {touching} touch, off by {worst:.5} m", shape.name());
        assert!(touching > 200, "{} {touching}", shape.name());
        assert!(worst <= 2.0 * ERROR, "{} is off by {worst} m", shape.name());
    }
}

/// The same for two fields.
#[test]
fn two_fields_are_as_far_apart_as_the_shapes_that_they_were_sampled_from() {
    let (half, other) = (Vec3::new(0.05, 0.04, 0.03), Vec3::new(0.03, 0.03, 0.045));
    let (exact, sampled) = (Shape::Box { half }, cuboid(half));
    let (exact_other, sampled_other) = (Shape::Box { half: other }, cuboid(other));
    let mut random = Random(3);
    let (mut touching, mut worst) = (0, 0.0_f32);
    for _ in 0..600 {
        let from = random.direction();
        let rotation = random.rotation();
        let place = Isometry { rotation, translation: random.between(0.055, 0.11) * from };
        let right = distance(&exact, &exact_other, &place).expect("convex").distance;
        if !(-0.005..0.02).contains(&right) {
            continue;
        }
        let (manifolds, apart) = contacts(&sampled, &sampled_other, &place, 0.004);
        match deepest(&manifolds) {
            Some((found, _)) => {
                touching += 1;
                worst = worst.max((found - right).abs() - 0.25 * right.abs());
            }
            None => {
                assert!(right > 0.004 - 2.0 * ERROR, "{right}");
                assert!(apart <= right + 2.0 * ERROR, "{apart} {right}");
            }
        }
    }
    println!("{touching} touch, off by {worst:.5} m");
    assert!(touching > 80, "{touching}");
    assert!(worst <= 2.0 * ERROR, "off by {worst} m");
}

/// Balls at random places around and in a torus, its hole among them.
#[test]
fn a_ball_is_as_far_from_a_torus_as_the_mesh_says() {
    let torus = field(torus(0.035, 0.015));
    let mut random = Random(23);
    let mut touching = 0;
    for _ in 0..2000 {
        let place = Isometry { rotation: random.rotation(), translation: random.vector() * 0.07 };
        let near = nearest_point(&torus, place.translation.as_dvec3(), f32::INFINITY).expect("no limit");
        let radius = random.between(0.002, 0.012);
        let ball = Shape::Sphere { radius };
        let (manifolds, _) = contacts(&torus, &ball, &place, 0.002);
        let right = near.distance - radius;
        match deepest(&manifolds) {
            Some((found, normal)) if right > -0.004 => {
                touching += 1;
                assert!((found - right).abs() <= 1.5 * ERROR, "{found} {right}");
                // In the hole it may touch on several sides: the direction is that of the surface where it says that it touches.
                let touch =
                    manifolds.iter().find(|m| m.normal == normal).expect("it is one of them").points()[0]
                        .position;
                let there = nearest_point(&torus, touch.as_dvec3(), f32::INFINITY).expect("no limit");
                assert!(normal.dot(there.normal) > 0.9, "{normal} {}", there.normal);
            }
            Some(_) => {}
            None => assert!(right > 0.002 - ERROR, "{right}"),
        }
    }
    assert!(touching > 100, "{touching}");
}

/// A ring that hangs on another one touches it where the circles of their tubes do.
#[test]
fn linked_tori_touch_where_their_tubes_do() {
    let torus = field(torus(0.035, 0.01));
    // The second hangs on edge through the hole of the first, which lies flat: inner radius 25 mm each.
    let upright = Mat3::from_quat(rotation::from_rotation_vector(Vec3::X * (0.25 * TAU)));
    for gap in [-0.001, 0.0, 0.001] {
        // At x = -35 mm of the first the second's ring passes through z = 0.
        let place = Isometry { rotation: upright, translation: Vec3::new(0.05 - gap, 0.0, 0.0) };
        let (manifolds, _) = contacts(&torus, &torus, &place, 0.003);
        // Both tubes cross at right angles; in the middle of the two holes is room of 50 mm less the tube's 20.
        let (found, normal) = deepest(&manifolds).expect("they touch");
        assert!(found.is_finite() && normal.is_finite());
        let expected = distance_of_rings(0.035, 0.05 - gap) - 0.02;
        assert!((found - expected).abs() < 1.5 * ERROR, "{found} {expected}");
    }
}

/// Promise: tubes that cross are parted to the side on which their middles are, as long as they have one, also where each has come through more than half of the other.
#[test]
fn tubes_deep_in_each_other_are_parted_to_one_side() {
    let ring = field(torus(0.035, 0.015));
    let mut random = Random(9);
    for depth in [0.004, 0.008, 0.012, 0.016, 0.02, 0.024, 0.027] {
        // The tube of A runs along y where that of B runs along x, higher by what is left of both.
        let upright = rotation::from_rotation_vector(Vec3::X * (0.25 * TAU));
        let turn = rotation::from_rotation_vector(Vec3::Y * random.between(0.0, TAU));
        let b_in_a = Isometry {
            rotation: Mat3::from_quat(rotation::compose(turn, upright)),
            translation: Vec3::new(0.035, 0.0, 0.03 - depth + 0.035),
        };
        let (manifolds, _) = contacts(&ring, &ring, &b_in_a, 1e-3);
        let touching = manifolds.iter().filter(|m| m.deepest() < -0.5 * depth);
        assert!(touching.clone().all(|m| m.normal.z > 0.98), "{depth}: {manifolds:#?}");
        let (found, _) = deepest(&manifolds).expect("they overlap");
        assert!((found + depth).abs() < 2.0 * ERROR + 0.05 * depth, "{depth}: {found}");
    }
}

/// Promise: rings that lie on each other, which overlap in more than one place, have a contact that touches in each of them, also where another place is much deeper: what is held on one side alone falls to the other, and rocks.
#[test]
fn rings_on_each_other_are_held_in_every_place() {
    let (ring, tube) = (0.035, 0.015);
    let shape = field(torus(ring, tube));
    let distance = |p: Vec3| Vec2::new(p.truncate().length() - ring, p.z).length() - tube;
    let circle = |k: usize, of: usize| trig::sin_cos(TAU * k as f32 / of as f32);
    let of = [96, 48];
    let surface: Vec<Vec3> = (0..of[0] * of[1])
        .map(|i| {
            let ((sin_u, cos_u), (sin_v, cos_v)) = (circle(i / of[1], of[0]), circle(i % of[1], of[1]));
            let r = ring + tube * cos_v;
            Vec3::new(r * cos_u, r * sin_u, tube * sin_v)
        })
        .collect();
    let mut random = Random(17);
    let (mut places, mut bare) = (0, Vec::new());
    for _ in 0..400 {
        let turn = |axis: Vec3, angle: f32| Mat3::from_quat(rotation::from_rotation_vector(angle * axis));
        let spins = [(); 2].map(|()| turn(Vec3::Z, random.between(0.0, TAU)));
        let tilt = turn(Vec3::X, random.between(0.0, 0.2));
        let aside = turn(Vec3::Z, random.between(0.0, TAU)) * Vec3::X * random.between(0.0, 0.045);
        let b_in_a = Isometry {
            rotation: spins[0] * tilt * spins[1],
            translation: aside + Vec3::Z * random.between(0.018, 0.03),
        };
        let depths: Vec<f32> = surface.iter().map(|&p| distance(b_in_a.inverse_point(p))).collect();
        // Where the exact surface of A is deeper in B than all around.
        let around = |i: usize| {
            let near = |i: usize, n: usize| [n - 1, 0, 1].map(move |step| (i + step) % n);
            let rows = near(i / of[1], of[0]);
            rows.into_iter().flat_map(move |u| near(i % of[1], of[1]).map(move |v| u * of[1] + v))
        };
        let is_place =
            |&i: &usize| (-4e-3..-1e-3).contains(&depths[i]) && around(i).all(|j| depths[i] <= depths[j]);
        let (manifolds, _) = contacts(&shape, &shape, &b_in_a, 0.008);
        let touching: Vec<Vec3> = manifolds
            .iter()
            .flat_map(|m| m.points().iter().filter(|p| p.distance < 0.0).map(|p| p.position))
            .collect();
        for i in (0..surface.len()).filter(is_place) {
            places += 1;
            if touching.iter().all(|p| p.distance(surface[i]) > 0.02) {
                bare.push((b_in_a, surface[i], depths[i]));
            }
        }
    }
    assert!(places > 130 && 50 * bare.len() < places, "{} of {places} places: {bare:?}", bare.len());
}

/// Distance of two circles of equal radius, one around z at the origin, one around y at (`apart`, 0, 0): metres, by brute force.
fn distance_of_rings(radius: f32, apart: f32) -> f32 {
    let point = |k: u32| {
        let (sin, cos) = trig::sin_cos(TAU * k as f32 / 2000.0);
        (radius * cos, radius * sin)
    };
    let mut least = f32::INFINITY;
    for i in 0..2000 {
        let (x, y) = point(i);
        for j in 0..2000 {
            let (u, w) = point(j);
            least = least.min(Vec3::new(x, y, 0.0).distance(Vec3::new(apart + u, 0.0, w)));
        }
    }
    least
}

/// A cube on floors of every kind: one manifold of four points, all of them as deep as it was put.
#[test]
fn a_cube_stands_on_any_floor_by_four_corners() {
    let cube = cuboid(Vec3::splat(0.05));
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let square = Mesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    let plain = HeightField::new(9, 9, Vec2::splat(0.2), vec![0.0; 81]).expect("a plain");
    let half = Vec3::new(1.0, 1.0, 0.1);
    let floors = [
        (Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, 0.0),
        (Shape::Box { half }, 0.1),
        (Shape::Hull(Arc::new(Hull::cuboid(half))), 0.1),
        (Shape::Mesh(Arc::new(square)), 0.0),
        (Shape::HeightField(Arc::new(plain)), 0.0),
        (Shape::Cylinder { half_length: 0.1, radius: 0.5 }, 0.1),
        (cuboid(Vec3::new(0.2, 0.2, 0.1)), 0.1),
    ];
    for (floor, top) in &floors {
        let turn = Mat3::from_quat(rotation::from_rotation_vector(Vec3::Z * 0.3));
        let place = Isometry { rotation: turn, translation: Vec3::new(0.013, 0.007, top + 0.0499) };
        let (manifolds, _) = contacts(floor, &cube, &place, 1e-3);
        assert_eq!(manifolds.len(), 1, "{} {manifolds:?}", floor.name());
        let m = &manifolds[0];
        assert_eq!(m.count, 4, "{}", floor.name());
        assert!(m.normal.dot(Vec3::Z) > 0.99999, "{} {}", floor.name(), m.normal);
        for p in m.points() {
            assert!((p.distance + 1e-4).abs() < 2e-5, "{} {p:?}", floor.name());
        }
        let xy = |k: usize| m.points[k].position.truncate();
        let span = [1, 2, 3].map(|k| xy(0).distance(xy(k))).into_iter().fold(0.0, f32::max);
        assert!(span > 0.13, "{} {span}", floor.name());
    }
}

/// Swapping the shapes leaves the distance, to half of the error: which of the two slides to the nearest place may differ.
#[test]
fn contacts_are_symmetric() {
    let torus = field(torus(0.035, 0.015));
    let mut others = convex();
    others.push(cuboid(Vec3::new(0.05, 0.04, 0.03)));
    let mut random = Random(77);
    let mut touching = 0;
    for other in &others {
        for _ in 0..60 {
            let place = Isometry {
                rotation: random.rotation(),
                translation: random.between(0.04, 0.09) * random.direction(),
            };
            let (straight, _) = contacts(&torus, other, &place, 0.002);
            let (swapped, _) = contacts(other, &torus, &place.inverse(), 0.002);
            assert_eq!(straight.is_empty(), swapped.is_empty(), "{}", other.name());
            let (Some(a), Some(b)) = (deepest(&straight), deepest(&swapped)) else { continue };
            if a.0 < -0.004 {
                continue;
            }
            touching += 1;
            assert!((a.0 - b.0).abs() < 0.5 * ERROR, "{} {} {}", other.name(), a.0, b.0);
        }
    }
    assert!(touching > 40, "{touching}");
}

/// Names stay and manifolds stay while two bodies slide on each other by a hundredth of a millimetre.
#[test]
fn names_survive_small_motions() {
    let (torus, cube) = (field(torus(0.035, 0.015)), cuboid(Vec3::splat(0.04)));
    let mut random = Random(41);
    let (mut kept, mut all) = (0, 0);
    for _ in 0..200 {
        let rotation = random.rotation();
        let place = Isometry { rotation, translation: random.between(0.04, 0.07) * random.direction() };
        let moved = Isometry { translation: place.translation + 1e-5 * random.direction(), ..place };
        let names = |place: &Isometry| {
            let (manifolds, _) = contacts(&torus, &cube, place, 0.001);
            manifolds.iter().flat_map(|m| m.points().iter().map(|p| p.feature)).collect::<Vec<u32>>()
        };
        let (before, after) = (names(&place), names(&moved));
        all += before.len();
        kept += before.iter().filter(|name| after.contains(name)).count();
    }
    assert!(all > 200 && kept as f32 > 0.95 * all as f32, "{kept} of {all}");
}

#[test]
fn penetrations_and_points_take_the_mesh_itself() {
    let half = Vec3::new(0.05, 0.04, 0.03);
    let sampled = cuboid(half);
    let near = nearest_point(&sampled, Vec3::new(0.02, 0.0, 0.0).as_dvec3(), 0.001).expect("it is inside");
    assert!((near.distance + 0.03).abs() < 1e-6, "{near:?}");
    let ball = Shape::Sphere { radius: 0.01 };
    let at = |x: f32| Isometry { translation: Vec3::new(x, 0.0, 0.0), ..Isometry::IDENTITY };
    assert_eq!(penetration(&ball, &sampled, &at(-0.07)), None);
    let deep = penetration(&ball, &sampled, &at(-0.055)).expect("they overlap");
    assert!((deep.distance + 0.005).abs() < ERROR && deep.normal.dot(Vec3::NEG_X) > 0.99, "{deep:?}");
    // A ball that is wholly inside touches no triangle.
    assert!(penetration(&ball, &sampled, &at(0.0)).is_some());
    assert_eq!(Frustum::of(&sampled), None);
}

/// Promise: rings that fly and turn are stopped at rings, boxes, balls and planes before any corner of them has sunk in by much more than a quarter of the inner radius; where nothing stops them nothing sinks
/// in deeper all the way; and they are stopped where they touch, or, from near by, where they sink in. Distances are those of the corners of the meshes from the exact shapes.
#[test]
fn rings_are_stopped_where_they_would_pass_through() {
    let (mesh, tube) = (Arc::new(torus(0.1, 0.03)), 0.03);
    let ring = Shape::Field(Arc::new(
        Field::new(mesh.clone(), FieldSettings::with_error(ERROR)).expect("a closed mesh"),
    ));
    let others = [
        ring.clone(),
        Shape::Box { half: Vec3::new(0.1, 0.05, 0.2) },
        Shape::Sphere { radius: 0.06 },
        Shape::HalfSpace { normal: Vec3::Z, offset: -0.1 },
    ];
    let mut random = Random(3);
    let [mut stops, mut passes] = [0; 2];
    for round in 0..120 {
        let other = &others[round % others.len()];
        let is_plane = matches!(other, Shape::HalfSpace { .. });
        let from = 0.4 * random.direction();
        let from = if is_plane { Vec3 { z: from.z.abs() + 0.05, ..from } } else { from };
        let motion = |start: Vec3, rotation: Mat3, way: Vec3, turn: Vec3| Motion {
            start: Isometry { rotation, translation: start },
            center: Vec3::ZERO,
            translation: way,
            rotation: turn,
        };
        let aim = 0.15 * random.vector() - from;
        let a = motion(from, random.rotation(), random.between(0.6, 2.0) * aim, 3.0 * random.vector());
        let b = match is_plane {
            true => Motion::at_rest(Isometry::IDENTITY),
            false => motion(Vec3::ZERO, random.rotation(), 0.1 * random.vector(), 2.0 * random.vector()),
        };
        let sweep = Sweep { a, b };
        // The least distance of a corner of one from the other, of every so many.
        let gap = |time: f32, every: usize| {
            let places = [sweep.a.at(time), sweep.b.at(time)];
            let least = |from: Isometry, to: Isometry, other: &Shape| {
                let corners =
                    mesh.vertices.iter().step_by(every).map(|v| to.inverse_point(from.point(*v)).as_dvec3());
                let distance = |p| nearest_point(other, p, f32::INFINITY).expect("a solid").distance;
                corners.map(distance).fold(f32::INFINITY, f32::min)
            };
            let of_a = least(places[0], places[1], other);
            if matches!(other, Shape::Field(_)) { of_a.min(least(places[1], places[0], &ring)) } else { of_a }
        };
        let toi = passage(&ring, other, &sweep, 1e-3);
        let end = toi.map_or(1.0, |toi| toi.time);
        let deepest = (0..=16).map(|k| gap(end * k as f32 / 16.0, 3)).fold(f32::INFINITY, f32::min);
        let name = other.name();
        assert!(deepest > -(0.25 * tube + 2.0 * ERROR), "round {round}, {name}: {deepest} before {toi:?}");
        match toi {
            Some(toi) => {
                // A field that says d is sure of d less its error and a third of the sum of both.
                let there = gap(toi.time, 1);
                assert!(there < 5.0 * ERROR, "round {round}, {name}: {there} apart at {toi:?}");
                assert!((toi.normal.length() - 1.0).abs() < 1e-5);
                stops += 1;
            }
            None => passes += 1,
        }
    }
    assert!(stops > 50 && passes > 15, "{stops} stopped, {passes} passed");
}
