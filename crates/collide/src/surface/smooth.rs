//! Any convex shape against one triangle: the nearest points of both, and what lies around them.
//!
//! Where the surface may push along the line of the nearest points, which leave the triangle at an edge or a corner, that is
//! the contact. Else A is pushed along the triangle's normal: what lies over the triangle of the patch that A turns to it (the
//! end of a cylinder, a line of its side, a face).

use super::facet::{Facet, corner_pushes};
use super::{Placed, Probe, Surface, Touch};
use crate::form::{Form, Solid};
use crate::gjk::{Core, Near, Placed as Seen, Walk, walk};
use crate::patch::{LEVEL, Patch, patch};
use crate::penetration::least_overlap;
use crate::reduce::start;
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::EdgeKind;

/// Cosine of 3°: a direction as near as this to a normal is that normal.
const ALIGNED: f32 = 0.9986;

/// Cosine of 10°: a face tilted less than this lies on what it touches.
const LIES: f32 = 0.985;

/// Sine by which a direction may leave the cone of an edge or a corner.
const CONE: f32 = 2e-4;

/// Share of A's size, or of the triangle's where that is smaller, by which another direction must be better than the triangle's own normal.
const BETTER: f32 = 1e-4;

/// The point of A's core that is lowest under a plane with this normal.
pub(super) fn lowest(a: &Solid, normal: Vec3) -> Vec3 {
    a.form.point(a.form.support(-normal.as_dvec3())).as_vec3()
}

/// Depths of the corners of A's discs that are equal, metres.
pub(super) fn tie(a: &Solid) -> f32 {
    match &a.form {
        Form::Frustum(f) => LEVEL * f.widest(),
        _ => 0.0,
    }
}

/// So many directions over an edge are tried, and so often is the room around the best of them cut.
const ARCS: u32 = 8;
const SECTIONS: u32 = 30;
/// So many rounds settle a way out over an edge; it has where the cosine to the last one is as near to 1 as this.
const ROUNDS: u32 = 8;
const SETTLED: f64 = 1e-13;
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Contacts of A with triangle `i`.
pub(super) fn touch<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    i: usize,
    a: &Solid,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    let facet = &facets[i];
    if !facet.close {
        return;
    }
    let deepest = lowest(a, facet.normal);
    let height = facet.height(deepest);
    // Deep inside the triangle no edge is as near as its face, and flat ones never push.
    let inside = height <= 0.0 && (0..3).all(|edge| facet.outside(edge, deepest) <= height);
    let flat = facet.kinds.iter().all(|kind| matches!(kind, EdgeKind::Flat | EdgeKind::Concave));
    if !(inside || flat) {
        let seen = Seen::new(&Isometry::IDENTITY);
        let near = match walk(&a.form, &facet.corners[..], &seen, f64::from(probe.margin + a.skin)) {
            Walk::Beyond(_) => {
                went_in_beside(facet, i, a, deepest, probe, touches);
                return;
            }
            Walk::Apart(near) => near,
            Walk::Overlap => least_overlap(&a.form, &facet.corners[..], &seen),
        };
        let touch = along(facet, i, a, &near);
        let cosine = touch.out.dot(facet.normal);
        let step = better(facet, probe);
        let is_better = near.distance as f32 > height + step || near.distance > 0.0;
        if cosine > 0.0
            && cosine < ALIGNED
            && is_better
            && pushes(placed, facet, touch.out, near.on_b.as_vec3())
        {
            touches.push(touch);
            return;
        }
        if near.distance <= 0.0 && is_better {
            // The shortest way out of the triangle alone may be one that the surface does not push.
            let ways = (0..3).filter_map(|edge| over(facet, edge, a));
            let best = ways.max_by(|one, two| one.separation.total_cmp(&two.separation));
            if let Some(best) = best.filter(|best| best.separation > height + step) {
                touches.extend(best.touch(placed, facet, i, a, step));
                return;
            }
        }
    }
    let spoke = probe.frame * start(probe.frame.transpose() * facet.normal);
    let shown = on_face(facet, i, a, &patch(a, -facet.normal, spoke), deepest, probe, touches);
    if !shown && height < 0.0 && !goes_on_lower(facet, deepest) {
        touches.extend(lowest_over(facet, i, a, height, probe));
    }
}

