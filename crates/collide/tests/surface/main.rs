//! Convex shapes on meshes and height fields.

mod against_exact;
#[path = "../common/mod.rs"]
mod common;
mod rim;

use common::{Random, at_size};
use rockfall_collide::{Manifold, convex_height_field, convex_mesh};
use rockfall_math::{Isometry, Mat3, Quat, Vec2, Vec3, rotation, trig};
use rockfall_shape::{HeightField, Hull, Mesh, Shape};
use std::sync::Arc;

fn at(position: Vec3, turn: Quat) -> Isometry {
    Isometry { rotation: Mat3::from_quat(turn), translation: position }
}

fn about_z(angle: f32) -> Quat {
    rotation::from_rotation_vector(Vec3::Z * angle)
}

/// A grid of cells × cells squares of the given side around the origin, corners moved sideways by up to `jitter`
/// sides, in the plane z = 0.
fn floor(cells: u32, side: f32, jitter: f32) -> Mesh {
    let mut random = Random(5);
    let samples = cells + 1;
    let vertices: Vec<Vec3> = (0..samples * samples)
        .map(|k| {
            let (i, j) = (k % samples, k / samples);
            let inner = i > 0 && j > 0 && i < cells && j < cells;
            let push = if inner {
                Vec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)) * jitter
            } else {
                Vec2::ZERO
            };
            let half = 0.5 * cells as f32;
            Vec3::new((i as f32 - half + push.x) * side, (j as f32 - half + push.y) * side, 0.0)
        })
        .collect();
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * samples + i;
            let [b, c, d] = [a + 1, a + samples + 1, a + samples];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a floor")
}

/// Floors of very fine, middling and very coarse triangles, regular and not.
fn floors() -> Vec<Mesh> {
    vec![
        floor(60, 0.1, 0.0),
        floor(12, 0.5, 0.0),
        floor(12, 0.5, 0.35),
        floor(2, 3.0, 0.0),
        floor(2, 1000.0, 0.0),
    ]
}

/// The closed mesh of a hull.
fn mesh_of(hull: &Hull) -> Mesh {
    let fan = |f: usize| {
        let face = hull.face(f);
        (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]])
    };
    let triangles: Vec<[u32; 3]> = (0..hull.normals.len()).flat_map(fan).collect();
    Mesh::from_triangles(&hull.vertices, &triangles).expect("a hull")
}

fn boulder(seed: u64, radius: f32) -> Shape {
    let mut random = Random(seed);
    let points: Vec<Vec3> = (0..24).map(|_| random.point(1.0).normalize_or(Vec3::X) * radius).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).expect("a boulder")))
}

fn shapes() -> Vec<Shape> {
    vec![
        Shape::Sphere { radius: 0.4 },
        Shape::Capsule { half_length: 0.6, radius: 0.2 },
        Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) },
        boulder(1, 0.5),
    ]
}

/// Those, and shapes that are collided by their support points alone.
fn all_shapes() -> Vec<Shape> {
    let Shape::Hull(hull) = boulder(2, 0.4) else { unreachable!("a boulder is a hull") };
    let mut all = shapes();
    all.extend([
        Shape::Cylinder { half_length: 0.3, radius: 0.4 },
        Shape::Cone { half_length: 0.4, lower: 0.4, upper: 0.0 },
        Shape::Cone { half_length: 0.3, lower: 0.2, upper: 0.5 },
        Shape::Ellipsoid { half: Vec3::new(0.5, 0.4, 0.3) },
        Shape::RoundedBox { half: Vec3::new(0.4, 0.3, 0.2), radius: 0.1 },
        Shape::RoundedHull { hull, radius: 0.15 },
    ]);
    all
}

/// How far the lowest point of a shape is along `out`.
fn lowest_along(shape: &Shape, pose: &Isometry, out: Vec3) -> f32 {
    let point = shape.support(-pose.inverse_vector(out)).expect("a bounded convex shape");
    pose.point(point).dot(out)
}

/// What the points of a disc may hide of the deepest place of its rim.
fn level(shape: &Shape) -> f32 {
    match shape {
        Shape::Cylinder { radius, .. } => 1e-4 * radius,
        Shape::Cone { lower, upper, .. } => 1e-4 * lower.max(*upper),
        _ => 0.0,
    }
}

