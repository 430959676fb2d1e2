//! Any two shapes in any place.

use crate::Bytes;
use rockfall_collide::{
    Cache, Manifold, Motion, Ray, Sweep, Toi, cast_ray, cast_shape, collide, distance, nearest_point,
    overlaps, passage, penetration, time_of_impact,
};
use rockfall_math::{DVec3, Isometry, Pose, Quat, Vec2, Vec3};
use rockfall_shape::{Compound, Field, FieldSettings, HeightField, Hull, Mesh, Shape};
use std::sync::Arc;

/// Further than that two bodies of a pair are not from each other, metres.
const FAR: f32 = 1e7;

/// A shape by itself, or a few as one.
fn shape(bytes: &mut Bytes) -> Shape {
    if !bytes.byte().is_multiple_of(8) {
        return single(bytes);
    }
    let parts = (0..1 + bytes.byte() % 4).map(|_| {
        let rotation = Quat::from_mat3(&bytes.rotation());
        let position = Vec3::new(bytes.share(), bytes.share(), bytes.share()).as_dvec3();
        (single(bytes), Pose { position, rotation })
    });
    // Not all shapes can be parts.
    Compound::new(parts).map_or(Shape::Sphere { radius: 1.0 }, |compound| Shape::Compound(Arc::new(compound)))
}

/// The surface of a hull.
fn mesh(hull: &Hull) -> Option<Arc<Mesh>> {
    let mut triangles = Vec::new();
    for f in 0..hull.normals.len() {
        let face = hull.face(f);
        triangles.extend((2..face.len()).map(|k| [face[0], face[k - 1], face[k]]));
    }
    Mesh::from_triangles(&hull.vertices, &triangles).ok().map(Arc::new)
}

fn single(bytes: &mut Bytes) -> Shape {
    let half = Vec3::new(bytes.length(), bytes.length(), bytes.length());
    let [radius, half_length] = [bytes.length(), bytes.length()];
    let hull = |bytes: &mut Bytes| {
        let points: Vec<Vec3> = (0..4 + bytes.byte() % 20)
            .map(|_| half * Vec3::new(bytes.share(), bytes.share(), bytes.share()))
            .collect();
        Arc::new(Hull::from_points(&points).unwrap_or_else(|_| Hull::cuboid(half)))
    };
    match bytes.byte() % 13 {
        0 => Shape::Sphere { radius },
        1 => Shape::Box { half },
        2 => Shape::Capsule { half_length, radius },
        3 => Shape::Hull(hull(bytes)),
        4 => Shape::HalfSpace { normal: bytes.rotation().x_axis, offset: bytes.share() },
        5 => Shape::Cylinder { half_length, radius },
        6 => Shape::Cone {
            half_length,
            lower: radius,
            upper: if bytes.byte().is_multiple_of(2) { 0.0 } else { half.x },
        },
        7 => Shape::Ellipsoid { half },
        8 => Shape::RoundedBox { half, radius },
        9 => Shape::RoundedHull { hull: hull(bytes), radius },
        10 => {
            let heights = (0..12).map(|_| bytes.share()).collect();
            let spacing = Vec2::new(bytes.length(), bytes.length());
            HeightField::new(4, 3, spacing, heights)
                .map_or(Shape::Sphere { radius }, |f| Shape::HeightField(Arc::new(f)))
        }
        11 => {
            // Coarse, so that it is made in no time.
            let field = mesh(&hull(bytes)).and_then(|mesh| {
                let size = (mesh.bounds.max - mesh.bounds.min).max_element();
                Field::new(mesh, FieldSettings { error: 0.1 * size, spacing: 0.2 * size }).ok()
            });
            field.map_or(Shape::Sphere { radius }, |field| Shape::Field(Arc::new(field)))
        }
        _ => mesh(&hull(bytes)).map_or(Shape::Sphere { radius }, Shape::Mesh),
    }
}

