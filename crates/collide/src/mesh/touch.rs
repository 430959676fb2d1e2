//! Contacts of corners and edges of two surfaces.

use super::near::{Corner, Edge, Features};
use super::{NAMES, TILT};
use crate::field::{Contact, FACING, Near, crossing, within};
use crate::point::nearest_point;
use crate::surface::Surface;
use crate::surface::facet::corner_pushes;
use rockfall_math::{Aabb, Isometry, Vec3, hash};
use rockfall_shape::{EdgeKind, Shape};

/// Share of the grain by which a point of an edge may be out of a side that it lies in, and edges may miss each other at their ends: of equal boxes that stand on each other, edges cross at corners.
const ROUNDING: f32 = 1e-2;

/// Cosine up to which the normals at an edge say that a crossing lies as deep below both sides as it should: see [`Two::crossing`].
const DEEP: f32 = 0.9;

/// Set in the names of crossings.
const OF_EDGES: u32 = 1 << 30;

/// The name of a body that lies in another one.
const SWALLOWED: u32 = 1 << 29;

/// A surface in its place.
pub(super) struct Side<'a, S> {
    pub(super) surface: &'a S,
    pub(super) shape: &'a Shape,
    /// Places it in A's frame.
    pub(super) place: Isometry,
}

/// Two surfaces, one of them closed.
pub(super) struct Two<'a, A, B> {
    pub(super) a: Side<'a, A>,
    pub(super) b: Side<'a, B>,
    pub(super) margin: f32,
    /// How far behind an open surface a point may be, metres.
    pub(super) depth: f32,
    /// Size of a place, metres.
    pub(super) grain: f32,
}

/// An edge in A's frame.
struct Placed {
    ends: [Vec3; 2],
    /// Unit vector between the normals at it, and the cosine of the angle to either.
    out: Vec3,
    cone: f32,
}

impl<A: Surface, B: Surface> Two<'_, A, B> {
    /// Appends the contacts of features that are near each other.
    pub(super) fn contacts(&self, features: &Features, out: &mut Vec<Contact>) {
        let mut hidden = None;
        let [of_a, of_b] = &features.corners;
        of_a.iter().for_each(|corner| self.corner(false, &self.a, &self.b, corner, out, &mut hidden));
        of_b.iter().for_each(|corner| self.corner(true, &self.b, &self.a, corner, out, &mut hidden));
        let [of_a, of_b] = &features.edges;
        for &(one, two) in &features.crossings {
            out.extend(self.crossing(&of_a[one as usize], &of_b[two as usize]));
        }
        // Where two bodies overlap and nothing else touches there is a contact, whichever way the surfaces look.
        if out.is_empty() {
            out.extend(hidden);
        }
    }

    /// A corner of one surface at the other one. One that is in it and looks away from the nearest place is pushed out by the nearest side that it does not look away from; where there is none it is `hidden`: of several, the deepest.
    fn corner<S: Surface, T: Surface>(
        &self,
        of_b: bool,
        own: &Side<'_, S>,
        other: &Side<'_, T>,
        &(id, triangle, k): &Corner,
        out: &mut Vec<Contact>,
        hidden: &mut Option<Contact>,
    ) {
        let p = own.place.point(own.surface.corners(triangle)[k]);
        let Some(there) = other.near(p, self.margin.max(self.depth)) else { return };
        if there.distance > self.margin {
            return;
        }
        let pushes =
            |normal: Vec3| corner_pushes(own.surface, triangle, k, own.place.inverse_vector(-normal), TILT);
        let name = (hash::mix(id) & NAMES) as u32;
        if pushes(there.normal) {
            out.push(Contact::new(of_b, p, there, name));
        } else if there.distance <= ROUNDING * self.grain {
            if let Some(side) = other.side_over(p, self.grain, pushes) {
                out.push(Contact::new(of_b, p, side, name));
            } else if there.distance <= 0.0 && hidden.is_none_or(|known| there.distance < known.distance) {
                *hidden = Some(Contact::new(of_b, p, there, name));
            }
        }
    }

    /// The contact of two edges that cross, along their common normal, if both surfaces can push that way.
    fn crossing(&self, one: &Edge, two: &Edge) -> Option<Contact> {
        let (of_a, of_b) = (self.a.edge(one), self.b.edge(two));
        let slack = ROUNDING * self.grain;
        let (on_a, on_b, normal) = crossing(of_a.ends, of_b.ends, of_a.out, slack)?;
        let distance = normal.dot(on_b - on_a);
        let cosines = [normal.dot(of_a.out), -normal.dot(of_b.out)];
        let faces = within(cosines[0], of_a.cone, FACING) && within(cosines[1], of_b.cone, FACING);
        if distance > self.margin || !faces || distance < -self.depth {
            return None;
        }
        // Each edge lies in the other solid; how deep below its sides it should be, the angle between the common normal and those sides says.
        let below = |edge: &Placed, cosine: f32| {
            let sine = |c: f32| (1.0 - c * c).max(0.0).sqrt();
            let least = edge.cone * cosine - sine(edge.cone) * sine(cosine);
            DEEP * least.max(0.0) * distance + slack
        };
        let is_in = |p: Vec3, near: Option<Near>, least: f32| {
            p.is_finite() && near.is_none_or(|near| near.distance <= least)
        };
        if distance < -slack {
            let limit = self.depth;
            let both = is_in(on_a, self.b.near(on_a, limit), below(&of_b, cosines[1]))
                && is_in(on_b, self.a.near(on_b, limit), below(&of_a, cosines[0]));
            if !both {
                return None;
            }
        }
        let [first, second] = [one.0, two.0].map(|ends| hash::combine(ends[0], ends[1]));
        let name = (hash::combine(first, second) & NAMES) as u32 | OF_EDGES;
        Some(Contact::new(false, on_a, Near { distance, normal: -normal }, name))
    }

    /// One body whose surface is nowhere near that of the other, in which it lies: the ball inside of it is pushed out.
    pub(super) fn swallowed(&self) -> Option<Contact> {
        swallowed(false, &self.a, &self.b).or_else(|| swallowed(true, &self.b, &self.a))
    }
}

