//! Finds the items whose boxes overlap a box.

use crate::{MAX_LEVELS, Tree, WIDTH};
use rockfall_math::Aabb;

impl Tree {
    /// Calls `f` with every item whose box shares a point with `area`, touching included, along the curve.
    /// Allocates nothing.
    #[inline]
    pub fn query(&self, area: &Aabb, mut f: impl FnMut(u32)) {
        let Some(root) = self.levels.checked_sub(1) else {
            return;
        };
        // Lanes still to visit in the block on each level of the path from the root; the path itself is the index.
        let mut open = [0_u32; MAX_LEVELS];
        let mut level = root;
        let mut index = 0;
        open[root] = self.block(root, 0).overlaps(area);
        loop {
            if level == 0 {
                let mut hits = open[0];
                while hits != 0 {
                    f(self.order[index * WIDTH + hits.trailing_zeros() as usize]);
                    hits &= hits - 1;
                }
                open[0] = 0;
            }
            while open[level] == 0 {
                if level == root {
                    return;
                }
                level += 1;
                index /= WIDTH;
            }
            let lane = open[level].trailing_zeros() as usize;
            open[level] &= open[level] - 1;
            level -= 1;
            index = index * WIDTH + lane;
            open[level] = self.block(level, index).overlaps(area);
        }
    }
}
