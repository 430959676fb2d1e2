//! A ray and a triangle, without a gap between triangles that share an edge.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", Journal of Computer Graphics Techniques 2(1), 2013. The
//! ray is sheared onto an axis; whether it passes a triangle's edge on the left or on the right then hangs on the edge's two corners
//! alone, and is computed from the same two products, only with the other sign, for the triangle beyond. So of two triangles with
//! an edge in common one at least is met. What the paper does in single precision, and in double where a product is zero, is in double here
//! from the start.

use super::Ray;
use rockfall_math::{DVec3, Vec3};

/// A ray, ready for many triangles.
pub(super) struct Sheared {
    origin: DVec3,
    /// The two lesser axes of the direction, and the greatest.
    axes: [usize; 3],
    /// By which the lesser ones lean per length of the greatest, and t per length of it.
    slopes: [f64; 3],
}

impl Sheared {
    pub(super) fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        let along = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let [x, y, z] = axes.map(|axis| ray.direction[axis]);
        Sheared { origin: ray.origin, axes, slopes: [x / z, y / z, 1.0 / z] }
    }

    /// Where the whole line meets a triangle, seen from either side.
    #[inline]
    pub(super) fn meets(&self, corners: &[Vec3; 3]) -> Option<f64> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners.map(|corner| {
            let p = corner.as_dvec3() - self.origin;
            let [x, y, z] = self.axes.map(|axis| p[axis]);
            [x - self.slopes[0] * z, y - self.slopes[1] * z, self.slopes[2] * z]
        });
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        // From the side a triangle is a line.
        (sum != 0.0).then(|| (u * az + v * bz + w * cz) / sum)
    }
}
