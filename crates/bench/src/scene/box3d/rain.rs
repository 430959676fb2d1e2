//! `rain`, in pieces. In Box3D's, ragdolls of fourteen capsules fall on a plane of triangles with an arch in each of a hundred
//! squares: three in each square, a column of squares after the other. There are no joints here, so it rains capsules: as many, at
//! the same times, of the same sizes up to a few millimetres, from the same height; but lying in stacks and not in the shape of a
//! person, in which they would overlap. Of the last eighty steps of Box3D's four hundred one thing is missing: it takes three
//! columns away and lets them fall again; here they stay. Nothing is around the plane: a few dozen capsules roll over its edge, and
//! count as escaped.

use super::{WATER, up};
use crate::scene::{Placed, Scene, Wave};
use rockfall::Shape;
use rockfall::math::{Pose, Quat, Vec3};
use rockfall::shape::Mesh;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Squares along each side.
const SQUARES: usize = 10;
/// Their width, metres.
const WIDTH: f64 = 15.0;
/// Cells of the plane along the side of a square.
const CELLS: u32 = 8;
/// Corners of an arch around its ring and around its tube.
const CORNERS: u32 = 16;
/// Radii of its ring and of its tube, metres.
const RING: f64 = 0.25 * WIDTH;
const TUBE: f64 = 1.0;
/// Ragdolls in a square, and metres from one to the next.
const GROUP: usize = 3;
const APART: f64 = 0.75;
/// From where they fall, metres.
const HEIGHT: f64 = 20.0;
/// A column comes in before each step in whose number none of these bits is set.
const BITS: u32 = 0x2f;
/// Half lengths and radii of a ragdoll's capsules, metres: pelvis, three of the spine, neck, head, and twice thigh, calf, upper
/// and lower arm.
const LIMBS: [(f32, f32); 14] = [
    (0.07, 0.13),
    (0.06, 0.12),
    (0.08, 0.1),
    (0.11, 0.145),
    (0.03, 0.07),
    (0.03, 0.0975),
    (0.2, 0.09),
    (0.2, 0.09),
    (0.22, 0.075),
    (0.22, 0.075),
    (0.125, 0.075),
    (0.125, 0.075),
    (0.15, 0.05),
    (0.15, 0.05),
];
/// Between the capsules of a layer, and between layers, metres: no radius is larger than half of it.
const PITCH: f64 = 0.3;

pub(in crate::scene) fn rain(count: usize) -> Result<Scene, crate::Error> {
    let half_width = 0.5 * WIDTH * SQUARES as f64;
    let mut scene = Scene { density: WATER, gravity: super::GRAVITY, half_width, ..Scene::empty() };
    scene.shapes = vec![Shape::Mesh(Arc::new(plane()?)), Shape::Mesh(Arc::new(arch()?))];
    let limbs = scene.shapes.len();
    let limb = |&(half_length, radius): &(f32, f32)| Shape::Capsule { half_length, radius };
    scene.shapes.extend(LIMBS.iter().map(limb));

    let middle = |i: usize| (i as f64 + 0.5) * WIDTH - half_width;
    for i in 0..SQUARES * SQUARES {
        let pose = Pose::at(up(middle(i / SQUARES), 0.0, middle(i % SQUARES)));
        scene.fixed.extend([0, 1].map(|shape| Placed { shape, pose }));
    }
    for (column, after) in (0..).filter(|step| step & BITS == 0).take(SQUARES).enumerate() {
        if column > 0 {
            scene.late.push(Wave { first: scene.bodies.len(), after });
        }
        for i in 0..SQUARES * GROUP {
            let (row, ragdoll) = (i / GROUP, i % GROUP);
            for number in 0..LIMBS.len() {
                // Two in each layer, along the other horizontal axis.
                let aside = PITCH * ((number % 2) as f64 - 0.5);
                let x = middle(column) + APART * ragdoll as f64 + aside;
                let position = up(x, HEIGHT + PITCH * (number / 2) as f64, middle(row));
                let rotation = Quat::from_rotation_x(FRAC_PI_2 as f32);
                scene.bodies.push(Placed { shape: limbs + number, pose: Pose { position, rotation } });
            }
        }
    }
    scene.bodies.truncate(count);
    scene.late.retain(|wave| wave.first < scene.bodies.len());
    Ok(scene)
}

/// A flat square, normals up.
fn plane() -> Result<Mesh, crate::Error> {
    let side = CELLS + 1;
    let place = |i: u32| (f64::from(i) / f64::from(CELLS) - 0.5) * WIDTH;
    let corners = (0..side * side).map(|i| up(place(i % side), 0.0, -place(i / side)).as_vec3());
    let cells = (0..CELLS * CELLS).map(|i| i / CELLS * side + i % CELLS);
    let triangles = cells.flat_map(|a| quad([a, a + 1, a + 1 + side, a + side]));
    Ok(Mesh::from_triangles(&corners.collect::<Vec<Vec3>>(), &triangles.collect::<Vec<_>>())?)
}

/// A ring that stands upright, half in the ground.
fn arch() -> Result<Mesh, crate::Error> {
    let angle = |i: u32| 2.0 * PI * f64::from(i) / f64::from(CORNERS);
    let corner = |i: u32| {
        let ((sin, cos), (rise, out)) = (angle(i % CORNERS).sin_cos(), angle(i / CORNERS).sin_cos());
        let radius = RING + TUBE * out;
        up(radius * cos, radius * sin, TUBE * rise).as_vec3()
    };
    let corners: Vec<Vec3> = (0..CORNERS * CORNERS).map(corner).collect();
    let at = |along: u32, around: u32| around % CORNERS * CORNERS + along % CORNERS;
    let cells = (0..CORNERS * CORNERS).map(|i| (i % CORNERS, i / CORNERS));
    let triangles = cells.flat_map(|(u, v)| quad([at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]));
    Ok(Mesh::from_triangles(&corners, &triangles.collect::<Vec<_>>())?)
}

/// Two triangles.
fn quad([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_looks_up_and_the_arch_outwards() {
        let plane = plane().expect("a mesh");
        assert_eq!(plane.triangles.len(), 128);
        assert!(plane.normals.iter().all(|n| n.z > 0.999));
        let arch = arch().expect("a mesh");
        assert_eq!((arch.triangles.len(), arch.closed), (512, true));
        for (t, normal) in arch.normals.iter().enumerate() {
            let middle = arch.triangle(t).into_iter().sum::<Vec3>() / 3.0;
            let ring = Vec3::new(middle.x, 0.0, middle.z).normalize() * RING as f32;
            // The tube has a radius of one metre, and the ring is round where its facets are flat.
            let out = (middle - ring).dot(*normal);
            assert!((0.8..1.1).contains(&out), "triangle {t}: {out}");
        }
    }

    #[test]
    fn columns_come_in_at_the_steps_of_box3d() {
        let scene = rain(usize::MAX).expect("a scene");
        let times: Vec<u32> = scene.late.iter().map(|wave| wave.after).collect();
        assert_eq!(times, [16, 64, 80, 128, 144, 192, 208, 256, 272]);
        assert_eq!([0, 15, 16, 400].map(|steps| scene.present(steps)), [420, 420, 840, 4200]);
        assert_eq!(rain(421).expect("a scene").late, [Wave { first: 420, after: 16 }]);
    }
}