/// The points that carry the shape, and the radius around them; of a round shape many of its surface.
fn core(shape: &Shape) -> (Vec<Vec3>, f32) {
    match shape {
        Shape::Sphere { radius } => (vec![Vec3::ZERO], *radius),
        Shape::Capsule { half_length, radius } => {
            (vec![Vec3::Z * *half_length, Vec3::Z * -*half_length], *radius)
        }
        Shape::Box { half } => {
            let corners = (0..8).map(|i| {
                let sign = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
                *half * Vec3::new(sign(1), sign(2), sign(4))
            });
            (corners.collect(), 0.0)
        }
        Shape::Hull(hull) => (hull.vertices.clone(), 0.0),
        _ => {
            let towards = (0..32).map(|k| {
                let (sin, cos) = trig::sin_cos(2.4 * k as f32);
                Vec3::new(cos, sin, k as f32 / 16.0 - 1.0)
            });
            (towards.filter_map(|d| shape.support(d)).collect(), 0.0)
        }
    }
}

fn touch(shape: &Shape, mesh: &Mesh, pose: &Isometry, margin: f32) -> Vec<Manifold> {
    let mut out = Vec::new();
    convex_mesh(shape, mesh, &pose.inverse(), margin, &mut out);
    out
}

/// The contacts must be those on the half-space z ≤ 0: one manifold, straight up, with the depths of the shape's own
/// points, and with every point of the shape that is among the lowest inside what the manifold spans.
fn check_like_half_space(what: &str, shape: &Shape, pose: &Isometry, manifolds: &[Manifold], margin: f32) {
    let (points, radius) = core(shape);
    let lowest = lowest_along(shape, pose, Vec3::Z);
    if lowest > margin {
        assert!(manifolds.is_empty(), "{what}: contact out of reach");
        return;
    }
    assert_eq!(manifolds.len(), 1, "{what}: {manifolds:#?}");
    let manifold = &manifolds[0];
    let up = pose.vector(-manifold.normal);
    assert!((up - Vec3::Z).length() < 1e-5, "{what}: normal {up}");
    let off = (manifold.deepest() - lowest).abs();
    assert!(off < 1e-5 + level(shape), "{what}: {} is not {lowest}", manifold.deepest());
    let placed: Vec<Vec3> = manifold.points().iter().map(|p| pose.point(p.position)).collect();
    for (p, q) in manifold.points().iter().zip(&placed) {
        assert!((q.z - 0.5 * p.distance).abs() < 1e-5, "{what}: a point at {q} for depth {}", p.distance);
    }
    for &p in &points {
        let p = pose.point(p);
        if p.z - radius < lowest + 1e-4 {
            // Within the span: no direction in the plane has it further out than all points of the manifold.
            for k in 0..16 {
                let (sin, cos) = trig::sin_cos(k as f32 * 0.4);
                let out = Vec3::new(cos, sin, 0.0);
                let reach = placed.iter().map(|q| q.dot(out)).fold(f32::NEG_INFINITY, f32::max);
                assert!(p.dot(out) < reach + 1e-5 || points.len() > 8, "{what}: {p} hangs over");
            }
        }
    }
}

#[test]
fn a_floor_of_triangles_is_a_plane() {
    let mut random = Random(2);
    for mesh in &floors() {
        for shape in &all_shapes() {
            let (points, _) = core(shape);
            for round in 0..60 {
                let turn = match round % 3 {
                    0 => about_z(random.between(0.0, 6.0)),
                    1 => rotation::compose(about_z(0.3 * round as f32), rotation::between(Vec3::Z, Vec3::X)),
                    _ => random.turn(),
                };
                // Over corners and edges of the triangles, and anywhere.
                let mut over = match round % 4 {
                    0 => mesh.vertices[mesh.vertices.len() / 2],
                    1 => {
                        0.5 * (mesh.triangle(mesh.triangles.len() / 2)[0]
                            + mesh.triangle(mesh.triangles.len() / 2)[2])
                    }
                    _ => random.point(1.0),
                };
                over = over.clamp(Vec3::splat(-1.0), Vec3::splat(1.0));
                let corner = points[round % points.len()];
                if round % 2 == 0 {
                    over -= rotation::rotate(turn, corner);
                }
                over.z = 0.0;
                let mut pose = at(over, turn);
                let lowest = lowest_along(shape, &pose, Vec3::Z);
                pose.translation.z = random.between(-0.06, 0.02) - lowest;
                let what = format!("round {round}, {} triangles, {shape:?}, {pose:?}", mesh.triangles.len());
                check_like_half_space(&what, shape, &pose, &touch(shape, mesh, &pose, 0.01), 0.01);
            }
        }
    }
}

