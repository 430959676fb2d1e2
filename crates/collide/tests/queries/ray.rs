//! Rays against closed forms, against `parry3d`, against each other, and where triangles meet.

use super::*;
use rockfall_collide::{INSIDE, Ray, RayHit, cast_ray, cast_ray_by_distance};
use rockfall_math::DVec3;

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin: origin.as_dvec3(), direction: direction.as_dvec3(), max: f64::INFINITY }
}

fn surfaces() -> Vec<Shape> {
    vec![
        Shape::Mesh(Arc::new(star())),
        Shape::Mesh(Arc::new(mesh_of(&boulder(3)))),
        Shape::HeightField(Arc::new(terrain(9, 14, 0.4))),
        Shape::HeightField(Arc::new(terrain(2, 2, 0.4))),
    ]
}

/// `parry3d` works in single precision; it decides no ray that passes an edge by less than that is worth.
#[test]
fn every_shape_is_met_where_parry_meets_it() {
    let mut random = Random(11);
    let all =
        convex().into_iter().chain(surfaces()).chain([Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 }]);
    for shape in all {
        let judge = parry(&shape);
        let (mut hits, mut from_inside, mut odd) = (0, 0, 0);
        // It takes polyhedra by GJK, with a tolerance of its own.
        let tolerance = if matches!(shape, Shape::Hull(_)) { 3e-4 } else { 2e-5 };
        for i in 0..4000 {
            let origin = random.point(if i % 2 == 0 { 0.6 } else { 3.0 });
            let direction = if i % 3 == 0 { random.point(1.0) } else { random.point(0.8) - origin };
            // Of unit length: `parry3d` takes a polyhedron's exit wrongly along others.
            let direction = direction.normalize();
            let solid = i % 4 < 2;
            let max = if i % 5 == 0 { 0.7 } else { 1e6 };
            let ours = cast_ray(&shape, &Ray { max: f64::from(max), ..ray(origin, direction) }, solid);
            let theirs =
                judge.cast_local_ray_and_get_normal(&parry3d::query::Ray::new(origin, direction), max, solid);
            match (ours, theirs) {
                (None, None) => {}
                (Some(ours), Some(theirs)) => {
                    let apart = (ours.t as f32 - theirs.time_of_impact).abs() * direction.length();
                    if apart > tolerance {
                        odd += 1;
                        continue;
                    }
                    hits += 1;
                    if ours.part == INSIDE {
                        from_inside += 1;
                        assert_eq!((ours.t, ours.normal), (0.0, Vec3::ZERO), "{}", shape.name());
                    } else {
                        // Theirs looks against the ray where it comes from within.
                        let turned = (ours.normal - theirs.normal)
                            .length()
                            .min((ours.normal + theirs.normal).length());
                        odd += usize::from(turned > 1e-3);
                    }
                }
                _ => odd += 1,
            }
        }
        assert!(hits > 200 && odd <= 8, "{}: {hits} hits, {odd} odd ones", shape.name());
        let solid = shape.is_convex();
        assert_eq!(from_inside > 100, solid, "{}: {from_inside} from inside", shape.name());
    }
}

#[test]
fn hits_lie_on_the_surface_and_normals_point_out() {
    let mut random = Random(13);
    for shape in convex().into_iter().chain(turned_on_a_lathe()) {
        let mut hits = 0;
        for i in 0..2000 {
            let origin = random.point(2.0);
            let ray = ray(origin, random.point(0.6) - origin);
            let Some(hit) = cast_ray(&shape, &ray, i % 2 == 0) else { continue };
            if hit.part == INSIDE {
                continue;
            }
            hits += 1;
            let near =
                rockfall_collide::nearest_point(&shape, ray.at(hit.t), f32::INFINITY).expect("no limit");
            assert!(near.distance.abs() < 2e-6, "{}: {near:?}", shape.name());
            assert!((hit.normal.length() - 1.0).abs() < 1e-6);
            let outside = ray.at(hit.t) + 1e-3 * hit.normal.as_dvec3();
            let above = rockfall_collide::nearest_point(&shape, outside, f32::INFINITY).expect("no limit");
            assert!((above.distance - 1e-3).abs() < 2e-6, "{}: {above:?}", shape.name());
        }
        assert!(hits > 1000);
    }
}