fn swallowed<S: Surface, T: Surface>(of_b: bool, own: &Side<'_, S>, other: &Side<'_, T>) -> Option<Contact> {
    let radius = own.shape.inner_radius();
    let middle = own.place.point(own.shape.inner_center());
    if radius == 0.0 {
        return None;
    }
    let near = other.near(middle, 0.0).filter(|near| near.distance < 0.0)?;
    let p = middle - radius * near.normal;
    Some(Contact::new(of_b, p, Near { distance: near.distance - radius, ..near }, SWALLOWED))
}

impl<S: Surface> Side<'_, S> {
    /// The signed distance of a point of A's frame, up to a limit where it is outside or behind an open surface.
    fn near(&self, p: Vec3, limit: f32) -> Option<Near> {
        let near = nearest_point(self.shape, self.place.inverse_point(p).as_dvec3(), limit)?;
        Some(Near { distance: near.distance, normal: self.place.vector(near.normal) })
    }

    /// Of the sides that a point lies behind, by no more than `depth`, and that something can push, the one that it is least behind.
    fn side_over(&self, p: Vec3, depth: f32, pushes: impl Fn(Vec3) -> bool) -> Option<Near> {
        let own = self.place.inverse_point(p);
        let mut best: Option<(f32, u64, Vec3)> = None;
        let area = Aabb::new(own - depth, own + depth);
        self.surface.near(&area, |triangle| {
            let (corners, normal) = (self.surface.corners(triangle), self.surface.normal(triangle));
            let height = normal.dot(own - corners[0]);
            let is_over = (0..3).all(|k| {
                let along = corners[(k + 1) % 3] - corners[k];
                let outward = along.cross(normal).normalize_or_zero();
                outward.dot(own - corners[k]) <= ROUNDING * depth
            });
            let better =
                best.is_none_or(|(known, other, _)| height > known || (height == known && triangle < other));
            let out = self.place.vector(normal);
            if (-depth..=ROUNDING * depth).contains(&height) && is_over && better && pushes(out) {
                best = Some((height, triangle, out));
            }
        });
        best.map(|(distance, _, normal)| Near { distance, normal })
    }

    fn edge(&self, &(_, triangle, k): &Edge) -> Placed {
        let (corners, normal) = (self.surface.corners(triangle), self.surface.normal(triangle));
        let (kind, beyond) = self.surface.beyond(triangle, k, &corners, normal);
        let ends = [corners[k], corners[(k + 1) % 3]];
        // Where a surface ends it pushes along all ways from its normal to straight out over the rim.
        let last = match kind {
            EdgeKind::Boundary => (ends[1] - ends[0]).cross(normal).normalize_or_zero(),
            _ => beyond,
        };
        let out = (normal + last).normalize_or(normal);
        let cone = out.dot(normal);
        Placed { ends: ends.map(|p| self.place.point(p)), out: self.place.vector(out), cone }
    }
}
