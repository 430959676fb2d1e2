//! Contact of a closed mesh with what is not bounded and convex: a half-space, another mesh, a height field, the mesh of a field.
//!
//! What flows in: two surfaces, one of them closed, or a closed mesh and a half-space. What flows out: manifolds, as many as there are directions in which they touch.
//!
//! Two solids with flat sides touch where a corner of one meets a side of the other, or where two edges cross; nothing else need be looked at, and what is found is exact.
//!
//! 1. `near` finds the triangles that are near each other, and their corners and edges.
//! 2. `touch` makes contacts of those that can push the way that the other surface does.
//!
//! Then manifolds are made as those of fields are. Bounded convex shapes have `surface` for this, as on a mesh that does not move.
//!
//! A corner is measured from the nearest place of the other surface, so that what came through more than half of a wall finds its way out on the far side; it looks away from there, and does not count.

mod near;
mod touch;

use crate::field::{Contact, Near, manifolds};
use crate::surface::Surface;
use crate::surface::facet::corner_pushes;
use crate::{Cache, Manifold};
use near::Features;
use rockfall_math::{Aabb, Isometry, Vec3};
use rockfall_shape::{Mesh, Shape};
use touch::{Side, Two};

/// How far beyond the margin triangles are looked for, as a share of the smaller body's contact scale: how deep a corner may be in a side that is finer than that.
const DEEP: f32 = 0.1;

/// What lies within that share of the smaller contact scale is in one place.
const GRAIN: f32 = 0.1;

/// Sine of 4°, by which the way to the other surface may leave those that a corner can push: points of a side that lies on another stay when it is tilted a little.
pub(crate) const TILT: f32 = 0.07;

/// Share of the contact scale up to which what is apart is looked for.
const ROOM: f32 = 0.5;

/// Corners of a flat side bear load however far it is tilted: a box that rocks would fall on those that are left out.
const ALL: f32 = f32::MAX;

/// The most of names.
const NAMES: u64 = (1 << 29) - 1;

/// Whether the pair is one of those that are found here.
pub(crate) fn takes(a: &Shape, b: &Shape) -> bool {
    let is_solid = |shape: &Shape| matches!(shape, Shape::Mesh(mesh) if mesh.inner_ball.1 > 0.0);
    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_));
    // Samples of a field know what an open surface does not: how deep they are.
    let with = |one: &Shape, other: &Shape| match other {
        Shape::HalfSpace { .. } | Shape::Mesh(_) | Shape::HeightField(_) => is_mesh(one),
        Shape::Field(_) => is_solid(one),
        _ => false,
    };
    with(a, b) || with(b, a)
}

/// Appends the manifolds; see [`collide`](crate::collide()). Nothing where no mesh has an inside.
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    match (a, b) {
        (Shape::Mesh(one), Shape::Mesh(two)) => surfaces([a, b], &**one, &**two, b_in_a, margin, cache, out),
        (Shape::Mesh(one), Shape::HeightField(two)) => {
            surfaces([a, b], &**one, &**two, b_in_a, margin, cache, out)
        }
        (Shape::HeightField(one), Shape::Mesh(two)) => {
            surfaces([a, b], &**one, &**two, b_in_a, margin, cache, out)
        }
        (Shape::Mesh(one), Shape::Field(two)) => {
            surfaces([a, b], &**one, &**two.mesh(), b_in_a, margin, cache, out)
        }
        (Shape::Field(one), Shape::Mesh(two)) => {
            surfaces([a, b], &**one.mesh(), &**two, b_in_a, margin, cache, out)
        }
        (Shape::HalfSpace { normal, offset }, Shape::Mesh(mesh)) => {
            half_space(*normal, *offset, mesh, b_in_a, [margin, scale([a, b])], cache, out)
        }
        (Shape::Mesh(_), Shape::HalfSpace { .. }) => {
            let first = out.len();
            let apart = collide(b, a, &b_in_a.inverse(), margin, cache, out);
            out[first..].iter_mut().for_each(|manifold| manifold.swap(b_in_a));
            apart
        }
        _ => 0.0,
    }
}

