//! Contacts and sensors as data: told once, in order, and true.

mod common;

use common::{Slope, Stage, at, columns, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, BodyId, Error, Events, Kind, Pair, Presence, Settings, Shape, Watch};
use std::collections::BTreeSet;

const CONTACTS: Watch = Watch { contacts: true, forces: false, impulse: None };
const FORCES: Watch = Watch { contacts: false, forces: true, impulse: None };

fn pair(a: BodyId, b: BodyId) -> Pair {
    Pair { a: a.min(b), b: a.max(b) }
}

#[test]
fn a_bouncing_ball_begins_and_ends_in_turns() {
    let mut stage = Stage::on_ground(frames(), rubs(0.0, 0.8));
    let ball = stage.ball(0.5);
    let body = stage.body(ball, at(0.0, 0.0, 2.0));
    let ball = stage.put(body);
    stage.world.watch(CONTACTS).expect("nothing to refuse");
    let (mut begun, mut ended, mut touches) = (0, 0, false);
    for _ in 0..200 {
        stage.steps(1);
        let events = stage.world.events();
        let known = pair(BodyId(1), ball);
        for told in [&events.begun, &events.persisting, &events.ended] {
            assert!(told.is_empty() || told[..] == [known]);
        }
        assert_eq!(events.persisting.is_empty(), !touches || !events.ended.is_empty());
        assert!(events.begun.is_empty() || !touches, "it touches already");
        assert!(events.ended.is_empty() || touches, "it does not touch");
        touches = !events.begun.is_empty() || !events.persisting.is_empty();
        begun += events.begun.len();
        ended += events.ended.len();
    }
    assert!(begun >= 3 && ended >= begun - 1, "{begun} begun, {ended} ended");
}

/// Promise: what has begun and has not ended is what touches, by the contacts of the world.
#[test]
fn pairs_are_those_whose_contacts_touch() {
    let mut stage = columns(3, false);
    stage.world.watch(CONTACTS).expect("nothing to refuse");
    let mut open: BTreeSet<Pair> = BTreeSet::new();
    let ids = stage.world.ids();
    for step in 0..60 {
        if step == 30 {
            stage.world.remove(ids[7]).expect("it is there");
            stage.world.set_pose(ids[12], at(0.0, 0.0, 40.0)).expect("it is there");
        }
        stage.steps(1);
        let events = stage.world.events();
        for list in [&events.begun, &events.persisting, &events.ended] {
            assert!(list.is_sorted() && list.iter().all(|pair| pair.a < pair.b));
        }
        assert!(events.persisting.iter().all(|pair| open.contains(pair)));
        assert!(events.begun.iter().all(|pair| open.insert(*pair)));
        assert!(events.ended.iter().all(|pair| open.remove(pair)));
        let expected: BTreeSet<Pair> = stage
            .world
            .contacts()
            .filter(|contact| contact.distance <= 0.0 || contact.impulse > 0.0)
            .map(|contact| pair(contact.a, contact.b))
            .collect();
        assert_eq!(open, expected, "step {step}");
    }
    assert!(open.len() > 30);
    assert!(open.iter().all(|pair| pair.a != ids[7] && pair.b != ids[7]), "it is gone");
    // Nobody watches any more: nothing is told, and nothing ends.
    stage.world.watch(Watch::default()).expect("nothing to refuse");
    stage.steps(1);
    let events = stage.world.events();
    assert!(events.begun.is_empty() && events.persisting.is_empty() && events.ended.is_empty());
}

