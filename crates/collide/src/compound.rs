//! Compounds: what their parts have to say, put together.
//!
//! What flows in: two shapes of which at least one is a compound, or a compound and a question. The tree of a compound tells which
//! parts come near; each of those is asked by itself, in the frame of the question.
//!
//! Parts know nothing of each other. So each contact is named by the numbers of its parts besides its features, and the manifolds of
//! parts that push the same way in one plane become one (`merge`): a table whose four legs stand on a floor has four points, as a box.

mod memory;
mod merge;
mod motion;
mod query;

pub(crate) use motion::first_impact;
pub(crate) use query::{cast_ray, cast_shape, distance, nearest_point, overlaps, penetration};

use crate::{Cache, Manifold};
use memory::Memory;
use rockfall_math::{Aabb, Isometry, Mat3, hash};
use rockfall_shape::{Compound, Shape};
use smallvec::SmallVec;

/// Whether one of two shapes is a compound.
pub(crate) fn takes_part(a: &Shape, b: &Shape) -> bool {
    [a, b].iter().any(|shape| matches!(shape, Shape::Compound(_)))
}

/// How far around parts are looked for when none is within the margin, as a share of the smaller shape: what is found
/// to be further apart need not be looked at again for so long.
const ROOM: f32 = 0.25;

/// Appends the manifolds of two shapes of which one is a compound; as [`collide`](crate::collide). The cache of the pair has room for two pairs of parts.
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let first = out.len();
    let mut memory = Memory::new(cache.word);
    let apart = parts(a, b, b_in_a, margin, 0, &mut memory, out);
    cache.word = memory.word();
    // Boxes alone know which of their corners made the last manifold; a bowl of hulls that keeps points rocks on them.
    let boxes_touch = cache.word != 0;
    if !boxes_touch {
        cache.kept = 0;
    }
    merge::merge(out, first, boxes_touch.then_some(&mut cache.kept));
    apart
}

/// The manifolds of all parts that come within `margin`; `tag` names those that have been chosen already.
fn parts(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    tag: u32,
    memory: &mut Memory,
    out: &mut Vec<Manifold>,
) -> f32 {
    match (a, b) {
        (_, Shape::Compound(b)) => with_parts_of_b(a, b, b_in_a, margin, tag, memory, out),
        (Shape::Compound(_), _) => {
            let first = out.len();
            let apart = parts(b, a, &b_in_a.inverse(), margin, tag, memory, out);
            out[first..].iter_mut().for_each(|manifold| manifold.swap(b_in_a));
            apart
        }
        _ => {
            let first = out.len();
            let mut cache = memory.recall(tag);
            let apart = crate::collide(a, b, b_in_a, margin, &mut cache, out);
            if out.len() > first {
                memory.keep(tag, cache);
            }
            apart
        }
    }
}

fn with_parts_of_b(
    a: &Shape,
    b: &Compound,
    b_in_a: &Isometry,
    margin: f32,
    tag: u32,
    memory: &mut Memory,
    out: &mut Vec<Manifold>,
) -> f32 {
    let whole = out.len();
    let mut apart = f32::INFINITY;
    let mut meet = |number: u32, out: &mut Vec<Manifold>| {
        let part = &b.parts()[number as usize];
        let first = out.len();
        let place = b_in_a.then_after(&part.place);
        let this = parts(a, &part.shape, &place, margin, memory::tag(tag, number), memory, out);
        apart = if this < apart { this } else { apart };
        for point in out[first..].iter_mut().flat_map(|m| &mut m.points[..m.count as usize]) {
            point.feature = name(number, point.feature);
        }
    };
    let area = Area::new(a, &b_in_a.inverse());
    let near = area.near(b, margin);
    near.iter().for_each(|&number| meet(number, out));
    if out.len() > whole {
        return 0.0;
    }
    // None touches: how long will that last?
    let room = ROOM * smaller(a, b);
    let further = area.near(b, margin + room);
    for number in further.into_iter().filter(|number| near.binary_search(number).is_err()) {
        meet(number, out);
    }
    apart.min(margin + room)
}

/// The name of a part's point in the compound.
fn name(part: u32, feature: u32) -> u32 {
    (hash::combine(u64::from(part) + 1, u64::from(feature)) >> 32) as u32
}

/// Half of the diagonal of the smaller one's box, metres.
fn smaller(a: &Shape, b: &Compound) -> f32 {
    let radius = |bounds: Aabb| bounds.half_extents().length();
    radius(a.bounds()).min(radius(b.bounds()))
}

/// Where a shape is in the frame of a compound.
#[derive(Clone, Copy)]
enum Area {
    /// It is solid down to where no box ends.
    Everywhere,
    Box(Aabb),
}

/// Numbers of parts, ascending.
type Numbers = SmallVec<[u32; 16]>;

impl Area {
    fn new(shape: &Shape, place: &Isometry) -> Self {
        match shape {
            Shape::HalfSpace { .. } | Shape::HeightField(_) => Area::Everywhere,
            _ => Area::Box(turned(&shape.bounds(), place)),
        }
    }

    /// Parts whose boxes come within `margin`.
    fn near(&self, compound: &Compound, margin: f32) -> Numbers {
        match self {
            Area::Everywhere => (0..compound.parts().len() as u32).collect(),
            Area::Box(area) => {
                let mut numbers = Numbers::new();
                compound.tree().query(&area.grown(margin), |number| numbers.push(number));
                numbers.sort_unstable();
                numbers
            }
        }
    }
}

/// The box around a box in another frame, rounded outwards.
fn turned(bounds: &Aabb, place: &Isometry) -> Aabb {
    let r = &place.rotation;
    let reach = Mat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
    let (center, half) = (place.point(bounds.center()), reach * bounds.half_extents());
    let slack = 1e-6 * (half + center.abs() + bounds.center().abs().max_element());
    Aabb::new(center - half - slack, center + half + slack)
}
