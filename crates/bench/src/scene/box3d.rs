//! The scenes that Box3D is measured with (`shared/benchmarks.c` of its repository, August 2026), with its sizes, counts, density and
//! gravity. Its y is our z. Fewer bodies than it has leave out layers; more are not possible.

mod large_world;
mod rain;

pub(super) use large_world::large_world;
pub(super) use rain::rain;

use super::driven::{Driven, Path};
use super::{Placed, Scene, pyramid};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::Hull;
use std::f64::consts::PI;
use std::sync::Arc;

/// m/s².
const GRAVITY: f32 = 10.0;
/// kg/m³, of pyramids and of all else.
const LIGHT: f32 = 100.0;
const WATER: f32 = 1000.0;

/// Bodies of each scene.
pub(super) const LARGE_PYRAMID: usize = 5050;
pub(super) const MANY_PYRAMIDS: usize = 14 * 14 * 55;
pub(super) const CONVEX_PILE: usize = 8 * 8 * 80;
pub(super) const JUNKYARD: usize = 21 * 21 * 24;
pub(super) const WASHER: usize = 20 * 20 * 20;
pub(super) const RAIN: usize = 10 * 10 * 3 * 14;
pub(super) const LARGE_WORLD: usize = 100;

/// A flat pyramid of unit boxes that touch their neighbours; the base of all is 100.
pub(super) fn large_pyramid(count: usize) -> Scene {
    let base = (0..=100).rev().find(|n| n * (n + 1) / 2 <= count).unwrap_or(0);
    let mut scene = with_ground(400.0, LIGHT);
    let shape = pyramid::unit_box(&mut scene);
    pyramid::build(&mut scene, shape, base, 1.0, DVec3::ZERO);
    scene
}

/// Fourteen rows of fourteen pyramids with a base of ten.
pub(super) fn many_pyramids(count: usize) -> Scene {
    let half = 77.0;
    let mut scene = with_ground(half as f32, LIGHT);
    let shape = pyramid::unit_box(&mut scene);
    for i in 0..count.min(MANY_PYRAMIDS) / 55 {
        let (row, column) = ((i / 14) as f64, (i % 14) as f64);
        let x = 1.0 - half + 11.0 * column + 4.5;
        let y = half - 1.0 - row * 2.0 * (half - 1.0) / 13.0;
        pyramid::build(&mut scene, shape, 10, 1.0, DVec3::new(x, y, 0.0));
    }
    scene
}

/// A tower of equal hulls, 4 m across, of 32 points on a sphere, that collapses into a pile.
pub(super) fn convex_pile(count: usize) -> Result<Scene, crate::Error> {
    let radius = 2.0;
    let mut scene = with_ground(250.0, WATER);
    scene.half_width = 250.0;
    let shape = add_hull(&mut scene, &on_sphere(32, radius as f32))?;
    for i in 0..count.min(CONVEX_PILE) {
        let [x, z, layer] = [i % 8, i / 8 % 8, i / 64].map(|n| n as f64);
        let place = up(2.0 * radius * (x - 4.0), radius + 2.0 * radius * layer, 2.0 * radius * (z - 4.0));
        scene.bodies.push(Placed { shape, pose: Pose::at(place) });
    }
    Ok(scene)
}

/// Points on a sphere by Box3D's own sequence of numbers, taken from the PEEL benchmark.
fn on_sphere(count: usize, radius: f32) -> Vec<Vec3> {
    let mut state = 42u32;
    let mut next = || {
        state = state.wrapping_mul(2_147_001_325).wrapping_add(715_136_305);
        (state & 0xffff) as f32 / 65535.0 - 0.5
    };
    let mut points = Vec::new();
    while points.len() < count {
        let [x, y, z] = [next(), next(), next()];
        let v = Vec3::new(x, -z, y);
        if v.length_squared() <= 0.25 {
            points.push(v * (radius / v.length()));
        }
    }
    points
}

/// Rocks dropped into a walled yard, in which a pillar goes round.
pub(super) fn junkyard(count: usize) -> Result<Scene, crate::Error> {
    let mut scene = with_ground(120.0, WATER);
    scene.half_width = 120.0;
    for (x, z) in [(-50.0, 0.0), (50.0, 0.0), (0.0, -50.0), (0.0, 50.0)] {
        let half = if x == 0.0 { Vec3::new(50.0, 1.0, 8.0) } else { Vec3::new(1.0, 50.0, 8.0) };
        scene.fixed.push(Placed { shape: scene.shapes.len(), pose: Pose::at(up(x, 7.0, z)) });
        scene.shapes.push(Shape::Box { half });
    }
    let rock = add_hull(&mut scene, &fibonacci(10, 1.5))?;
    for i in 0..count.min(JUNKYARD) {
        let [z, x, layer] = [i % 21, i / 21 % 21, i / 441].map(|n| 4.0 * n as f64);
        let pose = Pose::at(up(x - 40.0, layer + 25.0, z - 40.0));
        scene.bodies.push(Placed { shape: rock, pose });
    }
    let pillar: Vec<Vec3> = (0..32)
        .map(|i| {
            let (sin, cos) = (f64::from(i / 2) * PI / 8.0).sin_cos();
            up(4.0 * cos, 24.0 * f64::from(i % 2), 4.0 * sin).as_vec3()
        })
        .collect();
    let shape = add_hull(&mut scene, &pillar)?;
    scene.driven.push(Driven { shape, path: Path::Circle { radius: 35.0, rate: 6.0 * PI / 180.0 } });
    Ok(scene)
}

