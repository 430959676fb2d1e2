//! A ray on meshes and height fields.

use super::triangle::Sheared;
use super::{Ray, RayHit};
use crate::surface::Surface;
use rockfall_math::{Aabb, DVec3};
use rockfall_shape::{HeightField, Mesh};

/// The first of the triangles that were asked; of several at one place the one with the lowest number.
struct First<'a, S> {
    surface: &'a S,
    sheared: Sheared,
    t: f64,
    triangle: Option<u64>,
}

impl<'a, S: Surface> First<'a, S> {
    fn new(surface: &'a S, ray: &Ray) -> Self {
        First { surface, sheared: Sheared::new(ray), t: ray.max, triangle: None }
    }

    fn ask(&mut self, triangle: u64) {
        let Some(t) = self.sheared.meets(&self.surface.corners(triangle)) else { return };
        let nearer = t < self.t || (t == self.t && self.triangle.is_none_or(|known| triangle < known));
        if nearer && t >= 0.0 {
            (self.t, self.triangle) = (t, Some(triangle));
        }
    }

    fn hit(self) -> Option<RayHit> {
        let part = self.triangle?;
        Some(RayHit { t: self.t, normal: self.surface.normal(part), part })
    }
}

pub(super) fn mesh(mesh: &Mesh, ray: &Ray) -> Option<RayHit> {
    let mut first = First::new(mesh, ray);
    let origin = Aabb::around(ray.origin, ray.origin);
    // Single precision has no direction that is very short or long.
    let scale = ray.direction.abs().max_element();
    mesh.tree.cast_box(&origin, (ray.direction / scale).as_vec3(), up(ray.max * scale), |triangle, _| {
        first.ask(u64::from(triangle));
        up(first.t * scale)
    });
    first.hit()
}

/// In single precision, not less.
fn up(x: f64) -> f32 {
    let single = x as f32;
    if f64::from(single) < x { single.next_up() } else { single }
}

/// How much wider than it is a cell is taken, in cells: what outweighs the rounding of samples' places, as in [`HeightField::cells_under`].
const BORDER: f64 = 1e-3;

/// Column by column of cells, along the axis on which the ray passes more of them; in each the few cells above or below its stretch there.
pub(super) fn height_field(field: &HeightField, ray: &Ray) -> Option<RayHit> {
    let [mut from, mut until] = within(&field.bounds, ray)?;
    let cells = [field.columns - 1, field.rows - 1];
    let steps = [field.spacing.x, field.spacing.y].map(f64::from);
    // Place and speed in cells, counted from the border.
    let place = [0, 1].map(|k| ray.origin[k] / steps[k] + 0.5 * f64::from(cells[k]));
    let speed = [0, 1].map(|k| ray.direction[k] / steps[k]);
    let along = usize::from(speed[0].abs() < speed[1].abs());
    let across = 1 - along;
    let range = |axis: usize, from: f64, until: f64| {
        let ends = [from, until].map(|t| place[axis] + t * speed[axis]);
        let last = f64::from(cells[axis]) - 1.0;
        let cell = |x: f64| x.floor().clamp(0.0, last) as u32;
        cell(ends[0].min(ends[1]) - BORDER)..=cell(ends[0].max(ends[1]) + BORDER)
    };
    // A ray from far away: where it is to be looked for is known to the rounding of its ends only.
    let slack = 1e-12 * (from.abs() + until.abs());
    (from, until) = (from - slack, until + slack);
    let mut first = First::new(field, ray);
    let columns = range(along, from, until);
    let (low, high) = (*columns.start(), *columns.end());
    for k in 0..=high - low {
        let column = if speed[along] < 0.0 { high - k } else { low + k };
        let (mut enter, mut exit) = (from, until);
        if speed[along] != 0.0 {
            let ends = [-BORDER, 1.0 + BORDER].map(|x| (f64::from(column) + x - place[along]) / speed[along]);
            (enter, exit) = (from.max(ends[0].min(ends[1])), until.min(ends[0].max(ends[1])));
        }
        if enter > first.t {
            break;
        }
        if enter > exit {
            continue;
        }
        let heights = [enter, exit].map(|t| ray.origin.z + t * ray.direction.z);
        for row in range(across, enter, exit) {
            let (i, j) = if along == 0 { (column, row) } else { (row, column) };
            if passes(field, i, j, heights) {
                let cell = 2 * (u64::from(j) * u64::from(cells[0]) + u64::from(i));
                first.ask(cell);
                first.ask(cell + 1);
            }
        }
    }
    first.hit()
}

/// Whether a ray between two heights may meet cell (i, j).
fn passes(field: &HeightField, i: u32, j: u32, heights: [f64; 2]) -> bool {
    let at = |i: u32, j: u32| f64::from(field.heights[j as usize * field.columns as usize + i as usize]);
    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
    let (low, high) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
    let slack = 1e-9 * (low.abs() + high.abs() + heights[0].abs() + heights[1].abs());
    heights[0].min(heights[1]) <= high + slack && heights[0].max(heights[1]) >= low - slack
}

/// The part of a ray in a box that is a little larger than `area`.
fn within(area: &Aabb, ray: &Ray) -> Option<[f64; 2]> {
    let (min, max) = (area.min.as_dvec3(), area.max.as_dvec3());
    let slack = DVec3::splat(1e-6 * (max - min).max_element()) + 1e-12 * ray.origin.abs();
    let (low, high) = (min - slack - ray.origin, max + slack - ray.origin);
    let [mut from, mut until] = [0.0, ray.max];
    for axis in 0..3 {
        let d = ray.direction[axis];
        if d == 0.0 {
            if low[axis] > 0.0 || high[axis] < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (low[axis] / d, high[axis] / d);
        (from, until) = (f64::max(from, a.min(b)), f64::min(until, a.max(b)));
    }
    (from <= until && until < f64::INFINITY).then_some([from, until])
}
