//! Stage 5, **touch**: collision detection: position, normal and signed distance of every contact.
//!
//! Reads pairs, poses and the motion of the last step; writes contacts. All of them follow their bodies; those whose pair has moved
//! too far for that are found anew, each point with the impulse of the point of the same name. Pairs of which neither body moves are
//! left alone. Threads share nothing: each takes whole runs of pairs, and a contact belongs to one pair.

use crate::ahead::Ahead;
use crate::bodies::Bodies;
use crate::inherit::{Couple, Heir, portion};
use crate::recall::{Recall, leash};
use crate::recognise::recognise;
use crate::seam::Ground;
use crate::touches::{NEW, Run, Touches, rows};
use crate::{Settings, Shape};
use rayon::prelude::*;
use rockfall_collide::{Cache, Manifold as Local, Meeting, Met, collide_all};
use rockfall_math::lanes::Width;
use rockfall_math::room::make_room;
use rockfall_math::share::{self, Share};
use rockfall_math::{Isometry, Mat3, Vec3};
use rockfall_solve::line::Role;
use rockfall_solve::{
    Contacts, Desk, FIXED, Found, Lane, Leash, Manifold, Memory, NO_COLOR, Surface, row_of,
};
use std::sync::{Mutex, PoisonError};

/// What changed in the contacts of a run.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    /// Number of the run.
    run: usize,
    /// Contacts that need a lane; those that have a colour keep it.
    arrivals: Vec<Found>,
    /// For each of them, its place among the lanes of the run.
    slots: Vec<u32>,
    /// Lanes that were cleared.
    freed: Vec<Lane>,
    /// Rows of bodies whose contact was not finite.
    broken: Vec<usize>,
}

/// Finds the contacts of all pairs that have moved too far for their contacts to follow, and clears those of pairs that have
/// ended. `rooms` are kept from step to step, one for each thread. Returns what has to be coloured and given a lane: see
/// [`color`] and [`settle_in`].
pub(crate) fn touch(
    rooms: &mut Vec<Mutex<Fresh>>,
    touches: &mut Touches,
    contacts: &mut Contacts,
    ground: Ground<'_>,
    surface: &(impl Fn(usize, usize) -> Surface + Sync),
    settings: &Settings,
    width: Width,
) -> Vec<Changes> {
    let desk = contacts.desk(ground.bodies.rows());
    let look = Look { ground, surface, desk: &desk, dt: 1.0 / settings.rate, reuse: settings.reuse, width };
    rooms.resize_with(share::threads(), Mutex::default);
    touches
        .runs
        .par_iter_mut()
        .enumerate()
        .shared()
        .map(|(number, run)| {
            let room = &rooms[share::thread()];
            // A thread that panicked leaves nothing that the next one would not clear.
            let mut fresh = room.lock().unwrap_or_else(PoisonError::into_inner);
            let mut changes = Changes { run: number, ..Changes::default() };
            fresh.find(run, &look, &mut changes);
            if run.is_current() && fresh.fits(run) {
                fresh.put_in_place(run, &mut changes);
            } else {
                fresh.replace(run, &look, &mut changes);
            }
            changes.is_some().then_some(changes)
        })
        .flatten_iter()
        .collect()
}

impl Changes {
    fn is_some(&self) -> bool {
        !(self.arrivals.is_empty() && self.freed.is_empty() && self.broken.is_empty())
    }

    /// Rows of bodies whose contact was not finite.
    pub(crate) fn broken(changes: &[Changes]) -> Vec<usize> {
        changes.iter().flat_map(|changes| changes.broken.iter().copied()).collect()
    }
}

/// Gives every contact that arrived a colour.
pub(crate) fn color(changes: &mut [Changes], contacts: &mut Contacts, rows: usize) {
    let mut arrivals: Vec<Vec<Found>> = changes.iter_mut().map(|c| std::mem::take(&mut c.arrivals)).collect();
    contacts.paint(&mut arrivals, rows);
    changes.iter_mut().zip(arrivals).for_each(|(changes, arrivals)| changes.arrivals = arrivals);
}

/// Gives every contact that arrived a lane, and takes back those that were cleared. Splits bodies that have come to have too many.
pub(crate) fn settle_in(changes: Vec<Changes>, touches: &mut Touches, contacts: &mut Contacts) {
    changes.iter().for_each(|changes| contacts.free(&changes.freed));
    let (places, mut arrivals): (Vec<_>, Vec<_>) =
        changes.into_iter().map(|changes| ((changes.run, changes.slots), changes.arrivals)).unzip();
    contacts.place(&mut arrivals);
    for ((run, slots), arrivals) in places.iter().zip(&arrivals) {
        let lanes = &mut touches.runs[*run].lanes;
        slots.iter().zip(arrivals).for_each(|(&slot, arrival)| lanes[slot as usize] = arrival.lane);
    }
    if contacts.is_crowded() {
        contacts.split(touches.entries()).into_iter().for_each(|lanes| touches.relocate(&lanes));
    }
}

