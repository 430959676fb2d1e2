//! What the solver knows of a body.

use bytemuck::{Pod, Zeroable};
use rockfall_math::lanes::Row;
use rockfall_math::{Mat3, Quat, Vec3};

/// A body's cache line: what every contact reads, and in its first half what every contact writes.
///
/// Row 0 is the world: all zeros, read by every contact with an immobile body and written by none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Line {
    /// Velocity of the centre of mass (m/s), angular velocity (rad/s), inverse mass (1/kg), gravity scale.
    pub motion: Row,
    /// Inverse inertia about the centre of mass in world axes: xx, xy, xz, yy, yz, zz (1/(kg m²)); two unused.
    pub inertia: Row,
}

impl Line {
    /// m/s.
    pub fn velocity(&self) -> Vec3 {
        Vec3::new(self.motion[0], self.motion[1], self.motion[2])
    }

    /// rad/s.
    pub fn angular_velocity(&self) -> Vec3 {
        Vec3::new(self.motion[3], self.motion[4], self.motion[5])
    }

    /// 1/kg; 0 for a body that contacts can't move.
    pub fn inverse_mass(&self) -> f32 {
        self.motion[6]
    }

    /// Factor on gravity.
    pub fn gravity_scale(&self) -> f32 {
        self.motion[7]
    }

    /// Sets both velocities.
    pub fn set_velocities(&mut self, velocity: Vec3, angular: Vec3) {
        self.motion[..3].copy_from_slice(&velocity.to_array());
        self.motion[3..6].copy_from_slice(&angular.to_array());
    }

    /// Inverse inertia as a matrix.
    pub fn inverse_inertia(&self) -> Mat3 {
        let [xx, xy, xz, yy, yz, zz, ..] = self.inertia;
        Mat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz))
    }

    /// Sets the inverse inertia from a symmetric matrix.
    pub fn set_inverse_inertia(&mut self, m: &Mat3) {
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = m;
        self.inertia = [x.x, x.y, x.z, y.y, y.z, z.z, 0.0, 0.0];
    }
}

/// How far a body has moved since the step began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Drift(
    /// Δp of the centre of mass (m), Δθ as the sum of ω h (rad), two unused.
    pub Row,
);

impl Drift {
    /// Motion of the centre of mass, metres.
    pub fn translation(&self) -> Vec3 {
        Vec3::new(self.0[0], self.0[1], self.0[2])
    }

    /// Sum of ω h, rad.
    pub fn rotation(&self) -> Vec3 {
        Vec3::new(self.0[3], self.0[4], self.0[5])
    }

    /// Sets both.
    pub fn set(&mut self, translation: Vec3, rotation: Vec3) {
        self.0[..3].copy_from_slice(&translation.to_array());
        self.0[3..6].copy_from_slice(&rotation.to_array());
    }
}

/// How a body takes part in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// Does not move: static, asleep or frozen.
    #[default]
    Still,
    /// Moves by its velocity, which contacts don't change.
    Driven,
    /// Moves by forces and contacts.
    Free,
}

/// The columns of the bodies that a solver reads and writes, all of one length; row 0 is the world. In a sweep the first two are
/// longer: see `copies.rs`.
#[derive(Debug)]
pub struct Columns<'a> {
    /// Velocities and inverse masses.
    pub lines: &'a mut Vec<Line>,
    /// Motion since the step began.
    pub drifts: &'a mut Vec<Drift>,
    /// Velocities from which the next warm start is measured; see [`crate::push`].
    pub references: &'a mut [Row],
    /// Body to world, unit quaternions.
    pub rotations: &'a mut [Quat],
    /// The same when the step began.
    pub starts: &'a [Quat],
    /// Principal axes to body.
    pub frames: &'a [Quat],
    /// Inverse principal moments, 1/(kg m²).
    pub inverse_moments: &'a [Vec3],
    /// Linear and angular damping, 1/s.
    pub dampings: &'a [[f32; 2]],
    /// Who moves.
    pub roles: &'a [Role],
    /// Bit i locks translation along axis i, bit 3 + i rotation about it, world axes.
    pub locks: &'a [u8],
}

/// Bodies by themselves, for tests of what moves them.
#[cfg(test)]
pub(crate) struct Bodies {
    pub(crate) lines: Vec<Line>,
    pub(crate) drifts: Vec<Drift>,
    references: Vec<Row>,
    rotations: Vec<Quat>,
    starts: Vec<Quat>,
    frames: Vec<Quat>,
    inverse_moments: Vec<Vec3>,
    dampings: Vec<[f32; 2]>,
    roles: Vec<Role>,
    locks: Vec<u8>,
}

#[cfg(test)]
impl Bodies {
    /// So many rows, all of them free but without mass.
    pub(crate) fn new(rows: usize) -> Self {
        Bodies {
            lines: vec![Line::default(); rows],
            drifts: vec![Drift::default(); rows],
            references: vec![[0.0; 8]; rows],
            rotations: vec![Quat::IDENTITY; rows],
            starts: vec![Quat::IDENTITY; rows],
            frames: vec![Quat::IDENTITY; rows],
            inverse_moments: vec![Vec3::ONE; rows],
            dampings: vec![[0.0; 2]; rows],
            roles: vec![Role::Free; rows],
            locks: vec![0; rows],
        }
    }

    pub(crate) fn columns(&mut self) -> Columns<'_> {
        Columns {
            lines: &mut self.lines,
            drifts: &mut self.drifts,
            references: &mut self.references,
            rotations: &mut self.rotations,
            starts: &self.starts,
            frames: &self.frames,
            inverse_moments: &self.inverse_moments,
            dampings: &self.dampings,
            roles: &self.roles,
            locks: &self.locks,
        }
    }
}
