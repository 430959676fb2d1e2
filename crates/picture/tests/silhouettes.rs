//! A pixel shows a body exactly where the line through its middle comes into the shape, and at the distance where it does.
//!
//! That is asked of the engine's signed distance of a point, which knows nothing of rays: steps as long as the distance never jump over a surface.

mod common;

use common::{shapes, turned};
use rockfall_collide::nearest_point;
use rockfall_math::{DVec3, Pose, Quat, rotation};
use rockfall_picture::{Actor, Air, Camera, Quality, Shot, Stage, render};
use rockfall_shape::Shape;

const SIZE: [u32; 2] = [48, 36];

/// What passes a surface by less than this, metres, may be drawn or not.
const GRAZES: f64 = 2e-3;

/// Where a line first comes into a shape, and how near it comes if it never does. A height field is solid below its surface to points, and a sheet to rays and pictures: what comes in by its sides, where there is
/// nothing to be seen, goes on to the surface, which it meets from below.
fn march(shape: &Shape, pose: &Pose, from: DVec3, direction: DVec3) -> Result<f64, f64> {
    let (mut t, mut nearest) = (0.0, f64::INFINITY);
    while t < 40.0 {
        let local = rotation::rotate_back_double(pose.rotation, from + t * direction - pose.position);
        let Some(near) = nearest_point(shape, local, f32::INFINITY) else { return Err(nearest) };
        let distance = match shape {
            Shape::HeightField(_) => f64::from(near.distance).abs(),
            _ => f64::from(near.distance),
        };
        if distance <= 1e-5 {
            return Ok(t);
        }
        nearest = nearest.min(distance);
        t += distance.max(1e-5);
    }
    Err(nearest)
}

#[test]
fn silhouettes_and_depths_are_those_of_the_distance() {
    for (k, shape) in (0..).zip(shapes()) {
        // As it comes, and as ground lies.
        if !matches!(shape, Shape::HalfSpace { .. }) {
            compare(k, &shape, turned(k));
        }
        if !shape.can_move() {
            compare(k, &shape, Pose::default().rotation);
        }
    }
}

/// Holds the picture of a shape against its distance, far away from the origin as near to it.
fn compare(k: u32, shape: &Shape, rotation: Quat) {
    let position = DVec3::new(1000.0 * f64::from(k), -20.0, 3.0);
    let pose = Pose { position, rotation };
    let actor = Actor { shape: 0, pose, color: [0.5; 3], moves: true };
    let stage = Stage { shapes: vec![shape.clone()], actors: vec![actor] };
    let eye = position + DVec3::new(3.0, -4.0, 2.5);
    let camera = Camera { eye, target: position, up: DVec3::Z, fov: 40.0, lens: None };
    let shot = Shot { width: SIZE[0], height: SIZE[1], quality: Quality::Draft, air: Air::NONE };
    let image = render(&stage, &camera, &shot);
    let (mut shown, mut grazing) = (0, 0);
    for (index, &depth) in image.depth.iter().enumerate() {
        let [x, y] = [index as u32 % SIZE[0], index as u32 / SIZE[0]].map(|i| f64::from(i) + 0.5);
        let direction = camera.direction(x, y, SIZE[0], SIZE[1]);
        match march(shape, &pose, eye, direction) {
            Ok(t) if depth.is_finite() => {
                shown += 1;
                // Grazing lines creep up to the surface.
                assert!((f64::from(depth) - t).abs() < 0.02, "{}: {depth} and {t} at {x}, {y}", shape.name());
            }
            Err(nearest) if depth.is_infinite() => assert!(nearest > 0.0),
            Err(nearest) if nearest < GRAZES => grazing += 1,
            // A line that only just comes in: a little to the side it does not.
            Ok(_) => grazing += 1,
            Err(nearest) => panic!("{}: drawn at {x}, {y}, but {nearest} m away", shape.name()),
        }
    }
    assert!(shown > 80, "{}: {shown} pixels", shape.name());
    assert!(grazing * 100 < shown, "{}: {grazing} of {shown} pixels at the border differ", shape.name());
}