#[test]
fn a_box_on_triangles_has_the_four_corners_that_it_has_on_a_plane() {
    let half = Vec3::new(0.5, 0.4, 0.3);
    let shape = Shape::Box { half };
    for mesh in &floors() {
        for k in 0..50 {
            let turn = about_z(0.13 * k as f32);
            let pose = at(Vec3::new(0.05 * k as f32 - 1.25, 0.02 * k as f32 - 0.5, 0.299), turn);
            let manifolds = touch(&shape, mesh, &pose, 0.01);
            assert_eq!(manifolds.len(), 1);
            assert_eq!(manifolds[0].count, 4);
            for x in [-0.5, 0.5] {
                for y in [-0.4, 0.4] {
                    let corner = Vec3::new(x, y, -0.2995);
                    let found = manifolds[0]
                        .points()
                        .iter()
                        .any(|p| p.position.distance(corner) < 1e-5 && (p.distance + 0.001).abs() < 1e-5);
                    assert!(found, "{corner} at {k}: {:#?}", manifolds[0]);
                }
            }
        }
    }
}

/// Promise: what has sunk in by a line or by a point touches there only, not where its sides go through other triangles of the same floor.
#[test]
fn what_rolls_on_triangles_touches_where_it_does_on_a_plane() {
    let lying = rotation::between(Vec3::Z, Vec3::Y);
    let cylinder = Shape::Cylinder { half_length: 0.3, radius: 0.4 };
    let ellipsoid = Shape::Ellipsoid { half: Vec3::new(0.3, 0.5, 0.4) };
    let ends = [-0.3, 0.3].map(|y| Vec3::new(0.0, y, -0.3995));
    for (shape, turn, expected) in
        [(cylinder, lying, &ends[..]), (ellipsoid, Quat::IDENTITY, &[Vec3::Z * -0.3995])]
    {
        for mesh in &floors() {
            for k in 0..50 {
                let turn = rotation::compose(about_z(0.13 * k as f32), turn);
                let pose = at(Vec3::new(0.05 * k as f32 - 1.25, 0.02 * k as f32 - 0.5, 0.399), turn);
                let manifolds = touch(&shape, mesh, &pose, 0.01);
                assert_eq!(manifolds.len(), 1);
                let points = manifolds[0].points();
                let what = format!("{} at {k} on {} triangles", shape.name(), mesh.triangles.len());
                assert_eq!(points.len(), expected.len(), "{what}: {points:#?}");
                for &p in expected {
                    let heading = about_z(0.13 * k as f32);
                    let p = rotation::rotate(heading, p) + pose.translation;
                    let found = points.iter().any(|q| {
                        pose.point(q.position).distance(p) < 1e-4 && (q.distance + 0.001).abs() < 1e-5
                    });
                    assert!(found, "{what}: {p}, {points:#?}");
                }
            }
        }
    }
}

#[test]
fn a_sliding_body_feels_no_seams() {
    for mesh in &floors()[..3] {
        for (k, shape) in all_shapes().iter().enumerate() {
            // Hundreds of small triangles under one body take milliseconds.
            let stride = if k >= shapes().len() && mesh.triangles.len() > 5000 { 8 } else { 1 };
            for tilt in [0.0, 1e-4, 3e-3, 0.03, 0.2] {
                let lean = rotation::from_rotation_vector(Vec3::new(tilt, 0.7 * tilt, 0.4));
                let mut pose = at(Vec3::ZERO, lean);
                let lowest = lowest_along(shape, &pose, Vec3::Z);
                for k in (0..200).step_by(stride) {
                    let t = k as f32 * 0.0074;
                    pose.translation = Vec3::new(t - 0.7, 0.31 * t, -lowest - 0.003);
                    let what = format!("step {k}, tilt {tilt}, {}", shape.name());
                    check_like_half_space(&what, shape, &pose, &touch(shape, mesh, &pose, 0.02), 0.02);
                }
            }
        }
    }
}