/// What the contacts of a pair are found from.
struct Look<'a, S> {
    /// All bodies, and which of them never move.
    ground: Ground<'a>,
    surface: &'a S,
    desk: &'a Desk<'a>,
    /// Length of the step, s.
    dt: f32,
    /// Whether what is found serves for longer than a step.
    reuse: bool,
    /// How many pairs are met side by side; changes no bit.
    width: Width,
}

/// A pair that has to be looked at.
#[derive(Debug)]
struct Asked {
    /// Its number in the run.
    pair: usize,
    /// Its place in the columns of the last step, or [`NEW`].
    before: u32,
    ahead: Ahead,
    b_in_a: Isometry,
    /// How far apart contacts may be, metres.
    margin: f32,
}

/// A pair that was looked at.
#[derive(Debug)]
struct Seen {
    /// Its number in the run.
    pair: usize,
    /// First of its contacts among the lanes of [`Fresh`].
    first: usize,
    recall: Recall,
}

/// What is found of a run that is brought up to date. Each thread has its own, and keeps it from step to step.
#[derive(Debug, Default)]
pub(crate) struct Fresh {
    /// Pairs whose contacts can't follow, in the order of their numbers; what they remember; and what came of them.
    asked: Vec<Asked>,
    caches: Vec<Cache>,
    mets: Vec<Met>,
    found: Vec<Local>,
    /// The same pairs.
    seen: Vec<Seen>,
    /// Where their contacts are.
    lanes: Vec<Lane>,
    /// Columns of a run that has other pairs or other contacts than before.
    firsts: Vec<u32>,
    recalls: Vec<Recall>,
    all_lanes: Vec<Lane>,
    locals: Vec<Local>,
    olds: Vec<(Manifold, Memory)>,
    heirs: Vec<Heir>,
    goes_on: Vec<bool>,
}

impl<S: Fn(usize, usize) -> Surface + Sync> Look<'_, S> {
    /// Whether what the pair at place `before` knows is still true enough, and its contacts are where they belong.
    fn stays(&self, run: &Run, key: u64, before: u32) -> bool {
        let (bodies, lanes) = (self.ground.bodies, &run.lanes[run.contacts(before)]);
        if let Some(first) = lanes.first() {
            // What is parked does not follow.
            return match (self.is_active(key), first.is_parked()) {
                (true, false) => lanes.iter().all(|&lane| self.desk.may_follow(lane)),
                (false, true) => at_rest(bodies, key),
                _ => false,
            };
        }
        let [a, b] = bodies_of(key);
        run.recalls[before as usize].serves(bodies.ways[a].wrapping_add(bodies.ways[b]))
            || at_rest(bodies, key)
    }

    /// A pair that has to be looked at: where its bodies are, seen from the first.
    fn ask(&self, run: &Run, pair: usize, before: u32) -> Asked {
        let bodies = self.ground.bodies;
        let rows = bodies_of(run.keys[pair]);
        let touches = before != NEW && !run.contacts(before).is_empty();
        let ahead = self.ahead(rows, touches);
        let margin = bodies.reaches[rows[0]] + bodies.reaches[rows[1]];
        Asked { pair, before, ahead, b_in_a: ahead.b_in_a(bodies, rows), margin }
    }

    /// What a pair remembers, `apart` being how far its shapes are from each other, and for how long its contacts may follow the bodies.
    fn remember(&self, [a, b]: [usize; 2], asked: &Asked, apart: f32, recall: &mut Recall) -> Leash {
        let bodies = self.ground.bodies;
        let [Some(shape_a), Some(shape_b)] = self.shapes([a, b]) else { return Leash::default() };
        let count = bodies.ways[a].wrapping_add(bodies.ways[b]);
        if !self.reuse {
            recall.set(count, 0.0);
            return Leash::default();
        }
        recall.set(count, apart - asked.margin - asked.ahead.way);
        let balls = bodies.balls[a] && bodies.balls[b];
        leash(shape_a, shape_b, [bodies.radii[a], bodies.radii[b]], balls)
    }

    fn shapes(&self, pair: [usize; 2]) -> [Option<&Shape>; 2] {
        pair.map(|row| self.ground.shapes.get(self.ground.bodies.shapes[row] as usize))
    }

    /// For how long a pair, which touches already or does not, is moved ahead.
    fn ahead(&self, pair: [usize; 2], touches: bool) -> Ahead {
        match self.shapes(pair) {
            [Some(a), Some(b)] if touches => Ahead::new(self.ground.bodies, pair, [a, b], self.dt),
            _ => Ahead::default(),
        }
    }

    /// Whether contacts move one of two bodies in this step.
    fn is_active(&self, key: u64) -> bool {
        let (a, b) = rows(key);
        let free = |row: u32| self.ground.bodies.roles[row_of(row)] == Role::Free;
        free(a) || (b & FIXED == 0 && free(b))
    }
}

