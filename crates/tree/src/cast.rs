//! Finds the items that a ray meets, nearest first.

use crate::{MAX_LEVELS, Tree, WIDTH};
use rockfall_math::Vec3;

impl Tree {
    /// Follows the ray `origin + t direction` for 0 ≤ t ≤ `max` and calls `f(item, max)` for the items whose boxes it
    /// meets; `f` returns the new `max`, which cuts the rest of the ray: return the t of a hit for the first hit, the
    /// old value for every hit, 0 to stop at any hit. Nearer blocks come first, but boxes overlap, so the items do
    /// not come strictly sorted. `direction` need not be of unit length. A box that the ray passes by a
    /// rounding error may be reported too. A ray that is not finite meets nothing.
    pub fn cast_ray(&self, origin: Vec3, direction: Vec3, max: f32, mut f: impl FnMut(u32, f32) -> f32) {
        let Some(root) = self.levels.checked_sub(1) else {
            return;
        };
        if !origin.is_finite() || !direction.is_finite() || max.is_nan() {
            return;
        }
        let inverse = direction.recip();
        let mut max = max;
        // Each level leaves at most seven siblings behind.
        let mut stack = [(0.0_f32, 0_usize, 0_usize); MAX_LEVELS * WIDTH];
        stack[0] = (0.0, root, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (entry, level, index) = stack[height];
            if entry > max {
                continue;
            }
            let entries = self.block(level, index).enters(origin, inverse, max);
            let mut near = [(0.0, 0); WIDTH];
            let mut count = 0;
            for (lane, &entry) in entries.iter().enumerate() {
                if entry < f32::INFINITY {
                    let mut at = count;
                    while at > 0 && near[at - 1].0 > entry {
                        near[at] = near[at - 1];
                        at -= 1;
                    }
                    near[at] = (entry, index * WIDTH + lane);
                    count += 1;
                }
            }
            if level == 0 {
                for &(entry, place) in &near[..count] {
                    if entry <= max {
                        max = f(self.order[place], max);
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
}