/// A direction between the normals of two triangles in which A reaches less far beyond their common edge than in all others near it.
struct Over {
    out: Vec3,
    /// Signed distance of A's core from the edge along it, metres.
    separation: f32,
    /// Whether it is the last one that the edge can push along: there the triangle beyond does.
    is_last: bool,
}

impl Over {
    /// The contact along it; nothing where it is the last, which is the normal of the triangle beyond, or where A touches another place than the edge:
    /// other triangles know of those.
    fn touch<S: Surface>(
        &self,
        placed: &Placed<S>,
        facet: &Facet,
        i: usize,
        a: &Solid,
        step: f32,
    ) -> Option<Touch> {
        if self.is_last {
            return None;
        }
        let (mut out, mut separation) = (self.out.as_dvec3(), f64::from(self.separation));
        let mut best = None;
        // A that is moved out a little further than it needs is nearest to where it leaves the triangle: see `penetration`.
        for _ in 0..ROUNDS {
            let away = (separation - f64::from(step)) * out;
            let moved = Seen::new(&Isometry::IDENTITY).moved(away);
            let Walk::Apart(near) = walk(&a.form, &facet.corners[..], &moved, f64::INFINITY) else { break };
            let low = a.form.point(a.form.support(near.normal));
            let near = Near { on_b: near.on_b - away, ..near };
            let distance = near.normal.dot(near.on_b - low);
            let is_same = near.normal.dot(-out) > 1.0 - SETTLED;
            (out, separation) = (-near.normal, distance);
            best = Some(Near { distance, ..near });
            if is_same {
                break;
            }
        }
        let near = best?;
        let touch = along(facet, i, a, &near);
        pushes(placed, facet, touch.out, near.on_b.as_vec3()).then_some(touch)
    }
}

/// The shortest way out over an edge, along a direction that the surface can push in.
fn over(facet: &Facet, edge: usize, a: &Solid) -> Option<Over> {
    let last = match facet.kinds[edge] {
        EdgeKind::Flat | EdgeKind::Concave => return None,
        EdgeKind::Boundary => facet.outward[edge],
        EdgeKind::Convex => facet.beyond[edge],
    };
    let [first, last, outward] = [facet.normal, last, facet.outward[edge]].map(|v| v.as_dvec3());
    let corner = facet.corners[edge].as_dvec3();
    let middle = (first + last).normalize_or(outward);
    // From 0, the triangle's normal, to 2.
    let out = |t: f64| {
        let way = if t < 1.0 { first.lerp(middle, t) } else { middle.lerp(last, t - 1.0) };
        way.normalize_or(middle)
    };
    let separation = |t: f64| {
        let out = out(t);
        out.dot(a.form.point(a.form.support(-out)) - corner)
    };
    let step = 2.0 / f64::from(ARCS);
    let places = (0..=ARCS).map(|k| f64::from(k) * step);
    let best = places.fold((0.0, f64::NEG_INFINITY), |best, t| {
        let here = separation(t);
        if here > best.1 { (t, here) } else { best }
    });
    // Golden sections around the best of these.
    let (mut low, mut high) = ((best.0 - step).max(0.0), (best.0 + step).min(2.0));
    for _ in 0..SECTIONS {
        let (p, q) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if separation(p) > separation(q) { high = q } else { low = p }
    }
    let t = 0.5 * (low + high);
    let (t, separation) = if separation(t) > best.1 { (t, separation(t)) } else { best };
    Some(Over { out: out(t).as_vec3(), separation: separation as f32, is_last: t > 2.0 - 1e-3 })
}

/// By how much another direction must be better than the triangle's own normal, metres.
fn better(facet: &Facet, probe: &Probe) -> f32 {
    BETTER * probe.size.min(facet.size())
}

