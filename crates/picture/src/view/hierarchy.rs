//! A hierarchy of boxes for rays: eight boxes to a node, split where the surface area heuristic wants it.
//!
//! The engine's own tree is made for steps: built along a curve in a few milliseconds, and asked once for each body. A picture asks one tree millions of times, so that it is worth while to split it by
//! area (Wald, "On fast construction of SAH-based bounding volume hierarchies", RT 2007). Children of a node lie side by side, coordinate by coordinate, so that a beam meets eight at once (Wald, Benthin and
//! Boulos, "Getting rid of packets", RT 2008).

use rayon::prelude::*;
use rockfall_math::lanes::Lanes;
use rockfall_math::{Aabb, Vec3};

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Bins that a split chooses from.
const BINS: usize = 12;

/// Items from which on a branch is a task of its own.
const TASK: usize = 4096;

/// A child that is an item has this bit.
const ITEM: u32 = 1 << 31;

/// No child.
const NONE: u32 = u32::MAX;

/// Levels that are split by area; below them branches are halved three times over, which ends after eleven levels of at most 2³¹ items.
const BY_AREA: usize = 9;

/// Branches that may wait on the way down: seven of each level.
const WAITING: usize = 7 * (BY_AREA + 11) + 1;

/// By how much a far end is stretched, so that no hit is lost to rounding (Ize, "Robust BVH ray traversal", JCGT 2013).
const STRETCH: f32 = 1.0 + 8.0 * f32::EPSILON;

/// Eight boxes.
#[repr(align(64))]
#[derive(Clone, Debug)]
struct Node {
    /// Low and high ends on x, on y, and on z.
    sides: [[f32; WIDTH]; 6],
    children: [u32; WIDTH],
}

/// A hierarchy over boxes; items are their indices.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    nodes: Vec<Node>,
}

/// Who is shown items. Not a closure: those are not compiled for wide registers.
pub(super) trait Visit {
    /// `entry` is where the beam comes into the item's box; returns the new end of the beam in place of `max`, a negative number to see no more.
    fn visit<L: Lanes>(&mut self, token: L::Token, item: u32, entry: f32, max: f32) -> f32;
}

/// The points `origin + t direction` for 0 ≤ t ≤ `max`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    pub(crate) origin: Vec3,
    /// Of any length but zero.
    pub(crate) direction: Vec3,
    /// May be infinite.
    pub(crate) max: f32,
    inverse: Vec3,
}

impl Beam {
    #[inline(always)]
    pub(crate) fn new(origin: Vec3, direction: Vec3, max: f32) -> Self {
        Beam { origin, direction, max, inverse: inverse(direction) }
    }
}

/// One by each coordinate; one by nearly nothing where it is nothing, so that no product is undefined.
#[inline(always)]
pub(super) fn inverse(direction: Vec3) -> Vec3 {
    let one = |x: f32| 1.0 / if x.abs() < 1e-18 { 1e-18_f32.copysign(x) } else { x };
    Vec3::new(one(direction.x), one(direction.y), one(direction.z))
}

/// Each coordinate in all lanes.
#[inline(always)]
pub(super) fn all<L: Lanes>(token: L::Token, v: Vec3) -> [L; 3] {
    [L::splat(token, v.x), L::splat(token, v.y), L::splat(token, v.z)]
}

impl Hierarchy {
    /// Boxes that hold nothing are left out.
    pub(super) fn build(boxes: &[Aabb]) -> Self {
        let holds = |item: &u32| boxes[*item as usize].is_valid();
        let mut items: Vec<u32> = (0..boxes.len() as u32).filter(holds).collect();
        Hierarchy { nodes: if items.is_empty() { Vec::new() } else { branch(boxes, &mut items, 0) } }
    }

