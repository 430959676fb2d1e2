//! Height fields: terrain of immovable bodies.

use crate::{LARGEST, SMALLEST};
use rockfall_math::{Aabb, Vec2, Vec3};
use std::ops::Range;

/// A surface z = h(x, y) over a regular grid of `columns` × `rows` samples centred on the origin. Each cell
/// is two triangles, cut from its corner (i, j) to (i + 1, j + 1). Solid below.
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

/// Why numbers make no height field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// Less than one cell, or more samples on a side than single precision can count.
    #[error("the height field has {columns} x {rows} samples, expected 2 to {MOST_SAMPLES} on a side")]
    Samples {
        /// Samples along x.
        columns: u32,
        /// Samples along y.
        rows: u32,
    },
    /// Not one height per sample.
    #[error("the height field has {found} heights, expected {expected}, one per sample")]
    Count {
        /// Heights given.
        found: usize,
        /// Columns × rows.
        expected: u64,
    },
    /// The spacing is NaN, zero, negative, too small or too large.
    #[error("the spacing of the height field is {} x {} m, expected lengths from 1e-6 m, 1e6 m in all", .0.x, .0.y)]
    Spacing(Vec2),
    /// A height is NaN, infinite or beyond [`LARGEST`].
    #[error("height {index} of the height field is {height}, expected a number from -1e6 to 1e6")]
    Height {
        /// Index of the sample.
        index: usize,
        /// What it was.
        height: f32,
    },
    /// The box of a height field that was put together by hand is not the one around its samples.
    #[error("the box of the height field does not fit its samples")]
    Bounds,
}

/// The most samples on a side of a height field: their numbers are exact in single precision.
pub const MOST_SAMPLES: u32 = 1 << 22;

impl HeightField {
    /// A height field of `columns` × `rows` samples, `spacing` metres apart; the height of sample (i, j) is
    /// `heights[j * columns + i]`, metres.
    ///
    /// # Errors
    /// Less than 2 samples on a side, another number of heights than of samples, sizes and heights that are
    /// not finite or out of range.
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::Vec2;
    /// use rockfall_shape::HeightField;
    ///
    /// let ramp = HeightField::new(3, 2, Vec2::new(2.0, 5.0), vec![0.0, 1.0, 2.0, 0.0, 1.0, 2.0])?;
    /// assert_eq!(ramp.height_at(1.0, -2.0), Some(1.5));
    /// assert_eq!(ramp.height_at(2.1, 0.0), None);
    /// # Ok::<(), rockfall_shape::HeightFieldError>(())
    /// ```
    pub fn new(columns: u32, rows: u32, spacing: Vec2, heights: Vec<f32>) -> Result<Self, HeightFieldError> {
        let mut field = HeightField { columns, rows, spacing, heights, bounds: Aabb::EMPTY };
        field.check_numbers()?;
        field.bounds = field.box_around();
        Ok(field)
    }

    /// Whether all numbers make sense; always so for a field from [`HeightField::new`].
    ///
    /// # Errors
    /// As for [`HeightField::new`].
    pub fn check(&self) -> Result<(), HeightFieldError> {
        self.check_numbers()?;
        if self.bounds == self.box_around() { Ok(()) } else { Err(HeightFieldError::Bounds) }
    }

    fn check_numbers(&self) -> Result<(), HeightFieldError> {
        let HeightField { columns, rows, spacing, .. } = *self;
        let sides = 2..=MOST_SAMPLES;
        if !sides.contains(&columns) || !sides.contains(&rows) {
            return Err(HeightFieldError::Samples { columns, rows });
        }
        let expected = u64::from(columns) * u64::from(rows);
        if self.heights.len() as u64 != expected {
            return Err(HeightFieldError::Count { found: self.heights.len(), expected });
        }
        let fits = |step: f32, samples: u32| step >= SMALLEST && step * (samples - 1) as f32 <= LARGEST;
        if !fits(spacing.x, columns) || !fits(spacing.y, rows) {
            return Err(HeightFieldError::Spacing(spacing));
        }
        match self.heights.iter().position(|h| !(-LARGEST..=LARGEST).contains(h)) {
            Some(index) => Err(HeightFieldError::Height { index, height: self.heights[index] }),
            None => Ok(()),
        }
    }

    fn box_around(&self) -> Aabb {
        Aabb::from_points(self.samples())
    }

