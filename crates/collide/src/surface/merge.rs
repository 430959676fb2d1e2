//! From the contacts of single triangles to manifolds.

use super::facet::Facet;
use super::{Probe, Touch};
use crate::reduce::reduce;
use crate::{ContactPoint, Manifold};

/// Cosine of 2°: contacts whose normals differ less share a manifold.
const SAME: f32 = 0.999_39;

/// Appends the manifolds that the contacts make, deepest first.
pub(super) fn manifolds(facets: &[Facet], probe: &Probe, touches: Vec<Touch>, out: &mut Vec<Manifold>) {
    let mut kept: Vec<Touch> =
        touches.iter().filter(|t| !explained(facets, probe, t) && !behind(facets, probe, &touches, t)).copied().collect();
    // Deepest first, so that a group takes its normal from its deepest point.
    kept.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(facets[a.facet].triangle.cmp(&facets[b.facet].triangle))
            .then(a.feature.cmp(&b.feature))
    });
    let mut taken = vec![false; kept.len()];
    let mut points: Vec<ContactPoint> = Vec::new();
    let near = (2e-5 * probe.size) * (2e-5 * probe.size);
    for first in 0..kept.len() {
        if taken[first] {
            continue;
        }
        let normal = kept[first].out;
        points.clear();
        for (touch, taken) in kept.iter().zip(&mut taken).skip(first) {
            if *taken || touch.out.dot(normal) < SAME {
                continue;
            }
            *taken = true;
            let position = touch.on_a - 0.5 * touch.distance * touch.out;
            // Two triangles report a point over their common edge: one is enough.
            if points.iter().all(|p| p.position.distance_squared(position) > near) {
                points.push(ContactPoint { position, distance: touch.distance, feature: touch.feature });
            }
        }
        out.push(reduce(-normal, &points));
    }
}

/// Whether a point that is deep behind its triangle is much less deep behind another, which then is where it came
/// in: a box that leans on the side of a step does not stand on its top.
fn explained(facets: &[Facet], probe: &Probe, touch: &Touch) -> bool {
    touch.doubtful
        && -touch.distance > probe.margin
        && facets.iter().any(|other| {
            let height = other.height(touch.on_a);
            height <= 0.0
                && height > 0.5 * touch.distance
                && other.height(probe.center) > 0.0
                && other.holds(touch.on_a, height)
        })
}

/// Whether A's centre is behind the triangle while another one, which it is less behind, pushes it the other way: the
/// back of a thin wall does not pull a body through.
fn behind(facets: &[Facet], probe: &Probe, touches: &[Touch], touch: &Touch) -> bool {
    let height = |touch: &Touch| facets[touch.facet].height(probe.center);
    height(touch) < 0.0
        && touches.iter().any(|other| height(other) > height(touch) && other.out.dot(touch.out) < 0.0)
}
