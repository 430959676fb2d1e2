//! Linear maps with a place, in double precision, and what of them a rigid body can have.

use rockfall_math::{DMat3, DQuat, DVec3};

/// Maps a point `x` to `linear * x + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    pub(crate) linear: DMat3,
    pub(crate) translation: DVec3,
}

/// A place and a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) position: DVec3,
    /// Unit length.
    pub(crate) rotation: DQuat,
}

impl Affine {
    pub(crate) const IDENTITY: Affine = Affine { linear: DMat3::IDENTITY, translation: DVec3::ZERO };

    pub(crate) fn linear(linear: DMat3) -> Self {
        Affine { linear, translation: DVec3::ZERO }
    }

    pub(crate) fn translation(translation: DVec3) -> Self {
        Affine { linear: DMat3::IDENTITY, translation }
    }

    /// A quaternion of any length but zero, which is no rotation.
    pub(crate) fn rotation(q: DQuat) -> Self {
        Affine::linear(DMat3::from_quat(unit(q)))
    }

    /// First `inner`, then this.
    pub(crate) fn after(&self, inner: &Affine) -> Affine {
        Affine { linear: self.linear * inner.linear, translation: self.point(inner.translation) }
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.translation
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.translation.is_finite()
    }

    /// The map backwards; none where it makes things flat.
    pub(crate) fn inverse(&self) -> Option<Affine> {
        let linear = self.linear.inverse();
        let inverse = Affine { linear, translation: -(linear * self.translation) };
        (self.linear.determinant() != 0.0 && inverse.is_finite()).then_some(inverse)
    }

    /// The frame of a body whose axes the map stretches: where the origin goes, and the rotation that is left when the images
    /// of the axes are made orthonormal in the order x, y, z (Gram and Schmidt; mirrored in z where the map mirrors). None where the map makes
    /// things flat.
    pub(crate) fn frame(&self) -> Option<Frame> {
        let x = self.linear.x_axis.try_normalize()?;
        let y = (self.linear.y_axis - x * x.dot(self.linear.y_axis)).try_normalize()?;
        let z = x.cross(y);
        if z.dot(self.linear.z_axis) == 0.0 {
            return None;
        }
        let rotation = settle(DQuat::from_mat3(&DMat3::from_cols(x, y, z)));
        self.is_finite().then_some(Frame { position: self.translation, rotation })
    }
}

impl Frame {
    pub(crate) const IDENTITY: Frame = Frame { position: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// First `inner`, then this.
    pub(crate) fn after(&self, inner: &Frame) -> Frame {
        let rotation = DMat3::from_quat(self.rotation);
        Frame {
            position: rotation * inner.position + self.position,
            rotation: unit(self.rotation * inner.rotation),
        }
    }

    /// A map seen from this frame, numbers that rounding has left beside simple ones put right, so that bodies which are turned are made of the same
    /// shapes as those that are not.
    pub(crate) fn see(&self, map: &Affine) -> Affine {
        let back = DMat3::from_quat(self.rotation).transpose();
        let linear = back * map.linear;
        let translation = back * (map.translation - self.position);
        let size = linear.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let far = translation.abs().max_element().max(size);
        Affine {
            linear: DMat3::from_cols_array(&linear.to_cols_array().map(|x| snap(x, size))),
            translation: DVec3::from_array(translation.to_array().map(|x| snap(x, far))),
        }
    }

    pub(crate) fn turn(&self, v: DVec3) -> DVec3 {
        DMat3::from_quat(self.rotation) * v
    }
}

/// A quaternion at unit length; no rotation where it has none.
pub(crate) fn unit(q: DQuat) -> DQuat {
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if length > 0.0 && length.is_finite() {
        DQuat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length)
    } else {
        DQuat::IDENTITY
    }
}

/// A unit quaternion with w not negative, whose numbers next to 0 are 0.
pub(crate) fn settle(q: DQuat) -> DQuat {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    unit(DQuat::from_array(q.to_array().map(|x| if x.abs() < 1e-12 { 0.0 } else { sign * x })))
}

/// A number on a grid whose lines are some 10⁻¹¹ of `size` apart: far below what single precision tells apart, far above the
/// rounding of a few products.
fn snap(x: f64, size: f64) -> f64 {
    if !(size > 0.0 && size.is_finite()) {
        return x;
    }
    let (_, exponent) = libm::frexp(size);
    let step = libm::ldexp(1.0, exponent - 36);
    (x / step).round() * step + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_and_stretched_body_sees_its_own_scale() {
        let turn = Affine::rotation(DQuat::from_xyzw(0.3, -0.2, 0.5, 0.7));
        let place = Affine::translation(DVec3::new(1.0, 2.0, 3.0)).after(&turn);
        let map = place.after(&Affine::linear(DMat3::from_diagonal(DVec3::new(2.0, 3.0, 0.1))));
        let frame = map.frame().unwrap();
        assert_eq!(frame.position, DVec3::new(1.0, 2.0, 3.0));
        let seen = frame.see(&map);
        assert_eq!(seen, Affine::linear(DMat3::from_diagonal(DVec3::new(2.0, 3.0, 0.1))).snapped());
    }

    impl Affine {
        fn snapped(self) -> Affine {
            Frame::IDENTITY.see(&self)
        }
    }

    #[test]
    fn what_makes_things_flat_has_no_frame() {
        assert_eq!(Affine::linear(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0))).frame(), None);
        assert_eq!(Affine::linear(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0))).frame(), None);
        assert_eq!(Affine::linear(DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0))).frame(), None);
    }

    #[test]
    fn a_mirror_turns_nothing() {
        let map = Affine::linear(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -2.0)));
        assert_eq!(map.frame().unwrap().rotation, DQuat::IDENTITY);
    }
}