    /// The point of the surface at sample (i, j), `i < columns`, `j < rows`.
    pub fn sample(&self, i: u32, j: u32) -> Vec3 {
        let place = |k: u32, samples: u32, step: f32| (k as f32 - 0.5 * (samples - 1) as f32) * step;
        let height = self.heights[j as usize * self.columns as usize + i as usize];
        Vec3::new(place(i, self.columns, self.spacing.x), place(j, self.rows, self.spacing.y), height)
    }

    /// All points of the surface that are samples, row by row.
    pub fn samples(&self) -> impl Iterator<Item = Vec3> {
        (0..self.rows).flat_map(move |j| (0..self.columns).map(move |i| self.sample(i, j)))
    }

    /// The two triangles of cell (i, j), `i < columns - 1`, `j < rows - 1`, counter-clockwise from above:
    /// first the one towards +x, then the one towards +y. Both begin with the corner (i, j), their common
    /// edge ends at (i + 1, j + 1).
    pub fn cell(&self, i: u32, j: u32) -> [[Vec3; 3]; 2] {
        let [a, b] = [self.sample(i, j), self.sample(i + 1, j + 1)];
        [[a, self.sample(i + 1, j), b], [a, b, self.sample(i, j + 1)]]
    }

    /// Which cells, along x and along y, a box overlaps seen from above; touching counts. Both ranges are
    /// empty where it overlaps none. A box that is above or below the surface overlaps cells as well.
    pub fn cells_under(&self, area: &Aabb) -> [Range<u32>; 2] {
        let range = |low: f32, high: f32, samples: u32, step: f32| {
            let cells = samples - 1;
            // Cells from the border of the field; one thousandth more on both sides outweighs the rounding.
            let at = |x: f32| f64::from(x) / f64::from(step) + 0.5 * f64::from(cells);
            let (first, last) = ((at(low) - 1e-3).floor(), (at(high) + 1e-3).floor());
            if !(last >= 0.0 && first < f64::from(cells) && low <= high) {
                return 0..0;
            }
            // A cast saturates at zero.
            first as u32..(last as u32).saturating_add(1).min(cells)
        };
        let x = range(area.min.x, area.max.x, self.columns, self.spacing.x);
        let y = range(area.min.y, area.max.y, self.rows, self.spacing.y);
        if x.is_empty() || y.is_empty() { [0..0, 0..0] } else { [x, y] }
    }

    /// Height of the surface over (x, y), metres; `None` beside the field.
    pub fn height_at(&self, x: f32, y: f32) -> Option<f32> {
        let (height, slope, [u, v]) = self.locate(x, y)?;
        Some((height + slope[0] * u + slope[1] * v) as f32)
    }

    /// Unit normal of the triangle over (x, y), pointing up; `None` beside the field. On an edge that of one
    /// of its triangles.
    pub fn normal_at(&self, x: f32, y: f32) -> Option<Vec3> {
        let (_, slope, _) = self.locate(x, y)?;
        let [dx, dy] = [slope[0] / f64::from(self.spacing.x), slope[1] / f64::from(self.spacing.y)];
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        Some(Vec3::new((-dx / length) as f32, (-dy / length) as f32, (1.0 / length) as f32))
    }

