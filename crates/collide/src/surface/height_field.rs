//! A height field as a surface. Triangles 2 c and 2 c + 1 are the halves of cell c, the first on the side of x.

use super::Surface;
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{EdgeKind, HeightField};

/// Sine of the angle up to which an edge counts as flat: the rounding of heights, seen over one cell.
const FLAT: f32 = 1e-3;

/// Column and row of a cell, and which half.
#[derive(Clone, Copy)]
struct Half {
    i: u32,
    j: u32,
    upper: bool,
}

fn half(field: &HeightField, triangle: u64) -> Half {
    let cells = u64::from(field.columns - 1);
    let cell = triangle / 2;
    Half { i: (cell % cells) as u32, j: (cell / cells) as u32, upper: triangle & 1 == 1 }
}

fn name(field: &HeightField, i: u32, j: u32, upper: bool) -> u64 {
    2 * (u64::from(j) * u64::from(field.columns - 1) + u64::from(i)) + u64::from(upper)
}

fn upright([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize()
}

impl Surface for HeightField {
    const BOTTOMLESS: bool = true;

    fn near(&self, area: &Aabb, mut f: impl FnMut(u64)) {
        let [columns, rows] = self.cells_under(area);
        for j in rows {
            for i in columns.clone() {
                for (half, corners) in self.cell(i, j).iter().enumerate() {
                    if corners.iter().any(|c| c.z >= area.min.z) {
                        f(name(self, i, j, half == 1));
                    }
                }
            }
        }
    }

    fn corners(&self, triangle: u64) -> [Vec3; 3] {
        let Half { i, j, upper } = half(self, triangle);
        self.cell(i, j)[usize::from(upper)]
    }

    fn ids(&self, triangle: u64) -> [u64; 3] {
        let Half { i, j, upper } = half(self, triangle);
        let sample = |i: u32, j: u32| u64::from(j) * u64::from(self.columns) + u64::from(i);
        let third = if upper { sample(i, j + 1) } else { sample(i + 1, j) };
        let [first, across] = [sample(i, j), sample(i + 1, j + 1)];
        if upper { [first, across, third] } else { [first, third, across] }
    }

    fn normal(&self, triangle: u64) -> Vec3 {
        upright(&self.corners(triangle))
    }

    fn beyond(&self, triangle: u64, edge: usize, corners: &[Vec3; 3], normal: Vec3) -> (EdgeKind, Vec3) {
        let Some(other) = self.neighbour(triangle, edge) else {
            return (EdgeKind::Boundary, normal);
        };
        // The corner of the other triangle that is not on the edge.
        let far = if triangle & 1 == 0 { [0, 1, 2][edge] } else { [1, 2, 0][edge] };
        let theirs = self.corners(other);
        let way = theirs[far] - corners[edge];
        let (rise, flat) = (normal.dot(way), FLAT * way.length());
        let kind = if rise > flat {
            EdgeKind::Concave
        } else if rise < -flat {
            EdgeKind::Convex
        } else {
            EdgeKind::Flat
        };
        (kind, upright(&theirs))
    }

    fn neighbour(&self, triangle: u64, edge: usize) -> Option<u64> {
        let Half { i, j, upper } = half(self, triangle);
        let (i, j, upper) = match (upper, edge) {
            (false, 0) => (Some(i), j.checked_sub(1), true),
            (false, 1) => (Some(i + 1), Some(j), true),
            (false, _) => (Some(i), Some(j), true),
            (true, 0) => (Some(i), Some(j), false),
            (true, 1) => (Some(i), Some(j + 1), false),
            (true, _) => (i.checked_sub(1), Some(j), false),
        };
        let i = i.filter(|&i| i < self.columns - 1)?;
        let j = j.filter(|&j| j < self.rows - 1)?;
        Some(name(self, i, j, upper))
    }

    fn inside(&self) -> Option<(f32, f32)> {
        None
    }

    fn is_outside(&self, point: Vec3) -> bool {
        self.height_at(point.x, point.y).is_none_or(|height| point.z > height)
    }

    fn cover(&self, point: Vec3) -> Option<u64> {
        let area = Aabb::new(point, point);
        let [columns, rows] = self.cells_under(&area);
        // Next to a border there are two, of which either will do.
        let (i, j) = (columns.start, rows.start);
        if columns.is_empty() {
            return None;
        }
        let place = (point - self.sample(i, j)).truncate() / self.spacing;
        Some(name(self, i, j, place.y > place.x))
    }
}
