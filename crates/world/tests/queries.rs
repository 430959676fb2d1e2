//! Queries find what looking at every body finds, whatever happened since the last step.

mod common;

use common::{Stage, at, frames, rubs};
use rockfall::math::hash::mix;
use rockfall::math::{Aabb, DVec3, Pose, Quat, Vec2, Vec3, rotation};
use rockfall::shape::{HeightField, Hull, Mesh};
use rockfall::{
    Body, BodyId, Cast, Error, Filter, INSIDE, Kind, Movers, Ray, RayHit, Settings, Shape, World,
};
use rockfall_collide as collide;
use std::sync::Arc;

/// A stream of numbers.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        low + (high - low) * ((mix(self.0) >> 40) as f32 / (1_u64 << 24) as f32)
    }

    fn point(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    fn turn(&mut self) -> Quat {
        let v = self.point(1.0);
        rotation::normalize(Quat::from_xyzw(v.x, v.y, v.z, self.between(-1.0, 1.0)))
    }
}

fn pyramid() -> Mesh {
    let vertices = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y, Vec3::Z];
    let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 2], [0, 3, 2]];
    Mesh::from_triangles(&vertices, &triangles).expect("a pyramid")
}

fn terrain() -> HeightField {
    let mut random = Random(3);
    let heights = (0..100).map(|_| random.between(0.0, 0.5)).collect();
    HeightField::new(10, 10, Vec2::splat(0.8), heights).expect("a terrain")
}

/// Bodies of every kind around `origin`, a few metres across: some lie on a terrain, some fall, some are fixed, some turn.
fn heap(settings: Settings, origin: DVec3) -> Stage {
    let mut stage = Stage::new(settings, rubs(0.5, 0.1));
    let mut random = Random(9);
    let corners: Vec<Vec3> = (0..20).map(|_| random.point(1.0).normalize_or(Vec3::X) * 0.4).collect();
    let shapes = [
        Shape::Sphere { radius: 0.3 },
        Shape::Box { half: Vec3::new(0.3, 0.2, 0.25) },
        Shape::Capsule { half_length: 0.3, radius: 0.15 },
        Shape::Hull(Arc::new(Hull::from_points(&corners).expect("a hull"))),
        Shape::Mesh(Arc::new(pyramid())),
    ]
    .map(|shape| stage.shape(shape));
    let field = stage.shape(Shape::HeightField(Arc::new(terrain())));
    let ground = stage.shape(Shape::HalfSpace { normal: Vec3::Z, offset: -0.5 });
    for shape in [field, ground] {
        let body = Body::fixed(shape, stage.material, Pose::at(origin));
        stage.put(body);
    }
    for i in 0..120_usize {
        let offset =
            Vec3::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0), random.between(0.8, 5.0));
        let pose = Pose { position: origin + offset.as_dvec3(), rotation: random.turn() };
        let kind = match i % 10 {
            0 => Kind::Static,
            1 => Kind::Kinematic,
            _ => Kind::Dynamic,
        };
        let shape = shapes[if kind == Kind::Dynamic { i % 4 } else { i / 10 % 5 }];
        stage.put(Body {
            kind,
            group: 1 << (i % 3),
            velocity: random.point(3.0),
            angular_velocity: random.point(4.0),
            ..Body::new(shape, stage.material, pose)
        });
    }
    stage
}

fn rays(count: usize, origin: DVec3) -> Vec<Ray> {
    let mut random = Random(21);
    let mut rays = Vec::new();
    for i in 0..count {
        let from = random.point(5.0);
        let mut direction = random.point(2.5) - from;
        if i % 4 == 0 {
            direction = random.point(1.0);
        }
        if i % 16 == 0 {
            direction[i / 16 % 3] = 0.0;
        }
        let ray = Ray::new(origin + from.as_dvec3(), direction);
        let ray = if i % 3 == 0 { ray.up_to(3.0) } else { ray };
        rays.push(if i % 5 == 0 { ray.hollow() } else { ray });
    }
    rays
}