/// The nearest points of A and any triangle that it is in front of, for where no triangle has contacts: over the bottom of a
/// valley, as seen from each side, A is lowest beyond the other. Where A overlaps a triangle and has its middle in front of that along the way out, the shortest
/// such way along its normal or over an edge.
pub(super) fn nearest(facets: &[Facet], a: &Solid, probe: &Probe) -> Option<Touch> {
    let mut best: Option<Touch> = None;
    for (i, facet) in facets.iter().enumerate().filter(|(_, facet)| facet.close) {
        let limit = best.map_or(probe.margin, |touch| touch.distance.max(-a.skin)) + a.skin;
        let seen = Seen::new(&Isometry::IDENTITY);
        let (touch, front) = match walk(&a.form, &facet.corners[..], &seen, f64::from(limit)) {
            Walk::Apart(near) => (along(facet, i, a, &near), facet.height(near.on_a.as_vec3()) > 0.0),
            Walk::Overlap => {
                let touch = outward(facet, i, a);
                (touch, touch.in_front(probe.center) > 0.0)
            }
            Walk::Beyond(_) => continue,
        };
        let is_nearer = |best: Touch| match best.distance > -a.skin {
            true => touch.distance < best.distance,
            false => touch.distance <= -a.skin && touch.distance > best.distance,
        };
        if front && best.is_none_or(is_nearer) {
            best = Some(touch);
        }
    }
    best
}

/// The deepest point of A along the triangle's normal or over an edge, whichever is the shorter way out.
fn outward(facet: &Facet, i: usize, a: &Solid) -> Touch {
    let own = facet.height(lowest(a, facet.normal));
    let over = (0..3).filter_map(|edge| over(facet, edge, a)).map(|over| (over.separation, over.out));
    let (separation, out) =
        over.fold((own, facet.normal), |best, way| if way.0 > best.0 { way } else { best });
    Touch {
        out,
        on_a: lowest(a, out) - a.skin * out,
        distance: separation - a.skin,
        feature: facet.own_feature(7, 0, 0),
        facet: i,
        doubtful: false,
    }
}

/// The deepest point of A, where it lies under the triangle but A went in through a neighbour in the same plane.
fn went_in_beside(
    facet: &Facet,
    i: usize,
    a: &Solid,
    deepest: Vec3,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    let height = facet.height(deepest);
    if height >= 0.0 || facet.height(probe.center) <= 0.0 || !facet.holds(deepest, height) {
        return;
    }
    let outside = [0, 1, 2].map(|edge| facet.outside(edge, deepest));
    let nearest = (0..3).fold(0, |near, edge| if outside[edge] > outside[near] { edge } else { near });
    if facet.kinds[nearest] == EdgeKind::Flat {
        touches.push(facet.face_touch(i, deepest, a.skin, 0));
    }
}

/// Whether the surface goes on flat to where A is deeper. What is convex is lowest over the triangle on one of the edges that have the
/// deepest point beyond them, and over a flat one the neighbour has something lower. A point there would be one of the side that comes down
/// next: what rolls would run into it.
fn goes_on_lower(facet: &Facet, deepest: Vec3) -> bool {
    let mut towards = (0..3).filter(|&edge| facet.outside(edge, deepest) > 0.0).peekable();
    towards.peek().is_some() && towards.all(|edge| facet.kinds[edge] == EdgeKind::Flat)
}

/// The lowest part of A over a triangle whose plane it goes through by `height`, which is negative, deepest elsewhere: what is
/// nearest to the triangle once that is moved out of A.
fn lowest_over(facet: &Facet, i: usize, a: &Solid, height: f32, probe: &Probe) -> Option<Touch> {
    let out = (height - BETTER * probe.size) * facet.normal;
    let moved = Seen::new(&Isometry { translation: out, ..Isometry::IDENTITY });
    let Walk::Apart(near) = walk(&a.form, &facet.corners[..], &moved, f64::INFINITY) else { return None };
    let on_a = near.on_a.as_vec3();
    let height = facet.height(on_a);
    (height <= probe.margin + a.skin && facet.holds(on_a, height))
        .then(|| facet.face_touch(i, on_a, a.skin, 0))
}