    /// Shows a visitor the items whose boxes the beam meets, nearest first but for overlaps.
    #[inline(always)]
    pub(super) fn walk<L: Lanes>(&self, token: L::Token, beam: &Beam, visitor: &mut impl Visit) {
        if self.nodes.is_empty() {
            return;
        }
        let (origin, slopes) = (all(token, beam.origin), all::<L>(token, beam.inverse));
        let near = beam.inverse.to_array().map(|x| usize::from(x < 0.0));
        let (zero, stretch) = (L::splat(token, 0.0), L::splat(token, STRETCH));
        let mut max = beam.max;
        let mut stack = [(0.0_f32, 0_u32); WAITING];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (entry, index) = stack[height];
            if entry > max {
                continue;
            }
            let node = &self.nodes[index as usize];
            let mut enter = zero;
            let mut exit = L::splat(token, max);
            for axis in 0..3 {
                let (low, high) = (2 * axis + near[axis], 2 * axis + (near[axis] ^ 1));
                enter = ((L::load(token, &node.sides[low]) - origin[axis]) * slopes[axis]).max(enter);
                exit = ((L::load(token, &node.sides[high]) - origin[axis]) * slopes[axis]).min(exit);
            }
            let mut hits = !L::bits((exit * stretch).lt(enter)) & 0xff;
            if hits == 0 {
                continue;
            }
            let mut entries = [0.0; WIDTH];
            enter.store(&mut entries);
            // Nearest first; mostly there are one or two.
            let mut found = [(0.0_f32, 0_u32); WIDTH];
            let mut count = 0;
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let one = (entries[lane], node.children[lane]);
                let mut place = count;
                while place > 0 && found[place - 1].0 > one.0 {
                    found[place] = found[place - 1];
                    place -= 1;
                }
                found[place] = one;
                count += 1;
            }
            // The furthest first, so that the nearest is on top; items at once, from the near end.
            for &(entry, child) in &found[..count] {
                if child & ITEM != 0 && entry <= max {
                    max = visitor.visit::<L>(token, child & !ITEM, entry, max);
                }
            }
            for &(entry, child) in found[..count].iter().rev() {
                if child & ITEM == 0 && entry <= max {
                    stack[height] = (entry, child);
                    height += 1;
                }
            }
        }
    }

    /// Adds the items whose boxes are, or may be, in the cone of the origin whose sides these planes are, normals inwards, each with its distance from the origin.
    #[inline(always)]
    pub(super) fn gather<L: Lanes>(&self, token: L::Token, sides: &[Vec3; 4], found: &mut Vec<(f32, u32)>) {
        if self.nodes.is_empty() {
            return;
        }
        let zero = L::splat(token, 0.0);
        let mut stack = [0_u32; WAITING];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let node = &self.nodes[stack[height] as usize];
            let mut outside = 0;
            for side in sides {
                // The corner of each box that is furthest inwards.
                let mut most = zero;
                for axis in 0..3 {
                    let corner = 2 * axis + usize::from(side[axis] > 0.0);
                    most = most + L::load(token, &node.sides[corner]) * L::splat(token, side[axis]);
                }
                // No number where there is no box, or its side is at no distance.
                outside |= L::bits(most.lt(zero));
            }
            let mut squared = zero;
            for axis in 0..3 {
                let (low, high) =
                    (L::load(token, &node.sides[2 * axis]), L::load(token, &node.sides[2 * axis + 1]));
                let gap = low.max(-high).max(zero);
                squared = squared + gap * gap;
            }
            let mut distances = [0.0; WIDTH];
            squared.sqrt().store(&mut distances);
            for lane in 0..WIDTH {
                let child = node.children[lane];
                if child == NONE || outside >> lane & 1 != 0 {
                    continue;
                }
                if child & ITEM != 0 {
                    found.push((distances[lane], child & !ITEM));
                } else {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
    }
}

/// The nodes of a branch so many levels below the top; the first is its root, and indices are counted from it.
fn branch(boxes: &[Aabb], items: &mut [u32], level: usize) -> Vec<Node> {
    let mut groups: Vec<&mut [u32]> = vec![items];
    let mut sizes = vec![around(boxes, groups[0])];
    while groups.len() < WIDTH {
        // The largest one that can be split.
        let many = (0..groups.len()).filter(|&k| groups[k].len() > 1);
        let by_area = level < BY_AREA;
        let weight = |k: usize| if by_area { area(&sizes[k]) } else { groups[k].len() as f32 };
        let widest = many.reduce(|a, b| if weight(b) > weight(a) { b } else { a });
        let Some(widest) = widest else { break };
        let group = groups.swap_remove(widest);
        sizes.swap_remove(widest);
        let middle = if by_area { split(boxes, group) } else { group.len() / 2 };
        let (low, high) = group.split_at_mut(middle);
        for part in [low, high] {
            sizes.push(around(boxes, part));
            groups.push(part);
        }
    }
    let mut root = Node { sides: [[f32::INFINITY; WIDTH]; 6], children: [NONE; WIDTH] };
    for (lane, size) in sizes.iter().enumerate() {
        for axis in 0..3 {
            (root.sides[2 * axis][lane], root.sides[2 * axis + 1][lane]) = (size.min[axis], size.max[axis]);
        }
    }
    for lane in sizes.len()..WIDTH {
        (0..3).for_each(|axis| root.sides[2 * axis + 1][lane] = f32::NEG_INFINITY);
    }
    let below =
        |group: &mut [u32]| if group.len() > 1 { branch(boxes, group, level + 1) } else { Vec::new() };
    let only: Vec<u32> = groups.iter().map(|group| group[0]).collect();
    let branches: Vec<Vec<Node>> = if groups.iter().any(|group| group.len() > TASK) {
        groups.into_par_iter().map(below).collect()
    } else {
        groups.into_iter().map(below).collect()
    };
    let mut nodes = vec![root];
    for (lane, below) in branches.into_iter().enumerate() {
        if below.is_empty() {
            nodes[0].children[lane] = ITEM | only[lane];
            continue;
        }
        let start = nodes.len() as u32;
        nodes[0].children[lane] = start;
        nodes.extend(below.into_iter().map(|mut node| {
            for child in node.children.iter_mut().filter(|child| **child & ITEM == 0) {
                *child += start;
            }
            node
        }));
    }
    nodes
}

fn around(boxes: &[Aabb], items: &[u32]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, &item| all.union(&boxes[item as usize]))
}

