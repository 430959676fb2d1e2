use super::*;
use rockfall_math::{DVec3, Pose};
use rockfall_shape::{Compound, HeightField, Mesh};
use std::sync::Arc;

/// A lopsided polyhedron away from the origin.
fn stone() -> Arc<Hull> {
    let corner = |k: u32| {
        let next = |m: u32| ((k * m) % 97) as f32 / 97.0 - 0.5;
        Vec3::new(next(31), 2.0 * next(57) + 1.0, 0.7 * next(83))
    };
    Arc::new(Hull::from_points(&(1..40).map(corner).collect::<Vec<_>>()).unwrap())
}

/// All shapes with a volume, each with the radius of curvature that its chordal error is a share of; 0 where it is flat.
fn solids() -> Vec<(Shape, f32)> {
    vec![
        (Shape::Sphere { radius: 0.7 }, 0.7),
        (Shape::Box { half: Vec3::new(0.1, 0.2, 0.3) }, 0.0),
        (Shape::Capsule { half_length: 0.4, radius: 0.2 }, 0.2),
        (Shape::Capsule { half_length: 0.0, radius: 0.2 }, 0.2),
        (Shape::Cylinder { half_length: 0.05, radius: 0.6 }, 0.6),
        (Shape::Cone { half_length: 0.5, lower: 0.3, upper: 0.0 }, 0.3),
        (Shape::Cone { half_length: 0.5, lower: 0.0, upper: 0.3 }, 0.3),
        (Shape::Cone { half_length: 0.2, lower: 0.1, upper: 0.3 }, 0.3),
        (Shape::Ellipsoid { half: Vec3::new(0.5, 0.2, 0.3) }, 0.5),
        (Shape::RoundedBox { half: Vec3::new(0.5, 0.2, 0.3), radius: 0.1 }, 0.1),
        (Shape::Hull(stone()), 0.0),
        (Shape::RoundedHull { hull: stone(), radius: 0.25 }, 0.25),
    ]
}

/// Every edge of a triangle is there once in the other direction, corners told apart by their places.
fn assert_closed(surface: &Surface, what: &str) {
    let place = |c: u32| (surface.positions[c as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut edges: Vec<_> = surface
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|edge| edge.map(place))
        .collect();
    let mut back: Vec<_> = edges.iter().map(|&[a, b]| [b, a]).collect();
    edges.sort_unstable();
    back.sort_unstable();
    assert!(edges.windows(2).all(|w| w[0] != w[1]), "{what} has an edge twice");
    assert_eq!(edges, back, "{what} is open");
}

fn corners(surface: &Surface) -> impl Iterator<Item = [Vec3; 3]> {
    surface.triangles.iter().map(|t| t.map(|c| surface.positions[c as usize]))
}

fn volume(surface: &Surface) -> f64 {
    let of = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
    corners(surface).map(|t| of(t.map(|p| p.as_dvec3()))).sum()
}

/// How far a point is from the surface of a shape, found by pushing the point along `normal`: the shape's box in that direction.
fn below(shape: &Shape, point: Vec3, normal: Vec3) -> f32 {
    let support = match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { half_length, radius } => half_length * normal.z.abs() + radius,
        Shape::Cylinder { .. } | Shape::Cone { .. } => {
            let frustum = Frustum::of(shape).unwrap();
            frustum.support(normal.as_dvec3()).dot(normal.as_dvec3()) as f32
        }
        Shape::Ellipsoid { half } => (*half * normal).length(),
        Shape::Box { half } => half.dot(normal.abs()),
        Shape::RoundedBox { half, radius } => half.dot(normal.abs()) + radius,
        Shape::Hull(hull) => hull.vertices.iter().map(|v| v.dot(normal)).fold(f32::MIN, f32::max),
        Shape::RoundedHull { hull, radius } => {
            hull.vertices.iter().map(|v| v.dot(normal)).fold(f32::MIN, f32::max) + radius
        }
        _ => panic!("not convex"),
    };
    support - point.dot(normal)
}

#[test]
fn solids_are_closed_and_hardly_smaller_than_they_are() {
    for (shape, radius) in solids() {
        let surface = Surface::of(&shape, 0.0);
        assert_closed(&surface, shape.name());
        let exact = f64::from(shape.mass_properties(1.0).unwrap().mass);
        let share = volume(&surface) / exact;
        let least = if radius > 0.0 { 0.94 } else { 1.0 - 1e-5 };
        assert!((least..1.0 + 1e-5).contains(&share), "{shape:?}: {share}");
    }
}

