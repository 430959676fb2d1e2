//! From the contacts of single triangles to manifolds.

use super::facet::Facet;
use super::{Placed, Probe, Surface, Touch};
use crate::gjk::{Core, Placed as Seen, Proximity, Walk, proximity, walk};
use crate::reduce::{reduce_within, start};
use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};

/// Cosine of 2°: contacts whose normals differ less share a manifold.
const SAME: f32 = 0.999_39;

/// Share of A's size, or of the radius of the ball inside of a closed surface that is much smaller, from which on a depth needs an explanation.
const DEEP: f32 = 0.004;

/// Overlap with a closed surface, as a share of the radius of the ball inside, beyond which a shorter way out is the right one; what is fast is stopped before.
const DEEPEST: f32 = 0.25;

/// Cosine of 1.4 milliradians: directions that differ less are one.
const ONE_WAY: f32 = 0.999_999;

/// Share of the depth, and of A's size or that of the triangle where it is smaller, by which a way out is longer than another one: depths are known to that.
const LONGER: f32 = 2e-3;
const LONGER_OF_SIZE: f32 = 5e-5;

/// The contacts that no other triangle explains better.
pub(super) fn keep(facets: &[Facet], probe: &Probe, touches: &[Touch]) -> Vec<Touch> {
    let mut in_front = None;
    let mut dropped = |touch: &Touch| {
        let facet = &facets[touch.facet];
        let height = touch.in_front(probe.center);
        let buried = height < 0.0 && touch.distance + probe.radius < 0.0;
        // Whoever is in front of the surface is touched from behind only by what reaches over its edge.
        let wrong_side = buried
            && if *in_front
                .get_or_insert_with(|| nearest(facets, probe.center, probe).height(probe.center) > 0.0)
            {
                !crosses(probe.points, facet)
            } else {
                height < -probe.limit
            };
        wrong_side
            || explained(facets, probe, touches, touch)
            || height < 0.0 && opposed(probe, touches, touch)
    };
    let mut kept: Vec<Touch> = touches.iter().filter(|t| !dropped(t)).copied().collect();
    if kept.iter().all(|t| t.distance > 0.0) {
        // All explanations pointed at each other: where A crosses a triangle, the shallowest contact stays.
        let rest = touches.iter().filter(|t| t.distance <= 0.0 && crosses(probe.points, &facets[t.facet]));
        kept.extend(rest.max_by(|a, b| a.distance.total_cmp(&b.distance)));
    }
    kept
}

/// Appends the manifolds that the contacts make, deepest first, but for those that push A further than it needs.
pub(super) fn manifolds<A: Core + ?Sized>(
    facets: &[Facet],
    a: &A,
    probe: &Probe,
    mut kept: Vec<Touch>,
    out: &mut Vec<Manifold>,
) {
    // Of an open one each triangle counts by itself: in a pipe of strips a fast box is in several, and would be held by the wrong one.
    if probe.thickness.is_finite() {
        drop_longer(facets, a, probe, &mut kept);
    }
    let near = (2e-5 * probe.size) * (2e-5 * probe.size);
    let mut points: Vec<ContactPoint> = Vec::new();
    for group in by_direction(facets, kept) {
        points.clear();
        for touch in &group {
            let position = touch.on_a - 0.5 * touch.distance * touch.out;
            // Two triangles report a point over their common edge: one is enough.
            if points.iter().all(|p| p.position.distance_squared(position) > near) {
                points.push(ContactPoint { position, distance: touch.distance, feature: touch.feature });
            }
        }
        let normal = group[0].out;
        let from = probe.frame * start(probe.frame.transpose() * -normal);
        out.push(reduce_within(-normal, &points, from, probe.tie));
    }
}

/// Contacts that look the same way, deepest first, so that a group takes its normal from its deepest point.
fn by_direction(facets: &[Facet], mut kept: Vec<Touch>) -> Vec<Vec<Touch>> {
    kept.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(facets[a.facet].triangle.cmp(&facets[b.facet].triangle))
            .then(a.feature.cmp(&b.feature))
    });
    let mut groups: Vec<Vec<Touch>> = Vec::new();
    for touch in kept {
        match groups.iter_mut().find(|group| touch.out.dot(group[0].out) >= SAME) {
            Some(group) => group.push(touch),
            None => groups.push(vec![touch]),
        }
    }
    groups
}

/// Drops the contacts of triangles that push A further than another triangle does, whose way parts A from them as well: one triangle alone may
/// not know the way out over its rim that a neighbour knows.
fn drop_longer<A: Core + ?Sized>(facets: &[Facet], a: &A, probe: &Probe, kept: &mut Vec<Touch>) {
    let is_one_way = |one: &Touch, other: &Touch| one.out.dot(other.out) > ONE_WAY;
    if kept.iter().all(|touch| is_one_way(touch, &kept[0])) {
        return;
    }
    // The deepest touch of each triangle along each way.
    let mut ways: Vec<Touch> = Vec::new();
    let is_of = |way: &Touch, touch: &Touch| way.facet == touch.facet && is_one_way(way, touch);
    for touch in &*kept {
        match ways.iter_mut().find(|way| is_of(way, touch)) {
            Some(way) if touch.distance < way.distance => *way = *touch,
            Some(_) => {}
            None => ways.push(*touch),
        }
    }
    let is_longer = |way: &Touch| {
        let others = ways.iter().filter(|other| !is_one_way(way, other));
        others.into_iter().any(|other| is_longer(facets, a, probe, way, other))
    };
    let longer: Vec<Touch> = ways.iter().filter(|way| is_longer(way)).copied().collect();
    kept.retain(|touch| !longer.iter().any(|way| is_of(way, touch)));
}

