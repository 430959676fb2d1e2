//! The way out of each other for two fields that overlap by more than half of what is thin.
//!
//! A point that has come through more than half of a wall finds the way out on the wrong side. Of two tubes that cross, points of one lead out of the other to all sides from there on, none of them
//! faces it, and what is left pushes another way in each step: rings that a heap pressed into each other stayed so, and shook. How the overlap changes when one body moves is known from the surface in it: along the sum of its normals it shrinks
//! fastest (the divergence theorem; Wang, Faure and Pai, "Adaptive Image-based Intersection Volume", SIGGRAPH 2012). That way changes sides where the bodies are right in each other, twice as deep, and all points that are pressed go along it until they are out.

use super::exact::Two;
use super::gather::Contact;
use super::side::Near;
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::Field;
use std::collections::BTreeMap;

/// Overlaps deeper than this share of the smaller inner radius are parted as a whole, if that is more than the spacing of the samples: of thinner walls too few are in each other to be summed.
const DEEP: f32 = 0.5;

/// Width of the cells that an overlap is looked at by, in spacings; and how far around its samples contacts are of it.
const REGION: f32 = 1.5;

/// A point is pressed where its surface looks against its own way out by this cosine at least.
const PRESSED: f32 = 0.5;

/// Normals whose sum is a smaller share of the area that they stand for say nothing: a small body is all in a large one.
const SHARE: f32 = 0.05;

/// Looks along the way out of one point, each as far ahead as the field says that its surface is.
const LOOKS: usize = 32;

/// A sample that is in the other body.
pub(super) struct Sunk {
    /// Of which body, 0 or 1, and its number.
    pub(super) k: usize,
    pub(super) number: usize,
    /// Signed distance, metres.
    pub(super) distance: f32,
}

/// The same in A's frame.
struct Point {
    at: Vec3,
    normal: Vec3,
    /// Which of the overlaps it is in.
    region: usize,
}

/// Puts contacts along one way for each deep overlap in the place of those that were found there.
pub(super) fn part(pair: &Two, sunk: &[Sunk], out: &mut Vec<Contact>) {
    let thin = pair.fields.iter().fold(f32::INFINITY, |thin, field| thin.min(field.inner_ball().1));
    let is_deep = |s: &Sunk| s.distance < -DEEP * thin;
    if DEEP * thin < spacing(pair) || !sunk.iter().any(is_deep) {
        return;
    }
    let points = regions(pair, sunk);
    let mut deep: Vec<usize> =
        sunk.iter().zip(&points).filter(|(s, _)| is_deep(s)).map(|(_, p)| p.region).collect();
    deep.sort_unstable();
    deep.dedup();
    for region in deep {
        let inside = || sunk.iter().zip(&points).filter(|(_, point)| point.region == region);
        let (sum, area) = inside().fold((Vec3::ZERO, 0.0), |(sum, area), (s, point)| {
            let own = pair.fields[s.k].settings().spacing.powi(2);
            (sum + if s.k == 0 { -own } else { own } * point.normal, area + own)
        });
        if sum.length() < SHARE * area {
            continue;
        }
        // A goes along it, B against it.
        let way = sum.normalize();
        let pressed: Vec<Contact> = inside()
            .filter_map(|(s, point)| {
                let own_way = if s.k == 0 { way } else { -way };
                if point.normal.dot(own_way) > -PRESSED {
                    return None;
                }
                let other = 1 - s.k;
                let length = way_out(pair.fields[other], &pair.sides[other].place, point.at, own_way);
                let there = Near { distance: -length, normal: own_way };
                Some(Contact::new(s.k == 1, point.at, there, pair.sample_name(s.number)))
            })
            .collect();
        if pressed.is_empty() {
            continue;
        }
        let reach = REGION * pair.spacing;
        out.retain(|contact| {
            contact.distance > 0.0
                || inside().all(|(_, point)| point.at.distance(contact.own_point()) > reach)
        });
        out.extend(pressed);
    }
}

/// The larger one of the two, metres.
fn spacing(pair: &Two) -> f32 {
    pair.fields.iter().fold(0.0, |most, field| most.max(field.settings().spacing))
}

/// The samples in A's frame, those near each other with the number of the same region: what is in cells of a grid beside each other.
fn regions(pair: &Two, sunk: &[Sunk]) -> Vec<Point> {
    let width = REGION * spacing(pair);
    let mut points = Vec::new();
    let mut cells: BTreeMap<[i32; 3], Vec<usize>> = BTreeMap::new();
    for (i, s) in sunk.iter().enumerate() {
        let (place, sample) = (&pair.sides[s.k].place, &pair.fields[s.k].samples().points()[s.number]);
        let at = place.point(sample.position);
        // A cast saturates, so that what is out of range is in the last cell.
        let cell = (at / width).floor().to_array().map(|x| x as i32);
        cells.entry(cell).or_default().push(i);
        points.push(Point { at, normal: place.vector(sample.normal), region: 0 });
    }
    let (mut open, mut region) = (Vec::new(), 0);
    while let Some((cell, members)) = cells.pop_first() {
        open.push((cell, members));
        while let Some((cell, members)) = open.pop() {
            members.into_iter().for_each(|i| points[i].region = region);
            let beside = (0..27).map(|n| [n % 3, n / 3 % 3, n / 9]);
            let beside = beside.map(|step| std::array::from_fn(|i| cell[i].saturating_add(step[i] - 1)));
            open.extend(beside.filter_map(|cell| cells.remove_entry(&cell)));
        }
        region += 1;
    }
    points
}

/// How far a point in a field at some place has to go along a direction (unit) until it is out, metres.
fn way_out(field: &Field, place: &Isometry, p: Vec3, direction: Vec3) -> f32 {
    let nearly = 0.5 * field.settings().error;
    let mut length = 0.0;
    for _ in 0..LOOKS {
        let distance = field.distance(place.inverse_point(p + length * direction));
        if distance >= 0.0 {
            break;
        }
        length += -distance;
        if -distance < nearly {
            break;
        }
    }
    length
}