/// All bodies that a filter lets through.
fn seen<'a>(world: &'a World, filter: &Filter) -> Vec<(BodyId, Pose, &'a Shape)> {
    let (ids, poses, kinds) = (world.ids(), world.poses(), world.kinds());
    let groups = |id: BodyId| if id.0 <= 2 { 1 } else { 1_u32 << (id.0 % 3) };
    (0..ids.len())
        .filter(|&i| match filter.movers {
            Movers::All => true,
            Movers::Only => kinds[i] != Kind::Static,
            Movers::None => kinds[i] == Kind::Static,
        })
        .filter(|&i| filter.except != Some(ids[i]))
        .filter(|&i| filter.mask == u32::MAX || groups(ids[i]) & filter.mask != 0)
        .map(|i| (ids[i], poses[i], world.shape(ids[i]).expect("it is there")))
        .collect()
}

fn in_frame(pose: &Pose, p: DVec3) -> DVec3 {
    rotation::rotate_back_double(pose.rotation, p - pose.position)
}

/// What a ray meets, body by body, nearest first.
fn met(bodies: &[(BodyId, Pose, &Shape)], ray: &Ray) -> Vec<RayHit> {
    let unit = ray.direction.as_dvec3().normalize();
    let mut hits: Vec<RayHit> = bodies
        .iter()
        .filter_map(|(id, pose, shape)| {
            let local = collide::Ray {
                origin: in_frame(pose, ray.origin),
                direction: rotation::rotate_back_double(pose.rotation, unit),
                max: ray.max_distance,
            };
            let hit = collide::cast_ray(shape, &local, ray.solid)?;
            let normal = rotation::rotate(pose.rotation, hit.normal);
            Some(RayHit { body: *id, distance: hit.t, normal, part: hit.part })
        })
        .collect();
    hits.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.body.cmp(&b.body)));
    hits
}

/// To what the pose of a shape's frame, worked out from the centre of mass in single precision, is worth.
fn alike(ours: &RayHit, theirs: &RayHit) -> bool {
    ours.body == theirs.body
        && (ours.distance - theirs.distance).abs() < 1e-5
        && (ours.normal - theirs.normal).length() < 1e-2
}

/// Every kind of query against looking at every body. Returns how many rays met something.
fn agree(stage: &Stage, filter: &Filter, origin: DVec3) -> usize {
    let world = &stage.world;
    let bodies = seen(world, filter);
    let rays = rays(120, origin);
    let first = world.cast_rays(&rays, filter);
    let all = world.cast_rays_all(&rays, filter);
    let any = world.test_rays(&rays, filter);
    let mut hits = 0;
    for (i, ray) in rays.iter().enumerate() {
        let expected = met(&bodies, ray);
        assert_eq!(any[i], !expected.is_empty(), "ray {i}");
        assert_eq!(first[i].is_some(), !expected.is_empty(), "ray {i}");
        assert_eq!(world.cast_ray(ray, filter), first[i]);
        assert_eq!(all.get(i).len(), expected.len(), "ray {i}");
        // Bodies that are met within a rounding of each other may change places.
        let crowded = expected.windows(2).any(|pair| pair[1].distance - pair[0].distance < 1e-5);
        if !crowded {
            assert!(all.get(i).iter().zip(&expected).all(|(a, b)| alike(a, b)), "ray {i}");
            assert!(first[i].iter().zip(&expected).all(|(a, b)| alike(a, b)), "ray {i}");
        }
        hits += usize::from(any[i]);
    }

    let mut random = Random(31);
    let points: Vec<DVec3> = (0..40).map(|_| origin + random.point(4.0).as_dvec3()).collect();
    for (i, near) in world.nearest_points(&points, 1.5, filter).into_iter().enumerate() {
        let expected = bodies
            .iter()
            .filter_map(|(_, pose, shape)| collide::nearest_point(shape, in_frame(pose, points[i]), 1.5))
            .map(|near| near.distance)
            .reduce(f32::min);
        assert_eq!(near.is_some(), expected.is_some());
        let Some((near, expected)) = near.zip(expected) else { continue };
        assert!((near.distance - expected).abs() < 1e-5, "{near:?} {expected}");
        assert!(((near.point - points[i]).length() as f32 - near.distance.abs()).abs() < 1e-5);
    }

    let probe = Shape::Box { half: Vec3::new(0.5, 0.3, 0.4) };
    let poses: Vec<Pose> =
        points.iter().map(|&position| Pose { position, rotation: random.turn() }).collect();
    let overlaps = world.overlaps(&probe, &poses, filter).expect("a box");
    let deep = world.penetrations(&probe, &poses, filter).expect("a box");
    for (i, pose) in poses.iter().enumerate() {
        let expected: Vec<BodyId> = bodies
            .iter()
            .filter(|(_, there, shape)| collide::overlaps(&probe, shape, &pose.see(there)))
            .map(|body| body.0)
            .collect();
        assert_eq!(overlaps.get(i), expected);
        assert_eq!(deep.get(i).iter().map(|deep| deep.body).collect::<Vec<_>>(), expected);
    }

    let casts: Vec<Cast> = poses.iter().map(|&pose| Cast { pose, translation: random.point(4.0) }).collect();
    for (cast, hit) in casts.iter().zip(world.cast_shapes(&probe, &casts, filter).expect("a box")) {
        let expected = bodies
            .iter()
            .filter_map(|(_, there, shape)| {
                let way = rotation::rotate_back(there.rotation, cast.translation);
                collide::cast_shape(&probe, shape, &there.see(&cast.pose), way)
            })
            .map(|toi| toi.time)
            .reduce(f32::min);
        assert_eq!(hit.is_some(), expected.is_some());
        let Some((hit, expected)) = hit.zip(expected) else { continue };
        let apart = (hit.time - f64::from(expected)).abs() * f64::from(cast.translation.length());
        // Both are early by a few millionths along the normal; on a grazing way that is more.
        assert!(apart < 2e-3, "{hit:?} {expected}");
    }
    hits
}

