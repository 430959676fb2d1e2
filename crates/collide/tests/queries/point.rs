//! Distances of points against `parry3d` and against each other.

use super::*;
use rockfall_collide::nearest_point;
use rockfall_math::DVec3;

#[test]
fn convex_shapes_are_as_far_as_parry_says() {
    let mut random = Random(31);
    for shape in convex() {
        let judge = parry(&shape);
        let mut inside = 0;
        for _ in 0..3000 {
            let p = random.point(1.5);
            let ours = nearest_point(&shape, p.as_dvec3(), f32::INFINITY).expect("no limit");
            let theirs = judge.project_local_point(p, false);
            let away = theirs.point.distance(p);
            let signed = if theirs.is_inside { -away } else { away };
            inside += usize::from(ours.distance < 0.0);
            assert!((ours.distance - signed).abs() < 1e-4, "{}: {ours:?} {theirs:?}", shape.name());
            assert!(
                ((p - ours.point).length() - ours.distance.abs()).abs() < 1e-5,
                "{}: {ours:?} {theirs:?} {p}",
                shape.name()
            );
            assert!(
                (p - ours.point - ours.distance * ours.normal).length() < 1e-5,
                "{}: {ours:?}",
                shape.name()
            );
        }
        assert!(inside > 30, "{}", shape.name());
    }
    let ground = Shape::HalfSpace { normal: Vec3::Z, offset: 1.0 };
    let near = nearest_point(&ground, DVec3::new(3.0, 4.0, -1.0), f32::INFINITY).expect("no limit");
    assert_eq!((near.distance, near.point, near.normal), (-2.0, Vec3::new(3.0, 4.0, 1.0), Vec3::Z));
}

/// The nearest point by brute force over all triangles; the side by counting what a ray passes.
#[test]
fn meshes_are_as_far_as_their_nearest_triangle() {
    let mut random = Random(37);
    let mesh = star();
    let shape = Shape::Mesh(Arc::new(mesh.clone()));
    let judge = parry(&Shape::Mesh(Arc::new(mesh.clone())));
    let judge_of = |p: Vec3| judge.project_local_point(p, false).point.distance(p);
    let crossings = |p: Vec3| {
        let mut count = 0;
        let way = Vec3::new(0.311, 0.7, 0.23).normalize();
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.triangle(t).map(|c| (c - p).as_dvec3());
            let d = way.as_dvec3();
            let volumes = [a.cross(b).dot(d), b.cross(c).dot(d), c.cross(a).dot(d)];
            let same = volumes.iter().all(|&v| v > 0.0) || volumes.iter().all(|&v| v < 0.0);
            let n = (b - a).cross(c - a);
            count += usize::from(same && a.dot(n) / d.dot(n) > 0.0);
        }
        count
    };
    let mut inside = 0;
    for i in 0..4000 {
        let p = if i % 4 == 0 {
            // Beside a corner, where the wrong triangle would give the wrong side.
            let v = mesh.vertices[i % mesh.vertices.len()];
            v * random.between(0.9, 1.1) + random.point(0.02)
        } else {
            random.point(1.4)
        };
        let near = nearest_point(&shape, p.as_dvec3(), f32::INFINITY).expect("no limit");
        assert!((near.distance.abs() - judge_of(p)).abs() < 1e-5, "{near:?}");
        if near.distance.abs() > 1e-5 {
            assert_eq!(near.distance < 0.0, crossings(p) % 2 == 1, "the side of {p}: {near:?}");
            assert!((p - near.point - near.distance * near.normal).length() < 1e-5);
        }
        inside += usize::from(near.distance < 0.0);
    }
    assert!(inside > 500);
}

#[test]
fn height_fields_are_as_far_as_their_nearest_triangle() {
    let mut random = Random(41);
    for field in [terrain(9, 14, 0.4), terrain(30, 3, 3.0), terrain(2, 2, 1.0)] {
        let judge = parry(&Shape::HeightField(Arc::new(field.clone())));
        let shape = Shape::HeightField(Arc::new(field.clone()));
        for _ in 0..2000 {
            let p = random.point(4.0);
            let near = nearest_point(&shape, p.as_dvec3(), f32::INFINITY).expect("no limit");
            let theirs = judge.project_local_point(p, false).point.distance(p);
            assert!((near.distance.abs() - theirs).abs() < 2e-5, "{near:?} {theirs}");
            let below = field.height_at(p.x, p.y).is_some_and(|height| p.z < height);
            assert_eq!(near.distance < 0.0, below);
            assert!((p - near.point - near.distance * near.normal).length() < 1e-5);
        }
    }
}

#[test]
fn a_limit_leaves_out_what_is_further_and_nothing_else() {
    let mut random = Random(43);
    let surfaces = [Shape::Mesh(Arc::new(star())), Shape::HeightField(Arc::new(terrain(9, 14, 0.4)))];
    for shape in convex().iter().chain(&surfaces) {
        for _ in 0..500 {
            let p = random.point(2.0).as_dvec3();
            let near = nearest_point(shape, p, f32::INFINITY).expect("no limit");
            let limit = random.between(0.0, 1.0);
            let limited = nearest_point(shape, p, limit);
            assert_eq!(limited, (near.distance <= limit).then_some(near), "{}", shape.name());
        }
        assert_eq!(nearest_point(shape, DVec3::NAN, 1.0), None);
        assert_eq!(nearest_point(shape, DVec3::splat(f64::INFINITY), f32::INFINITY), None);
        assert_eq!(nearest_point(shape, DVec3::ZERO, f32::NAN), None);
    }
}