/// Another method, in single precision, and the closed forms.
#[test]
fn casts_by_distance_meet_what_closed_forms_meet() {
    let mut random = Random(17);
    for shape in convex().into_iter().chain(turned_on_a_lathe()) {
        let (mut hits, mut odd) = (0, 0);
        for i in 0..2000 {
            let origin = random.point(if i % 3 == 0 { 0.4 } else { 2.5 });
            let ray =
                Ray { max: if i % 7 == 0 { 1.0 } else { 9.0 }, ..ray(origin, random.point(0.9) - origin) };
            let solid = i % 2 == 0;
            let (exact, other) = (cast_ray(&shape, &ray, solid), cast_ray_by_distance(&shape, &ray, solid));
            match (exact, other) {
                (None, None) => {}
                (Some(exact), Some(other)) => {
                    hits += 1;
                    let way = ray.at(exact.t) - ray.at(other.t);
                    let grazes = exact.normal.as_dvec3().dot(ray.direction.normalize()).abs() < 0.05;
                    if exact.part != INSIDE && !grazes {
                        assert!(way.length() < 1e-4, "{}: {exact:?} {other:?}", shape.name());
                        // At an edge the normal of either face will do.
                        odd += usize::from((exact.normal - other.normal).length() > 1e-2);
                    }
                }
                _ => odd += 1,
            }
        }
        assert!(hits > 800 && odd < 20, "{}: {hits} hits, {odd} odd ones", shape.name());
    }
}

/// Known answers along faces, through corners, at the surface, and away from it.
#[test]
fn known_answers() {
    let cube = Shape::Box { half: Vec3::ONE };
    let t = |shape: &Shape, origin, direction| {
        cast_ray(shape, &ray(origin, direction), true).map(|hit| (hit.t, hit.normal))
    };
    assert_eq!(t(&cube, Vec3::new(-3.0, 1.0, 0.0), Vec3::X), Some((2.0, -Vec3::X)), "along a face");
    assert_eq!(t(&cube, Vec3::new(-3.0, 1.0, 1.0), Vec3::X), Some((2.0, -Vec3::X)), "along an edge");
    assert_eq!(t(&cube, Vec3::new(-3.0, 1.0001, 0.0), Vec3::X), None);
    assert_eq!(t(&cube, Vec3::splat(3.0), -Vec3::ONE).map(|hit| hit.0), Some(2.0), "through two corners");
    assert_eq!(
        t(&cube, Vec3::new(3.0, -1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)).map(|hit| hit.0),
        Some(2.0),
        "an edge"
    );
    assert_eq!(
        t(&cube, Vec3::new(1.0, 0.0, 0.0), -Vec3::X),
        Some((0.0, Vec3::X)),
        "from the surface inwards"
    );
    assert_eq!(t(&cube, Vec3::new(3.0, 0.0, 0.0), Vec3::X), None, "away from it");
    let hull = Shape::Hull(Arc::new(Hull::cuboid(Vec3::ONE)));
    assert_eq!(t(&hull, Vec3::new(-3.0, 1.0, 0.0), Vec3::X), Some((2.0, -Vec3::X)), "along a hull's face");
    let capsule = Shape::Capsule { half_length: 1.0, radius: 0.5 };
    assert_eq!(t(&capsule, Vec3::new(0.0, 0.0, 5.0), -Vec3::Z), Some((3.5, Vec3::Z)), "along its axis");
    assert_eq!(t(&capsule, Vec3::new(0.5, 0.0, 5.0), -Vec3::Z).map(|hit| hit.0), Some(4.0), "along its side");
    assert_eq!(t(&capsule, Vec3::new(5.0, 0.0, 0.5), -Vec3::X), Some((4.5, Vec3::X)));
    let ground = Shape::HalfSpace { normal: Vec3::Z, offset: 1.0 };
    assert_eq!(t(&ground, Vec3::new(0.0, 0.0, 5.0), -2.0 * Vec3::Z), Some((2.0, Vec3::Z)));
    assert_eq!(t(&ground, Vec3::new(0.0, 0.0, 5.0), Vec3::X), None, "along the ground, above");
    assert_eq!(t(&ground, Vec3::new(0.0, 0.0, 1.0), Vec3::X), Some((0.0, Vec3::ZERO)), "in its surface");
    let parts = |origin, direction| cast_ray(&capsule, &ray(origin, direction), true).map(|hit| hit.part);
    assert_eq!(parts(Vec3::new(0.0, 0.1, -5.0), Vec3::Z), Some(0));
    assert_eq!(parts(Vec3::new(0.0, 0.1, 5.0), -Vec3::Z), Some(1));
    assert_eq!(parts(Vec3::new(5.0, 0.1, 0.0), -Vec3::X), Some(2));
}

