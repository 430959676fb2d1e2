//! Height fields: terrain of immovable bodies.

use rockfall_math::{Aabb, Vec2};

/// A surface z = h(x, y) over a regular grid of `columns` × `rows` samples centred on the origin. Each cell is two
/// triangles, cut from its corner (i, j) to (i + 1, j + 1). Solid below.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Samples along x, at least 2.
    pub columns: u32,
    /// Samples along y, at least 2.
    pub rows: u32,
    /// Distance between samples along x and y, metres.
    pub spacing: Vec2,
    /// Heights, metres; sample (i, j) is at `heights[j * columns + i]`.
    pub heights: Vec<f32>,
    /// Box around the surface.
    pub bounds: Aabb,
}