/// The contact along the line of the nearest points.
fn along(facet: &Facet, i: usize, a: &Solid, near: &Near) -> Touch {
    let out = -near.normal.as_vec3();
    let (_, edge, at) = facet.rim(near.on_b.as_vec3());
    let corners = if at > 0.0 && at < 1.0 {
        [edge, edge + 1]
    } else {
        let corner = if at > 0.0 { edge + 1 } else { edge };
        [corner, corner]
    };
    Touch {
        out,
        on_a: near.on_a.as_vec3() - a.skin * out,
        distance: near.distance as f32 - a.skin,
        feature: facet.shared_feature(corners, 0),
        facet: i,
        doubtful: false,
    }
}

/// Whether the surface can push along `out` from a point on the rim of the triangle.
fn pushes<S: Surface>(placed: &Placed<S>, facet: &Facet, out: Vec3, at: Vec3) -> bool {
    let (_, edge, t) = facet.rim(at);
    let length = facet.corners[edge].distance(facet.corners[(edge + 1) % 3]);
    // Nearest points know their place to a share of the size only.
    let end = 1e-5;
    if t > end && t < 1.0 - end && length > 0.0 {
        facet.edge_pushes(edge, out, CONE)
    } else {
        let corner = if t > 0.5 { (edge + 1) % 3 } else { edge };
        corner_pushes(placed.surface, facet.triangle, corner, placed.direction_back(out), CONE)
    }
}

/// A under the triangle's normal: the parts of its patch in the prism over the triangle, the triangle's corners under it, and
/// the deepest point where the patch does not show it. Whether anything of the patch is over the triangle.
fn on_face(
    facet: &Facet,
    i: usize,
    a: &Solid,
    patch: &Patch,
    deepest: Vec3,
    probe: &Probe,
    touches: &mut Vec<Touch>,
) -> bool {
    let reach = probe.margin + a.skin;
    let n = patch.corners.len();
    let (before, mut crossed) = (touches.len(), false);
    let mut shown = f32::INFINITY;
    for (k, &v) in patch.corners.iter().enumerate() {
        let height = facet.height(v);
        shown = shown.min(height);
        if height <= reach && facet.holds(v, height) {
            touches.push(facet.face_touch(i, v, a.skin, k + 1));
        }
    }
    let height = facet.height(deepest);
    if height < shown - patch.tie && height <= reach && facet.holds(deepest, height) {
        touches.push(facet.face_touch(i, deepest, a.skin, 0));
    }
    // Of a line there is one edge, of a face as many as it has corners.
    for e in 0..if n == 2 { 1 } else { n } {
        let (p, q) = (patch.corners[e], patch.corners[(e + 1) % n]);
        let heights = [facet.height(p), facet.height(q)];
        if heights[0].min(heights[1]) > reach {
            continue;
        }
        let sides = (0..3).map(|side| {
            let [from, to] = [(p, heights[0]), (q, heights[1])]
                .map(|(v, height)| facet.outside(side, v) - facet.allowance(side, height));
            (from, to)
        });
        let Some(ends) = super::solid::clip(sides) else { continue };
        crossed |= ends.iter().any(|(t, _)| facet.height(p + *t * (q - p)) <= reach);
        for (k, (t, cut)) in ends.into_iter().enumerate() {
            // Over a flat border the neighbour has the rest, and its end.
            let v = p + t * (q - p);
            if cut.is_some_and(|side| facet.kinds[side] != EdgeKind::Flat) && facet.height(v) <= reach {
                let feature = facet.own_feature(3, e, k);
                touches.push(Touch { feature, ..facet.face_touch(i, v, a.skin, 0) });
            }
        }
    }
    if n < 3 || patch.cosine < LIES {
        return crossed || touches.len() > before;
    }
    for (k, &corner) in facet.corners.iter().enumerate() {
        let distance = patch.height(corner) / patch.cosine - a.skin;
        if distance <= probe.margin && patch.sides().all(|(from, outward)| outward.dot(corner - from) <= 0.0)
        {
            touches.push(Touch {
                out: facet.normal,
                on_a: corner + distance * facet.normal,
                distance,
                feature: facet.shared_feature([k, k], 64 + patch.face),
                facet: i,
                doubtful: true,
            });
        }
    }
    crossed || touches.len() > before
}
