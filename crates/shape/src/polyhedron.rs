//! Integrals over the inside of a closed triangle surface, exact up to rounding in double precision.
//!
//! Each triangle spans a tetrahedron with a reference point; signed, these add up to the inside. For corners
//! a, b, c seen from the reference point, with d = a · (b × c) and s = a + b + c (Tonon 2004):
//! volume d / 6, first moments d s / 24, second moments d (aaᵀ + bbᵀ + ccᵀ + ssᵀ) / 120.

use rockfall_math::DVec3;

/// Integrals of 1, x and x xᵀ over a volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    /// m³.
    pub(crate) volume: f64,
    /// Centroid.
    pub(crate) center: DVec3,
    /// Second moments about the centroid: xx, yy, zz, m⁵.
    pub(crate) squares: DVec3,
    /// Second moments about the centroid: yz, zx, xy, m⁵.
    pub(crate) products: DVec3,
}

/// Integrates over the inside of `triangles`, counter-clockwise from outside. The volume is negative where
/// they are clockwise; without volume the centre is the reference point, the first corner.
pub(crate) fn moments(triangles: impl Iterator<Item = [DVec3; 3]>) -> Moments {
    let mut reference = None;
    let (mut volume, mut first) = (0.0, DVec3::ZERO);
    let (mut squares, mut products) = (DVec3::ZERO, DVec3::ZERO);
    for triangle in triangles {
        let o = *reference.get_or_insert(triangle[0]);
        let [a, b, c] = triangle.map(|p| p - o);
        let d = a.dot(b.cross(c));
        let s = a + b + c;
        let turned = |v: DVec3| DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y);
        volume += d;
        first += d * s;
        squares += d * (a * a + b * b + c * c + s * s);
        products += d * (turned(a) + turned(b) + turned(c) + turned(s));
    }
    let o = reference.unwrap_or_default();
    if volume == 0.0 {
        return Moments { volume, center: o, squares: squares / 120.0, products: products / 120.0 };
    }
    let (volume, shift) = (volume / 6.0, first / (4.0 * volume));
    let shifted = volume * DVec3::new(shift.y * shift.z, shift.z * shift.x, shift.x * shift.y);
    Moments {
        volume,
        center: o + shift,
        squares: squares / 120.0 - volume * shift * shift,
        products: products / 120.0 - shifted,
    }
}
