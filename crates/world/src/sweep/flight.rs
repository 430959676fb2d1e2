//! The way of a fast body through a step, in straight legs.

use super::Scene;
use crate::Shape;
use crate::bodies::Bodies;
use rockfall_collide::{Motion, Sweep, Toi, passage, time_of_impact};
use rockfall_math::{Aabb, DVec3, Isometry, Mat3, Vec3, rotation};
use rockfall_solve::Drift;
use rockfall_solve::line::Role;
use smallvec::SmallVec;

/// Distance at which a fast body is stopped, as a share of its inner radius: within its reach at rest.
const STOP: f32 = 0.01;

/// Radians in a step.
const SPIN: f32 = 1.0;

/// How often in a step a body that was stopped goes on along what stopped it: into the corner of three walls.
pub(super) const SLIDES: usize = 3;

/// How a body moves from some time of the step to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    /// Share of the step, 0 to 1.
    pub(super) from: f32,
    pub(super) motion: Motion,
}

impl Leg {
    /// Which share of the leg's motion is over at a time.
    fn share(&self, time: f32) -> f32 {
        let whole = 1.0 - self.from;
        if whole > 0.0 { ((time - self.from) / whole).min(1.0) } else { 0.0 }
    }
}

/// Legs one after the other: each holds until the next begins, the last until the end of the step.
#[derive(Clone, Debug)]
pub(super) struct Flight {
    pub(super) row: u32,
    /// What the legs are seen from: the body's place at the start of the step.
    pub(super) origin: DVec3,
    pub(super) legs: SmallVec<[Leg; 2]>,
    /// How often it has been stopped.
    pub(super) stops: usize,
    /// Whether the solver turned it by more than [`SPIN`].
    pub(super) spins: bool,
}

impl Flight {
    /// The way that the solver has given a body.
    pub(super) fn straight(scene: &Scene<'_>, row: u32) -> Self {
        let (way, turn) = way(scene.bodies, row);
        let origin = scene.bodies.positions[row as usize] - way.as_dvec3();
        let motion = motion(scene, row, origin);
        let spins = turn.length() > SPIN;
        Flight { row, origin, legs: SmallVec::from_slice(&[Leg { from: 0.0, motion }]), stops: 0, spins }
    }

    /// The leg that holds at a time, and when it ends.
    pub(super) fn leg(&self, time: f32) -> (&Leg, f32) {
        let next = self.legs.iter().position(|leg| leg.from > time).unwrap_or(self.legs.len());
        (&self.legs[next.saturating_sub(1)], self.legs.get(next).map_or(1.0, |leg| leg.from))
    }

    /// The motion from a time to the end of the step, if nothing more comes in the way.
    pub(super) fn onwards(&self, time: f32) -> Motion {
        let leg = self.leg(time).0;
        leg.motion.after(leg.share(time))
    }

    /// Goes on with another motion from a time on.
    pub(super) fn turn_off(&mut self, time: f32, motion: Motion) {
        self.legs.retain(|leg| leg.from < time);
        self.legs.push(Leg { from: time, motion });
        self.stops += 1;
    }

    /// All of the motion.
    pub(super) fn drift(&self) -> Drift {
        let (first, last) = (self.legs[0], self.legs[self.legs.len() - 1]);
        let center = |motion: &Motion, time: f32| motion.at(time).point(motion.center);
        let turned: Vec3 =
            self.legs.iter().map(|leg| leg.motion.rotation * leg.share(self.leg(leg.from).1)).sum();
        let mut drift = Drift::default();
        drift.set(center(&last.motion, 1.0) - center(&first.motion, 0.0), turned);
        drift
    }

    /// The part of the motion between two times, within one leg, seen from another origin.
    pub(super) fn between(&self, from: f32, until: f32, origin: DVec3) -> Motion {
        let leg = self.leg(from).0;
        let mut motion = leg.motion.between(leg.share(from), leg.share(until));
        motion.start.translation += (self.origin - origin).as_vec3();
        motion
    }

    /// A box around the body from a time on.
    pub(super) fn area(&self, bodies: &Bodies, from: f32) -> Aabb {
        let turns = self.legs.iter().map(|leg| leg.from).filter(|&time| time > from);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for time in turns.chain([from, 1.0]) {
            let motion = self.onwards(time);
            let place = self.origin + motion.start.point(motion.center).as_dvec3();
            (low, high) = (low.min(place), high.max(place));
        }
        let row = self.row as usize;
        Aabb::around(low, high).grown(bodies.radii[row] + STOP * bodies.inners[row])
    }
}