/// The smaller contact scale of the bodies that have one, metres; infinite where none does.
fn scale(shapes: [&Shape; 2]) -> f32 {
    let scales = shapes.into_iter().map(Shape::contact_scale).filter(|&scale| scale > 0.0);
    scales.fold(f32::INFINITY, f32::min)
}

fn surfaces<A: Surface, B: Surface>(
    shapes: [&Shape; 2],
    a: &A,
    b: &B,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let scale = scale(shapes);
    if !scale.is_finite() {
        return 0.0;
    }
    let pair = Two {
        a: Side { surface: a, shape: shapes[0], place: Isometry::IDENTITY },
        b: Side { surface: b, shape: shapes[1], place: *b_in_a },
        margin,
        depth: scale,
        grain: GRAIN * scale,
    };
    let features = Features::near(a, b, shapes.map(Shape::bounds), b_in_a, margin + DEEP * scale);
    let mut contacts = Vec::new();
    if features.is_empty() {
        // One may be all in the other.
        contacts.extend(pair.swallowed());
        if contacts.is_empty() {
            let further = margin + ROOM * scale;
            let room = Features::near(a, b, shapes.map(Shape::bounds), b_in_a, further);
            return if room.is_empty() { further } else { margin };
        }
    } else {
        pair.contacts(&features, &mut contacts);
    }
    manifolds(&contacts, margin, pair.grain, ALL, cache, |_, _| (), out);
    0.0
}

/// Corners of a mesh of that contact scale at a plane, in the plane's frame.
fn half_space(
    normal: Vec3,
    offset: f32,
    mesh: &Mesh,
    place: &Isometry,
    [margin, scale]: [f32; 2],
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    if mesh.inner_ball.1 == 0.0 {
        return 0.0;
    }
    let up = place.inverse_vector(normal);
    // The height of the mesh's origin over the plane.
    let origin = normal.dot(place.translation) - offset;
    let Some(area) = below(&mesh.bounds, up, margin - origin) else {
        let (middle, half) = (mesh.bounds.center(), mesh.bounds.half_extents());
        return (origin + up.dot(middle) - up.abs().dot(half)) * (1.0 - 1e-5);
    };
    let mut contacts = Vec::new();
    for (vertex, triangle, corner) in near::sharp_corners(mesh, &area) {
        let p = place.point(mesh.vertices[vertex as usize]);
        let distance = normal.dot(p) - offset;
        if distance <= margin && corner_pushes(mesh, triangle, corner, -up, TILT) {
            contacts.push(Contact::new(true, p, Near { distance, normal }, (vertex & NAMES) as u32));
        }
    }
    manifolds(&contacts, margin, GRAIN * scale, ALL, cache, |_, _| (), out);
    0.0
}

/// The box around the part of a box that is no higher than `height` along `up`; none where there is no such part.
fn below(bounds: &Aabb, up: Vec3, height: f32) -> Option<Aabb> {
    let low = Vec3::select(up.cmpge(Vec3::ZERO), bounds.min, bounds.max);
    let slack = 1e-5 * (bounds.min.abs().max(bounds.max.abs()).length() + height.abs());
    let room = height + slack - up.dot(low);
    if room < 0.0 {
        return None;
    }
    // Along each axis as far as the height lets a point go that is lowest along the others.
    let way = room / up.abs().max(Vec3::splat(1e-6));
    Some(Aabb::new(bounds.min.max(low - way), bounds.max.min(low + way)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_below_a_plane_is_in_the_box_around_it() {
        let bounds = Aabb::new(Vec3::new(-1.0, -2.0, -3.0), Vec3::new(2.0, 1.0, 4.0));
        let up = Vec3::new(0.6, 0.0, 0.8);
        // The lowest corner is at (-1, any, -3): height -3.
        assert!(below(&bounds, up, -3.1).is_none());
        let area = below(&bounds, up, -2.4).expect("some");
        assert!((area.max - Vec3::new(0.0, 1.0, -2.25)).abs().max_element() < 1e-3, "{area:?}");
        assert_eq!(area.min, bounds.min);
        assert_eq!(below(&bounds, up, 100.0), Some(bounds));
        // Turned around, the other end.
        let area = below(&bounds, -up, -4.1).expect("some");
        assert!(area.max == bounds.max && area.min.x > 1.4 && area.min.z > 3.6, "{area:?}");
    }
}
