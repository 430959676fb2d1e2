//! A mesh as a surface.

use super::Surface;
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{EdgeKind, Mesh};

/// Share of the size of a mesh by which a point may seem to be on the wrong side of it.
const ROUNDING: f32 = 1e-5;

impl Surface for Mesh {
    const BOTTOMLESS: bool = false;

    fn near(&self, area: &Aabb, mut f: impl FnMut(u64)) {
        self.tree.query(area, |triangle| f(u64::from(triangle)));
    }

    fn corners(&self, triangle: u64) -> [Vec3; 3] {
        self.triangle(triangle as usize)
    }

    fn ids(&self, triangle: u64) -> [u64; 3] {
        self.triangles[triangle as usize].map(u64::from)
    }

    fn normal(&self, triangle: u64) -> Vec3 {
        self.normals[triangle as usize]
    }

    fn beyond(&self, triangle: u64, edge: usize, _corners: &[Vec3; 3], normal: Vec3) -> (EdgeKind, Vec3) {
        let other = self.neighbour(triangle, edge);
        (self.edges[triangle as usize][edge], other.map_or(normal, |other| self.normal(other)))
    }

    fn neighbour(&self, triangle: u64, edge: usize) -> Option<u64> {
        let other = self.neighbours[triangle as usize][edge];
        (other != u32::MAX).then_some(u64::from(other))
    }

    fn cover(&self, _point: Vec3) -> Option<u64> {
        None
    }

    fn inside(&self) -> Option<(f32, f32)> {
        self.closed.then(|| (self.inner_ball.1, 2.0 * self.bounds.half_extents().length()))
    }

    fn is_outside(&self, point: Vec3) -> bool {
        let slack = f64::from(ROUNDING * self.bounds.half_extents().length());
        self.nearest(point.as_dvec3(), f64::INFINITY).is_some_and(|near| near.distance > slack)
    }
}