/// Promise: queries are right before the first step, after every step, and after each change between two.
#[test]
fn queries_are_right_whatever_happened() {
    let mut stage = heap(frames(), DVec3::ZERO);
    let all = Filter::default();
    assert!(agree(&stage, &all, DVec3::ZERO) > 50, "before the first step");
    for step in 0..30 {
        stage.steps(1);
        if step % 5 == 4 {
            assert!(agree(&stage, &all, DVec3::ZERO) > 50, "step {step}");
        }
    }
    // Put somewhere else: a dynamic, a kinematic and a static body.
    let ids = stage.world.ids();
    let kinds = stage.world.kinds();
    for (k, kind) in [Kind::Dynamic, Kind::Kinematic, Kind::Static].into_iter().enumerate() {
        let i = (2..ids.len()).find(|&i| kinds[i] == kind).expect("one of each kind");
        stage.world.set_pose(ids[i], at(-2.0 + 2.0 * k as f64, 1.0, 2.5)).expect("it is there");
        agree(&stage, &all, DVec3::ZERO);
    }
    // Come and gone.
    let ball = stage.ball(0.8);
    for k in 0..3 {
        let body = Body {
            group: 1 << ((ids.len() + k + 1) % 3),
            ..stage.body(ball, at(0.0, 2.0 * k as f64 - 2.0, 4.0))
        };
        stage.put(body);
        agree(&stage, &all, DVec3::ZERO);
    }
    for &id in ids.iter().step_by(7) {
        stage.world.remove(id).expect("it is there");
    }
    agree(&stage, &all, DVec3::ZERO);
    stage.steps(1);
    agree(&stage, &all, DVec3::ZERO);
    // A burst: every body is thrown, and turns.
    let mut random = Random(41);
    for id in stage.world.ids() {
        stage.world.set_velocity(id, random.point(20.0), random.point(40.0)).expect("it is there");
    }
    for _ in 0..6 {
        stage.steps(1);
        agree(&stage, &all, DVec3::ZERO);
    }
}

#[test]
fn filters_leave_out_what_they_say() {
    let mut stage = heap(frames(), DVec3::ZERO);
    let two = stage.world.ids()[40];
    for filter in [
        Filter::groups(1),
        Filter::groups(6),
        Filter { movers: Movers::Only, ..Filter::default() },
        Filter { movers: Movers::None, mask: 3, ..Filter::default() },
        Filter::except(two),
        Filter::except(BodyId(999_999)),
    ] {
        agree(&stage, &filter, DVec3::ZERO);
        stage.steps(2);
        assert!(agree(&stage, &filter, DVec3::ZERO) > 5, "{filter:?}");
    }
    assert!(stage.world.cast_rays(&rays(50, DVec3::ZERO), &Filter::groups(0)).iter().all(Option::is_none));
}

