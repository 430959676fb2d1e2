//! Contact of a signed distance field with any other shape, another field included.
//!
//! What flows in: two shapes, one of them a field at least. What flows out: manifolds, as many as there are directions in which they touch.
//!
//! Points of each body are measured in the other one's distance: the samples of a field (`shape::Samples`), corners and edges of everything else (`points.rs`). Most of them are never looked at: a ball
//! around many points, further from the other body than it is wide, has none that is near.
//!
//! Two fields touch at corners and edges of their meshes, near the samples that are near the other body (`exact`). With anything else:
//!
//! 1. `gather` finds the points that are near, with the direction in which the other body's distance grows.
//! 2. `slide` moves those that are nearer than their neighbours along their own surface to where the distance is least, since the true contact lies between samples.
//!
//! Then `cluster` makes manifolds of what looks the same way.
//!
//! The distances that are told are those of the meshes; which points are found is decided to the error of the fields, and what is smaller than their spacing may be missed; a plane, a box or a mesh adds nothing of its own. A point counts only
//! where the surfaces face each other: one of a floor beside what stands on it looks past the edge of that, and what has come through more than half of a thin wall finds the way out on the wrong side, and must not be pushed there.

mod cluster;
mod deep;
mod edges;
mod exact;
mod few;
mod gather;
mod keep;
mod passage;
mod points;
mod side;
mod slide;

use crate::{Cache, ContactPoint, Manifold};
use cluster::BEARING;
pub(crate) use cluster::manifolds;
pub(crate) use exact::crossing;
pub(crate) use gather::{Contact, FACING, within};
pub(crate) use passage::passage;
pub(crate) use side::Near;

use rockfall_math::Isometry;
use rockfall_shape::Shape;
use side::Side;

/// Points up to this share of the spacing beyond the margin are looked at: the true contact may be nearer than they are.
const SLACK: f32 = 0.5;

/// Appends the manifolds; one of the shapes is a field. Returns a distance by which the samples of one are apart from the other shape, or 0.
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let spacing = [a, b].into_iter().fold(f32::INFINITY, |least, shape| match shape {
        Shape::Field(field) => least.min(field.settings().spacing),
        _ => least,
    });
    let reach = margin + SLACK * spacing;
    let depth = [a, b].into_iter().fold(0.0_f32, |most, shape| match shape {
        Shape::Field(_) => most.max(shape.contact_scale()),
        _ => most,
    });
    let side_a = Side::new(a, Isometry::IDENTITY, depth);
    let side_b = Side::new(b, *b_in_a, depth);
    let mut contacts = Vec::new();
    if let (Shape::Field(of_a), Shape::Field(of_b)) = (a, b) {
        let pair = exact::Two { sides: [&side_a, &side_b], fields: [of_a, of_b], margin, reach, spacing };
        let least = pair.contacts(&mut contacts);
        if contacts.is_empty() {
            return pair.apart(least);
        }
        manifolds(&contacts, margin, spacing, BEARING, cache, |_, _| (), out);
        return 0.0;
    }
    let least_a = gather::points_near(&side_a, &side_b, reach, spacing, false, &mut contacts);
    let least_b = gather::points_near(&side_b, &side_a, reach, spacing, true, &mut contacts);
    if contacts.is_empty() {
        return (least_a.min(least_b) - SLACK * spacing).max(0.0);
    }
    slide::settle(&side_a, &side_b, spacing, &mut contacts);
    let nearest = contacts.iter().fold(f32::INFINITY, |least: f32, c: &Contact| least.min(c.distance));
    contacts.retain(|contact| contact.faces && contact.distance <= margin);
    if contacts.is_empty() {
        return nearest.max(0.0);
    }
    // What of the contacts is left is measured by the meshes: where two points of a place say by a field's error different distances, and take turns, bodies are pushed.
    let measure = |contact: &Contact, point: &mut ContactPoint| {
        let other = if contact.is_of_b() { &side_a } else { &side_b };
        let Some(distance) = other.exact_distance(contact.own_point(), contact.distance) else { return };
        let out = if contact.is_of_b() { contact.normal } else { -contact.normal };
        point.position += 0.5 * (contact.distance - distance) * out;
        point.distance = distance;
    };
    manifolds(&contacts, margin, spacing, BEARING, cache, measure, out);
    0.0
}
