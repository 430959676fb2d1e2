//! Finds the items that a ray, or a box on its way, meets: nearest first.

use crate::block::{Beam, STRETCH};
use crate::{MAX_LEVELS, Tree, WIDTH};
use rockfall_math::{Aabb, Vec3};

impl Tree {
    /// Follows the ray `origin + t direction` for 0 ≤ t ≤ `max` and calls `f(item, max)` for the items whose boxes it
    /// meets; `f` returns the new `max`, which cuts the rest of the ray: return the t of a hit for the first hit, the
    /// old value for every hit, a negative number to stop. Nearer blocks come first, but boxes overlap, so the items do
    /// not come strictly sorted. `direction` need not be of unit length. A box that the ray passes by a
    /// rounding error may be reported too. A ray that is not finite meets nothing.
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, max: f32, f: impl FnMut(u32, f32) -> f32) {
        self.cast_box(&Aabb::new(origin, origin), direction, max, f);
    }

    /// [`Tree::cast_ray`] with a box instead of the origin: the items whose boxes are met by `area`, moved by t `direction`. A ray from
    /// a point that is not a number in single precision is cast as the box around it, and loses nothing; its direction may be rounded.
    pub fn cast_box(&self, area: &Aabb, direction: Vec3, max: f32, mut f: impl FnMut(u32, f32) -> f32) {
        let Some(root) = self.levels.checked_sub(1) else {
            return;
        };
        if !area.is_valid() || !direction.is_finite() || max.is_nan() {
            return;
        }
        let beam = Beam::new(area, direction);
        let mut max = max;
        let mut end = max * STRETCH;
        // Each level leaves at most seven siblings behind.
        let mut stack = [(0.0_f32, 0_u32, 0_u32); MAX_LEVELS * WIDTH];
        stack[0] = (0.0, root as u32, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (entry, level, index) = stack[height];
            if entry > end {
                continue;
            }
            let (entries, mut hits) = self.block(level as usize, index as usize).enters(&beam, end);
            let mut near = [(0.0, 0); WIDTH];
            let mut count = 0;
            while hits != 0 {
                let lane = hits.trailing_zeros();
                hits &= hits - 1;
                sort_in(&mut near, &mut count, (entries[lane as usize], index * WIDTH as u32 + lane));
            }
            if level == 0 {
                for &(entry, place) in &near[..count] {
                    if entry <= end {
                        max = f(self.order[place as usize], max);
                        end = max * STRETCH;
                    }
                }
            } else {
                for &(entry, child) in near[..count].iter().rev() {
                    stack[height] = (entry, level - 1, child);
                    height += 1;
                }
            }
        }
    }

    /// Calls `f(item, max)` for the items whose boxes are no further from `area` than `max`, nearest blocks first; `f` returns the new
    /// `max`: the distance of what it found, to find the nearest item. A little beyond `max` may be reported too. An area that is not finite is near nothing.
    pub fn nearest(&self, area: &Aabb, max: f32, mut f: impl FnMut(u32, f32) -> f32) {
        let Some(root) = self.levels.checked_sub(1) else {
            return;
        };
        if !area.is_valid() || max.is_nan() || max < 0.0 {
            return;
        }
        let mut max = max;
        let square = |max: f32| if max < 0.0 { -1.0 } else { max * max * STRETCH };
        let mut most = square(max);
        let mut stack = [(0.0_f32, 0_u32, 0_u32); MAX_LEVELS * WIDTH];
        stack[0] = (0.0, root as u32, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (squared, level, index) = stack[height];
            if squared > most {
                continue;
            }
            let block = self.block(level as usize, index as usize);
            let (distances, mut hits) = block.squared_distances(area, most);
            let mut near = [(0.0, 0); WIDTH];
            let mut count = 0;
            while hits != 0 {
                let lane = hits.trailing_zeros();
                hits &= hits - 1;
                sort_in(&mut near, &mut count, (distances[lane as usize], index * WIDTH as u32 + lane));
            }
            if level == 0 {
                for &(squared, place) in &near[..count] {
                    if squared <= most {
                        max = f(self.order[place as usize], max);
                        most = square(max);
                    }
                }
            } else {
                for &(squared, child) in near[..count].iter().rev() {
                    stack[height] = (squared, level - 1, child);
                    height += 1;
                }
            }
        }
    }
}

/// Puts one more into a short list that ascends; equals keep their order.
#[inline]
fn sort_in(list: &mut [(f32, u32); WIDTH], count: &mut usize, one: (f32, u32)) {
    let mut at = *count;
    while at > 0 && list[at - 1].0 > one.0 {
        list[at] = list[at - 1];
        at -= 1;
    }
    list[at] = one;
    *count += 1;
}
