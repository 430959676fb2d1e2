//! A rotation and a translation in single precision: one body seen from another.

use glam::{Mat3, Vec3};

/// Maps a point `x` of one frame to `rotation * x + translation` in another. Between two bodies that are
/// near each other single precision is enough; see [`Pose`](crate::Pose) for places in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isometry {
    /// Orthonormal, right-handed.
    pub rotation: Mat3,
    /// Metres.
    pub translation: Vec3,
}

impl Isometry {
    /// The map that changes nothing.
    pub const IDENTITY: Isometry = Isometry { rotation: Mat3::IDENTITY, translation: Vec3::ZERO };

    /// Maps a point.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// Maps a direction.
    #[inline]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    /// Maps a point back.
    #[inline]
    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.inverse_vector(p - self.translation)
    }

    /// Maps a direction back.
    #[inline]
    pub fn inverse_vector(&self, v: Vec3) -> Vec3 {
        let r = &self.rotation;
        Vec3::new(r.x_axis.dot(v), r.y_axis.dot(v), r.z_axis.dot(v))
    }

    /// The opposite map.
    #[inline]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Isometry { rotation, translation: -(rotation * self.translation) }
    }

    /// First `other`, then `self`.
    #[inline]
    pub fn then_after(&self, other: &Isometry) -> Self {
        Isometry { rotation: self.rotation * other.rotation, translation: self.point(other.translation) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes() {
        let m = Isometry {
            rotation: Mat3::from_quat(glam::Quat::from_xyzw(0.3, -0.2, 0.5, 0.7).normalize()),
            translation: Vec3::new(1.0, -2.0, 3.0),
        };
        let p = Vec3::new(0.4, 5.0, -1.0);
        assert!((m.inverse_point(m.point(p)) - p).length() < 1e-5);
        assert!((m.inverse().point(m.point(p)) - p).length() < 1e-5);
        assert!((m.then_after(&m.inverse()).point(p) - p).length() < 1e-5);
    }
}
