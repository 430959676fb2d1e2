//! Stage 14, **report**: what happened between bodies, as data.
//!
//! Reads contacts, poses and the trees; writes lists sorted by ids. Nothing is done for who does not ask: contacts are looked through
//! only in a world that watches them, and sensors are bodies that nothing collides with, so that only themselves look around.

use crate::bodies::Bodies;
use crate::touches::{Run, Touches, rows};
use crate::{BodyId, Settings};
use rayon::prelude::*;
use rockfall_math::share::{Share, ShareSort};
use rockfall_math::{DVec3, Vec3};
use rockfall_solve::{Contacts, row_of};

/// What a world is to tell after each step; nothing by default. Sensors tell in any case. The solvers `impulse` and `reflect` keep no impulses: with them
/// pairs touch by their distance alone, and there are no forces and no hits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Watch {
    /// Which bodies begin to touch, go on, and cease: [`Events::begun`] and the others.
    pub contacts: bool,
    /// The forces in all contacts: [`Events::forces`].
    pub forces: bool,
    /// Bodies that press each other by more than this in a step, N s: [`Events::hits`].
    pub impulse: Option<f32>,
}

/// Two bodies, the one with the smaller id first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    /// The smaller id.
    pub a: BodyId,
    /// The larger id.
    pub b: BodyId,
}

/// A body in a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Presence {
    /// The sensor.
    pub sensor: BodyId,
    /// What is in it.
    pub body: BodyId,
}

/// Two bodies that pressed each other hard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Who.
    pub pair: Pair,
    /// Sum of the normal impulses of all their contact points over the step, N s: divided by the length of the step, the mean force.
    pub impulse: f32,
}

/// The force between two bodies at one place of contact, at the end of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Who.
    pub pair: Pair,
    /// The middle of the contact's points at the start of the step, weighted by their forces; metres.
    pub position: DVec3,
    /// Unit vector from `pair.a` to `pair.b`.
    pub normal: Vec3,
    /// On `pair.b` along the normal, and on `pair.a` against it, N.
    pub normal_force: f32,
    /// On `pair.b`, at right angles to the normal; the opposite on `pair.a`; N.
    pub friction: Vec3,
}

/// What the last step had to tell. All lists ascend by ids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Pairs that touch and did not in the step before: a contact point had no distance left at the start of the step, or carried a load.
    pub begun: Vec<Pair>,
    /// Pairs that touch and did before.
    pub persisting: Vec<Pair>,
    /// Pairs that touched in the step before and do not any more, those of bodies that were removed included.
    pub ended: Vec<Pair>,
    /// Bodies that have come into a sensor.
    pub entered: Vec<Presence>,
    /// Bodies that are in a sensor, those that have just come included.
    pub present: Vec<Presence>,
    /// Bodies that have left a sensor, those that were removed included.
    pub left: Vec<Presence>,
    /// Pairs that pressed each other by more than [`Watch::impulse`].
    pub hits: Vec<Hit>,
    /// All contacts that carry a load.
    pub forces: Vec<ContactForce>,
}

/// A pair that touches, and by how much it is pressed.
type Touching = (Pair, f32);

impl Events {
    /// Tells of the contacts of a step.
    pub(crate) fn tell_contacts(
        &mut self,
        watch: &Watch,
        bodies: &Bodies,
        touches: &Touches,
        contacts: &Contacts,
        settings: &Settings,
    ) {
        self.forces.clear();
        self.hits.clear();
        let mut touching: Vec<Touching> = Vec::new();
        if watch.contacts || watch.impulse.is_some() {
            let runs = touches.runs.par_iter().shared();
            touching = runs.flat_map_iter(|run| touching_in(run, bodies, contacts)).collect();
            touching.sort_shared_by_key(|(pair, _)| *pair);
        }
        if let Some(least) = watch.impulse {
            let hits = touching.iter().filter(|(_, impulse)| *impulse > least);
            self.hits.extend(hits.map(|&(pair, impulse)| Hit { pair, impulse }));
        }
        let now = touching.into_iter().map(|(pair, _)| pair).filter(|_| watch.contacts);
        let before = merge(std::mem::take(&mut self.begun), std::mem::take(&mut self.persisting));
        let (begun, persisting, ended) = compare(&before, &now.collect::<Vec<_>>());
        // Nothing ends where nobody watches any more.
        (self.begun, self.persisting) = (begun, persisting);
        self.ended = if watch.contacts { ended } else { Vec::new() };
        if watch.forces {
            let rate = settings.rate * settings.substeps as f32;
            let runs = touches.runs.par_iter().shared();
            self.forces = runs.flat_map_iter(|run| forces_in(run, bodies, contacts, rate)).collect();
            // A pair's contacts keep the order in which the pair has them.
            self.forces.sort_shared_stably_by_key(|force| force.pair);
        }
    }