#[test]
fn corners_keep_their_names_while_they_slide() {
    let mesh = floor(12, 0.5, 0.35);
    let shape = Shape::Box { half: Vec3::new(0.5, 0.4, 0.3) };
    let names = |x: f32| {
        let manifolds = touch(&shape, &mesh, &at(Vec3::new(x, 0.1, 0.299), about_z(0.2)), 0.01);
        let mut names: Vec<u32> = manifolds[0].points().iter().map(|p| p.feature).collect();
        names.sort_unstable();
        names
    };
    let first = names(0.0);
    assert!(first.windows(2).all(|pair| pair[0] != pair[1]));
    for k in 1..100 {
        assert_eq!(names(0.01 * k as f32), first);
    }
}

/// A roof z = −slope |x| (a ridge), or with a negative slope a valley, of strips along y.
fn roof(slope: f32, strips: u32) -> Mesh {
    let mut vertices = Vec::new();
    for k in 0..=strips {
        let y = 10.0 * (k as f32 / strips as f32 - 0.5);
        vertices.extend([
            Vec3::new(-5.0, y, -5.0 * slope),
            Vec3::new(0.0, y, 0.0),
            Vec3::new(5.0, y, -5.0 * slope),
        ]);
    }
    let mut triangles = Vec::new();
    for k in 0..strips {
        let a = 3 * k;
        triangles.extend([
            [a, a + 1, a + 4],
            [a, a + 4, a + 3],
            [a + 1, a + 2, a + 5],
            [a + 1, a + 5, a + 4],
        ]);
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a roof")
}

#[test]
fn a_ridge_pushes_between_its_sides() {
    for strips in [1, 7, 40] {
        let mesh = roof(1.0, strips);
        for shape in &shapes() {
            let (points, radius) = core(shape);
            let pose = at(Vec3::new(0.013, 0.021, 0.0), about_z(0.0));
            // The lowest height at which the shape clears the ridge.
            let clear = match shape {
                Shape::Sphere { radius } => (radius * radius - 0.013 * 0.013).sqrt(),
                Shape::Hull(hull) => {
                    // Distance to the axis along z through the hull, by its faces.
                    let mut low = f32::NEG_INFINITY;
                    for y in -50..50 {
                        let (x, y) = (-0.013, 0.01 * y as f32);
                        let mut exit = f32::INFINITY;
                        let mut inside = true;
                        for (n, o) in hull.normals.iter().zip(&hull.offsets) {
                            let rest = o - n.x * x - n.y * y;
                            if n.z < 0.0 {
                                exit = exit.min(rest / -n.z);
                            } else if n.z == 0.0 && rest < 0.0 {
                                inside = false;
                            }
                        }
                        if inside
                            && hull
                                .normals
                                .iter()
                                .zip(&hull.offsets)
                                .all(|(n, o)| n.dot(Vec3::new(x, y, -exit)) <= o + 1e-4)
                        {
                            low = low.max(exit);
                        }
                    }
                    low
                }
                _ => points.iter().map(|p| radius - p.z).fold(f32::NEG_INFINITY, f32::max),
            };
            let pose = Isometry { translation: pose.translation + Vec3::Z * (clear - 0.004), ..pose };
            let manifolds = touch(shape, &mesh, &pose, 0.01);
            assert!(!manifolds.is_empty(), "{shape:?} fell through {strips} strips");
            for m in &manifolds {
                let up = pose.vector(-m.normal);
                assert!(up.z > 0.70 && up.y.abs() < 0.2, "{shape:?}: {up}");
                assert!(m.deepest() > -0.02, "{shape:?}: {m:?}");
            }
            let deepest = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
            assert!(deepest < -0.0005, "{shape:?} with {strips} strips: {deepest}");
            if matches!(shape, Shape::Box { .. }) {
                assert_eq!(manifolds.len(), 1, "{manifolds:#?}");
                assert!((pose.vector(-manifolds[0].normal) - Vec3::Z).length() < 1e-4);
                assert!((manifolds[0].deepest() + 0.004).abs() < 1e-5);
                let ys: Vec<f32> = manifolds[0].points().iter().map(|p| p.position.y).collect();
                let span = ys.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b))
                    - ys.iter().fold(f32::INFINITY, |a, &b| a.min(b));
                assert!((span - 0.8).abs() < 1e-4, "the ridge carries the box along all of it: {ys:?}");
            }
        }
    }
}

