//! Part of stage 5: contacts that are hidden in a seam between bodies that never move.
//!
//! Blocks laid side by side are one floor, but each pair of shapes knows of one block alone: what slides over the floor would run into the side
//! of the next block, of which a hair's breadth reaches into it, and what rolls would be kicked by its edge. So a contact
//! with a static body holds only where the surface of *all* static bodies can push that way, as with the triangles of one mesh
//! ([`rockfall_collide`]'s `surface`): a contact is dropped where its point lies on or in a neighbour that has more of itself
//! further out, and the neighbours cover all of the body's own face around the point. The second condition keeps the floor under a box that
//! stands against a wall: there the point is in the wall as well, but the floor before it is bare.
//!
//! Who is asked are all static bodies at the point, from the tree, whatever contacts they have: the answer depends on places alone.

use crate::bodies::{Bodies, State};
use crate::{Kind, Shape};
use rockfall_collide::{Manifold, nearest_point};
use rockfall_math::{Aabb, DVec3, Isometry, Vec3};
use rockfall_tree::Tree;
use smallvec::SmallVec;

/// Two bodies whose surfaces differ by less than this share of the mover's inner radius are flush.
const FLUSH: f32 = 1e-4;

/// How far around its point a face is looked at, as a share of the mover's inner radius.
const AROUND: f32 = 0.1;

/// Overlap beyond which a contact is never dropped, as a share of the mover's inner radius. What slides over a floor hardly sinks in; in a corner, what has
/// sunk deep into the floor and into the wall would be hidden from each by the other, and be lost.
const DEEP: f32 = 0.5 * AROUND;

/// Sine up to which a direction is that of a face.
const TILT: f32 = 1e-4;

/// Cosine from which on a face looks that way: of several faces at a point the one that is meant.
const FACING: f32 = 0.999;

/// What a place is worth in single precision, as a share of its distance from the origin of a shape.
const ROUNDING: f32 = 5e-7;

/// The static bodies of a world.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a [Shape],
    /// Over their rows.
    pub(crate) tree: &'a Tree,
}

/// A static body near a contact, seen from the mover.
struct Part<'a> {
    shape: &'a Shape,
    place: Isometry,
}

impl Ground<'_> {
    /// Takes the points out of `manifolds` that are hidden in a seam; those are contacts of the mover of row `a` with the static body of
    /// row `b`, in the frame of the mover's shape.
    pub(crate) fn bare(&self, a: usize, b: usize, manifolds: &mut Vec<Manifold>) {
        let Ground { bodies, tree, .. } = *self;
        if tree.len() < 2 || bodies.kinds[b] != Kind::Static || self.is_plane(b) {
            return;
        }
        let size = bodies.inners[a];
        let from = bodies.shape_pose(a);
        let turn = rockfall_math::Mat3::from_quat(from.rotation);
        let place = |p: Vec3| from.position + (turn * p).as_dvec3();
        manifolds.retain_mut(|manifold| {
            let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for point in manifold.points() {
                let on_b = place(on_b(manifold.normal, point));
                (low, high) = (low.min(on_b), high.max(on_b));
            }
            let mut neighbours: SmallVec<[Part; 4]> = SmallVec::new();
            tree.query(&Aabb::around(low, high).grown(AROUND * bodies.inners[a]), |other| {
                let other = other as usize;
                if other != b && self.collide(a, other) {
                    neighbours.extend(self.part(other, &from));
                }
            });
            let Some(own) = self.part(b, &from).filter(|_| !neighbours.is_empty()) else { return true };
            let mut kept = 0;
            for p in 0..manifold.count as usize {
                let point = manifold.points[p];
                let on_b = own.onto(on_b(manifold.normal, &point));
                let deep = point.distance < -DEEP * size;
                if deep || !is_hidden(&own, &neighbours, on_b, -manifold.normal, size) {
                    manifold.points[kept] = point;
                    kept += 1;
                }
            }
            manifold.count = kept as u32;
            kept > 0
        });
    }

    /// A plane has no side that anything could run into.
    fn is_plane(&self, row: usize) -> bool {
        matches!(self.shapes.get(self.bodies.shapes[row] as usize), Some(Shape::HalfSpace { .. }))
    }

    fn collide(&self, a: usize, other: usize) -> bool {
        let ([group, mask], [others, other_mask]) = (self.bodies.filters[a], self.bodies.filters[other]);
        group & other_mask != 0 && others & mask != 0 && self.bodies.states[other] != State::Dead
    }

    fn part(&self, row: usize, from: &rockfall_math::Pose) -> Option<Part<'_>> {
        let shape = self.shapes.get(self.bodies.shapes[row] as usize)?;
        Some(Part { shape, place: from.see(&self.bodies.shape_pose(row)) })
    }
}

