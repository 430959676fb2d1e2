//! A height field as a surface. Triangles 2 c and 2 c + 1 are the halves of cell c, the first on the side of x.

use super::Surface;
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{EdgeKind, HeightField};

/// Sine of the angle up to which an edge counts as flat: the rounding of heights, seen over one cell.
const FLAT: f32 = 2e-3;

/// Column and row of a cell, and which half.
#[derive(Clone, Copy)]
struct Half {
    i: u32,
    j: u32,
    upper: bool,
}

fn half(field: &HeightField, triangle: u32) -> Half {
    let cells = field.columns - 1;
    let cell = triangle / 2;
    Half { i: cell % cells, j: cell / cells, upper: triangle % 2 == 1 }
}

fn samples(field: &HeightField, triangle: u32) -> [(u32, u32); 3] {
    let Half { i, j, upper } = half(field, triangle);
    if upper { [(i, j), (i + 1, j + 1), (i, j + 1)] } else { [(i, j), (i + 1, j), (i + 1, j + 1)] }
}

fn sample(field: &HeightField, (i, j): (u32, u32)) -> Vec3 {
    Vec3::new(
        (i as f32 - 0.5 * (field.columns - 1) as f32) * field.spacing.x,
        (j as f32 - 0.5 * (field.rows - 1) as f32) * field.spacing.y,
        field.heights[j as usize * field.columns as usize + i as usize],
    )
}

/// Column and row, not whole, of a place over the field.
fn place(field: &HeightField, x: f32, y: f32) -> (f32, f32) {
    (
        x / field.spacing.x + 0.5 * (field.columns - 1) as f32,
        y / field.spacing.y + 0.5 * (field.rows - 1) as f32,
    )
}

impl Surface for HeightField {
    const BOTTOMLESS: bool = true;

    fn near(&self, area: &Aabb, mut f: impl FnMut(u32)) {
        let (low, high) = (place(self, area.min.x, area.min.y), place(self, area.max.x, area.max.y));
        let range = |low: f32, high: f32, cells: u32| {
            // A sample on the border of two cells belongs to both.
            let first = ((low.next_down().floor()).max(0.0) as u32).min(cells);
            let last = if high < 0.0 { 0 } else { (high.next_up().floor() as u32).saturating_add(1).min(cells) };
            first..last
        };
        for j in range(low.1, high.1, self.rows - 1) {
            for i in range(low.0, high.0, self.columns - 1) {
                for upper in 0..2 {
                    let triangle = 2 * (j * (self.columns - 1) + i) + upper;
                    let top = self.corners(triangle).iter().fold(f32::NEG_INFINITY, |z, c| z.max(c.z));
                    if top >= area.min.z {
                        f(triangle);
                    }
                }
            }
        }
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        samples(self, triangle).map(|s| sample(self, s))
    }

    fn ids(&self, triangle: u32) -> [u32; 3] {
        samples(self, triangle).map(|(i, j)| j * self.columns + i)
    }

    fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize()
    }

    fn kind(&self, triangle: u32, edge: usize) -> EdgeKind {
        let Some(other) = self.neighbour(triangle, edge) else {
            return EdgeKind::Boundary;
        };
        let (mine, theirs) = (self.corners(triangle), self.corners(other));
        let ids = self.ids(triangle);
        let far = (0..3).find(|&k| !ids.contains(&self.ids(other)[k])).map_or(mine[0], |k| theirs[k]);
        let rise = self.normal(triangle).dot(far - mine[edge]);
        let reach = (far - mine[edge]).length();
        if rise > FLAT * reach {
            EdgeKind::Concave
        } else if rise < -FLAT * reach {
            EdgeKind::Convex
        } else {
            EdgeKind::Flat
        }
    }

    fn neighbour(&self, triangle: u32, edge: usize) -> Option<u32> {
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
        Some(2 * (j * (self.columns - 1) + i) + u32::from(upper))
    }

    fn cover(&self, point: Vec3) -> Option<u32> {
        let (x, y) = place(self, point.x, point.y);
        if !(x >= 0.0 && y >= 0.0 && x < (self.columns - 1) as f32 && y < (self.rows - 1) as f32) {
            return None;
        }
        let (i, j) = (x as u32, y as u32);
        let upper = y - j as f32 > x - i as f32;
        Some(2 * (j * (self.columns - 1) + i) + u32::from(upper))
    }
}