#[test]
fn a_valley_pushes_from_both_sides_and_never_from_its_bottom() {
    for strips in [1, 7, 40] {
        let mesh = roof(-1.0, strips);
        // A sphere that sinks 0.003 into both sides.
        let r = 0.4_f32;
        let sphere = Shape::Sphere { radius: r };
        for height in [r * 2.0_f32.sqrt() - 0.003 * 2.0_f32.sqrt(), 0.02, -0.05] {
            let manifolds = touch(&sphere, &mesh, &at(Vec3::new(0.0, 0.02, height), Quat::IDENTITY), 0.01);
            assert_eq!(manifolds.len(), 2, "at {height}: {manifolds:#?}");
            for m in &manifolds {
                assert!((m.normal.x.abs() - 0.5_f32.sqrt()).abs() < 1e-5 && m.normal.z < 0.0, "{m:?}");
                assert!((m.deepest() - (height * 0.5_f32.sqrt() - r)).abs() < 1e-5, "{m:?}");
            }
        }
        // A box on its edge fits into the valley: two faces, two manifolds of four points.
        let shape = Shape::Box { half: Vec3::new(0.3, 0.5, 0.3) };
        let turn = rotation::from_rotation_vector(Vec3::Y * std::f32::consts::FRAC_PI_4);
        let manifolds =
            touch(&shape, &mesh, &at(Vec3::new(0.0, 0.02, 0.3 * 2.0_f32.sqrt() - 0.002), turn), 0.01);
        assert_eq!(manifolds.len(), 2, "{manifolds:#?}");
        for m in &manifolds {
            assert_eq!(m.count, 4);
            assert!((m.deepest() + 0.002 * 0.5_f32.sqrt()).abs() < 1e-5);
        }
    }
}

