use super::*;
use crate::Mesh;
use rockfall_math::{DVec3, Quat};
use std::sync::Arc;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::at(DVec3::new(x, y, z))
}

fn turned(pose: Pose, about: Vec3) -> Pose {
    Pose { rotation: rotation::from_rotation_vector(about), ..pose }
}

fn cube(half: f32) -> Shape {
    Shape::Box { half: Vec3::splat(half) }
}

fn compound(parts: Vec<(Shape, Pose)>) -> Shape {
    Shape::Compound(Arc::new(Compound::new(parts).expect("the parts make sense")))
}

#[test]
fn compounds_in_compounds_are_taken_apart() {
    let inner =
        compound(vec![(cube(0.5), at(1.0, 0.0, 0.0)), (Shape::Sphere { radius: 0.1 }, at(0.0, 0.0, 2.0))]);
    let quarter = turned(at(0.0, 3.0, 0.0), Vec3::Z * std::f32::consts::FRAC_PI_2);
    let outer =
        Compound::new(vec![(cube(0.25), at(0.0, 0.0, 0.0)), (inner, quarter)]).expect("they make sense");
    let places: Vec<DVec3> = outer.parts().iter().map(|part| part.pose.position).collect();
    let expected = [DVec3::ZERO, DVec3::new(0.0, 4.0, 0.0), DVec3::new(0.0, 3.0, 2.0)];
    for (found, expected) in places.iter().zip(expected) {
        assert!((*found - expected).length() < 1e-6, "{found} {expected}");
    }
    assert!(outer.parts().iter().all(|part| !matches!(part.shape, Shape::Compound(_))));
    assert_eq!(outer.parts().len(), 3);
}

#[test]
fn bounds_are_those_of_the_parts_wherever_it_is() {
    let shape = compound(vec![
        (Shape::Sphere { radius: 0.5 }, at(2.0, 0.0, 0.0)),
        (cube(0.5), turned(at(-2.0, 0.0, 0.0), Vec3::Z * std::f32::consts::FRAC_PI_4)),
    ]);
    let expected = Aabb::new(
        Vec3::new(-2.0 - 0.5_f32.sqrt(), -0.5_f32.sqrt(), -0.5),
        Vec3::new(2.5, 0.5_f32.sqrt(), 0.5),
    );
    let off = |a: Aabb, b: Aabb| (a.min - b.min).abs().max((a.max - b.max).abs()).max_element();
    assert!(off(shape.bounds(), expected) < 1e-5, "{:?}", shape.bounds());
    // Upright, the ball is 2.5 over the origin, far below the box around the turned box.
    let upright = turned(at(10.0, 0.0, 0.0), Vec3::Y * -std::f32::consts::FRAC_PI_2);
    let placed = shape.placed_bounds(&upright);
    assert!(
        (placed.max.z - 2.5).abs() < 1e-4 && (placed.min.z + 2.0 + 0.5_f32.sqrt()).abs() < 1e-4,
        "{placed:?}"
    );
}

#[test]
fn extent_is_that_of_the_parts() {
    let shape = compound(vec![
        (Shape::Sphere { radius: 0.5 }, at(2.0, 0.0, 0.0)),
        (Shape::Capsule { half_length: 2.0, radius: 0.1 }, at(0.0, 0.0, 0.0)),
    ]);
    assert!((shape.radius_about(Vec3::ZERO) - 2.5).abs() < 1e-6);
    assert_eq!((shape.inner_radius(), shape.inner_center()), (0.1, Vec3::ZERO));
    assert!(!shape.is_convex() && shape.has_inside() && shape.can_move());
    assert_eq!(shape.support(Vec3::X), None);
}

#[test]
fn open_surfaces_make_it_immovable() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh::from_triangles(&corners, &[[0, 1, 2]]).expect("a triangle");
    let shape = compound(vec![(cube(0.5), Pose::default()), (Shape::Mesh(Arc::new(mesh)), Pose::default())]);
    assert!(!shape.can_move() && !shape.has_inside());
}

#[test]
fn parts_that_make_no_sense_are_refused() {
    let refused =
        |parts: Vec<(Shape, Pose)>| Compound::new(parts).expect_err("it makes no sense").to_string();
    assert_eq!(refused(vec![]), "the compound has no parts");
    let floor = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
    assert_eq!(
        refused(vec![(cube(0.5), Pose::default()), (floor, Pose::default())]),
        "part 1 is a half-space, expected a shape that ends on all sides: give it a body of its own"
    );
    assert_eq!(
        refused(vec![(Shape::Sphere { radius: -1.0 }, Pose::default())]),
        "part 0: the radius of the sphere is -1, expected a length from 1e-6 m to 1e6 m"
    );
    for pose in [
        at(f64::NAN, 0.0, 0.0),
        at(2e6, 0.0, 0.0),
        Pose { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..Pose::default() },
    ] {
        assert!(refused(vec![(cube(0.5), pose)]).starts_with("the place of part 0 makes no sense"));
    }
    let far = compound(vec![(cube(0.5), at(1e6, 0.0, 0.0))]);
    assert!(refused(vec![(far, at(1e6, 0.0, 0.0))]).starts_with("the place of part 0 makes no sense"));
}