/// The point of a contact that lies on the other body.
fn on_b(normal: Vec3, point: &rockfall_collide::ContactPoint) -> Vec3 {
    point.position + 0.5 * point.distance * normal
}

/// Whether neighbours hide the point `p` of a body, which pushes along `out` there; `size` is the mover's inner radius.
fn is_hidden(own: &Part, neighbours: &[Part], p: Vec3, out: Vec3, size: f32) -> bool {
    let flush = FLUSH * size;
    if !neighbours.iter().any(|part| part.goes_on(p, out, flush)) {
        return false;
    }
    // Where the direction is not that of a face, the body ends beside the point.
    let (s, t) = out.any_orthonormal_pair();
    let step = AROUND * size;
    [s, s + t, t, t - s, -s, -s - t, -t, s - t].iter().all(|&way| {
        let beside = p + step * way.normalize_or_zero();
        !own.ends_at(beside, out, TILT * step)
            || neighbours.iter().any(|part| part.holds(beside, flush).is_some())
    })
}

impl Part<'_> {
    /// A point moved onto the part, if it is beside it: sides of faces are moved out a little where manifolds are made.
    fn onto(&self, p: Vec3) -> Vec3 {
        let near = nearest_point(self.shape, self.place.inverse_point(p).as_dvec3(), f32::INFINITY);
        near.filter(|near| near.distance > 0.0).map_or(p, |near| self.place.point(near.point))
    }

    /// The signed distance of a point in the mover's frame, in units of `flush` metres and of rounding, and the direction out of the part, if it
    /// is near or inside.
    fn near(&self, p: Vec3, flush: f32) -> Option<(f32, Vec3)> {
        let local = self.place.inverse_point(p);
        let flush = flush + ROUNDING * local.abs().max_element();
        // An open surface knows its inside only as far as it is looked for.
        let near = nearest_point(self.shape, local.as_dvec3(), 10.0 * flush)?;
        Some((near.distance / flush, self.place.vector(near.normal)))
    }

    /// The direction out of the part at a point that lies on it or in it.
    fn holds(&self, p: Vec3, flush: f32) -> Option<Vec3> {
        self.near(p, flush).filter(|(distance, _)| *distance <= 1.0).map(|(_, normal)| normal)
    }

    /// Whether a point lies on the surface of the part where that looks along `out`.
    fn ends_at(&self, p: Vec3, out: Vec3, flush: f32) -> bool {
        self.near(p, flush)
            .is_some_and(|(distance, normal)| distance.abs() <= 1.0 && normal.dot(out) > FACING)
    }

    /// Whether the point `p` is part of this one, and there is more of it further along `out`.
    fn goes_on(&self, p: Vec3, out: Vec3, flush: f32) -> bool {
        let Some(normal) = self.holds(p, flush) else { return false };
        let Some(end) = self.shape.support(self.place.inverse_vector(out)) else {
            return normal.dot(out) < 1.0 - TILT;
        };
        let more = self.place.point(end) - p;
        more.dot(out) > flush + TILT * more.length()
    }
}