impl Fresh {
    /// Finds the contacts of those pairs of a run whose contacts can't follow.
    fn find<S: Fn(usize, usize) -> Surface + Sync>(
        &mut self,
        run: &Run,
        look: &Look<'_, S>,
        changes: &mut Changes,
    ) {
        self.asked.clear();
        self.caches.clear();
        for (pair, &key) in run.keys.iter().enumerate() {
            let before = run.before(pair);
            if before == NEW || !look.stays(run, key, before) {
                self.asked.push(look.ask(run, pair, before));
                self.caches.push(if before == NEW {
                    Cache::default()
                } else {
                    run.recalls[before as usize].cache
                });
            }
        }
        let meeting = |i: usize| {
            let Asked { pair, ref b_in_a, margin, .. } = self.asked[i];
            let [Some(a), Some(b)] = look.shapes(bodies_of(run.keys[pair])) else { return None };
            Some(Meeting { a, b, b_in_a, margin })
        };
        collide_all(look.width, meeting, &mut self.caches, &mut self.mets, &mut self.found);

        self.seen.clear();
        self.lanes.clear();
        for i in 0..self.asked.len() {
            let (pair, first) = (self.asked[i].pair, self.lanes.len());
            let recall = self.see(i, run, look, changes);
            self.seen.push(Seen { pair, first, recall });
        }
    }

    /// Contacts of pair number `i` of those that were looked at, as a range of the lanes.
    fn contacts(&self, i: usize) -> std::ops::Range<usize> {
        self.seen[i].first..self.seen.get(i + 1).map_or(self.lanes.len(), |next| next.first)
    }

    /// Whether each pair has as many contacts as before, in a run that has the same pairs.
    fn fits(&self, run: &Run) -> bool {
        let fits = |(i, seen): (usize, &Seen)| self.contacts(i).len() == run.contacts(seen.pair as u32).len();
        self.seen.iter().enumerate().all(fits)
    }

    /// Puts what was found in the place of what was there.
    fn put_in_place(&self, run: &mut Run, changes: &mut Changes) {
        let mut slots = changes.slots.iter_mut().peekable();
        for (i, seen) in self.seen.iter().enumerate() {
            let (here, there) = (self.contacts(i), run.contacts(seen.pair as u32));
            while let Some(slot) = slots.next_if(|slot| here.contains(&(**slot as usize))) {
                *slot = (there.start + *slot as usize - here.start) as u32;
            }
            run.lanes[there].copy_from_slice(&self.lanes[here]);
            run.recalls[seen.pair] = seen.recall;
        }
    }

    /// Makes the columns of a run anew, of what was found and what stays, and gives back the lanes of pairs that have ended.
    fn replace<S: Fn(usize, usize) -> Surface + Sync>(
        &mut self,
        run: &mut Run,
        look: &Look<'_, S>,
        changes: &mut Changes,
    ) {
        self.firsts.clear();
        self.recalls.clear();
        self.all_lanes.clear();
        let mut slots = std::mem::take(&mut changes.slots).into_iter().peekable();
        let (mut next, mut i) = (0, 0);
        for pair in 0..run.keys.len() {
            self.firsts.push(self.all_lanes.len() as u32);
            let before = run.before(pair);
            if before != NEW {
                // Pairs that stand between two that go on have ended.
                end(run, next..before, look.desk, changes);
                next = before + 1;
            }
            let Some(seen) = self.seen.get(i).filter(|seen| seen.pair == pair) else {
                self.all_lanes.extend_from_slice(&run.lanes[run.contacts(before)]);
                self.recalls.push(run.recalls[before as usize]);
                continue;
            };
            let here = self.contacts(i);
            while let Some(slot) = slots.next_if(|&slot| here.contains(&(slot as usize))) {
                changes.slots.push((self.all_lanes.len() + slot as usize - here.start) as u32);
            }
            self.recalls.push(seen.recall);
            self.all_lanes.extend_from_slice(&self.lanes[here]);
            i += 1;
        }
        end(run, next..run.recalls.len() as u32, look.desk, changes);
        self.firsts.push(self.all_lanes.len() as u32);
        run.befores = Vec::new();
        put(&self.firsts, &mut run.firsts);
        put(&self.recalls, &mut run.recalls);
        put(&self.all_lanes, &mut run.lanes);
    }

