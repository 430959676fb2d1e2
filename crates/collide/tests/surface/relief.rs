//! Ridges, valleys, steps and walls.

use crate::common::Random;
use crate::{about_z, all_shapes, at, core, level, lowest_along, shapes, touch};
use rockfall_collide::Manifold;
use rockfall_math::{Isometry, Quat, Vec3, rotation};
use rockfall_shape::{Mesh, Shape};

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