    /// The triangle over (x, y) as height of its cell's first corner and slopes per cell, and the place
    /// within the cell.
    fn locate(&self, x: f32, y: f32) -> Option<(f64, [f64; 2], [f64; 2])> {
        let place = |x: f32, samples: u32, step: f32| {
            let cells = f64::from(samples - 1);
            let u = f64::from(x) / f64::from(step) + 0.5 * cells;
            let cell = u.floor().min(cells - 1.0);
            (0.0..=cells).contains(&u).then_some((cell as u32, u - cell))
        };
        let (i, u) = place(x, self.columns, self.spacing.x)?;
        let (j, v) = place(y, self.rows, self.spacing.y)?;
        let h = |i: u32, j: u32| f64::from(self.heights[j as usize * self.columns as usize + i as usize]);
        let (corner, across) = (h(i, j), h(i + 1, j + 1));
        let slope = if u >= v {
            let side = h(i + 1, j);
            [side - corner, across - side]
        } else {
            let side = h(i, j + 1);
            [across - side, side - corner]
        };
        Some((corner, slope, [u, v]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bumpy() -> HeightField {
        let heights = (0..7 * 5).map(|i| ((i * 37) % 11) as f32 * 0.1).collect();
        HeightField::new(7, 5, Vec2::new(0.5, 2.0), heights).unwrap()
    }

    #[test]
    fn heights_and_normals_lie_on_the_triangles() {
        let field = bumpy();
        for j in 0..4 {
            for i in 0..6 {
                for [a, b, c] in field.cell(i, j) {
                    let normal = (b - a).cross(c - a).normalize();
                    assert!(normal.z > 0.0);
                    for (s, t) in [(0.3, 0.3), (0.1, 0.8), (0.8, 0.1), (0.05, 0.05)] {
                        let p = a + s * (b - a) + t * (c - a);
                        assert!((field.height_at(p.x, p.y).unwrap() - p.z).abs() < 1e-6);
                        assert!((field.normal_at(p.x, p.y).unwrap() - normal).length() < 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn heights_at_samples_are_the_samples() {
        let field = bumpy();
        for p in field.samples() {
            assert_eq!(field.height_at(p.x, p.y), Some(p.z));
        }
        assert_eq!(field.height_at(1.51, 0.0), None);
        assert_eq!(field.height_at(0.0, -4.01), None);
        assert_eq!(field.height_at(f32::NAN, 0.0), None);
    }

    #[test]
    fn the_box_is_around_the_surface() {
        let field = bumpy();
        assert_eq!(field.bounds, Aabb::new(Vec3::new(-1.5, -4.0, 0.0), Vec3::new(1.5, 4.0, 1.0)));
    }

    #[test]
    fn cells_under_a_box_are_all_that_it_overlaps() {
        let field = bumpy();
        for k in 0..2000 {
            let next = |m: u32| ((k * m) % 997) as f32 / 997.0;
            let min = Vec3::new(6.0 * next(31) - 3.0, 12.0 * next(57) - 6.0, 0.0);
            let area = Aabb::new(min, min + Vec3::new(2.0 * next(91), 3.0 * next(13), 1.0));
            let [columns, rows] = field.cells_under(&area);
            for j in 0..4 {
                for i in 0..6 {
                    let (low, high) = (field.sample(i, j), field.sample(i + 1, j + 1));
                    let overlaps = low.x <= area.max.x
                        && high.x >= area.min.x
                        && low.y <= area.max.y
                        && high.y >= area.min.y;
                    let listed = columns.contains(&i) && rows.contains(&j);
                    assert!(listed || !overlaps, "cell ({i}, {j}) is missing");
                    let near = area.grown(0.01);
                    let close = low.x <= near.max.x
                        && high.x >= near.min.x
                        && low.y <= near.max.y
                        && high.y >= near.min.y;
                    assert!(close || !listed, "cell ({i}, {j}) is far away");
                }
            }
        }
        assert_eq!(field.cells_under(&Aabb::EMPTY), [0..0, 0..0]);
        let everything = Aabb::new(Vec3::splat(-1e30), Vec3::splat(1e30));
        assert_eq!(field.cells_under(&everything), [0..6, 0..4]);
    }

    #[test]
    fn numbers_that_make_no_sense_are_refused() {
        let new = |columns, rows, spacing: f32, heights: &[f32]| {
            HeightField::new(columns, rows, Vec2::splat(spacing), heights.to_vec()).unwrap_err().to_string()
        };
        assert_eq!(
            new(1, 2, 1.0, &[0.0; 2]),
            "the height field has 1 x 2 samples, expected 2 to 4194304 on a side"
        );
        assert_eq!(
            new(u32::MAX, u32::MAX, 1.0, &[]),
            "the height field has 4294967295 x 4294967295 samples, expected 2 to 4194304 on a side"
        );
        assert_eq!(new(3, 2, 1.0, &[0.0; 5]), "the height field has 5 heights, expected 6, one per sample");
        for (spacing, text) in
            [(0.0, "0 x 0"), (-1.0, "-1 x -1"), (f32::NAN, "NaN x NaN"), (2e6, "2000000 x 2000000")]
        {
            assert_eq!(
                new(2, 2, spacing, &[0.0; 4]),
                format!(
                    "the spacing of the height field is {text} m, expected lengths from 1e-6 m, 1e6 m in all"
                )
            );
        }
        assert_eq!(
            new(2, 2, 1.0, &[0.0, f32::NAN, 0.0, 0.0]),
            "height 1 of the height field is NaN, expected a number from -1e6 to 1e6"
        );
    }
}