#[test]
fn forces_carry_the_weight() {
    let mut stage = Stage::on_ground(frames(), rubs(0.6, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let tower: Vec<BodyId> = (0..3)
        .map(|i| {
            let body = stage.body(cube, at(0.0, 0.0, 0.5 + f64::from(i)));
            stage.put(body)
        })
        .collect();
    stage.world.watch(FORCES).expect("nothing to refuse");
    stage.steps(240);
    let forces = &stage.world.events().forces;
    assert_eq!(forces.len(), 3);
    assert!(forces.is_sorted_by_key(|force| force.pair));
    for (i, force) in forces.iter().enumerate() {
        let below = if i == 0 { BodyId(1) } else { tower[i - 1] };
        assert_eq!(force.pair, pair(below, tower[i]));
        let carried = 1000.0 * common::G * (3 - i) as f32;
        assert!((force.normal_force / carried - 1.0).abs() < 1e-2, "{force:?} carries {carried} N");
        assert!((force.normal - Vec3::Z).length() < 1e-3, "from the lower id, which lies below, up");
        assert!(force.friction.length() < 0.01 * carried);
        assert!((force.position - DVec3::new(0.0, 0.0, i as f64)).length() < 0.05, "{force:?}");
    }
}

/// Whichever of the two has the smaller id, the forces are those on the other one.
#[test]
fn friction_holds_a_cube_on_a_slope() {
    for cube_first in [false, true] {
        let mut stage = Stage::new(frames(), rubs(0.8, 0.0));
        let slope = Slope::new(25.0);
        let plane = stage.shape(Shape::HalfSpace { normal: slope.normal, offset: 0.0 });
        let cube = stage.cuboid(0.5, 0.5, 0.5);
        let [plane_id, cube_id] = if cube_first { [9, 4] } else { [4, 9] };
        let ground =
            Body { id: Some(BodyId(plane_id)), ..Body::fixed(plane, stage.material, Pose::default()) };
        stage.put(ground);
        let body = Body { id: Some(BodyId(cube_id)), ..stage.body(cube, slope.pose(0.5)) };
        stage.put(body);
        stage.world.watch(FORCES).expect("nothing to refuse");
        stage.steps(240);
        let forces = &stage.world.events().forces;
        assert_eq!(forces.len(), 1);
        let force = &forces[0];
        let weight = 1000.0 * common::G;
        let on_cube = if cube_first { -1.0 } else { 1.0 };
        let normal = slope.normal * on_cube;
        assert!((force.normal - normal).length() < 1e-3, "{force:?}");
        assert!((force.normal_force / (weight * slope.normal.z) - 1.0).abs() < 1e-2, "{force:?}");
        let uphill = -slope.down * (weight * slope.normal.x * on_cube);
        assert!((force.friction - uphill).length() < 0.02 * weight, "{force:?}, expected {uphill}");
    }
}

/// Promise: a ball of mass m that falls at v gives the ground (1 + e) m v, in whichever sub-step it lands, and is told of once if that is more than is asked for.
#[test]
fn a_hit_is_told_when_it_is_hard() {
    for (restitution, height) in [(0.0, 2.0), (0.5, 2.0), (0.0, 2.03), (0.0, 2.06), (0.9, 2.09)] {
        let told = |share: f32| {
            let mut stage = Stage::on_ground(frames(), rubs(0.0, restitution));
            let ball = stage.ball(0.5);
            let body = Body { velocity: Vec3::NEG_Z * 10.0, ..stage.body(ball, at(0.0, 0.0, height)) };
            let ball = stage.put(body);
            let mass = stage.world.mass(ball).expect("it is there");
            let fall = height as f32 - 0.5;
            let momentum = (1.0 + restitution) * mass * (100.0 + 2.0 * common::G * fall).sqrt();
            let watch = Watch { impulse: Some(share * momentum), ..Watch::default() };
            stage.world.watch(watch).expect("a good number");
            let mut hits = Vec::new();
            for _ in 0..25 {
                stage.steps(1);
                hits.extend(stage.world.events().hits.iter().copied());
            }
            assert!(hits.iter().all(|hit| hit.pair == pair(BodyId(1), ball)));
            hits.iter().map(|hit| hit.impulse / momentum).collect::<Vec<_>>()
        };
        let hits = told(0.5);
        assert_eq!(hits.len(), 1, "once: {hits:?}");
        // Within a step gravity adds 0.16 m/s to the 11.4 of the fall.
        assert!((hits[0] - 1.0).abs() < 0.02, "restitution {restitution}, from {height} m: {hits:?}");
        assert!(told(1.1).is_empty(), "harder than it hits");
    }
}

/// What rests is pressed by its weight times the length of the step.
#[test]
fn what_rests_presses_by_its_weight() {
    let mut stage = Stage::on_ground(frames(), rubs(0.6, 0.0));
    let cube = stage.cuboid(0.5, 0.5, 0.5);
    let body = stage.body(cube, at(0.0, 0.0, 0.5));
    stage.put(body);
    stage.steps(120);
    stage.world.watch(Watch { impulse: Some(0.0), ..Watch::default() }).expect("a good number");
    stage.steps(1);
    let hits = &stage.world.events().hits;
    assert_eq!(hits.len(), 1);
    assert!((hits[0].impulse / (1000.0 * common::G / 60.0) - 1.0).abs() < 1e-3, "{hits:?}");
}

/// A ball falls through a sensor: it is told of when it comes and when it goes, and falls as if nothing were there.
#[test]
fn a_sensor_tells_who_comes_and_goes() {
    let fall = |sensor: bool| {
        let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
        let (ball, gate) = (stage.ball(0.25), stage.cuboid(1.0, 1.0, 0.5));
        let body = stage.body(ball, at(0.0, 0.0, 6.0));
        let ball = stage.put(body);
        if sensor {
            let body = Body { sensor: true, ..Body::fixed(gate, stage.material, at(0.0, 0.0, 3.0)) };
            stage.put(body);
        }
        (stage, ball)
    };
    let (mut with, ball) = fall(true);
    let (mut without, _) = fall(false);
    let here = Presence { sensor: BodyId(3), body: ball };
    let (mut entered, mut left) = (0, 0);
    for _ in 0..120 {
        with.steps(1);
        without.steps(1);
        let events = with.world.events();
        let height = with.position(ball).z;
        assert_eq!(height, without.position(ball).z, "a sensor holds nobody");
        let inside = (height - 3.0).abs() <= 0.75;
        assert_eq!(events.present, if inside { vec![here] } else { vec![] }, "at {height} m");
        entered += events.entered.len();
        left += events.left.len();
        assert!(left <= entered && events.entered.iter().chain(&events.left).all(|told| *told == here));
    }
    assert_eq!((entered, left), (1, 1));
    assert_eq!(with.world.contacts().filter(|contact| contact.b == BodyId(3)).count(), 0);
}

#[test]
fn sensors_mind_groups_and_forget_who_is_gone() {
    let mut stage = Stage::on_ground(Settings { gravity: Vec3::ZERO, ..frames() }, rubs(0.5, 0.0));
    let (ball, gate) = (stage.ball(0.25), stage.ball(2.0));
    let put = |stage: &mut Stage, x: f64, change: fn(Body) -> Body| {
        let body = change(stage.body(ball, at(x, 0.0, 5.0)));
        stage.put(body)
    };
    let plain = put(&mut stage, 0.0, |body| body);
    let other = put(&mut stage, 0.6, |body| Body { group: 4, ..body });
    put(&mut stage, -0.6, |body| Body { kind: Kind::Static, ..body });
    put(&mut stage, 1.2, |body| Body { mask: 2, ..body });
    put(&mut stage, -1.2, |body| Body { sensor: true, ..body });
    let sensor = Body { sensor: true, ..Body::fixed(gate, stage.material, at(0.0, 0.0, 5.0)) };
    let all = stage.put(Body { mask: u32::MAX, ..sensor.clone() });
    let some = stage.put(Body { mask: 4, ..sensor });
    stage.steps(1);
    let at_all = |body| Presence { sensor: all, body };
    let at_some = Presence { sensor: some, body: other };
    assert_eq!(stage.world.events().entered, [at_all(plain), at_all(other), at_some]);
    stage.steps(1);
    assert_eq!(stage.world.events().present, [at_all(plain), at_all(other), at_some]);
    assert!(stage.world.events().entered.is_empty());
    stage.world.remove(plain).expect("it is there");
    stage.steps(1);
    assert_eq!(stage.world.events().left, [at_all(plain)]);
    stage.world.set_pose(other, at(50.0, 0.0, 5.0)).expect("it is there");
    stage.steps(1);
    assert_eq!(stage.world.events().left, [at_all(other), at_some]);
    stage.world.set_pose(other, at(1.0, 0.0, 5.0)).expect("it is there");
    stage.steps(1);
    assert_eq!(stage.world.events().entered, [at_all(other), at_some]);
    stage.world.remove(all).expect("it is there");
    stage.world.remove(some).expect("it is there");
    stage.steps(1);
    assert_eq!(stage.world.events().left, [at_all(other), at_some]);
    stage.steps(1);
    assert!(stage.world.events().left.is_empty(), "told once");
}

/// Promise: what is told is the same for any number of threads, and telling changes no motion.
#[test]
fn watching_changes_nothing_and_is_the_same_for_any_number_of_threads() {
    let run = |threads: usize, watch: Option<Watch>| {
        let mut stage = Stage::on_ground(Settings { threads, ..frames() }, rubs(0.5, 0.0));
        let (cube, ball) = (stage.cuboid(0.3, 0.4, 0.5), stage.ball(0.4));
        let mut numbers = common::Numbers(7);
        for i in 0..300 {
            let position = DVec3::new(0.0, 0.0, 8.0) + numbers.vector() * DVec3::new(3.0, 3.0, 7.0);
            let pose = Pose { position, rotation: numbers.rotation() };
            let body = stage.body(if i % 2 == 0 { cube } else { ball }, pose);
            stage.put(body);
        }
        let gate = stage.cuboid(2.0, 2.0, 2.0);
        let sensor = Body { sensor: true, ..Body::fixed(gate, stage.material, at(0.0, 0.0, 2.0)) };
        stage.put(sensor);
        stage.world.watch(watch.unwrap_or_default()).expect("good numbers");
        let mut told = Vec::new();
        for _ in 0..60 {
            stage.steps(1);
            told.push(stage.world.events().clone());
        }
        (stage.world.hash(), told)
    };
    let watch = Watch { contacts: true, forces: true, impulse: Some(50.0) };
    let (hash, told) = run(1, Some(watch));
    for threads in [2, 5] {
        assert!(run(threads, Some(watch)) == (hash, told.clone()), "{threads} threads");
    }
    let (quiet, little) = run(2, None);
    assert_eq!(quiet, hash);
    assert!(little.iter().all(|events| events.forces.is_empty() && events.begun.is_empty()));
    assert!(told.iter().zip(&little).all(|(a, b)| a.present == b.present && a.entered == b.entered));
    let count = |list: fn(&Events) -> usize| told.iter().map(list).sum::<usize>();
    assert!(count(|e| e.hits.len()) > 0 && count(|e| e.forces.len()) > 0);
    assert!(count(|e| e.ended.len()) > 0 && count(|e| e.left.len()) > 0);
}

#[test]
fn an_impulse_that_is_no_number_is_refused() {
    let mut stage = Stage::on_ground(frames(), rubs(0.5, 0.0));
    for impulse in [f32::NAN, -1.0] {
        let watch = Watch { impulse: Some(impulse), ..Watch::default() };
        assert!(matches!(stage.world.watch(watch), Err(Error::Value { .. })));
    }
}
