//! Spheres and capsules against one triangle: points and a segment, at a distance.

use super::facet::{Facet, ROUNDING, corner_pushes};
use super::{Placed, Probe, Surface, Touch, merge};
use rockfall_math::Vec3;
use rockfall_shape::EdgeKind;

/// Contacts of a sphere (one core point) or a capsule (two) with triangle `i`.
pub(super) fn touch<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    i: usize,
    core: &[Vec3],
    radius: f32,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    let facet = &facets[i];
    if !facet.close || core.iter().all(|&p| facet.height(p) - radius > probe.margin) {
        return;
    }
    for (k, &p) in core.iter().enumerate() {
        let height = facet.height(p);
        if height - radius > probe.margin {
            continue;
        }
        if facet.holds(p, height) {
            touches.push(facet.face_touch(i, p, radius, k));
        } else if height > 0.0 {
            let (q, edge, at) = facet.rim(p);
            push(placed, facets, i, (p, q), (edge, at), radius, k, probe, touches);
        }
    }
    if let &[start, end] = core {
        for edge in 0..3 {
            if matches!(facet.kinds[edge], EdgeKind::Flat | EdgeKind::Concave) {
                continue;
            }
            let (a, b) = (facet.corners[edge], facet.corners[(edge + 1) % 3]);
            let (s, t) = crossing(start, end, a, b);
            // The ends of the core had their turn.
            if s > 0.0 && s < 1.0 {
                let (p, q) = (start + s * (end - start), a + t * (b - a));
                let inside = p - q;
                let buried = facet.outward[edge].dot(inside) < 0.0
                    && facet.back_from_beyond(edge).dot(inside) < 0.0
                    && facet.kinds[edge] == EdgeKind::Convex;
                if buried && t > 0.0 && t < 1.0 {
                    // The core itself passes below the edge.
                    let depth = inside.length();
                    let out = (-inside).normalize_or(facet.normal);
                    touches.push(Touch {
                        out,
                        on_a: p - radius * out,
                        distance: -depth - radius,
                        feature: facet.shared_feature([edge, edge + 1], 2),
                        facet: i,
                        doubtful: false,
                    });
                } else {
                    push(placed, facets, i, (p, q), (edge, t), radius, 2, probe, touches);
                }
            }
        }
    }
}

/// The contact of the core point that is nearest to the surface, if that is in front of it, for where no triangle has any: of a ball that is much
/// larger than the triangles rounding may say of each that the nearest point is another one's.
pub(super) fn nearest(facets: &[Facet], core: &[Vec3], radius: f32, probe: &Probe) -> Option<Touch> {
    let near = |&p: &Vec3| {
        let facet = merge::nearest(facets, p, probe);
        (p, facet, facet.distance(p))
    };
    let (p, facet, gap) = core.iter().map(near).min_by(|one, two| one.2.total_cmp(&two.2))?;
    if facet.height(p) <= 0.0 || gap - radius > probe.margin {
        return None;
    }
    let (q, edge, _) = facet.rim(p);
    let out = (p - q).normalize_or(facet.normal);
    let feature = facet.shared_feature([edge, edge + 1], 3);
    let place = facets.iter().position(|other| other.triangle == facet.triangle)?;
    Some(Touch {
        out,
        on_a: p - radius * out,
        distance: gap - radius,
        feature,
        facet: place,
        doubtful: false,
    })
}

/// Contact of the core point `p` with the point `q` at parameter `at` of an edge, if the surface can push from there.
#[allow(clippy::too_many_arguments)]
fn push<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    i: usize,
    (p, q): (Vec3, Vec3),
    (edge, at): (usize, f32),
    radius: f32,
    k: usize,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    let facet = &facets[i];
    let gap = (p - q).length();
    if gap - radius > probe.margin {
        return;
    }
    let out = if gap > 0.0 { (p - q) / gap } else { facet.normal };
    let (pushes, feature) = if at > 0.0 && at < 1.0 {
        (facet.edge_pushes(edge, out, ROUNDING), facet.shared_feature([edge, edge + 1], k))
    } else {
        let corner = if at > 0.0 { (edge + 1) % 3 } else { edge };
        (
            corner_pushes(placed.surface, facet.triangle, corner, placed.direction_back(out), ROUNDING),
            facet.shared_feature([corner, corner], k),
        )
    };
    if pushes && facet.normal.dot(out) > -ROUNDING {
        let on_a = p - radius * out;
        touches.push(Touch { out, on_a, distance: gap - radius, feature, facet: i, doubtful: false });
    }
}

/// Parameters of the nearest points of the segments from `p` to `q` and from `a` to `b` (Ericson, *Real-Time Collision
/// Detection*, 2005, section 5.1.9).
fn crossing(p: Vec3, q: Vec3, a: Vec3, b: Vec3) -> (f32, f32) {
    let (d1, d2, r) = (q - p, b - a, p - a);
    let (l1, l2) = (d1.length_squared(), d2.length_squared());
    let (c, f, m) = (d1.dot(r), d2.dot(r), d1.dot(d2));
    // Far from the origin the ends of a short edge fall together.
    if l2 <= 0.0 {
        return (if l1 > 0.0 { (-c / l1).clamp(0.0, 1.0) } else { 0.0 }, 0.0);
    }
    if l1 <= 0.0 {
        return (0.0, (f / l2).clamp(0.0, 1.0));
    }
    let denominator = l1 * l2 - m * m;
    let s = if denominator > 1e-6 * l1 * l2 { ((m * f - c * l2) / denominator).clamp(0.0, 1.0) } else { 0.5 };
    let t = (m * s + f) / l2;
    if t < 0.0 {
        ((-c / l1).clamp(0.0, 1.0), 0.0)
    } else if t > 1.0 {
        (((m - c) / l1).clamp(0.0, 1.0), 1.0)
    } else {
        (s, t)
    }
}