    /// Turns what was found of a pair into contacts, which go on in the place of its old ones. Returns what it remembers.
    fn see<S: Fn(usize, usize) -> Surface + Sync>(
        &mut self,
        i: usize,
        run: &Run,
        look: &Look<'_, S>,
        changes: &mut Changes,
    ) -> Recall {
        let (bodies, desk, asked) = (look.ground.bodies, look.desk, &self.asked[i]);
        let (key, ahead) = (run.keys[asked.pair], asked.ahead);
        let [a, b] = bodies_of(key);
        let lanes = if asked.before == NEW { &[] } else { &run.lanes[run.contacts(asked.before)] };
        let Met { apart, ref manifolds } = self.mets[i];
        self.locals.clear();
        self.locals.extend_from_slice(&self.found[manifolds.clone()]);
        if !self.locals.is_empty() {
            look.ground.bare(a, b, &mut self.locals);
        }
        let mark = if asked.before == NEW { 0 } else { run.recalls[asked.before as usize].mark };
        let mut recall = Recall { cache: self.caches[i], mark };
        let balls = bodies.balls[a] && bodies.balls[b];
        let leash = look.remember([a, b], asked, apart, &mut recall);
        if self.locals.is_empty() && lanes.is_empty() {
            return recall;
        }
        let (turn, offset) = ahead.axes(bodies, [a, b]);
        self.olds.clear();
        self.olds.extend(lanes.iter().map(|&lane| desk.read(lane)));
        // Of two manifolds that both know an old one the first goes on in its place.
        self.goes_on.clear();
        self.goes_on.resize(lanes.len(), false);
        self.heirs.clear();
        for (local, ordinal) in self.locals.iter().zip(0..) {
            if !is_finite(local) {
                changes.broken.push(a);
                continue;
            }
            let (mut manifold, mut memory) = named(rows(key), local, &turn, bodies.centers[a]);
            let Manifold { count, normal, arms, distances, .. } = &mut manifold;
            let (arms, distances) = (&arms[..*count as usize], &mut distances[..*count as usize]);
            ahead.take_back(bodies, [a, b], offset, *normal, arms, distances);
            let source = recognise(&manifold, &mut memory, &mut self.olds).filter(|&i| !self.goes_on[i]);
            if let Some(i) = source {
                self.goes_on[i] = true;
            }
            self.heirs.push(Heir { manifold, memory, source, ordinal });
        }
        let surface = (look.surface)(a, b);
        if let ([Some(one), Some(other)], false) = (look.shapes([a, b]), self.olds.is_empty()) {
            let portion = portion(bodies, [a, b], [one, other], look.dt);
            if portion > 0.0 {
                let couple = Couple::new(bodies, [a, b], offset, surface.friction);
                couple.inherit(portion, &self.olds, &mut self.heirs);
            }
        }
        for &Heir { mut manifold, mut memory, source, ordinal } in &self.heirs {
            if let Some(i) = source {
                let (old, known) = &self.olds[i];
                // A colour goes with the rows that it is taken at, which may be those of copies.
                (manifold.a, manifold.b, memory.color) = (old.a, old.b, known.color);
            }
            // What was found before it bore any load is looked at once more: where flat shapes come to lie on each other, rounding decides
            // what touches first. Two balls have only one way to touch.
            let contact = Found {
                manifold,
                memory,
                surface,
                offset,
                active: look.is_active(key),
                ordinal,
                balls,
                leash: if source.is_some() || balls { leash } else { Leash::default() },
                lane: source.map_or(Lane::NONE, |i| lanes[i]),
            };
            if source.is_none() || !desk.rewrite(&contact) {
                if source.is_some() {
                    desk.clear(contact.lane, false);
                    changes.freed.push(contact.lane);
                }
                changes.slots.push(self.lanes.len() as u32);
                changes.arrivals.push(Found { lane: Lane::NONE, ..contact });
                self.lanes.push(Lane::NONE);
            } else {
                self.lanes.push(contact.lane);
            }
        }
        for (&lane, _) in lanes.iter().zip(&self.goes_on).filter(|(_, goes_on)| !**goes_on) {
            desk.clear(lane, true);
            changes.freed.push(lane);
        }
        recall
    }
}

