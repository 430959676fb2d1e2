//! Questions to a compound: each part answers for itself, the first or nearest or deepest of the answers counts.

use super::{Area, turned};
use crate::{Distance, Nearest, Ray, RayHit, Toi};
use rockfall_math::{Aabb, DVec3, Isometry, Vec3, rotation};
use rockfall_shape::{Compound, Part, Shape};

/// The nearest pair of parts, or the one that overlaps most.
pub(crate) fn distance(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Distance> {
    let Shape::Compound(compound) = b else {
        let a_in_b = b_in_a.inverse();
        return distance(b, a, &a_in_b).map(|d| seen_from_a(&d, b_in_a));
    };
    let mut best: Option<(u32, Distance)> = None;
    let mut ask = |number: u32| {
        let part = &compound.parts()[number as usize];
        if let Some(this) = crate::distance(a, &part.shape, &b_in_a.then_after(&part.place)) {
            let nearer = |(known, d): &(u32, Distance)| {
                this.distance < d.distance || (this.distance == d.distance && number < *known)
            };
            if best.as_ref().is_none_or(nearer) {
                best = Some((number, this));
            }
        }
        // All that overlap are of interest, and what is as near by rounding.
        best.map_or(f32::INFINITY, |(_, d)| d.distance.max(0.0) * (1.0 + 1e-5))
    };
    match Area::new(a, &b_in_a.inverse()) {
        Area::Everywhere => (0..compound.parts().len() as u32).for_each(|number| {
            ask(number);
        }),
        Area::Box(area) => compound.tree().nearest(&area, f32::INFINITY, |number, _| ask(number)),
    }
    best.map(|(_, distance)| distance)
}

/// The distance of a pair in the frame of B, where A was second, as one in the frame of A, where it is first.
fn seen_from_a(d: &Distance, b_in_a: &Isometry) -> Distance {
    Distance {
        distance: d.distance,
        normal: -b_in_a.vector(d.normal),
        on_a: b_in_a.point(d.on_b),
        on_b: b_in_a.point(d.on_a),
    }
}

/// The part that a point is nearest to, or deepest in.
pub(crate) fn nearest_point(compound: &Compound, p: DVec3, limit: f32) -> Option<Nearest> {
    let mut best: Option<(u32, Nearest)> = None;
    let mut max = limit;
    compound.tree().nearest(&Aabb::around(p, p), max, |number, _| {
        let part = &compound.parts()[number as usize];
        let there = rotation::rotate_back_double(part.pose.rotation, p - part.pose.position);
        if let Some(near) = crate::nearest_point(&part.shape, there, max) {
            let nearer = |(known, by): &(u32, Nearest)| {
                near.distance < by.distance || (near.distance == by.distance && number < *known)
            };
            if best.as_ref().is_none_or(nearer) {
                best = Some((number, near));
                max = near.distance;
            }
        }
        max.max(0.0)
    });
    best.map(|(number, near)| {
        let place = &compound.parts()[number as usize].place;
        Nearest { point: place.point(near.point), normal: place.vector(near.normal), ..near }
    })
}

/// Whether a part of one shares a point with the other.
pub(crate) fn overlaps(a: &Shape, b: &Shape, b_in_a: &Isometry) -> bool {
    match (a, b) {
        (_, Shape::Compound(compound)) => near(a, compound, b_in_a)
            .any(|part| crate::overlaps(a, &part.shape, &b_in_a.then_after(&part.place))),
        (Shape::Compound(compound), _) => {
            let a_in_b = b_in_a.inverse();
            near(b, compound, &a_in_b).any(|part| {
                let b_in_part = part.place.inverse().then_after(b_in_a);
                crate::overlaps(&part.shape, b, &b_in_part)
            })
        }
        _ => false,
    }
}

/// The deepest overlap of two parts, in A's frame.
pub(crate) fn penetration(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Distance> {
    let deepest = |all: &mut dyn Iterator<Item = Distance>| {
        all.reduce(|first, other| if other.distance < first.distance { other } else { first })
    };
    match (a, b) {
        (_, Shape::Compound(compound)) => deepest(
            &mut near(a, compound, b_in_a)
                .filter_map(|part| crate::penetration(a, &part.shape, &b_in_a.then_after(&part.place))),
        ),
        (Shape::Compound(compound), _) => {
            let a_in_b = b_in_a.inverse();
            deepest(&mut near(b, compound, &a_in_b).filter_map(|part| {
                let b_in_part = part.place.inverse().then_after(b_in_a);
                let d = crate::penetration(&part.shape, b, &b_in_part)?;
                let place = &part.place;
                let (normal, on_a, on_b) = (place.vector(d.normal), place.point(d.on_a), place.point(d.on_b));
                Some(Distance { normal, on_a, on_b, ..d })
            }))
        }
        _ => None,
    }
}

/// Parts of B whose boxes meet that of A, in their order.
fn near<'a>(a: &Shape, b: &'a Compound, b_in_a: &Isometry) -> impl Iterator<Item = &'a Part> + use<'a> {
    let numbers = Area::new(a, &b_in_a.inverse()).near(b, 0.0);
    numbers.into_iter().map(|number| &b.parts()[number as usize])
}

/// The first part that a ray meets.
pub(crate) fn cast_ray(compound: &Compound, ray: &Ray, solid: bool) -> Option<RayHit> {
    let mut best: Option<(u32, RayHit)> = None;
    let mut max = ray.max;
    // Single precision has no direction that is very short or long.
    let scale = ray.direction.abs().max_element();
    let along = (ray.direction / scale).as_vec3();
    compound.tree().cast_box(&Aabb::around(ray.origin, ray.origin), along, up(max * scale), |number, _| {
        let part = &compound.parts()[number as usize];
        let back = |v: DVec3| rotation::rotate_back_double(part.pose.rotation, v);
        let there =
            Ray { origin: back(ray.origin - part.pose.position), direction: back(ray.direction), max };
        if let Some(hit) = crate::cast_ray(&part.shape, &there, solid) {
            let nearer = |(known, by): &(u32, RayHit)| hit.t < by.t || (hit.t == by.t && number < *known);
            if best.as_ref().is_none_or(nearer) {
                best = Some((number, hit));
                max = hit.t;
            }
        }
        up(max * scale)
    });
    best.map(|(number, hit)| {
        let inside = hit.part == crate::INSIDE;
        let normal = compound.parts()[number as usize].place.vector(hit.normal);
        RayHit { normal, part: if inside { hit.part } else { u64::from(number) }, ..hit }
    })
}

/// In single precision, not less.
fn up(x: f64) -> f32 {
    let single = x as f32;
    if f64::from(single) < x { single.next_up() } else { single }
}

/// The first touch of a part of one with the other; see [`cast_shape`](crate::cast_shape).
pub(crate) fn cast_shape(a: &Shape, b: &Shape, a_in_b: &Isometry, translation: Vec3) -> Option<Toi> {
    match (a, b) {
        (_, Shape::Compound(compound)) => {
            let mut first: Option<(u32, Toi)> = None;
            let area = turned(&a.bounds(), a_in_b);
            compound.tree().cast_box(&area, translation, 1.0, |number, max| {
                let part = &compound.parts()[number as usize];
                let a_in_part = part.place.inverse().then_after(a_in_b);
                let way = part.place.inverse_vector(translation);
                if let Some(toi) = crate::cast_shape(a, &part.shape, &a_in_part, way) {
                    let earlier =
                        |(known, by): &(u32, Toi)| sooner(&toi, by) || (!sooner(by, &toi) && number < *known);
                    if first.as_ref().is_none_or(earlier) {
                        first = Some((number, toi));
                    }
                }
                first.map_or(max, |(_, toi)| toi.time)
            });
            first.map(|(number, toi)| {
                let place = &compound.parts()[number as usize].place;
                Toi { normal: place.vector(toi.normal), point: place.point(toi.point), ..toi }
            })
        }
        (Shape::Compound(compound), _) => compound
            .parts()
            .iter()
            .filter_map(|part| {
                crate::cast_shape(&part.shape, b, &a_in_b.then_after(&part.place), translation)
            })
            .reduce(|first, other| if sooner(&other, &first) { other } else { first }),
        _ => None,
    }
}

/// Which of two touches comes first: of those from the start, the deeper one.
fn sooner(one: &Toi, other: &Toi) -> bool {
    one.time < other.time || (one.time == other.time && one.distance < other.distance)
}
