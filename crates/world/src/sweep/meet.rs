//! Fast bodies that would pass through bodies that contacts move.
//!
//! Each fast body looks for the first that it would pass through, with the whole ways of both. Those meetings are then settled in the order
//! of time. Of two fast bodies each yields by its share of the mass: from there on both go along their common normal at the speed that
//! their momenta have in common, as after an inelastic impact. A body that is not fast, and may lie in a pile, goes its way, and the
//! fast one yields alone. Whoever yields has a new way from there on, and so may meet others; whose partner has yielded looks again.
//!
//! The meetings are few, and are settled one after the other; they are found beside each other.

use super::flight::{Flight, SLIDES, fly, leaves, stop, stop_distance};
use super::ways::Ways;
use super::{Crowd, Scene};
use crate::Kind;
use rayon::prelude::*;
use rockfall_collide::{Motion, Sweep};
use rockfall_math::share::Share;
use rockfall_math::{Aabb, Vec3};
use rockfall_tree::Fold;
use std::collections::BTreeMap;

/// How often in a step a body yields, to whatever; then it goes its way, and others yield.
const STOPS: usize = 4 * SLIDES;

/// How often it yields where the other does not any more either: bullets that rest on a wall, which each further one turns off.
const LAST: usize = 4 * STOPS;

/// A fast body comes to another that contacts move.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    /// Share of the step, 0 to 1.
    time: f32,
    row: u32,
    other: u32,
    /// From the first to the other.
    normal: Vec3,
    /// Of both, when it was found.
    stops: [usize; 2],
}

/// Settles all meetings. `flights` are those of the fast bodies, by rows; returns those that go another way than the solver gave them.
pub(super) fn meet(scene: &Scene<'_>, flights: Vec<Flight>) -> Vec<Flight> {
    let strays = flights.iter().filter(|flight| flight.stops > 0);
    let (rows, areas): (Vec<_>, Vec<_>) =
        strays.map(|flight| (flight.row, flight.area(scene.bodies, 0.0))).unzip();
    let strays = Crowd::new(rows, &areas);
    let mut sky = Sky { scene, flights, ways: Ways::of_all(scene), strays, strayed: Vec::new() };
    let first: Vec<Meeting> =
        sky.flights.par_iter().shared().filter_map(|flight| sky.first_meeting(flight, 0.0)).collect();
    let mut queue: BTreeMap<_, _> = first.into_iter().map(|meeting| (sky.turn(&meeting), meeting)).collect();
    while let Some((_, meeting)) = queue.pop_first() {
        let rows = [meeting.row, meeting.other];
        let again = if rows.map(|row| sky.stops(row)) == meeting.stops {
            sky.settle(&meeting)
        } else {
            vec![meeting.row]
        };
        for row in again {
            let next = sky.fast(row).and_then(|i| sky.first_meeting(&sky.flights[i], meeting.time));
            queue.extend(next.map(|next| (sky.turn(&next), next)));
        }
    }
    sky.flights.retain(|flight| flight.stops > 0);
    sky.flights
}

/// All flights of fast bodies.
struct Sky<'a> {
    scene: &'a Scene<'a>,
    /// By rows.
    flights: Vec<Flight>,
    /// How the solver has moved all bodies.
    ways: Fold<Ways>,
    /// Those that were stopped before any meeting, and go elsewhere.
    strays: Crowd,
    /// Rows of those that were stopped since, and where they go.
    strayed: Vec<(u32, Aabb)>,
}