    /// Tells who is in sensors now; `now` ascends.
    pub(crate) fn tell_presence(&mut self, now: Vec<Presence>) {
        (self.entered, _, self.left) = compare(&self.present, &now);
        self.present = now;
    }
}

/// What is new, what is in both, and what is gone, of two lists that ascend.
fn compare<T: Copy + Ord>(before: &[T], now: &[T]) -> (Vec<T>, Vec<T>, Vec<T>) {
    let (mut new, mut both, mut gone) = (Vec::new(), Vec::new(), Vec::new());
    let mut rest = before;
    for &one in now {
        while let Some((&first, after)) = rest.split_first().filter(|(first, _)| **first < one) {
            gone.push(first);
            rest = after;
        }
        match rest.split_first() {
            Some((&first, after)) if first == one => {
                both.push(one);
                rest = after;
            }
            _ => new.push(one),
        }
    }
    gone.extend_from_slice(rest);
    (new, both, gone)
}

fn merge(mut a: Vec<Pair>, b: Vec<Pair>) -> Vec<Pair> {
    a.extend(b);
    // Two stretches that ascend: what this sort is quick at.
    a.sort();
    a
}

/// The pair of a key, and whether its first row has the larger id.
fn pair_of(key: u64, bodies: &Bodies) -> (Pair, bool) {
    let (a, b) = rows(key);
    let [a, b] = [row_of(a), row_of(b)].map(|row| BodyId(bodies.ids[row]));
    if a <= b { (Pair { a, b }, false) } else { (Pair { a: b, b: a }, true) }
}

fn touching_in<'a>(
    run: &'a Run,
    bodies: &'a Bodies,
    contacts: &'a Contacts,
) -> impl Iterator<Item = Touching> + 'a {
    (0..run.keys.len()).filter_map(move |i| {
        let mut touches = false;
        let mut impulse = 0.0;
        for &lane in &run.lanes[run.contacts(i as u32)] {
            let (manifold, memory) = contacts.read(lane);
            let count = manifold.count as usize;
            touches |= manifold.deepest() <= 0.0 || memory.normals[..count].iter().any(|&x| x > 0.0);
            impulse += contacts.total(lane).unwrap_or_default().iter().sum::<f32>();
        }
        touches.then(|| (pair_of(run.keys[i], bodies).0, impulse))
    })
}

fn forces_in<'a>(
    run: &'a Run,
    bodies: &'a Bodies,
    contacts: &'a Contacts,
    rate: f32,
) -> impl Iterator<Item = ContactForce> + 'a {
    (0..run.keys.len()).flat_map(move |i| {
        let (pair, swapped) = pair_of(run.keys[i], bodies);
        let row = row_of(rows(run.keys[i]).0);
        let start = bodies.positions[row] - bodies.drifts[row].translation().as_dvec3();
        run.lanes[run.contacts(i as u32)].iter().filter_map(move |&lane| {
            let (manifold, memory) = contacts.read(lane);
            let points = manifold.arms.iter().zip(&memory.normals).take(manifold.count as usize);
            let (mut impulse, mut moment) = (0.0, Vec3::ZERO);
            for (arm, normal) in points {
                impulse += normal;
                moment += *arm * *normal;
            }
            let sign = if swapped { -1.0 } else { 1.0 };
            (impulse > 0.0).then(|| ContactForce {
                pair,
                position: start + (moment / impulse).as_dvec3(),
                normal: manifold.normal * sign,
                normal_force: impulse * rate,
                friction: memory.friction * (sign * rate),
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_told_apart() {
        let (new, both, gone) = compare(&[1, 3, 4, 7, 9], &[0, 3, 5, 7, 8]);
        assert_eq!((new, both, gone), (vec![0, 5, 8], vec![3, 7], vec![1, 4, 9]));
        let none: [i32; 0] = [];
        assert_eq!(compare(&none, &[1, 2]), (vec![1, 2], vec![], vec![]));
        assert_eq!(compare(&[1, 2], &none), (vec![], vec![], vec![1, 2]));
    }
}