/// A cube around the origin, its sides cut into n × n squares.
fn cube(half: f32, n: u32) -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { -1.0 } else { 1.0 });
        let start = vertices.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                let mut p = [0.0; 3];
                p[axis] = sign * half;
                p[(axis + 1) % 3] = half * (2.0 * i as f32 / n as f32 - 1.0);
                p[(axis + 2) % 3] = half * (2.0 * j as f32 / n as f32 - 1.0);
                vertices.push(Vec3::from_array(p));
            }
        }
        for j in 0..n {
            for i in 0..n {
                let a = start + j * (n + 1) + i;
                let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
                if sign > 0.0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    let mesh = Mesh::from_triangles(&vertices, &triangles).expect("a cube");
    assert!(mesh.closed);
    mesh
}

#[test]
fn a_closed_cube_pushes_out_of_the_side_that_was_hit() {
    let mut random = Random(9);
    for n in [1, 5] {
        let mesh = cube(1.0, n);
        for shape in &all_shapes() {
            for round in 0..300 {
                let turn = if round % 4 == 0 { Quat::IDENTITY } else { random.turn() };
                let axis = round % 3;
                let mut out = Vec3::ZERO;
                out[axis] = if round % 2 == 0 { 1.0 } else { -1.0 };
                let mut pose = at(random.point(0.4), turn);
                pose.translation[axis] = 0.0;
                let lowest = lowest_along(shape, &pose, out);
                let depth = random.between(0.0, 0.05);
                pose.translation += out * (1.0 - lowest - depth);
                let manifolds = touch(shape, &mesh, &pose, 0.01);
                assert_eq!(manifolds.len(), 1, "{n} {shape:?} {pose:?} {manifolds:#?}");
                assert!((pose.vector(-manifolds[0].normal) - out).length() < 1e-5);
                let off = (manifolds[0].deepest() + depth).abs();
                assert!(off < 1e-5 + level(shape), "{n} {shape:?} {pose:?} {depth} {manifolds:#?}");
            }
        }
    }
}

#[test]
fn a_box_beside_a_step_does_not_stand_on_it() {
    // The box leans 1 mm into the side of the cube and reaches far below its top, at any angle.
    let mesh = cube(1.0, 4);
    let shape = Shape::Box { half: Vec3::splat(0.3) };
    for k in 0..40 {
        let turn = about_z(0.04 * k as f32);
        let pose = at(Vec3::new(0.0, 0.013 * k as f32, 0.9), turn);
        let (points, _) = core(&shape);
        let lowest = points.iter().map(|&p| pose.point(p).x).fold(f32::INFINITY, f32::min);
        let pose = Isometry { translation: pose.translation + Vec3::X * (1.0 - lowest - 0.001), ..pose };
        let manifolds = touch(&shape, &mesh, &pose, 0.005);
        assert!(!manifolds.is_empty());
        for m in &manifolds {
            assert!((pose.vector(-m.normal) - Vec3::X).length() < 0.1, "{k}: {manifolds:#?}");
            assert!(m.deepest() > -0.002);
        }
    }
}

#[test]
fn the_back_of_a_thin_wall_does_not_pull() {
    // A plate of 2 cm, and shapes that sank up to half through.
    let mesh = {
        let cube = cube(1.0, 3);
        let flat: Vec<Vec3> = cube.vertices.iter().map(|v| *v * Vec3::new(3.0, 3.0, 0.01)).collect();
        Mesh::from_triangles(&flat, &cube.triangles).expect("a plate")
    };
    for shape in &all_shapes() {
        for depth in [0.001, 0.01, 0.019, 0.03, 0.1, 0.18] {
            let mut pose = at(Vec3::new(0.1, 0.2, 0.0), about_z(0.3));
            let lowest = lowest_along(shape, &pose, Vec3::Z);
            pose.translation.z = 0.01 - lowest - depth;
            let manifolds = touch(shape, &mesh, &pose, 0.01);
            assert!(!manifolds.is_empty());
            for m in &manifolds {
                assert!(pose.vector(-m.normal).z > 0.9, "{shape:?} at {depth}: {manifolds:#?}");
                assert!(
                    (m.deepest() + depth).abs() < 1e-5 + level(shape),
                    "{shape:?} at {depth}: {manifolds:#?}"
                );
            }
        }
    }
}

/// Gentle random hills.
fn hills(columns: u32, spacing: f32, roughness: f32, seed: u64) -> HeightField {
    let mut random = Random(seed);
    let heights = (0..columns * columns).map(|_| random.between(-0.5, 0.5) * roughness * spacing).collect();
    HeightField::new(columns, columns, Vec2::splat(spacing), heights).expect("hills")
}

fn as_mesh(field: &HeightField) -> Mesh {
    let vertices: Vec<Vec3> = field.samples().collect();
    let mut triangles = Vec::new();
    for j in 0..field.rows - 1 {
        for i in 0..field.columns - 1 {
            let a = j * field.columns + i;
            let c = a + field.columns + 1;
            triangles.extend([[a, a + 1, c], [a, c, c - 1]]);
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("hills")
}

#[test]
fn a_height_field_collides_like_its_mesh() {
    let mut random = Random(21);
    let field = hills(24, 0.3, 0.8, 4);
    let mesh = as_mesh(&field);
    let mut contacts = 0;
    for shape in &all_shapes() {
        for _ in 0..300 {
            let over = random.point(2.0);
            let ground = field.height_at(over.x, over.y).expect("over the field");
            let pose = at(Vec3::new(over.x, over.y, ground + random.between(0.2, 0.7)), random.turn());
            let by_mesh = touch(shape, &mesh, &pose, 0.02);
            let mut by_field = Vec::new();
            convex_height_field(shape, &field, &pose.inverse(), 0.02, &mut by_field);
            let summary = |list: &[Manifold]| {
                let mut list: Vec<(i32, u32)> =
                    list.iter().map(|m| ((m.deepest() * 1e4).round() as i32, m.count)).collect();
                list.sort_unstable();
                list
            };
            contacts += by_mesh.len();
            // Deep points are treated otherwise where all below is solid: also those of a sharp rim that went through a ridge.
            let shallow = |list: &[Manifold]| list.iter().all(|m| m.deepest() > -0.02);
            let sharp = matches!(shape, Shape::Cylinder { .. } | Shape::Cone { .. });
            if shallow(&by_mesh) && (!sharp || shallow(&by_field)) {
                assert_eq!(summary(&by_mesh), summary(&by_field), "{shape:?} {pose:?}");
            }
        }
    }
    assert!(contacts > 500);
}

#[test]
fn a_surface_a_thousand_times_larger_or_smaller_has_the_same_contacts() {
    let mut random = Random(23);
    let mesh = as_mesh(&hills(9, 0.5, 0.6, 4));
    for by in [1e-3, 1e3] {
        let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| *v * by).collect();
        let other = Mesh::from_triangles(&vertices, &mesh.triangles).expect("hills");
        let mut met = 0;
        for shape in &all_shapes() {
            let scaled = at_size(shape, by);
            for _ in 0..60 {
                let turn = random.turn();
                let place = random.point(1.2).with_z(random.between(0.2, 0.7));
                let here = touch(shape, &mesh, &at(place, turn), 0.05);
                let there = touch(&scaled, &other, &at(place * by, turn), 0.05 * by);
                let deepest = |manifolds: &[Manifold]| {
                    manifolds.iter().fold(f32::INFINITY, |low, m| low.min(m.deepest()))
                };
                let (depth, scaled_depth) = (deepest(&here), deepest(&there) / by);
                if here.is_empty() || there.is_empty() {
                    // At the margin rounding decides.
                    assert!(
                        depth.min(scaled_depth) > 0.05 - 1e-4,
                        "{} {place} {depth} {scaled_depth}",
                        shape.name()
                    );
                    continue;
                }
                met += 1;
                let off = (depth - scaled_depth).abs();
                assert!(off < 1e-4, "{} at {place}: {depth} is {scaled_depth}", shape.name());
            }
        }
        assert!(met > 100, "{met}");
    }
}

#[test]
fn whatever_is_below_a_height_field_is_pushed_up() {
    let mut random = Random(31);
    let field = hills(24, 0.3, 0.8, 4);
    for shape in &all_shapes() {
        for _ in 0..200 {
            let over = random.point(2.0);
            let pose = at(Vec3::new(over.x, over.y, random.between(-50.0, -0.3)), random.turn());
            let mut manifolds = Vec::new();
            convex_height_field(shape, &field, &pose.inverse(), 0.02, &mut manifolds);
            assert!(!manifolds.is_empty(), "{shape:?} {pose:?} fell for ever");
            assert!(manifolds.iter().all(|m| pose.vector(-m.normal).z > 0.3));
            let deepest = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
            assert!(deepest < 0.3 * pose.translation.z + 0.5);
        }
    }
}

mod oracle {
    //! parry3d as the judge of distances.
    use super::*;
    use parry3d::math::Pose;
    use parry3d::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, TriMesh};

    fn parry(shape: &Shape) -> Box<dyn parry3d::shape::Shape> {
        match shape {
            Shape::Sphere { radius } => Box::new(Ball::new(*radius)),
            Shape::Capsule { half_length, radius } => {
                Box::new(Capsule::new(Vec3::Z * -*half_length, Vec3::Z * *half_length, *radius))
            }
            Shape::Box { half } => Box::new(Cuboid::new(*half)),
            Shape::Hull(hull) => {
                Box::new(ConvexPolyhedron::from_convex_hull(&hull.vertices).expect("a hull"))
            }
            _ => unreachable!("not convex"),
        }
    }

    fn distance(shape: &dyn parry3d::shape::Shape, pose: &Isometry, mesh: &TriMesh) -> f32 {
        let there = Pose::from_parts(pose.translation, Quat::from_mat3(&pose.rotation));
        parry3d::query::distance(&there, shape, &Pose::identity(), mesh).expect("supported").distance
    }

    /// Somewhere over the terrain, the distance from it not more than `wanted`.
    fn lowered(
        shape: &dyn parry3d::shape::Shape,
        mesh: &TriMesh,
        wanted: f32,
        random: &mut Random,
    ) -> (Isometry, f32) {
        let mut pose = at(random.point(2.0), random.turn());
        pose.translation.z = 3.0;
        for _ in 0..60 {
            let d = distance(shape, &pose, mesh);
            if d <= wanted * 1.001 {
                break;
            }
            pose.translation.z -= d - wanted;
        }
        (pose, distance(shape, &pose, mesh))
    }

    fn terrains() -> Vec<(f32, Mesh, TriMesh)> {
        [0.2, 0.8, 2.0]
            .into_iter()
            .map(|roughness| {
                let mesh = as_mesh(&hills(16, 0.4, roughness, 6));
                let judge = TriMesh::new(mesh.vertices.clone(), mesh.triangles.clone()).expect("a mesh");
                (roughness, mesh, judge)
            })
            .collect()
    }

    /// A contact whenever the surfaces are nearer than the margin, none when they are not. Its distance is exact for
    /// round shapes; a polyhedron that is near a corner gets the distance of planes, which differs by a few
    /// millimetres in the worst terrain, and never by more than the margin.
    /// What the caller relies on when it does not ask again for a while.
    #[test]
    fn what_is_apart_says_so_and_never_by_too_much() {
        let mut random = Random(47);
        let mut known = 0;
        for (_, mesh, judge) in &terrains() {
            for shape in &shapes() {
                let body = parry(shape);
                for _ in 0..100 {
                    let (pose, truth) = lowered(&*body, judge, random.between(0.0, 2.0), &mut random);
                    let apart = convex_mesh(shape, mesh, &pose.inverse(), 0.03, &mut Vec::new());
                    assert!(apart <= truth + 1e-4, "{apart} of {truth}: {shape:?} {pose:?}");
                    known += u32::from(apart > 0.1);
                }
            }
        }
        assert!(known > 200, "{known}");
    }

    #[test]
    fn distances_on_rough_terrain_are_those_of_parry() {
        let mut random = Random(41);
        let margin = 0.03;
        for (roughness, mesh, judge) in &terrains() {
            for shape in &shapes() {
                let body = parry(shape);
                let round = matches!(shape, Shape::Sphere { .. } | Shape::Capsule { .. });
                let (mut near, mut off) = (0, 0);
                for _ in 0..120 {
                    let wanted = random.between(0.001, 0.05);
                    let (pose, truth) = lowered(&*body, judge, wanted, &mut random);
                    let manifolds = touch(shape, mesh, &pose, margin);
                    let found = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
                    let what = format!("{roughness} {} {pose:?}: {found} for {truth}", shape.name());
                    if truth > 1.01 * margin {
                        assert!(manifolds.is_empty() || !round, "{what}");
                    } else if truth < 0.99 * margin {
                        near += 1;
                        assert!(!manifolds.is_empty(), "{what}");
                        let error = (found - truth).abs();
                        assert!(error < if round { 5e-4 } else { margin }, "{what}");
                        off += i32::from(error > 5e-4);
                    }
                }
                assert!(near > 50 && off * 6 < near, "{roughness} {}: {off} of {near} are off", shape.name());
            }
        }
    }

    #[test]
    fn whatever_overlaps_has_a_contact_that_says_so() {
        let mut random = Random(43);
        let (mut wrong, mut total) = (0, 0);
        for (roughness, mesh, judge) in &terrains() {
            for shape in &shapes() {
                let body = parry(shape);
                for _ in 0..120 {
                    let (mut pose, _) = lowered(&*body, judge, 1e-4, &mut random);
                    let depth = random.between(0.002, 0.03);
                    pose.translation.z -= depth;
                    let there = Pose::from_parts(pose.translation, Quat::from_mat3(&pose.rotation));
                    if !parry3d::query::intersection_test(&there, &*body, &Pose::identity(), judge)
                        .expect("supported")
                        .intersecting
                    {
                        continue;
                    }
                    let manifolds = touch(shape, mesh, &pose, 0.01);
                    let deepest = manifolds.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
                    assert!(deepest < 0.0, "{roughness} {} {pose:?}: {deepest}", shape.name());
                    // Straight down by `depth` is the way in. Where steep triangles meet, the triangle that a point came
                    // in through is a guess; a wrong one must stay rare and shallow.
                    assert!(
                        deepest > -0.15,
                        "{roughness} {} {pose:?}: {deepest} after {depth}",
                        shape.name()
                    );
                    wrong += i32::from(deepest < -1.5 * depth - 1e-3);
                    total += 1;
                }
            }
        }
        assert!(total > 1000 && wrong * 100 < total, "{wrong} of {total}");
    }
}
