//! What the tests of pictures share: one of each shape.

use rockfall_math::{DVec3, Pose, Quat, Vec2, Vec3, rotation};
use rockfall_shape::{Compound, Field, FieldSettings, HeightField, Hull, Mesh, Shape};
use std::sync::{Arc, OnceLock};

/// A turn that leaves no axis where it was.
pub(crate) fn turned(k: u32) -> Quat {
    let x = |i: u32| ((k * 7 + i * 13 + 5) % 17) as f32 / 17.0 - 0.5;
    rotation::normalize(Quat::from_xyzw(x(0), x(1), x(2), 0.4 + x(3)))
}

/// One of each kind, about as large as a ball of radius 1, but for the half-space; and a compound of hulls, as a decomposition is.
pub(crate) fn shapes() -> Vec<Shape> {
    static SHAPES: OnceLock<Vec<Shape>> = OnceLock::new();
    SHAPES.get_or_init(cook).clone()
}

fn cook() -> Vec<Shape> {
    let top = [Vec3::new(0.0, 0.0, 1.2), Vec3::new(0.4, 0.3, 1.0)];
    let ring = (0..6_u32).map(|k| {
        let [x, y] =
            [[1.0, 0.0], [0.5, 0.8], [-0.6, 0.7], [-1.0, 0.0], [-0.4, -0.9], [0.6, -0.7]][k as usize];
        Vec3::new(x, y, -0.5 + 0.1 * k as f32)
    });
    let points: Vec<Vec3> = ring.chain(top).collect();
    let hull = Arc::new(Hull::from_points(&points).expect("a hull"));
    let mesh = Arc::new(cup());
    let parts = [
        (Shape::Box { half: Vec3::new(0.9, 0.25, 0.2) }, Pose::default()),
        (
            Shape::Cylinder { half_length: 0.6, radius: 0.3 },
            Pose { position: DVec3::new(0.6, 0.2, 0.4), rotation: turned(3) },
        ),
    ];
    let heights = (0..9 * 7_u32).map(|k| ((k * 37) % 11) as f32 * 0.05).collect();
    vec![
        Shape::Sphere { radius: 0.9 },
        Shape::Box { half: Vec3::new(0.9, 0.7, 0.5) },
        Shape::Capsule { half_length: 0.6, radius: 0.4 },
        Shape::Cylinder { half_length: 0.5, radius: 0.8 },
        Shape::Cone { half_length: 0.8, lower: 0.9, upper: 0.2 },
        Shape::Ellipsoid { half: Vec3::new(1.1, 0.7, 0.5) },
        Shape::RoundedBox { half: Vec3::new(0.6, 0.5, 0.4), radius: 0.25 },
        Shape::Hull(hull.clone()),
        Shape::RoundedHull { hull, radius: 0.15 },
        Shape::Mesh(mesh.clone()),
        Shape::Field(Arc::new(Field::new(mesh, FieldSettings::with_error(0.01)).expect("a field"))),
        Shape::Compound(Arc::new(Compound::new(parts).expect("a compound"))),
        Shape::HeightField(Arc::new(
            HeightField::new(9, 7, Vec2::splat(0.3), heights).expect("a height field"),
        )),
        Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 },
        Shape::Compound(Arc::new(Compound::new(wedges()).expect("a compound"))),
    ]
}

/// A ring of five hulls that lie against each other.
fn wedges() -> Vec<(Shape, Pose)> {
    let rim = |k: usize, radius: f32| {
        let [x, y] = [
            [1.0, 0.0],
            [0.309_017, 0.951_057],
            [-0.809_017, 0.587_785],
            [-0.809_017, -0.587_785],
            [0.309_017, -0.951_057],
        ][k % 5];
        [-0.4, 0.4].map(|z| Vec3::new(radius * x, radius * y, z))
    };
    let wedge = |k: usize| {
        let points = [rim(k, 1.0), rim(k + 1, 1.0), rim(k, 0.4), rim(k + 1, 0.4)].concat();
        (Shape::Hull(Arc::new(Hull::from_points(&points).expect("a hull"))), Pose::default())
    };
    (0..5).map(wedge).collect()
}

/// A closed cup: a line turned about z, outer wall and inner wall.
fn cup() -> Mesh {
    let line = [[0.0, -0.8], [0.7, -0.8], [0.9, 0.8], [0.7, 0.8], [0.5, -0.5], [0.0, -0.5]];
    let line: Vec<Vec2> = line.into_iter().map(Vec2::from_array).collect();
    Mesh::turned(&line, 14).expect("a mesh")
}