#[test]
fn a_ray_that_ends_early_or_is_no_ray_meets_nothing() {
    for shape in convex().iter().chain(&surfaces()) {
        let down = ray(Vec3::new(0.01, 0.02, 9.0), -Vec3::Z);
        let hit = cast_ray(shape, &down, true).expect("it is aimed at the shape");
        assert!(cast_ray(shape, &Ray { max: hit.t, ..down }, true).is_some(), "up to the hit");
        assert_eq!(cast_ray(shape, &Ray { max: hit.t - 1e-9, ..down }, true), None);
        for scale in [1e-100, 1e100] {
            let scaled = cast_ray(shape, &Ray { direction: -scale * DVec3::Z, ..down }, true);
            let t = scaled.expect("as long as it has a direction").t * scale;
            assert!((t - hit.t).abs() < 1e-9, "{}", shape.name());
        }
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for x in bad {
            assert_eq!(cast_ray(shape, &Ray { origin: DVec3::new(x, 0.0, 9.0), ..down }, true), None);
            assert_eq!(cast_ray(shape, &Ray { direction: DVec3::new(0.0, x, -1.0), ..down }, true), None);
        }
        assert_eq!(cast_ray(shape, &Ray { direction: DVec3::ZERO, ..down }, true), None);
        assert_eq!(cast_ray(shape, &Ray { max: f64::NAN, ..down }, true), None);
        assert_eq!(cast_ray(shape, &Ray { max: -1.0, ..down }, true), None);
    }
}

#[test]
fn a_pebble_is_met_from_a_thousand_kilometres_as_from_beside_it() {
    let mut random = Random(19);
    for shape in convex() {
        for _ in 0..200 {
            let aim = random.point(0.2);
            let direction = random.point(1.0).normalize_or(Vec3::X).as_dvec3();
            let near = Ray { origin: aim.as_dvec3() - 3.0 * direction, direction, max: f64::INFINITY };
            let far = Ray { origin: aim.as_dvec3() - 1e6 * direction, ..near };
            let (near, far) = (cast_ray(&shape, &near, true), cast_ray(&shape, &far, true));
            let (near, far) = (near.expect("aimed at it"), far.expect("aimed at it"));
            assert!((far.t - 1e6 - (near.t - 3.0)).abs() < 1e-8, "{}: {near:?} {far:?}", shape.name());
            assert!((far.normal - near.normal).length() < 1e-6);
        }
    }
}