#[test]
fn no_triangle_is_farther_inside_than_the_chordal_error_says() {
    for (shape, radius) in solids() {
        let surface = Surface::of(&shape, 0.0).shaded();
        let allowed = CHORDAL_ERROR * radius + 1e-6;
        let mut worst = 0.0_f32;
        for triangle in &surface.triangles {
            let [p, n] = [&surface.positions, &surface.normals].map(|all| triangle.map(|c| all[c as usize]));
            for (s, t) in
                (0..=6_u8).flat_map(|i| (0..=6 - i).map(move |j| (f32::from(i) / 6.0, f32::from(j) / 6.0)))
            {
                let mix = |v: [Vec3; 3]| v[0] + s * (v[1] - v[0]) + t * (v[2] - v[0]);
                // However deep a point is inside a convex body, it is no deeper than along any one direction.
                worst = worst.max(below(&shape, mix(p), mix(n).normalize()));
            }
        }
        assert!(worst <= allowed, "{shape:?}: {worst} > {allowed}");
        for (position, normal) in surface.positions.iter().zip(&surface.normals) {
            let off = below(&shape, *position, *normal).abs();
            assert!(off < 2e-6, "a corner of the {} is {off} m off", shape.name());
        }
    }
}

#[test]
fn normals_are_of_unit_length_and_point_out_of_every_triangle_around() {
    for (shape, _) in solids() {
        let surface = Surface::of(&shape, 0.0).shaded();
        assert_eq!(surface.normals.len(), surface.positions.len());
        for &[a, b, c] in &surface.triangles {
            let [p, q, r] = [a, b, c].map(|c| surface.positions[c as usize]);
            let face = (q - p).cross(r - p);
            let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
            // On a ball the plane of a splinter is anything.
            if face.length() < 0.2 * longest {
                continue;
            }
            let face = face.normalize();
            for corner in [a, b, c] {
                let normal = surface.normals[corner as usize];
                assert!((normal.length() - 1.0).abs() < 1e-5);
                assert!(normal.dot(face) > 0.7, "{shape:?}: {normal} on {face}");
            }
        }
        assert_closed(&surface, shape.name());
    }
}

#[test]
fn flat_shapes_share_corners_and_shading_splits_them() {
    let cube = Surface::of(&Shape::Box { half: Vec3::ONE }, 0.0);
    assert_eq!((cube.positions.len(), cube.normals.len(), cube.triangles.len()), (8, 0, 12));
    let shaded = cube.shaded();
    assert_eq!((shaded.positions.len(), shaded.triangles.len()), (24, 12));
}

#[test]
fn surfaces_without_an_inside_are_what_they_are() {
    let mesh = Arc::new(
        Mesh::from_triangles(&[Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y], &[[0, 1, 2], [0, 2, 3]]).unwrap(),
    );
    let surface = Surface::of(&Shape::Mesh(mesh.clone()), 0.0);
    assert_eq!((&surface.positions, &surface.triangles), (&mesh.vertices, &mesh.triangles));

    let heights = (0..12).map(|k| ((k * 5) % 7) as f32 * 0.3).collect();
    let field = HeightField::new(4, 3, rockfall_math::Vec2::new(0.5, 2.0), heights).unwrap();
    let surface = Surface::of(&Shape::HeightField(Arc::new(field.clone())), 0.0);
    let cells = (0..2).flat_map(|j| (0..3).flat_map(move |i| [(i, j, 0), (i, j, 1)]));
    let expected: Vec<[Vec3; 3]> = cells.map(|(i, j, k)| field.cell(i, j)[k]).collect();
    assert_eq!(corners(&surface).collect::<Vec<_>>(), expected);

    let normal = Vec3::new(0.6, 0.0, 0.8);
    let surface = Surface::of(&Shape::HalfSpace { normal, offset: 2.0 }, 10.0);
    for [a, b, c] in corners(&surface) {
        assert!(((b - a).cross(c - a).normalize() - normal).length() < 1e-6);
        assert!([a, b, c].iter().all(|p| (p.dot(normal) - 2.0).abs() < 1e-5));
    }
    let middle = 2.0 * normal;
    assert!(surface.positions.iter().all(|p| (p.distance(middle) - 200_f32.sqrt()).abs() < 1e-4));
}

#[test]
fn compounds_are_their_parts_each_where_it_is() {
    let cube = Shape::Box { half: Vec3::splat(0.5) };
    let ball = Shape::Sphere { radius: 0.25 };
    let turn = rockfall_math::Quat::from_xyzw(0.0, 0.6, 0.0, 0.8);
    let at = |x: f64, rotation| Pose { position: DVec3::new(x, 1.0, 0.0), rotation };
    let parts = [(cube.clone(), at(2.0, turn)), (ball.clone(), at(-1.0, turn))];
    let whole = Surface::of(&Shape::Compound(Arc::new(Compound::new(parts).unwrap())), 0.0);
    assert_closed(&whole, "compound");
    let alone = [cube, ball].map(|shape| volume(&Surface::of(&shape, 0.0)));
    assert!((volume(&whole) - alone[0] - alone[1]).abs() < 1e-6);
    let corner = at(2.0, turn).point(Vec3::splat(0.5)).as_vec3();
    let (_, normal) = whole
        .positions
        .iter()
        .zip(&whole.normals)
        .find(|(p, n)| p.distance(corner) < 1e-6 && n.y > 0.9)
        .expect("a corner of the cube, on its upper side");
    assert!((*normal - Vec3::Y).length() < 1e-6);
}