/// Promise: every query gives the same bits for any number of threads.
#[test]
fn answers_are_the_same_for_any_number_of_threads() {
    let answers: Vec<_> = [1, 2, 5]
        .into_iter()
        .map(|threads| {
            let mut stage = heap(Settings { threads, ..frames() }, DVec3::ZERO);
            stage.steps(20);
            let rays = rays(2000, DVec3::ZERO);
            let points: Vec<DVec3> = rays.iter().map(|ray| ray.origin).collect();
            let poses: Vec<Pose> = points.iter().map(|&p| Pose::at(p)).collect();
            let casts: Vec<Cast> = rays
                .iter()
                .map(|ray| Cast { pose: Pose::at(ray.origin), translation: ray.direction })
                .collect();
            let (all, ball) = (Filter::default(), Shape::Sphere { radius: 0.4 });
            let world = &stage.world;
            (
                (
                    world.cast_rays(&rays, &all),
                    world.cast_rays_all(&rays, &all),
                    world.test_rays(&rays, &all),
                ),
                world.nearest_points(&points, f32::INFINITY, &all),
                world.overlaps(&ball, &poses, &all).expect("a ball"),
                world.penetrations(&ball, &poses, &all).expect("a ball"),
                world.cast_shapes(&ball, &casts, &all).expect("a ball"),
            )
        })
        .collect();
    assert!(answers[1] == answers[0] && answers[2] == answers[0]);
    assert!(answers[0].0.0.iter().filter(|hit| hit.is_some()).count() > 1000);
}

/// Promise: ten thousand kilometres from the origin a ray meets the same place.
#[test]
fn far_from_the_origin_as_near_it() {
    let away = DVec3::new(8.0e6, -6.0e6, 1.0e6);
    let near = heap(frames(), DVec3::ZERO);
    let far = heap(frames(), away);
    let (all, mut hits) = (Filter::default(), 0);
    // The positions themselves are worth a nanometre there.
    for (a, b) in rays(2000, DVec3::ZERO).iter().zip(&rays(2000, away)) {
        let (a, b) = (near.world.cast_ray(a, &all), far.world.cast_ray(b, &all));
        assert_eq!(a.map(|hit| hit.body), b.map(|hit| hit.body));
        let Some((a, b)) = a.zip(b) else { continue };
        hits += 1;
        let grazing = a.distance > 0.0 && (a.distance - b.distance).abs() > 1e-6;
        assert!(!grazing, "{a:?} {b:?}");
    }
    assert!(hits > 1000);
    let p = DVec3::new(0.3, 0.4, 7.0);
    let [a, b] = [near.world.nearest_point(p, 9.0, &all), far.world.nearest_point(away + p, 9.0, &all)];
    let [a, b] = [a, b].map(|near| near.expect("something is within nine metres"));
    assert!(a.body == b.body && (a.distance - b.distance).abs() < 1e-6);
    assert!((b.point - away - a.point).length() < 1e-6);
}

#[test]
fn of_equals_the_smallest_id_is_told() {
    for order in [[7, 3, 5], [3, 5, 7], [5, 7, 3]] {
        let mut stage = Stage::new(frames(), rubs(0.5, 0.0));
        let cube = stage.cuboid(0.5, 0.5, 0.5);
        for id in order {
            let body = Body { id: Some(BodyId(id)), ..stage.body(cube, at(3.0, 0.0, 0.0)) };
            stage.put(body);
        }
        let all = Filter::default();
        let ids = |hits: &[RayHit]| hits.iter().map(|hit| hit.body.0).collect::<Vec<_>>();
        let ray = Ray::new(DVec3::ZERO, Vec3::new(1.0, 0.01, 0.003));
        assert_eq!(stage.world.cast_ray(&ray, &all).expect("three cubes").body, BodyId(3));
        assert_eq!(ids(stage.world.cast_rays_all(&[ray], &all).get(0)), [3, 5, 7]);
        assert_eq!(stage.world.nearest_point(DVec3::ZERO, 9.0, &all).expect("three").body, BodyId(3));
        let cast = Cast { pose: at(0.0, 0.0, 0.0), translation: Vec3::new(9.0, 0.1, 0.0) };
        let hit = stage.world.cast_shape(&Shape::Sphere { radius: 0.1 }, &cast, &all).expect("a ball");
        assert_eq!(hit.expect("three cubes").body, BodyId(3));
    }
}