/// Whether a contact pushes A further than `other` does, which parts it from the triangle of that contact as well.
fn is_longer<A: Core + ?Sized>(facets: &[Facet], a: &A, probe: &Probe, touch: &Touch, other: &Touch) -> bool {
    let facet = &facets[touch.facet];
    let (depth, way) = (-touch.distance, -other.distance);
    let room = LONGER * depth + LONGER_OF_SIZE * probe.size.min(facet.size());
    if way <= 0.0 || way >= depth - room {
        return false;
    }
    let moved = (way + 0.5 * room) * other.out;
    // What is over the triangle and behind it still is not parted.
    let point = touch.on_a + probe.radius * touch.out + moved;
    let height = facet.height(point);
    if height < 0.0 && facet.holds(point, 0.0) {
        return false;
    }
    // What is all behind the triangle was moved through it.
    let top = a.point(a.support(facet.normal.as_dvec3())).as_vec3() + moved;
    let seen = Seen::new(&Isometry { translation: -moved, ..Isometry::IDENTITY });
    facet.height(top) > 0.0
        && matches!(walk(a, &facet.corners[..], &seen, f64::from(probe.radius)), Walk::Beyond(_))
}

/// Whether a point that is deep behind its triangle is much nearer to another, which then is where it came in, or is
/// not inside the surface at all: a box that leans on the side of a step does not stand on its top, and one that
/// reaches over a ridge does not hang from its far side. A thin wall that was pierced still holds.
fn explained(facets: &[Facet], probe: &Probe, touches: &[Touch], touch: &Touch) -> bool {
    let large = probe.is_large();
    let exact = (probe.radius > 0.0 || large) && !touch.doubtful;
    let deep = DEEP * if large { probe.thickness } else { probe.size };
    if exact || -touch.distance <= deep {
        return false;
    }
    let core = touch.on_a + probe.radius * touch.out;
    let depth = -(touch.distance + probe.radius);
    let sees = |facet: &Facet| facet.height(probe.center) > 0.0;
    let pushes_less = |i: usize| {
        let of_it = touches.iter().filter(|other| other.facet == i).map(|other| other.distance);
        of_it.reduce(f32::min).is_some_and(|deepest| deepest > touch.distance)
    };
    let nearest = nearest(facets, core, probe);
    let outside = nearest.height(core) > 0.0;
    outside && (sees(nearest) || !crosses(probe.points, &facets[touch.facet]))
        || touch.doubtful
            && facets
                .iter()
                .enumerate()
                .any(|(i, other)| sees(other) && other.distance(core) < 0.5 * depth && pushes_less(i))
}

/// Whether A's core overlaps the triangle.
fn crosses(core: &[Vec3], facet: &Facet) -> bool {
    let way = proximity(core, &facet.corners, &Isometry::IDENTITY, -facet.normal, 0.0);
    matches!(way, Proximity::Overlap)
}

/// Drops what has passed a closed surface: points of A's core behind a triangle, but not in the surface any more; and, where anything overlaps less, what would push A out through it: one triangle alone may know no shorter way.
pub(super) fn drop_passed<S: Surface>(
    placed: &Placed<S>,
    facets: &[Facet],
    probe: &Probe,
    touches: &mut Vec<Touch>,
) {
    let Some((thickness, width)) = placed.surface.inside() else { return };
    // What has its middle in front came through from there, however thin the wall is.
    let came_from_behind = |touch: &Touch| !touch.doubtful || facets[touch.facet].height(probe.center) <= 0.0;
    let core = |touch: &Touch| touch.on_a + probe.radius * touch.out;
    let is_outside = |touch: &Touch| placed.surface.is_outside(placed.back(core(touch)));
    let is_core = |touch: &Touch| touch.doubtful || probe.radius > 0.0;
    touches.retain(|touch| {
        !(touch.distance < -probe.radius && is_core(touch) && came_from_behind(touch) && is_outside(touch))
    });
    // And no way out of it is longer than all of it.
    let far = |touch: &Touch| {
        let depth = -touch.distance - probe.radius;
        depth > DEEPEST * thickness && came_from_behind(touch) || depth > width
    };
    if touches.iter().any(|touch| touch.distance <= 0.0 && !far(touch)) {
        touches.retain(|touch| !far(touch));
    }
}

/// Whether another triangle, which A's centre is less behind, pushes the other way: the back of a thin wall does not
/// pull a body through.
fn opposed(probe: &Probe, touches: &[Touch], touch: &Touch) -> bool {
    let height = |touch: &Touch| touch.in_front(probe.center);
    touches.iter().any(|other| height(other) > height(touch) && other.out.dot(touch.out) < -0.5)
}

/// The triangle nearest to a point; where several meet in the nearest place, the one that faces it most, which
/// tells whether the point is in front of the surface.
pub(super) fn nearest<'a>(facets: &'a [Facet], p: Vec3, probe: &Probe) -> &'a Facet {
    let tie = 1e-5 * probe.size;
    let mut best = (f32::INFINITY, &facets[0]);
    for facet in facets {
        let distance = facet.distance(p);
        let faces = facet.height(p).abs() > best.1.height(p).abs();
        if distance < best.0 - tie || (distance < best.0 + tie && faces) {
            best = (distance.min(best.0), facet);
        }
    }
    best.1
}
