//! parry3d, asked for the distance of two shapes.

use parry3d::math::{Pose, Rotation};
use parry3d::query;
use parry3d::shape as other;
use rockfall_math::{Isometry, Mat3, Vec3, rotation};
use rockfall_shape::Shape;

fn parry(shape: &Shape) -> Option<Box<dyn other::Shape>> {
    Some(match shape {
        Shape::Sphere { radius } => Box::new(other::Ball::new(*radius)),
        Shape::Box { half } => Box::new(other::Cuboid::new(*half)),
        Shape::Capsule { half_length, radius } => Box::new(other::Capsule::new_z(*half_length, *radius)),
        Shape::Hull(hull) => Box::new(other::ConvexPolyhedron::from_convex_hull(&hull.vertices)?),
        Shape::RoundedBox { half, radius } => {
            Box::new(other::RoundCuboid { inner_shape: other::Cuboid::new(*half), border_radius: *radius })
        }
        Shape::RoundedHull { hull, radius } => Box::new(other::RoundConvexPolyhedron {
            inner_shape: other::ConvexPolyhedron::from_convex_hull(&hull.vertices)?,
            border_radius: *radius,
        }),
        // Along y.
        Shape::Cylinder { half_length, radius } => Box::new(other::Cylinder::new(*half_length, *radius)),
        Shape::Cone { half_length, lower, upper } if *upper == 0.0 => {
            Box::new(other::Cone::new(*half_length, *lower))
        }
        _ => return None,
    })
}

/// What parry3d says of the distance, where it has such shapes and an opinion.
pub(crate) fn second_opinion(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<f32> {
    let (shape_a, shape_b) = (parry(a)?, parry(b)?);
    let upright = Mat3::from_quat(rotation::from_rotation_vector(Vec3::X * std::f32::consts::FRAC_PI_2));
    let turn = |shape: &Shape| match shape {
        Shape::Cylinder { .. } | Shape::Cone { .. } => upright,
        _ => Mat3::IDENTITY,
    };
    let place = |translation: Vec3, turn: Mat3| Pose::from_parts(translation, Rotation::from_mat3(&turn));
    let pose_a = place(Vec3::ZERO, turn(a));
    let pose_b = place(b_in_a.translation, b_in_a.rotation * turn(b));
    query::contact(&pose_a, &*shape_a, &pose_b, &*shape_b, 100.0).ok()?.map(|c| c.dist)
}