/// The rows of a pair's bodies.
fn bodies_of(key: u64) -> [usize; 2] {
    let (a, b) = rows(key);
    [a as usize, row_of(b)]
}

/// Gives back the lanes of pairs that have ended.
fn end(run: &Run, pairs: std::ops::Range<u32>, desk: &Desk<'_>, changes: &mut Changes) {
    for &lane in pairs.flat_map(|before| &run.lanes[run.contacts(before)]) {
        desk.clear(lane, true);
        changes.freed.push(lane);
    }
}

/// Makes `to` a copy of `from`, with little room to spare.
fn put<T: Copy>(from: &[T], to: &mut Vec<T>) {
    to.clear();
    make_room(to, from.len());
    to.extend_from_slice(from);
}

/// Whether neither body of a pair moves.
fn at_rest(bodies: &Bodies, key: u64) -> bool {
    let (a, b) = rows(key);
    rests(bodies, a as usize) && rests(bodies, row_of(b))
}

/// Whether the body of a row has not moved in the last step and nothing moves it in this one.
fn rests(bodies: &Bodies, row: usize) -> bool {
    let still = match bodies.roles[row] {
        Role::Still => true,
        Role::Free => false,
        Role::Driven => bodies.lines[row].motion[..6].iter().all(|&x| x == 0.0),
    };
    still && bodies.drifts[row].0.iter().all(|&x| x == 0.0)
}

fn is_finite(local: &Local) -> bool {
    local.normal.is_finite()
        && local.points().iter().all(|p| p.position.is_finite() && p.distance.is_finite())
}

/// A manifold in axes that `turn` takes those of A's shape to, with the names of its points. `center` is A's middle in those of its shape.
fn named((a, b): (u32, u32), local: &Local, turn: &Mat3, center: Vec3) -> (Manifold, Memory) {
    let normal = *turn * local.normal;
    let mut manifold = Manifold { a, b, count: local.count, normal, ..Manifold::default() };
    let mut memory = Memory { color: NO_COLOR, ..Memory::default() };
    for (p, point) in local.points().iter().enumerate() {
        manifold.arms[p] = *turn * (point.position - center);
        manifold.distances[p] = point.distance;
        memory.features[p] = point.feature;
    }
    (manifold, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touches::tests::{lanes, run_of};
    use rockfall_tree::Tree;

    /// Where pairs have as many contacts as before, columns that are changed in place are those that would be made anew.
    #[test]
    fn in_place_or_anew_is_the_same() {
        let all = lanes(5);
        let run = || run_of(&[1, 2, 3, 4], &mut all.iter().copied(), |key| [1, 2, 0, 2][key as usize - 1]);
        let seen = |pair: usize, first: usize| Seen {
            pair,
            first,
            recall: Recall { mark: 10 + pair as u32, ..Recall::default() },
        };
        // Of the second pair the second contact has come, of the last the first.
        let mut fresh = Fresh {
            seen: vec![seen(1, 0), seen(2, 2), seen(3, 2)],
            lanes: vec![all[1], Lane::NONE, Lane::NONE, all[4]],
            ..Fresh::default()
        };
        let (mut place, mut anew) = (run(), run());
        let came = || Changes { slots: vec![1, 2], ..Changes::default() };
        let (mut in_place, mut made_anew) = (came(), came());
        assert!(fresh.fits(&place));
        fresh.put_in_place(&mut place, &mut in_place);

        let mut contacts = Contacts::default();
        let surface = |_, _| Surface::default();
        let bodies = Bodies::new();
        let tree = Tree::default();
        let ground = Ground { bodies: &bodies, shapes: &[], tree: &tree };
        let (desk, width) = (contacts.desk(1), Width::Scalar);
        let look = Look { ground, surface: &surface, desk: &desk, dt: 1.0, reuse: true, width };
        fresh.replace(&mut anew, &look, &mut made_anew);

        assert_eq!(in_place.slots, [2, 3]);
        assert_eq!(place.lanes, [all[0], all[1], Lane::NONE, Lane::NONE, all[4]]);
        assert_eq!(place.recalls.iter().map(|recall| recall.mark).collect::<Vec<_>>(), [1, 11, 12, 13]);
        assert_eq!((in_place.slots, &place.lanes), (made_anew.slots, &anew.lanes));
        assert_eq!((&place.firsts, place.recalls.len()), (&anew.firsts, anew.recalls.len()));
        assert!(place.recalls.iter().zip(&anew.recalls).all(|(a, b)| a.mark == b.mark));
        assert!(made_anew.freed.is_empty());

        fresh.lanes.pop();
        assert!(!fresh.fits(&anew));
    }
}