/// Points of a Fibonacci lattice on a sphere.
fn fibonacci(count: usize, radius: f64) -> Vec<Vec3> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let point = |i: usize| {
        let height = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (2.0 * PI / golden * i as f64).sin_cos();
        let across = (1.0 - height * height).sqrt();
        (radius * up(across * cos, across * sin, height)).as_vec3()
    };
    (0..count).map(point).collect()
}

/// Cubes in a turning drum of 36 staves with four vanes, open at its ends. The drum is forty bodies that turn
/// together, because not every engine here makes one body of many shapes.
pub(super) fn washer(count: usize) -> Result<Scene, crate::Error> {
    let mut scene = with_ground(60.0, WATER);
    scene.half_width = 60.0;
    let middle = DVec3::new(0.0, 0.0, 21.0);
    let path =
        Path::Spin { middle, velocity: up(0.001, -0.002, 0.0), axis: -Vec3::Y, rate: 25.0 * PI / 180.0 };
    // Corners of a part between two angles, in steps of 10°, and two radii.
    let part = |from: f64, to: f64, inner: f64, outer: f64| -> Vec<Vec3> {
        let corner = |i: usize| {
            let (sin, cos) = (if i & 1 == 0 { from } else { to } * PI / 18.0).sin_cos();
            let radius = if i & 2 == 0 { inner } else { outer };
            up(radius * cos, radius * sin, if i & 4 == 0 { -10.0 } else { 10.0 }).as_vec3()
        };
        (0..8).map(corner).collect()
    };
    for stave in 0..36 {
        let from = f64::from(stave);
        let mut parts = vec![part(from - 0.1, from + 1.1, 16.0, 18.0)];
        if stave % 9 == 0 {
            parts.push(part(from, from + 1.0, 14.0, 16.0));
        }
        for points in parts {
            let shape = add_hull(&mut scene, &points)?;
            scene.driven.push(Driven { shape, path });
        }
    }
    let half = 0.2;
    let cube = scene.shapes.len();
    scene.shapes.push(Shape::Box { half: Vec3::splat(half as f32) });
    for i in 0..count.min(WASHER) {
        let [z, y, x] = [i % 20, i / 20 % 20, i / 400].map(|n| 4.0 * half * n as f64 - 40.0 * half);
        scene.bodies.push(Placed { shape: cube, pose: Pose::at(middle + up(x, y, z)) });
    }
    Ok(scene)
}

/// Its y upwards is our z.
fn up(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, -z, y)
}

fn with_ground(half_width: f32, density: f32) -> Scene {
    let half = Vec3::new(half_width, half_width, 1.0);
    let mut scene = Scene { density, gravity: GRAVITY, ..Scene::empty() };
    scene.shapes.push(Shape::Box { half });
    scene.fixed.push(Placed { shape: 0, pose: Pose::at(-DVec3::Z) });
    scene
}

fn add_hull(scene: &mut Scene, points: &[Vec3]) -> Result<usize, crate::Error> {
    scene.shapes.push(Shape::Hull(Arc::new(Hull::from_points(points)?)));
    Ok(scene.shapes.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_those_of_box3d() {
        let all = usize::MAX;
        assert_eq!(large_pyramid(all).bodies.len(), 5050);
        assert_eq!(many_pyramids(all).bodies.len(), 10_780);
        assert_eq!(convex_pile(all).expect("a scene").bodies.len(), 5120);
        let yard = junkyard(all).expect("a scene");
        assert_eq!((yard.bodies.len(), yard.driven.len()), (10_584, 1));
        let washer = washer(all).expect("a scene");
        assert_eq!((washer.bodies.len(), washer.driven.len()), (8000, 40));
        let rain = rain(all).expect("a scene");
        assert_eq!((rain.bodies.len(), rain.fixed.len()), (4200, 200));
        let world = large_world(all);
        assert_eq!((world.bodies.len(), world.fixed.len()), (100, 1_000_000));
    }

    #[test]
    fn few_bodies_leave_out_the_upper_layers() {
        assert_eq!(large_pyramid(100).bodies.len(), 91);
        assert_eq!(many_pyramids(120).bodies.len(), 110);
        let few = junkyard(441).expect("a scene");
        assert!(few.bodies.iter().all(|b| b.pose.position.z == 25.0));
    }

    #[test]
    fn hulls_have_all_their_points_as_corners() {
        let corners = |points: &[Vec3]| Hull::from_points(points).expect("a hull").vertices.len();
        assert_eq!(corners(&on_sphere(32, 2.0)), 32);
        assert_eq!(corners(&fibonacci(10, 1.5)), 10);
    }

    #[test]
    fn places_are_those_of_box3d() {
        let scene = many_pyramids(usize::MAX);
        assert_eq!(scene.bodies[0].pose.position, up(-76.0, 0.5, -76.0));
        let last = scene.bodies[scene.bodies.len() - 1].pose.position;
        assert!((last - up(67.0 + 4.5, 9.5, 76.0)).length() < 1e-9, "{last}");
        let pile = convex_pile(usize::MAX).expect("a scene");
        assert_eq!(pile.bodies[0].pose.position, up(-16.0, 2.0, -16.0));
        assert_eq!(pile.bodies[5119].pose.position, up(12.0, 318.0, 12.0));
    }
}
