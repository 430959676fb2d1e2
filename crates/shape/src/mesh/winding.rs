//! How often a closed surface goes around a point.
//!
//! The generalised winding number of Jacobson, Kavan and Sorkine-Hornung ("Robust Inside-Outside Segmentation using Generalized Winding Numbers", ACM Transactions on Graphics 32(4), 2013)
//! is a whole number for a closed surface, and then a count along a ray: one more for each triangle that it leaves through, one less for each that it enters by.

use super::Mesh;
use rockfall_math::{Aabb, DVec3, Vec3};

/// Directions of rays, of which no regular body has an edge in the way; the first that meets none counts.
const RAYS: [Vec3; 3] =
    [Vec3::new(0.577, 0.211, 0.789), Vec3::new(-0.319, 0.887, 0.334), Vec3::new(0.137, -0.485, -0.864)];

impl Mesh {
    /// How often the surface, if it is closed, goes around a point that is not on it: 1 inside of a solid body and 0 outside; more where parts of the surface lie within each other, less where
    /// they are inside out. Nothing where each of three rays meets an edge or a corner.
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::{DVec3, Vec3};
    /// use rockfall_shape::Mesh;
    ///
    /// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    /// let mesh = Mesh::from_triangles(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// assert_eq!(mesh.winding(DVec3::splat(0.1)), Some(1));
    /// assert_eq!(mesh.winding(DVec3::splat(-0.1)), Some(0));
    /// # Ok::<(), rockfall_shape::MeshError>(())
    /// ```
    pub fn winding(&self, p: DVec3) -> Option<i32> {
        RAYS.iter().find_map(|&ray| self.winding_along(p, ray))
    }

    fn winding_along(&self, p: DVec3, direction: Vec3) -> Option<i32> {
        let (ray, mut count, mut grazes) = (direction.as_dvec3(), 0, false);
        self.tree.cast_box(&Aabb::around(p, p), direction, f32::INFINITY, |t, max| {
            let [a, b, c] = self.triangle(t as usize).map(|corner| corner.as_dvec3() - p);
            // On which side of each edge the ray passes: of an edge seen from the other triangle that is the same number with the other sign, to the last bit.
            let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|edge| edge.dot(ray));
            let all = |side: fn(&f64) -> bool| sides.iter().all(side);
            if all(|s| *s > 0.0) || all(|s| *s < 0.0) {
                // Ahead of the point, not behind it.
                let (volume, along) = (a.dot(b.cross(c)), sides.iter().sum::<f64>());
                if (volume > 0.0) == (along > 0.0) {
                    count += if along > 0.0 { 1 } else { -1 };
                }
            } else if all(|s| *s >= 0.0) || all(|s| *s <= 0.0) {
                grazes = true;
            }
            max
        });
        (!grazes).then_some(count)
    }
}
