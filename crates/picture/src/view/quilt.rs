//! A height field as patches under a tree, so that a ray looks only at those that it comes near.
//!
//! The engine's ray cast walks over all columns of cells between a ray's ends, which is a few for the rays of a simulation and hundreds for those of a
//! picture. Here it is asked for the stretch of a ray in the box of a patch.

use rockfall_collide::{Ray, RayHit, cast_ray};
use rockfall_math::{Aabb, DVec3};
use rockfall_shape::{HeightField, Shape};
use rockfall_tree::Tree;

/// Cells along each side of a patch.
const SIDE: u32 = 4;

/// Patches of a height field.
pub(super) struct Quilt {
    tree: Tree,
    boxes: Vec<Aabb>,
}

impl Quilt {
    pub(super) fn new(field: &HeightField) -> Self {
        let [columns, rows] = [field.columns - 1, field.rows - 1];
        let starts = |cells: u32| (0..cells).step_by(SIDE as usize);
        let patch = |(i, j): (u32, u32)| {
            let samples =
                (j..=(j + SIDE).min(rows)).flat_map(|j| (i..=(i + SIDE).min(columns)).map(move |i| (i, j)));
            let area = Aabb::from_points(samples.map(|(i, j)| field.sample(i, j)));
            // Wider than the rounding of its samples and of the ray's ends, so that none slips through between two.
            area.grown(1e-3 * field.spacing.max_element())
        };
        let boxes: Vec<Aabb> =
            starts(rows).flat_map(|j| starts(columns).map(move |i| (i, j))).map(patch).collect();
        Quilt { tree: Tree::build(&boxes), boxes }
    }

    /// [`cast_ray`] on the field.
    pub(super) fn cast(&self, shape: &Shape, ray: &Ray) -> Option<RayHit> {
        let mut found: Option<RayHit> = None;
        let mut max = ray.max;
        let origin = Aabb::around(ray.origin, ray.origin);
        self.tree.cast_box(&origin, ray.direction.as_vec3(), super::up(max), |patch, _| {
            if let Some([from, until]) = stretch(&self.boxes[patch as usize], ray, max) {
                let part = Ray { origin: ray.at(from), max: until - from, ..*ray };
                if let Some(hit) = cast_ray(shape, &part, false) {
                    max = from + hit.t;
                    found = Some(RayHit { t: max, ..hit });
                }
            }
            super::up(max)
        });
        found
    }
}

/// Where a ray, up to `max`, is in a box.
fn stretch(area: &Aabb, ray: &Ray, max: f64) -> Option<[f64; 2]> {
    let (low, high) = (area.min.as_dvec3() - ray.origin, area.max.as_dvec3() - ray.origin);
    let [mut from, mut until] = [0.0_f64, max];
    for axis in 0..3 {
        let inverse: f64 = 1.0 / ray.direction[axis];
        if inverse.is_infinite() {
            if low[axis] > 0.0 || high[axis] < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (low[axis] * inverse, high[axis] * inverse);
        (from, until) = (f64::max(from, a.min(b)), f64::min(until, a.max(b)));
    }
    // Its corners are on the surface where it is flat: there a stretch may be a point.
    (from <= until && from.is_finite() && DVec3::is_finite(ray.at(from))).then_some([from, until])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::{Vec2, hash::mix};
    use std::sync::Arc;

    #[test]
    fn a_ray_meets_the_same_point_as_without_patches() {
        let heights = (0..61 * 43).map(|k| (mix(k) % 1000) as f32 * 0.003).collect();
        let field = HeightField::new(61, 43, Vec2::new(0.5, 0.8), heights).expect("a height field");
        let quilt = Quilt::new(&field);
        let shape = Shape::HeightField(Arc::new(field));
        let share = |k: u64| (mix(k) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let point = |k: u64, size: DVec3| size * DVec3::new(share(3 * k), share(3 * k + 1), share(3 * k + 2));
        let mut met = 0;
        for k in 0..4000 {
            let origin = point(2 * k, DVec3::new(50.0, 60.0, 30.0)) + DVec3::Z * 8.0;
            let target = point(2 * k + 1, DVec3::new(28.0, 32.0, 3.0));
            let max = if k % 3 == 0 { 0.9 } else { f64::INFINITY };
            let ray = Ray { origin, direction: target - origin, max };
            let (whole, parts) = (cast_ray(&shape, &ray, false), quilt.cast(&shape, &ray));
            match (whole, parts) {
                (Some(a), Some(b)) => {
                    met += 1;
                    assert!((a.t - b.t).abs() < 1e-9, "{a:?} {b:?}");
                }
                (a, b) => assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
            }
        }
        assert!(met > 1000, "{met}");
    }
}
