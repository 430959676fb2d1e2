//! Where a body is in the world.

use crate::{Isometry, rotation};
use glam::{DVec3, Mat3, Quat, Vec3};

/// A place in the world: position in double precision, so that a pile ten kilometres from the origin behaves
/// as one at the origin, and a unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres.
    pub position: DVec3,
    /// Unit quaternion, body to world.
    pub rotation: Quat,
}

impl Default for Pose {
    fn default() -> Self {
        Pose { position: DVec3::ZERO, rotation: Quat::IDENTITY }
    }
}

impl Pose {
    /// At `position`, not rotated.
    pub fn at(position: DVec3) -> Self {
        Pose { position, rotation: Quat::IDENTITY }
    }

    /// Maps a point of the body to the world.
    pub fn point(&self, local: Vec3) -> DVec3 {
        self.position + rotation::rotate(self.rotation, local).as_dvec3()
    }

    /// Maps a point of the world to the body.
    pub fn inverse_point(&self, world: DVec3) -> Vec3 {
        rotation::rotate_back(self.rotation, (world - self.position).as_vec3())
    }

    /// This pose in a frame that is not rotated and has its origin at `origin`.
    pub fn isometry_from(&self, origin: DVec3) -> Isometry {
        Isometry { rotation: Mat3::from_quat(self.rotation), translation: (self.position - origin).as_vec3() }
    }

    /// `other` seen from this body. The difference of the positions is taken in double precision.
    pub fn see(&self, other: &Pose) -> Isometry {
        let back = Mat3::from_quat(self.rotation).transpose();
        Isometry {
            rotation: back * Mat3::from_quat(other.rotation),
            translation: back * (other.position - self.position).as_vec3(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seen_far_from_the_origin_as_near_it() {
        let q = Quat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize();
        let far = DVec3::new(1.0e7, -1.0e7, 3.0e6);
        let pair = |o: DVec3| {
            let a = Pose { position: o, rotation: q };
            let b = Pose { position: o + DVec3::new(0.25, 0.5, -0.125), rotation: Quat::IDENTITY };
            a.see(&b)
        };
        assert_eq!(pair(DVec3::ZERO), pair(far));
    }
}