#[test]
fn known_answers() {
    let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
    let cube = stage.cuboid(1.0, 1.0, 1.0);
    let body = stage.body(cube, at(0.0, 0.0, 5.0));
    let id = stage.put(body);
    let world = &stage.world;
    let all = Filter::default();
    let from = |x, y, z| Ray::new(DVec3::new(x, y, z), Vec3::NEG_Z);
    let tell =
        |ray: Ray| world.cast_ray(&ray, &all).map(|hit| (hit.body == id, hit.distance, hit.normal, hit.part));
    assert_eq!(tell(from(0.2, 0.3, 9.0)), Some((true, 3.0, Vec3::Z, 5)));
    assert_eq!(tell(from(0.2, 0.3, 5.0)), Some((true, 0.0, Vec3::ZERO, INSIDE)), "it starts inside");
    assert_eq!(tell(from(0.2, 0.3, 5.0).hollow()), Some((true, 1.0, -Vec3::Z, 4)), "and leaves there");
    assert_eq!(tell(from(1.0, 0.3, 9.0)), Some((true, 3.0, Vec3::Z, 5)), "along a face");
    assert_eq!(tell(from(1.5, 0.3, 9.0)), Some((false, 9.0, Vec3::Z, 0)), "on the ground");
    assert_eq!(tell(from(0.2, 0.3, 9.0).up_to(2.99)), None);
    assert_eq!(tell(from(0.2, 0.3, 9.0).up_to(3.0)).map(|hit| hit.0), Some(true), "just as far");
    let ray = Ray::between(DVec3::new(0.0, 0.0, 9.0), DVec3::new(0.0, 0.0, 6.5));
    assert_eq!((tell(ray), ray.at(2.5)), (None, DVec3::new(0.0, 0.0, 6.5)));
    let deep =
        world.penetrations(&Shape::Sphere { radius: 0.5 }, &[at(0.0, 0.0, 0.25)], &all).expect("a ball");
    assert_eq!((deep.get(0)[0].depth, deep.get(0)[0].normal), (0.25, Vec3::Z));
    assert_eq!(deep.get(0)[0].point, DVec3::new(0.0, 0.0, -0.25));
}

#[test]
fn what_makes_no_sense_is_a_miss_or_an_error() {
    let stage = heap(frames(), DVec3::ZERO);
    let (world, all) = (&stage.world, Filter::default());
    let good = Ray::new(DVec3::new(0.0, 0.0, 9.0), Vec3::NEG_Z);
    assert!(world.cast_ray(&good, &all).is_some());
    for ray in [
        Ray { origin: DVec3::NAN, ..good },
        Ray { origin: DVec3::splat(f64::INFINITY), ..good },
        Ray { origin: DVec3::splat(1e300), ..good },
        Ray { direction: Vec3::ZERO, ..good },
        Ray { direction: Vec3::NAN, ..good },
        Ray { direction: Vec3::NEG_INFINITY, ..good },
        good.up_to(f64::NAN),
        good.up_to(-1.0),
    ] {
        assert_eq!(world.cast_ray(&ray, &all), None, "{ray:?}");
        assert_eq!(
            (world.test_rays(&[ray], &all), world.cast_rays_all(&[ray], &all).items().len()),
            (vec![false], 0)
        );
    }
    // Tiny and huge directions are directions.
    for scale in [1e-30, 1e30] {
        assert_eq!(
            world.cast_ray(&Ray { direction: Vec3::NEG_Z * scale, ..good }, &all),
            world.cast_ray(&good, &all)
        );
    }
    for (point, max) in
        [(DVec3::NAN, 1.0), (DVec3::ZERO, f32::NAN), (DVec3::ZERO, -1.0), (DVec3::splat(f64::INFINITY), 1.0)]
    {
        assert_eq!(world.nearest_point(point, max, &all), None);
    }
    let ball = Shape::Sphere { radius: 0.5 };
    let bad_pose = Pose { position: DVec3::NAN, ..Pose::default() };
    assert!(matches!(world.overlaps(&ball, &[bad_pose], &all), Err(Error::Value { what: "position", .. })));
    let cast = Cast { pose: Pose::default(), translation: Vec3::NAN };
    assert!(matches!(world.cast_shapes(&ball, &[cast], &all), Err(Error::Value { what: "translation", .. })));
    assert!(matches!(world.overlaps(&Shape::Sphere { radius: -1.0 }, &[], &all), Err(Error::Shape(_))));
    for shape in [Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }, Shape::Mesh(Arc::new(pyramid()))] {
        assert!(matches!(
            world.penetrations(&shape, &[], &all),
            Err(Error::Value { what: "shape of a query", .. })
        ));
    }
    let empty = Stage::new(frames(), rubs(0.5, 0.0));
    assert_eq!(empty.world.cast_rays(&[good], &all), [None]);
    assert_eq!(empty.world.nearest_point(DVec3::ZERO, 1.0, &all), None);
}

