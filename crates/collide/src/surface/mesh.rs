//! A mesh as a surface.

use super::Surface;
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{EdgeKind, Mesh};

impl Surface for Mesh {
    const BOTTOMLESS: bool = false;

    fn near(&self, area: &Aabb, f: impl FnMut(u32)) {
        self.tree.query(area, f);
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.vertices[v as usize])
    }

    fn ids(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize]
    }

    fn normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    fn kind(&self, triangle: u32, edge: usize) -> EdgeKind {
        self.edges[triangle as usize][edge]
    }

    fn neighbour(&self, triangle: u32, edge: usize) -> Option<u32> {
        let other = self.neighbours[triangle as usize][edge];
        (other != u32::MAX).then_some(other)
    }

    fn cover(&self, _point: Vec3) -> Option<u32> {
        None
    }
}