/// The edges that two triangles share, and the normals of all triangles around both ends.
fn seams(shape: &Shape) -> Vec<([Vec3; 2], Vec<Vec3>)> {
    let mesh = match shape {
        Shape::Mesh(mesh) => (**mesh).clone(),
        Shape::HeightField(field) => mesh_of_field(field),
        _ => unreachable!("a surface"),
    };
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (corners, normal) in mesh.triangles.iter().zip(&mesh.normals) {
        corners.iter().for_each(|&c| around[c as usize].push(*normal));
    }
    let mut seams = Vec::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            if mesh.neighbours[t][k] != u32::MAX {
                let ends = [corners[k], corners[(k + 1) % 3]].map(|c| c as usize);
                seams.push((ends.map(|c| mesh.vertices[c]), ends.map(|c| around[c].clone()).concat()));
            }
        }
    }
    seams
}

/// Promise: whoever aims at an edge or at a corner that triangles share meets the surface there.
#[test]
fn no_ray_slips_through_a_seam() {
    let mut random = Random(23);
    let mut rays = 0;
    for shape in surfaces() {
        let seams = seams(&shape);
        // Within the border of a field: its edges that are not shared are no seams, and neither are their ends.
        let inner = |p: Vec3| match &shape {
            Shape::HeightField(field) => {
                let b = field.bounds;
                p.x > b.min.x + 0.01 && p.x < b.max.x - 0.01 && p.y > b.min.y + 0.01 && p.y < b.max.y - 0.01
            }
            _ => true,
        };
        for i in 0..100_000_usize {
            let ([a, b], normals) = &seams[i % seams.len()];
            let aim = match i % 3 {
                0 => *a,
                1 => a.lerp(*b, random.between(0.0, 1.0)),
                _ => a.lerp(*b, 0.5),
            };
            if !inner(aim) {
                continue;
            }
            // From afar and near, along axes as well, down on a field and inwards on a star.
            let mut away = match &shape {
                Shape::HeightField(_) => Vec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), 1.0),
                _ => aim + random.point(0.3),
            };
            if i % 5 == 0 {
                away = Vec3::AXES[away.abs().max_position()] * away[away.abs().max_position()].signum();
            }
            let length = [0.01, 1.0, 1000.0][i % 3] / away.length();
            let origin = aim.as_dvec3() + f64::from(length) * away.as_dvec3();
            // Where the surface folds back, whoever aims at the fold may pass beside it.
            let direction = (aim.as_dvec3() - origin).as_vec3().normalize();
            if normals.iter().any(|normal| normal.dot(direction) > -1e-3) {
                continue;
            }
            // To far beyond the surface, so that a miss of the seam can only be a hit behind it.
            let ray = Ray { origin, direction: aim.as_dvec3() - origin, max: f64::INFINITY };
            let hit = cast_ray(&shape, &ray, true);
            let gone = |hit: RayHit| (hit.t - 1.0) * ray.direction.length();
            assert!(hit.is_some_and(|hit| gone(hit) < 1e-4), "{} {i}: {hit:?} of {ray:?}", shape.name());
            rays += 1;
        }
    }
    assert!(rays > 100_000, "{rays} rays");
}

#[test]
fn parts_name_the_triangle_that_was_met() {
    let mut random = Random(29);
    let field = terrain(9, 14, 0.4);
    let mesh = mesh_of_field(&field);
    let (as_field, as_mesh) = (Shape::HeightField(Arc::new(field)), Shape::Mesh(Arc::new(mesh)));
    let mut hits = 0;
    for i in 0..20_000 {
        let mut direction = random.point(1.0);
        if i % 4 == 0 {
            direction[i % 3] = 0.0;
        }
        if i % 9 == 0 {
            direction = Vec3::AXES[i % 3];
        }
        let ray = ray(random.point(2.0), direction);
        let (a, b) = (cast_ray(&as_field, &ray, true), cast_ray(&as_mesh, &ray, true));
        hits += usize::from(a.is_some());
        match (a, b) {
            (Some(a), Some(b)) => {
                assert_eq!((a.t, a.part), (b.t, b.part));
                assert!((a.normal - b.normal).length() < 1e-5);
            }
            (None, None) => {}
            _ => panic!("ray {i}: {a:?} on the field, {b:?} on the mesh"),
        }
    }
    assert!(hits > 3000, "{hits} hits");
}