impl Sky<'_> {
    /// When a meeting has its turn: the earliest first, then by the ids of both.
    fn turn(&self, meeting: &Meeting) -> (u32, [u64; 2]) {
        let ids = [meeting.row, meeting.other].map(|row| self.scene.bodies.ids[row as usize]);
        // Times are not negative, so that their bits are in their order.
        (meeting.time.max(0.0).to_bits(), ids)
    }

    fn fast(&self, row: u32) -> Option<usize> {
        self.flights.binary_search_by_key(&row, |flight| flight.row).ok()
    }

    fn stops(&self, row: u32) -> usize {
        self.fast(row).map_or(0, |i| self.flights[i].stops)
    }

    /// The first body that contacts move through which a fast one would pass from a time on.
    fn first_meeting(&self, flight: &Flight, from: f32) -> Option<Meeting> {
        let bodies = self.scene.bodies;
        if flight.stops > LAST {
            return None;
        }
        let near = self.near(flight, &flight.area(bodies, from));
        let meetings = near.into_iter().filter_map(|other| {
            let (time, normal) = match self.fast(other) {
                Some(i) => self.passage(flight, &self.flights[i], from)?,
                None => self.passage(flight, &Flight::straight(self.scene, other), from)?,
            };
            Some(Meeting { time, row: flight.row, other, normal, stops: [flight.stops, self.stops(other)] })
        });
        let id = |meeting: &Meeting| bodies.ids[meeting.other as usize];
        meetings.min_by(|a, b| a.time.total_cmp(&b.time).then_with(|| id(a).cmp(&id(b))))
    }

    /// Rows of bodies that contacts move and that a flight may pass through within `area`, ascending. Most of a stream go the same way; they are
    /// passed over before anything that takes time.
    fn near(&self, flight: &Flight, area: &Aabb) -> Vec<u32> {
        let own = Some(Ways::of(self.scene, flight.row)).filter(|_| flight.stops == 0);
        let mut near = Vec::new();
        let mut meets = |other: u32| {
            let moves = self.scene.bodies.kinds[other as usize] == Kind::Dynamic;
            near.extend(Some(other).filter(|&other| moves && self.scene.collide(flight.row, other)));
        };
        let reaches = |ways: &Ways, from: &Aabb| {
            own.is_none_or(|own| !own.is_calm(ways)) && ways.reached_from(area).overlaps(from)
        };
        let movers = &self.scene.trees.movers;
        movers.query_where(&self.ways.all.reached_from(area), &self.ways, reaches, &mut meets);
        self.strays.query(area, &mut meets);
        self.strayed.iter().filter(|(_, theirs)| theirs.overlaps(area)).for_each(|(row, _)| meets(*row));
        near.sort_unstable();
        near.dedup();
        near
    }

    /// When and along which normal one flight would pass through another, leg by leg.
    fn passage(&self, a: &Flight, b: &Flight, from: f32) -> Option<(f32, Vec3)> {
        let [shape_a, shape_b] = [self.scene.shape(a.row)?, self.scene.shape(b.row)?];
        let target = stop_distance(self.scene, a.row);
        let mut time = from;
        loop {
            let until = a.leg(time).1.min(b.leg(time).1);
            let [of_a, of_b] = [a, b].map(|flight| flight.between(time, until, a.origin));
            if let Some(hit) = stop(shape_a, shape_b, &Sweep { a: of_a, b: of_b }, target, a.spins) {
                return Some((time + (until - time) * hit.time, hit.normal));
            }
            if until >= 1.0 {
                return None;
            }
            time = until;
        }
    }

    /// Turns those off that yield. Returns who has to look again.
    fn settle(&mut self, meeting: &Meeting) -> Vec<u32> {
        let Meeting { time, row, other, normal, .. } = *meeting;
        let lines = &self.scene.bodies.lines;
        let yields = |most: usize| {
            [row, other].map(|row| self.fast(row).is_some_and(|i| self.flights[i].stops < most))
        };
        let flights = [row, other].map(|row| match self.fast(row) {
            Some(i) => self.flights[i].clone(),
            None => Flight::straight(self.scene, row),
        });
        let motions = [0, 1].map(|side: usize| flights[side].onwards(time));
        let into = (motions[0].translation - motions[1].translation).dot(normal);
        let inverse = [row, other].map(|row| lines[row as usize].motion[6]);
        let both = inverse[0] + inverse[1];
        let shares = match (yields(STOPS), yields(LAST)) {
            ([true, true], _) if both > 0.0 => [inverse[0] / both, inverse[1] / both],
            ([true, _], _) => [1.0, 0.0],
            ([_, true], _) => [0.0, 1.0],
            // The lighter one: who is heavy is in the way of many.
            (_, [true, true]) if inverse[0] < inverse[1] => [0.0, 1.0],
            (_, [true, _]) => [1.0, 0.0],
            (_, [_, true]) => [0.0, 1.0],
            _ => return Vec::new(),
        };
        let blow = normal * into.max(0.0);
        let along = [-blow, blow];
        let slides = |side: usize| Motion {
            translation: motions[side].translation + along[side] * shares[side],
            rotation: if shares[side] > 0.0 { Vec3::ZERO } else { motions[side].rotation },
            ..motions[side]
        };
        let mut on = [slides(0), slides(1)];
        // Both seen from the first one's origin.
        let mut seen = on;
        seen[1].start.translation += (flights[1].origin - flights[0].origin).as_vec3();
        if leaves(self.scene, [row, other], seen, blow) {
            let common = motions[0].translation * shares[1] + motions[1].translation * shares[0];
            on.iter_mut()
                .zip(shares)
                .filter(|(_, share)| *share > 0.0)
                .for_each(|(on, _)| on.translation = common);
        }
        let mut again = Vec::new();
        for (side, row) in [row, other].into_iter().enumerate() {
            if let Some(i) = self.fast(row).filter(|_| shares[side] > 0.0) {
                self.flights[i].turn_off(time, on[side]);
                self.flights[i] = fly(self.scene, self.flights[i].clone());
                let area = self.flights[i].area(self.scene.bodies, time);
                self.strayed.retain(|(strayed, _)| *strayed != row);
                self.strayed.push((row, area));
                again.push(row);
            }
        }
        again
    }
}
