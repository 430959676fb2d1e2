//! A half-space against anything convex: heights of support points.

use crate::closest::Closest;
use crate::feature;
use crate::poly::Poly;
use crate::reduce::reduce;
use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};
use smallvec::SmallVec;

/// All points p with `normal · p ≤ offset`.
#[derive(Clone, Copy)]
pub(crate) struct HalfSpace {
    pub(crate) normal: Vec3,
    pub(crate) offset: f32,
}

impl HalfSpace {
    /// The nearest of the points `cores`, given in B's frame, each with a skin of `radius`.
    pub(crate) fn closest(&self, cores: &[Vec3], radius: f32, b_in_a: &Isometry) -> Closest {
        let mut best = (0, f32::INFINITY, Vec3::ZERO);
        for (i, &core) in cores.iter().enumerate() {
            let p = b_in_a.point(core);
            let height = self.normal.dot(p) - self.offset;
            if height < best.1 {
                best = (i, height, p);
            }
        }
        let (i, height, p) = best;
        let on_a = p - height * self.normal;
        Closest { distance: height, normal: self.normal, on_a, on_b: p, feature: feature::pair(0, i) }
            .with_skins(0.0, radius)
    }

    /// The points `cores`, each with a skin of `radius`, that come within `margin`, or how far away the nearest is.
    pub(crate) fn manifold(
        &self,
        cores: &[Vec3],
        radius: f32,
        b_in_a: &Isometry,
        margin: f32,
    ) -> Result<Manifold, f32> {
        let mut points: SmallVec<[ContactPoint; 16]> = SmallVec::new();
        let mut least = f32::INFINITY;
        for (i, &core) in cores.iter().enumerate() {
            let p = b_in_a.point(core);
            let distance = self.normal.dot(p) - self.offset - radius;
            least = least.min(distance);
            if distance <= margin {
                let position = p - (radius + 0.5 * distance) * self.normal;
                points.push(ContactPoint { position, distance, feature: feature::pair(0, i) });
            }
        }
        if points.is_empty() { Err(least) } else { Ok(reduce(self.normal, &points)) }
    }

    /// The corners of a polyhedron that come within `margin`, or how far away the nearest is.
    pub(crate) fn poly_manifold(&self, b: &Poly, b_in_a: &Isometry, margin: f32) -> Result<Manifold, f32> {
        self.manifold(b.vertices, 0.0, b_in_a, margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poly::BoxPoly;

    const GROUND: HalfSpace = HalfSpace { normal: Vec3::Z, offset: 1.0 };

    #[test]
    fn a_box_stands_on_four_corners() {
        let cuboid = BoxPoly::new(Vec3::splat(0.5));
        let pose = Isometry { translation: Vec3::new(0.0, 0.0, 1.375), ..Isometry::IDENTITY };
        let m = GROUND.poly_manifold(&cuboid.poly(), &pose, 0.01).unwrap();
        assert_eq!((m.count, m.normal), (4, Vec3::Z));
        for p in m.points() {
            assert_eq!((p.distance, p.position.z), (-0.125, 0.9375));
        }
    }

    #[test]
    fn a_sphere_touches_below_its_centre() {
        let pose = Isometry { translation: Vec3::new(3.0, 4.0, 2.5), ..Isometry::IDENTITY };
        let m = GROUND.manifold(&[Vec3::ZERO], 1.0, &pose, 1.0).unwrap();
        assert_eq!(m.points[0].position, Vec3::new(3.0, 4.0, 1.25));
        assert_eq!(m.points[0].distance, 0.5);
        assert_eq!(GROUND.manifold(&[Vec3::ZERO], 1.0, &pose, 0.4), Err(0.5));
    }
}