fn check_manifold(m: &Manifold, what: &dyn Fn() -> String) {
    assert!((1..=4).contains(&m.count), "{m:?}\n{}", what());
    assert!((m.normal.length() - 1.0).abs() < 1e-3, "{m:?}\n{}", what());
    let finite = m.points().iter().all(|p| p.position.is_finite() && p.distance.is_finite());
    assert!(finite, "{m:?}\n{}", what());
}

fn check_toi(toi: Option<Toi>, name: &str, what: &dyn Fn() -> String) {
    if let Some(toi) = toi {
        assert!((0.0..=1.0).contains(&toi.time) && toi.distance.is_finite(), "{name}: {toi:?}\n{}", what());
        assert!(
            toi.point.is_finite() && (toi.normal.length() - 1.0).abs() < 1e-3,
            "{name}: {toi:?}\n{}",
            what()
        );
    }
}

/// Two shapes, a place and motions from `bytes`, through every function of a pair.
pub fn pair(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let [a, b] = [(); 2].map(|()| shape(&mut bytes));
    if a.validate().is_err() || b.validate().is_err() {
        return;
    }
    let reach = |shape: &Shape| shape.bounds().max.max_element().clamp(1e-6, 1e6);
    let scale = reach(&a) + reach(&b);
    let way = |bytes: &mut Bytes| match bytes.byte() % 4 {
        0 => bytes.vector(),
        1 => bytes.vector() * scale,
        _ => Vec3::new(bytes.share(), bytes.share(), bytes.share()) * scale,
    };
    let b_in_a = Isometry { rotation: bytes.rotation(), translation: way(&mut bytes) };
    let motion = |start, bytes: &mut Bytes| Motion {
        start,
        center: 0.1 * scale * Vec3::new(bytes.share(), bytes.share(), bytes.share()),
        translation: way(bytes),
        rotation: 4.0 * Vec3::new(bytes.share(), bytes.share(), bytes.share()),
    };
    let sweep = Sweep { a: motion(Isometry::IDENTITY, &mut bytes), b: motion(b_in_a, &mut bytes) };
    let margin = bytes.share().abs() * 0.1 * scale;
    let what = || format!("{a:?}\n{b:?}\n{b_in_a:?}\n{sweep:?}");

    let mut manifolds = Vec::new();
    let apart = collide(
        &a,
        &b,
        &b_in_a,
        margin,
        &mut Cache { word: bytes.word(), kept: bytes.word() },
        &mut manifolds,
    );
    assert!(apart >= 0.0, "{apart}\n{}", what());
    if b_in_a.translation.abs().max_element() <= FAR {
        manifolds.iter().for_each(|m| check_manifold(m, &what));
        if let Some(d) = distance(&a, &b, &b_in_a) {
            let finite = d.distance.is_finite() && d.on_a.is_finite() && d.on_b.is_finite();
            assert!(finite && (d.normal.length() - 1.0).abs() < 1e-3, "{d:?}\n{}", what());
        }
        overlaps(&a, &b, &b_in_a);
        penetration(&a, &b, &b_in_a);
    }
    let near = |motion: &Motion| motion.translation.abs().max_element() <= FAR;
    if near(&sweep.a) && near(&sweep.b) && b_in_a.translation.abs().max_element() <= FAR {
        check_toi(time_of_impact(&a, &b, &sweep, 0.01 * margin), "time_of_impact", &what);
        check_toi(passage(&a, &b, &sweep, 0.01 * margin), "passage", &what);
        check_toi(cast_shape(&a, &b, &b_in_a.inverse(), sweep.a.translation), "cast_shape", &what);
    }
    let point = DVec3::from(way(&mut bytes));
    if let Some(near) = nearest_point(&a, point, f32::INFINITY)
        && point.abs().max_element() <= f64::from(FAR)
    {
        assert!(near.distance.is_finite() && near.point.is_finite(), "{point} {near:?}\n{}", what());
    }
    let ray = Ray { origin: point, direction: DVec3::from(bytes.vector()), max: f64::from(bytes.number()) };
    if let Some(hit) = cast_ray(&a, &ray, bytes.byte() % 2 == 0) {
        assert!(!hit.t.is_nan() && hit.normal.is_finite(), "{ray:?} {hit:?}\n{}", what());
    }
}