/// Takes a body on its last leg past those that contacts can't move: up to the first, and then along it, without turning: that would take
/// its ends further in at each stop.
pub(super) fn fly(scene: &Scene<'_>, mut flight: Flight) -> Flight {
    let mut last = None;
    for slides in 0.. {
        let from = flight.legs[flight.legs.len() - 1].from;
        let Some((time, normal, other)) = first_impact(scene, &flight, from) else { break };
        let their = motion(scene, other, flight.origin).after(time);
        let mut left = Motion { rotation: Vec3::ZERO, ..flight.onwards(time) };
        let blow = normal * (left.translation - their.translation).dot(normal).max(0.0);
        // After the last slide it stays at what it met, and goes with that.
        left.translation = if slides == SLIDES { their.translation } else { left.translation - blow };
        flight.turn_off(time, left);
        last = Some((time, other, their, blow));
        if slides == SLIDES {
            return flight;
        }
    }
    if let Some((time, other, their, blow)) = last {
        let left = flight.onwards(time);
        if leaves(scene, [flight.row, other], [left, their], blow) {
            flight.turn_off(time, Motion { translation: their.translation, ..left });
        }
    }
    flight
}

/// Whether a body that hit another hard, and lost a way `blow` that no contact makes good, slides past the rim of what it hit: to where
/// that way would not lead onto it again in the next step. The blow would be lost.
pub(super) fn leaves(scene: &Scene<'_>, [a, b]: [u32; 2], on: [Motion; 2], blow: Vec3) -> bool {
    let (Some(shape_a), Some(shape_b)) = (scene.shape(a), scene.shape(b)) else { return false };
    let [end_a, end_b] = on.map(|motion| Motion::at_rest(motion.at(1.0)));
    let sweep = Sweep { a: Motion { translation: blow, ..end_a }, b: end_b };
    blow.length() > scene.bodies.inners[a as usize]
        && time_of_impact(shape_a, shape_b, &sweep, stop_distance(scene, a)).is_none()
}

/// When a body on its last leg meets one that contacts can't move, along which normal, and which.
fn first_impact(scene: &Scene<'_>, flight: &Flight, from: f32) -> Option<(f32, Vec3, u32)> {
    let shape = scene.shape(flight.row)?;
    let left = flight.onwards(from);
    let target = stop_distance(scene, flight.row);
    let area = flight.area(scene.bodies, from);
    let hits = scene.near_fixed(flight.row, &area).into_iter().filter_map(|other| {
        let motion = motion(scene, other, flight.origin);
        let sweep = Sweep { a: left, b: motion.after(from) };
        Some((stop(shape, scene.shape(other)?, &sweep, target, flight.spins)?, other))
    });
    let ids = &scene.bodies.ids;
    hits.min_by(|(a, m), (b, n)| {
        a.time.total_cmp(&b.time).then_with(|| ids[*m as usize].cmp(&ids[*n as usize]))
    })
    .map(|(Toi { time, normal, .. }, other)| (from + (1.0 - from) * time, normal, other))
}

/// Where a body has to be stopped: see [`passage`].
///
/// What `spins`, turns by more than [`SPIN`], has made another way than the one that it is taken, between the same two places; so, besides,
/// the ball inside is stopped, which looks the same from all sides.
pub(super) fn stop(a: &Shape, b: &Shape, sweep: &Sweep, target: f32, spins: bool) -> Option<Toi> {
    let whole = passage(a, b, sweep, target);
    if !spins || !a.is_convex() {
        return whole;
    }
    let middle = sweep.a.start.point(sweep.a.center);
    let start = Isometry { translation: middle, ..Isometry::IDENTITY };
    let ball = Motion { translation: sweep.a.translation, ..Motion::at_rest(start) };
    let inner =
        passage(&Shape::Sphere { radius: a.inner_radius() }, b, &Sweep { a: ball, b: sweep.b }, target);
    match (whole, inner) {
        (Some(p), Some(q)) => Some(if q.time < p.time { q } else { p }),
        (p, q) => p.or(q),
    }
}

/// How far from what it would pass through a body is stopped, metres.
pub(super) fn stop_distance(scene: &Scene<'_>, row: u32) -> f32 {
    STOP * scene.bodies.inners[row as usize]
}

/// What a body has gone and turned in the step.
pub(super) fn way(bodies: &Bodies, row: u32) -> (Vec3, Vec3) {
    match bodies.roles[row as usize] {
        Role::Still => (Vec3::ZERO, Vec3::ZERO),
        _ => (bodies.drifts[row as usize].translation(), bodies.drifts[row as usize].rotation()),
    }
}

/// How the body of a row moved in this step, seen from `origin`: straight from where it was to where it is, by the shorter turn. Whatever it did in between, it
/// can't have come through what it does not come through this way.
fn motion(scene: &Scene<'_>, row: u32, origin: DVec3) -> Motion {
    let Scene { bodies, starts, .. } = *scene;
    let (way, row) = (way(bodies, row).0, row as usize);
    let (start, end) = (starts[row], bodies.rotations[row]);
    let turn = match bodies.roles[row] {
        Role::Still => Vec3::ZERO,
        _ => rotation::to_rotation_vector(rotation::compose(end, rotation::inverse(start))),
    };
    let rotation = Mat3::from_quat(start);
    let center = bodies.centers[row];
    let place = (bodies.positions[row] - way.as_dvec3() - origin).as_vec3();
    Motion {
        start: Isometry { rotation, translation: place - rotation * center },
        center,
        translation: way,
        rotation: turn,
    }
}
