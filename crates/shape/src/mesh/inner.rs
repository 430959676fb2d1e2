//! A large ball inside a closed mesh.
//!
//! Reads a surface; finds the middle and the radius of a ball that fits behind it. From some triangles a ball that touches the surface there shrinks until nothing is in it (Ma, Bae and Choi, "3D medial axis point approximation using
//! nearest neighbors and the normal field", The Visual Computer 28, 2012); the largest then goes to where there is more room.

use super::Mesh;
use rockfall_math::{Aabb, DVec3, Vec3};

/// Triangles that a ball starts from, evenly among all: the ball need not be the largest, and a mesh may have millions.
const STARTS: usize = 64;

/// How often a ball shrinks at most; a handful is usual.
const SHRINKS: usize = 32;

/// Steps towards more room are halved so often, from half of the radius on.
const HALVINGS: usize = 8;

/// Steps of one length, in each of the six directions: enough for one across a body, and no more where a tiny ball would go a long way.
const STEPS: usize = 64;

/// Middle and radius, metres, of a ball behind a closed surface; no ball where nothing is enclosed.
pub(super) fn inner_ball(mesh: &Mesh) -> (Vec3, f32) {
    let stride = mesh.triangles.len().div_ceil(STARTS);
    let largest = (mesh.bounds.max - mesh.bounds.min).length();
    let mut best = (DVec3::ZERO, 0.0);
    for t in (0..mesh.triangles.len()).step_by(stride) {
        let corners = mesh.triangle(t).map(|c| c.as_dvec3());
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let ball = shrunk(mesh, middle, -mesh.normals[t].as_dvec3(), f64::from(largest));
        best = if ball.1 > best.1 { ball } else { best };
    }
    let (middle, radius) = roomiest(mesh, best);
    // Rounded down, so that it does fit.
    (middle.as_vec3(), ((radius - 1e-6 * f64::from(largest)).max(0.0)) as f32)
}

/// How far a point is behind the surface, metres. What lies beyond the bounds is not enclosed, though it be behind what it is nearest to: where a part of the mesh
/// is inside out, all the rest of the world is.
fn depth(mesh: &Mesh, p: DVec3) -> f64 {
    if !mesh.bounds.contains(&Aabb::around(p, p)) {
        return 0.0;
    }
    mesh.nearest(p, f64::INFINITY).map_or(0.0, |near| -near.distance)
}

/// The ball that touches the surface in `at` from behind, along `into`, and has nothing in it.
fn shrunk(mesh: &Mesh, at: DVec3, into: DVec3, largest: f64) -> (DVec3, f64) {
    let mut radius = largest;
    for _ in 0..SHRINKS {
        let middle = at + radius * into;
        let Some(near) = mesh.nearest(middle, f64::INFINITY) else { break };
        let way = near.point - at;
        // Of the balls that touch in `at`, the one through the nearest point.
        let along = way.dot(into);
        let through = if along > 0.0 { 0.5 * way.length_squared() / along } else { radius };
        if through >= radius * (1.0 - 1e-3) {
            break;
        }
        radius = through;
    }
    let middle = at + radius * into;
    (middle, depth(mesh, middle))
}

/// A larger ball near by, if there is one: along the axes in steps that grow shorter. It ends where three sides of a corner are equally near, with two thirds of the ball of a cube.
fn roomiest(mesh: &Mesh, (mut middle, mut radius): (DVec3, f64)) -> (DVec3, f64) {
    let mut step = 0.5 * radius;
    for _ in 0..HALVINGS {
        for _ in 0..STEPS {
            let before = middle;
            for way in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
                let there = middle + step * way;
                let room = depth(mesh, there);
                // By enough to be worth the way.
                if room > radius + 1e-2 * step {
                    (middle, radius) = (there, room);
                }
            }
            if middle == before {
                break;
            }
        }
        step *= 0.5;
    }
    (middle, radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hull, Shape};
    use rockfall_math::{Vec2, trig};
    use std::f32::consts::TAU;
    use std::sync::Arc;

    fn mesh_of(hull: &Hull) -> Mesh {
        let fan = |f: usize| {
            let face = hull.face(f);
            (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]])
        };
        let triangles: Vec<[u32; 3]> = (0..hull.normals.len()).flat_map(fan).collect();
        Mesh::from_triangles(&hull.vertices, &triangles).expect("a hull")
    }

    #[test]
    fn the_ball_in_a_box_is_as_large_as_its_shortest_side_allows() {
        for half in [Vec3::new(0.5, 0.4, 0.3), Vec3::new(2.0, 0.01, 1.0), Vec3::splat(100.0)] {
            let mesh = mesh_of(&Hull::cuboid(half));
            let (middle, radius) = mesh.inner_ball;
            let least = half.min_element();
            // Where three sides are equally near no step along an axis leads away from all of them: of a cube it finds two thirds.
            let share = if half.max_element() > least { 0.85 } else { 0.66 };
            assert!(radius <= least && radius > share * least, "{radius} of {least}");
            assert!((half - middle.abs()).min_element() >= radius, "{middle}");
        }
    }

    #[test]
    fn the_ball_in_a_ring_is_in_its_tube() {
        let around = (0..24).map(|k| {
            let (sin, cos) = trig::sin_cos(TAU * k as f32 / 24.0);
            Vec2::new(0.1 + 0.03 * cos, 0.03 * sin)
        });
        let mesh = Mesh::turned(&around.collect::<Vec<_>>(), 48).expect("a ring");
        let (middle, radius) = mesh.inner_ball;
        assert!(radius <= 0.03 && radius > 0.028, "{radius}");
        assert!((middle.truncate().length() - 0.1).abs() < 0.002 && middle.z.abs() < 0.002, "{middle}");
    }

    /// Behind the small one is the whole world, and room without end.
    #[test]
    fn the_ball_stays_within_where_a_part_is_inside_out() {
        let cube = |half: f32, at: Vec3| {
            let hull = Hull::cuboid(Vec3::splat(half));
            let vertices: Vec<Vec3> = hull.vertices.iter().map(|v| *v + at).collect();
            (vertices, mesh_of(&hull).triangles.clone())
        };
        let ((mut vertices, mut triangles), (more, turned)) =
            (cube(1.0, Vec3::ZERO), cube(0.1, Vec3::new(3.0, 0.0, 0.0)));
        let first = vertices.len() as u32;
        vertices.extend(more);
        triangles.extend(turned.iter().map(|t| [t[0], t[2], t[1]].map(|c| c + first)));
        let mesh = Mesh::from_triangles(&vertices, &triangles).expect("two cubes");
        let (middle, radius) = mesh.inner_ball;
        assert!(
            mesh.bounds.contains(&Aabb::from_points([middle])) && radius > 0.6 && radius < 4.2,
            "{middle} {radius}"
        );
    }

    #[test]
    fn what_encloses_nothing_has_none() {
        let room: Vec<[u32; 3]> =
            mesh_of(&Hull::cuboid(Vec3::ONE)).triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
        let mesh = Mesh::from_triangles(&Hull::cuboid(Vec3::ONE).vertices, &room).expect("a room");
        assert!(mesh.closed);
        assert_eq!(mesh.inner_ball.1, 0.0);
        assert_eq!(Shape::Mesh(Arc::new(mesh)).inner_radius(), 0.0);
        let mesh = Mesh::from_triangles(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]).expect("one");
        assert_eq!(mesh.inner_ball.1, 0.0);
    }
}