/// `parry3d` casts the same rays into the same heap.
#[test]
fn parry_meets_the_same() {
    use parry3d::math::{Pose as Place, Rotation};
    use parry3d::shape::SharedShape;
    let mut stage = heap(frames(), DVec3::ZERO);
    stage.steps(60);
    let all = Filter::default();
    let bodies: Vec<(BodyId, Place, SharedShape)> = seen(&stage.world, &all)
        .into_iter()
        .map(|(id, pose, shape)| {
            let theirs = match shape {
                Shape::Sphere { radius } => SharedShape::ball(*radius),
                Shape::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
                Shape::Capsule { half_length, radius } => SharedShape::capsule_z(*half_length, *radius),
                Shape::Hull(hull) => SharedShape::convex_hull(&hull.vertices).expect("a hull"),
                Shape::Mesh(mesh) => {
                    SharedShape::trimesh(mesh.vertices.clone(), mesh.triangles.clone()).expect("a mesh")
                }
                Shape::HeightField(field) => {
                    let at = |i: u32, j: u32| j * field.columns + i;
                    let cells = (0..81).map(|cell| (cell % 9, cell / 9));
                    let triangles = cells.flat_map(|(i, j)| {
                        let (a, b) = (at(i, j), at(i + 1, j + 1));
                        [[a, at(i + 1, j), b], [a, b, at(i, j + 1)]]
                    });
                    SharedShape::trimesh(field.samples().collect(), triangles.collect()).expect("a mesh")
                }
                // At its own place: parry3d's half-spaces pass through the origin.
                Shape::HalfSpace { .. } => SharedShape::halfspace(Vec3::Z),
                other => panic!("there is no {} in the heap", other.name()),
            };
            let down = if matches!(shape, Shape::HalfSpace { .. }) { -0.5 * Vec3::Z } else { Vec3::ZERO };
            let place = Place::from_parts(
                pose.position.as_vec3() + down,
                Rotation::from_array(pose.rotation.to_array()),
            );
            (id, place, theirs)
        })
        .collect();
    let rays = rays(3000, DVec3::ZERO);
    let (mut hits, mut odd) = (0, 0);
    for (ray, ours) in rays.iter().zip(stage.world.cast_rays(&rays, &all)) {
        let there = parry3d::query::Ray::new(ray.origin.as_vec3(), ray.direction.normalize());
        let theirs = bodies
            .iter()
            .filter_map(|(id, place, shape)| {
                let t = shape.cast_ray(place, &there, ray.max_distance.min(1e6) as f32, ray.solid)?;
                Some((t, *id))
            })
            .min_by(|a, b| a.partial_cmp(b).expect("numbers"));
        match (ours, theirs) {
            (Some(ours), Some((t, _))) => {
                hits += 1;
                // In single precision, and by GJK with a tolerance of its own.
                odd += usize::from((ours.distance as f32 - t).abs() > 1e-3);
            }
            (None, None) => {}
            _ => odd += 1,
        }
    }
    assert!(hits > 2000 && odd < 10, "{hits} hits, {odd} odd ones");
}

/// Promise: what a query finds is inside of the box that the shape has.
#[test]
fn hits_lie_on_the_bodies() {
    let mut stage = heap(frames(), DVec3::ZERO);
    stage.steps(10);
    let rays = rays(1000, DVec3::ZERO);
    for (ray, hit) in rays.iter().zip(stage.world.cast_rays(&rays, &Filter::default())) {
        let Some(hit) = hit else { continue };
        let pose = stage.world.pose(hit.body).expect("it is there");
        let p = ray.at(hit.distance);
        let area = stage.world.shape(hit.body).expect("it is there").placed_bounds(&pose).grown(1e-4);
        assert!(area.contains(&Aabb::around(p, p)), "{hit:?}");
    }
}