/// Half of the surface.
fn area(size: &Aabb) -> f32 {
    let side = size.max - size.min;
    let area = side.x * side.y + side.y * side.z + side.z * side.x;
    if area >= 0.0 { area } else { 0.0 }
}

/// Sorts items to two sides and says how many there are on the first, at least one on each.
fn split(boxes: &[Aabb], items: &mut [u32]) -> usize {
    // Twice the middle of a box.
    let middle = |item: u32| boxes[item as usize].min + boxes[item as usize].max;
    let middles =
        items.iter().fold(Aabb::EMPTY, |all, &item| all.union(&Aabb::new(middle(item), middle(item))));
    let reach = middles.max - middles.min;
    let axis = (0..3).fold(0, |best, axis| if reach[axis] > reach[best] { axis } else { best });
    let scale = BINS as f32 / reach[axis];
    let bin = |item: u32| (((middle(item)[axis] - middles.min[axis]) * scale) as usize).min(BINS - 1);
    let mut bins = [(Aabb::EMPTY, 0_u32); BINS];
    for &item in items.iter() {
        let (size, count) = &mut bins[bin(item)];
        (*size, *count) = (size.union(&boxes[item as usize]), *count + 1);
    }
    // What the items behind each border cost, and then those before it as well.
    let mut behind = [0.0; BINS];
    let (mut size, mut count) = (Aabb::EMPTY, 0);
    for k in (1..BINS).rev() {
        (size, count) = (size.union(&bins[k].0), count + bins[k].1);
        behind[k] = if count > 0 { area(&size) * count as f32 } else { f32::INFINITY };
    }
    let (mut best, mut least) = (0, f32::INFINITY);
    (size, count) = (Aabb::EMPTY, 0);
    for k in 1..BINS {
        (size, count) = (size.union(&bins[k - 1].0), count + bins[k - 1].1);
        let cost = area(&size) * count as f32 + behind[k];
        if count > 0 && cost < least {
            (best, least) = (k, cost);
        }
    }
    if best == 0 {
        // All in one place, or of no size that could be compared.
        return items.len() / 2;
    }
    let (mut low, mut high) = (0, items.len());
    while low < high {
        if bin(items[low]) < best {
            low += 1;
        } else {
            high -= 1;
            items.swap(low, high);
        }
    }
    low
}
