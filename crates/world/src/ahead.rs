//! Where two bodies that touch will be in the middle of the step.
//!
//! Arms and normals of contacts stay what they are for all sub-steps of a step. Found at its start they are late by half a step on average; a force that is late by τ feeds an oscillation of ω rad/s,
//! whose amplitude grows by ω² τ / 2 a second: rings of 10 cm that hang in each other swing at 12 rad/s, and would swing by twice as much after every second. So the contacts of two fields or meshes, which may hang in each other, and of a mesh that may hang on a convex body, are found
//! for the middle of the step, from the velocities that the bodies have; distances are taken back to its start, from where the solver counts.

use crate::Shape;
use crate::bodies::Bodies;
use rockfall_math::{DVec3, Isometry, Mat3, Pose, Quat, Vec3, rotation};

/// Two bodies are not moved ahead by more than this share of the size that their contacts are measured by.
const FARTHEST: f32 = 0.25;

/// For how long a pair is moved ahead, s.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ahead {
    time: f32,
    /// By no more than that do the two come nearer to each other meanwhile, metres.
    pub(crate) way: f32,
}

/// Whether a shape may have a hole or a hook by which it hangs.
pub(crate) fn may_hang(shape: &Shape) -> bool {
    match shape {
        Shape::Field(_) => true,
        Shape::Mesh(mesh) => mesh.inner_ball.1 > 0.0,
        _ => false,
    }
}

/// Whether a mesh may hang on a convex body, a peg.
fn hangs_on(shapes: [&Shape; 2]) -> bool {
    let is_peg = |shape: &Shape| shape.is_convex() && !matches!(shape, Shape::HalfSpace { .. });
    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_)) && may_hang(shape);
    let [a, b] = shapes;
    is_mesh(a) && is_peg(b) || is_mesh(b) && is_peg(a)
}

/// No point of one of two bodies goes faster than that, seen from the other, m/s.
pub(crate) fn passing_speed(bodies: &Bodies, [a, b]: [usize; 2]) -> f32 {
    let turn = |row: usize| {
        let turn = bodies.lines[row].angular_velocity().length();
        // A plane is infinitely large, and does not turn.
        if turn > 0.0 { turn * bodies.radii[row] } else { 0.0 }
    };
    (bodies.lines[b].velocity() - bodies.lines[a].velocity()).length() + turn(a) + turn(b)
}

impl Ahead {
    /// Of two bodies whose contacts are found anew in a step of `dt` seconds.
    pub(crate) fn new(bodies: &Bodies, [a, b]: [usize; 2], shapes: [&Shape; 2], dt: f32) -> Self {
        if !shapes.iter().all(|shape| may_hang(shape)) && !hangs_on(shapes) {
            return Ahead::default();
        }
        let speed = passing_speed(bodies, [a, b]);
        let scale = shapes.iter().map(|shape| shape.contact_scale()).fold(f32::INFINITY, f32::min);
        if speed <= 0.0 {
            return Ahead::default();
        }
        let time = (0.5 * dt).min(FARTHEST * scale / speed);
        Ahead { time, way: time * speed }
    }

    /// The middle of a body, and how it is turned.
    fn body(&self, bodies: &Bodies, row: usize) -> (DVec3, Quat) {
        let (position, turned) = (bodies.positions[row], bodies.rotations[row]);
        if self.time == 0.0 {
            return (position, turned);
        }
        let line = &bodies.lines[row];
        let turn = rotation::from_rotation_vector(self.time * line.angular_velocity());
        (
            position + (self.time * line.velocity()).as_dvec3(),
            rotation::normalize(rotation::compose(turn, turned)),
        )
    }

    /// B's shape in the frame of A's.
    pub(crate) fn b_in_a(&self, bodies: &Bodies, [a, b]: [usize; 2]) -> Isometry {
        let pose = |row: usize| {
            let (position, turned) = self.body(bodies, row);
            let center = rotation::rotate(turned, bodies.centers[row]);
            Pose { position: position - center.as_dvec3(), rotation: turned }
        };
        pose(a).see(&pose(b))
    }

    /// From A's frame to the world's axes, and the way from the middle of A to that of B.
    pub(crate) fn axes(&self, bodies: &Bodies, [a, b]: [usize; 2]) -> (Mat3, Vec3) {
        let ((from, turned), (to, _)) = (self.body(bodies, a), self.body(bodies, b));
        (Mat3::from_quat(turned), (to - from).as_vec3())
    }

    /// Takes the distances of a manifold, whose arms from A are in the world's axes, back to the start of the step.
    pub(crate) fn take_back(
        &self,
        bodies: &Bodies,
        [a, b]: [usize; 2],
        offset: Vec3,
        normal: Vec3,
        arms: &[Vec3],
        distances: &mut [f32],
    ) {
        if self.time == 0.0 {
            return;
        }
        let speed = |row: usize, arm: Vec3| {
            let line = &bodies.lines[row];
            line.velocity() + line.angular_velocity().cross(arm)
        };
        for (arm, distance) in arms.iter().zip(distances) {
            *distance -= self.time * normal.dot(speed(b, *arm - offset) - speed(a, *arm));
        }
    }
}
