//! The nearest points of two shapes, or those of least penetration.

use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};

/// Along a shorter way than this, in metres, there is no direction: its square is less than single precision holds exactly.
pub(crate) const CONCENTRIC: f32 = 1e-18;

/// Signed distance of two shapes and where it is taken, in the frame of shape A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Metres. Negative where the shapes overlap: then the length of the shortest translation that parts them.
    pub distance: f32,
    /// Unit vector from A to B.
    pub normal: Vec3,
    /// On the surface of A.
    pub on_a: Vec3,
    /// On the surface of B: `on_a + distance * normal`.
    pub on_b: Vec3,
}

/// A [`Distance`] with a name for its features.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest {
    pub(crate) distance: f32,
    pub(crate) normal: Vec3,
    pub(crate) on_a: Vec3,
    pub(crate) on_b: Vec3,
    pub(crate) feature: u32,
}

impl Closest {
    /// The same for shapes with skins of these thicknesses around them, metres.
    pub(crate) fn with_skins(self, of_a: f32, of_b: f32) -> Self {
        Closest {
            distance: self.distance - (of_a + of_b),
            on_a: self.on_a + of_a * self.normal,
            on_b: self.on_b - of_b * self.normal,
            ..self
        }
    }

    /// As a contact point.
    pub(crate) fn point(&self) -> ContactPoint {
        ContactPoint {
            position: 0.5 * (self.on_a + self.on_b),
            distance: self.distance,
            feature: self.feature,
        }
    }

    /// As a manifold of one point.
    pub(crate) fn manifold(&self) -> Manifold {
        let mut manifold = Manifold { normal: self.normal, count: 1, ..Manifold::default() };
        manifold.points[0] = self.point();
        manifold
    }

    /// Seen from the frame of the other shape, which becomes A; `b_in_a` places the frame of this one in that.
    pub(crate) fn swapped(&self, b_in_a: &Isometry) -> Self {
        Closest {
            normal: -b_in_a.vector(self.normal),
            on_a: b_in_a.point(self.on_b),
            on_b: b_in_a.point(self.on_a),
            ..*self
        }
    }
}

impl From<Closest> for Distance {
    fn from(c: Closest) -> Self {
        Distance { distance: c.distance, normal: c.normal, on_a: c.on_a, on_b: c.on_b }
    }
}
