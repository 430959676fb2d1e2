//! Manifolds of contacts that look the same way.
//!
//! A manifold holds a body by four points that share a normal; so contacts are sorted by normal alone: of those that look the same way, the four that span the largest area
//! carry as much as all, wherever they are. Points that touch come first, by name, so that the same ones lead from step to step.

use super::gather::Contact;
use super::side::Side;
use crate::reduce::{reduce_within, start};
use crate::{ContactPoint, Manifold};
use rockfall_math::Vec3;

/// Cosine of the largest angle between a contact and the one that leads its manifold: 25°.
const ALIKE: f32 = 0.906;

/// Points that are open by more than this share of the manifold's span beyond the deepest bear no load: next to a line of contact, on a surface that bends away, they would span the larger area.
const BEARING: f32 = 1.5e-3;

/// Depths that differ by less than this share of the span are equal.
const EQUAL: f32 = 2.5e-4;

/// Appends the manifolds of contacts that are no further apart than `margin`. What is left of them is measured by the meshes: where two points of a place say by a field's error different
/// distances, and take turns, bodies are pushed.
pub(super) fn manifolds(sides: [&Side; 2], contacts: &[Contact], margin: f32, out: &mut Vec<Manifold>) {
    let mut order: Vec<&Contact> = contacts.iter().collect();
    order.sort_by_key(|contact| (contact.distance > 0.0, contact.name));
    let mut clusters: Vec<Vec<&Contact>> = Vec::new();
    for contact in order {
        let nearest = clusters
            .iter_mut()
            .map(|cluster| (cluster[0].normal.dot(contact.normal), cluster))
            .filter(|(cosine, _)| *cosine > ALIKE)
            .max_by(|(a, _), (b, _)| a.total_cmp(b));
        match nearest {
            Some((_, cluster)) => cluster.push(contact),
            None => clusters.push(vec![contact]),
        }
    }
    out.extend(clusters.iter().map(|cluster| {
        let mut manifold = manifold(cluster, margin);
        for point in &mut manifold.points[..manifold.count as usize] {
            if let Some(contact) = cluster.iter().find(|contact| contact.name == point.feature) {
                measure(sides, contact, point);
            }
        }
        manifold
    }));
}

/// Gives a point the exact distance of its own body's point from the other body.
fn measure([a, b]: [&Side; 2], contact: &Contact, point: &mut ContactPoint) {
    let other = if contact.is_of_b() { a } else { b };
    let Some(distance) = other.exact_distance(contact.own_point(), contact.distance) else { return };
    point.position += 0.5
        * (contact.distance - distance)
        * if contact.is_of_b() { contact.normal } else { -contact.normal };
    point.distance = distance;
}

fn manifold(cluster: &[&Contact], margin: f32) -> Manifold {
    let deepest = cluster.iter().fold(f32::INFINITY, |least, c| least.min(c.distance));
    // What is deep says most of the direction, and what only just came near nothing at all.
    let scale = (margin - deepest).max(f32::MIN_POSITIVE);
    let weight = |c: &Contact| {
        let share = (margin - c.distance) / scale;
        share * share * share * share
    };
    let sum: Vec3 = cluster.iter().map(|c| weight(c) * c.normal).sum();
    let normal = sum.normalize_or(cluster[0].normal);
    let first = cluster[0].position;
    let span = cluster.iter().fold(0.0_f32, |far, c| far.max(c.position.distance(first)));
    let points: Vec<ContactPoint> = cluster
        .iter()
        .filter(|c| c.distance <= deepest + BEARING * span)
        .map(|c| ContactPoint { position: c.position, distance: c.distance, feature: c.name })
        .collect();
    reduce_within(normal, &points, start(normal), EQUAL * span)
}
