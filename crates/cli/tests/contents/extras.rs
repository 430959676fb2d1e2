//! Contacts, events and columns that a scene asks for: what is in them is true.

use crate::common::{Place, expect, out};
use rockfall_cache::{Column, EventKind, FRAMES, RunReader, Values};
use std::fs;

/// A crate of 100 kg slides to rest on the floor, another one lies on a third, and a ball falls through a gate onto the floor.
const SCENE: &str = r#"
[world]
frames = 150

[output]
velocities = true
contacts = true
events = "all"
hits = 50
columns = ["speed", "kinetic_energy", "contact_count", "contact_force", "asleep"]

[shapes.floor]
kind = "half-space"
[shapes.ball]
kind = "sphere"
radius = 0.25
[shapes.crate]
kind = "box"
size = [1, 1, 0.5]
[shapes.gate]
kind = "box"
size = [2, 2, 0.5]

[[bodies]]
shape = "floor"
[[bodies]]
name = "gate"
shape = "gate"
sensor = true
position = [5, 0, 1.5]
[[bodies]]
name = "slider"
shape = "crate"
mass = 100
position = [0, 0, 0.25]
velocity = [1, 0, 0]
[[bodies]]
shape = "crate"
mass = 100
position = [0, 5, 0.25]
[[bodies]]
shape = "crate"
mass = 50
position = [0, 5, 0.75]
[[bodies]]
name = "ball"
shape = "ball"
mass = 10
position = [5, 0, 3]
"#;

const FLOOR: u64 = 1;
const GATE: u64 = 2;
const SLIDER: u64 = 3;
const BALL: u64 = 6;

fn place(scene: &str) -> Place {
    let place = Place::with("scene.toml", scene);
    expect(&place.rockfall("run scene.toml --out run --quiet --threads 2"), 0);
    place
}

fn column(run: &RunReader, name: &str) -> (Column, rockfall_cache::ColumnReader) {
    let column = run.columns().unwrap().into_iter().find(|column| column.name == name).unwrap();
    let reader = run.column(&column).unwrap();
    (column, reader)
}

fn floats(values: Values) -> Vec<f32> {
    let Values::F32(numbers) = values else { panic!("other numbers") };
    numbers
}

#[test]
fn contacts_carry_what_rests_on_them() {
    let place = place(SCENE);
    let run = RunReader::open(&place.path("run")).unwrap();
    let contacts = run.contacts().unwrap().unwrap();
    let at_rest = contacts.at(60).unwrap();
    let of_pair = |a: u64, b: u64| -> Vec<usize> {
        (0..at_rest.len()).filter(|&k| (at_rest.a[k], at_rest.b[k]) == (a, b)).collect()
    };
    // Four corners each, the forces of which are the weights above.
    for (a, b, mass) in [(FLOOR, SLIDER, 100.0), (FLOOR, 4, 150.0), (4, 5, 50.0)] {
        let found = of_pair(a, b);
        assert_eq!(found.len(), 4, "{a} {b}");
        let force: f32 = found.iter().map(|&k| at_rest.forces[k] * at_rest.normals[k][2]).sum();
        assert!((force / (mass * 9.81) - 1.0).abs() < 0.01, "{a} {b}: {force} N");
        for &k in &found {
            assert!(at_rest.distances[k].abs() < 1e-3);
            let height = if a == FLOOR { 0.0 } else { 0.5 };
            assert!((at_rest.positions[k][2] - height).abs() < 1e-3);
        }
    }
    assert!(contacts.at(0).unwrap().is_empty());
    // Friction slows the slider down, at 0.6 g, and nothing pulls at what is at rest. It is the force on the body with the larger id.
    let friction = |frame: u64, b: u64| -> [f32; 3] {
        let found = contacts.at(frame).unwrap();
        let mine = (0..found.len()).filter(|&k| (found.a[k], found.b[k]) == (FLOOR, b));
        mine.fold([0.0; 3], |sum, k| std::array::from_fn(|axis| sum[axis] + found.frictions[k][axis]))
    };
    let [x, y, z] = friction(5, SLIDER);
    assert!((x / (-0.6 * 100.0 * 9.81) - 1.0).abs() < 0.02 && y.abs() < 5.0 && z.abs() < 5.0, "{x} {y} {z}");
    for body in [SLIDER, 4] {
        assert!(friction(60, body).iter().all(|force| force.abs() < 5.0), "{:?}", friction(60, body));
    }
    // Nothing that is merely near: the ball in the air has no contact.
    assert!((1..20).all(|frame| !contacts.at(frame).unwrap().b.contains(&BALL)));

    let rows = fs::read_to_string(place.path("run").join(FRAMES)).unwrap();
    let cell = rows.lines().next().unwrap().split(',').position(|name| name == "kinetic_energy_J").unwrap();
    let said: Vec<f64> =
        rows.lines().skip(1).map(|row| row.split(',').nth(cell).unwrap().parse().unwrap()).collect();
    let (speeds, energies) = (column(&run, "speed"), column(&run, "kinetic_energy"));
    let (counts, forces) = (column(&run, "contact_count"), column(&run, "contact_force"));
    assert_eq!((energies.0.units.as_str(), forces.0.units.as_str()), ("J", "N"));
    for frame in 0..=150 {
        let found = contacts.at(frame).unwrap();
        let velocities = run.velocities(frame).unwrap().unwrap();
        let speeds = floats(speeds.1.at(frame).unwrap());
        assert!((0..6).all(|row| velocities.at(row).unwrap().0.length() == speeds[row]), "frame {frame}");
        if frame > 0 {
            let energy: f64 = floats(energies.1.at(frame).unwrap()).into_iter().map(f64::from).sum();
            let said = said[frame as usize - 1];
            assert!((energy - said).abs() < 1e-5 * said.max(1e-3), "frame {frame}: {energy} {said}");
        }
        let Values::U32(counts) = counts.1.at(frame).unwrap() else { panic!("other numbers") };
        let forces = floats(forces.1.at(frame).unwrap());
        for id in 1..=6 {
            let mine = || (0..found.len()).filter(|&k| found.a[k] == id || found.b[k] == id);
            assert_eq!(counts[id as usize - 1] as usize, mine().count(), "frame {frame}, body {id}");
            let sum: f32 = mine().map(|k| found.forces[k]).sum();
            assert!((forces[id as usize - 1] - sum).abs() <= 1e-5 * sum, "frame {frame}, body {id}");
        }
    }
    let Values::U8(asleep) = column(&run, "asleep").1.at(150).unwrap() else { panic!("other numbers") };
    assert_eq!(asleep, [0, 0, 1, 1, 1, 1]);

    expect(&place.rockfall("verify run"), 0);
    let info = out(&place.rockfall("info run"));
    assert!(info.contains("contacts on disk") && info.contains("speed, kinetic_energy"), "{info}");
    let json = out(&place.rockfall("info run --json"));
    assert!(json.contains(&format!("\"contacts\": {}", contacts.total())), "{json}");
    let chunk = place.path("run/trajectory.zarr/contacts/force/c.0");
    let mut bytes = fs::read(&chunk).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 8;
    fs::write(&chunk, bytes).unwrap();
    expect(&place.rockfall("verify run"), 1);
}

#[test]
fn events_tell_who_passes_the_gate_and_who_touches() {
    let place = place(SCENE);
    let run = RunReader::open(&place.path("run")).unwrap();
    let events = run.events().unwrap().unwrap();
    let all: Vec<(u64, EventKind, u64, u64)> = (0..=150)
        .flat_map(|frame| {
            let told = events.at(frame).unwrap();
            assert!(told.is_sorted());
            told.into_iter().map(move |event| (frame, event.kind, event.a, event.b))
        })
        .collect();
    let of = |kind, a, b| -> Vec<u64> {
        all.iter().filter(|event| (event.1, event.2, event.3) == (kind, a, b)).map(|event| event.0).collect()
    };
    // The ball's lowest point falls from 2.75 m: at the gate's top at 1.75 m, its highest one at the bottom, 1.25 m, after 2 m.
    let frame = |fall: f64| (2.0 * fall / 9.81_f64).sqrt() * 60.0;
    for (kind, fall) in [(EventKind::Entered, 1.0), (EventKind::Left, 2.0)] {
        let [at] = of(kind, GATE, BALL)[..] else { panic!("{kind:?} once: {all:?}") };
        assert!((at as f64 - frame(fall)).abs() <= 1.0, "{kind:?} at {at}, expected {}", frame(fall));
    }
    let landed = frame(2.75);
    let [at] = of(EventKind::Begun, FLOOR, BALL)[..] else { panic!("it lands once: {all:?}") };
    assert!((at as f64 - landed).abs() <= 1.0, "landed at {at}, expected {landed}");
    assert_eq!(of(EventKind::Begun, FLOOR, SLIDER), [1]);
    assert!(!all.iter().any(|event| event.1 == EventKind::Entered && event.3 != BALL));
    // What begins and has not ended touches, by the contacts.
    let contacts = run.contacts().unwrap().unwrap();
    let mut open = std::collections::BTreeSet::new();
    for frame in 0..=150 {
        for &(_, kind, a, b) in all.iter().filter(|event| event.0 == frame) {
            match kind {
                EventKind::Begun => assert!(open.insert((a, b))),
                EventKind::Ended => assert!(open.remove(&(a, b))),
                EventKind::Entered | EventKind::Left | EventKind::Hit => {}
            }
        }
        let found = contacts.at(frame).unwrap();
        let pairs: std::collections::BTreeSet<_> =
            found.a.iter().copied().zip(found.b.iter().copied()).collect();
        assert_eq!(open, pairs, "frame {frame}");
    }
}

/// Promise: what a hit gives the ball is what its velocity says; and what rests, however heavy, is not told of.
#[test]
fn hits_change_velocities_by_their_impulse() {
    let place = place(SCENE);
    let run = RunReader::open(&place.path("run")).unwrap();
    let (events, mut hits) = (run.events().unwrap().unwrap(), 0);
    let fall = |frame: u64| run.velocities(frame).unwrap().unwrap().at(BALL as usize - 1).unwrap().0.z;
    for frame in 0..=150 {
        for event in events.at(frame).unwrap() {
            if event.kind != EventKind::Hit {
                assert_eq!(event.impulse, 0.0);
                continue;
            }
            assert_eq!((event.a, event.b), (FLOOR, BALL));
            let given = 10.0 * (fall(frame) - fall(frame - 1) + 9.81 / 60.0);
            assert!(
                event.impulse > 50.0 && (event.impulse / given - 1.0).abs() < 0.01,
                "{event:?}, {given} N s"
            );
            hits += 1;
        }
    }
    assert_eq!(hits, 1);
}

#[test]
fn what_is_not_asked_for_is_not_written_and_nothing_changes() {
    let place = place(SCENE);
    let hash = |name: &str| RunReader::open(&place.path(name)).unwrap().summary().hash.clone();
    for (name, output, told) in [
        ("nothing", "events = \"none\"", None),
        ("sensors", "", Some(2)),
        ("hits", "events = \"none\"\nhits = 50", Some(1)),
        ("some", "contacts = true\ncontacts_every = 10\ncontacts_force = 300\nevents = \"none\"", None),
    ] {
        let (start, rest) = SCENE.split_once("[output]").unwrap();
        let (_, rest) = rest.split_once("[shapes.floor]").unwrap();
        let text = format!("{start}[output]\n{output}\n[shapes.floor]{rest}");
        fs::write(place.path("other.toml"), text).unwrap();
        expect(&place.rockfall(&format!("run other.toml --out {name} --quiet --threads 1 --lanes 4")), 0);
        assert_eq!(hash(name), hash("run"), "{name}");
        let run = RunReader::open(&place.path(name)).unwrap();
        assert_eq!(run.events().unwrap().map(|events| events.total()), told);
        assert_eq!(run.has_hits().unwrap(), name == "hits");
        assert!(run.columns().unwrap().is_empty());
        let Some(contacts) = run.contacts().unwrap() else { continue };
        let all = RunReader::open(&place.path("run")).unwrap().contacts().unwrap().unwrap();
        for frame in 0..=150 {
            let (found, all) = (contacts.at(frame).unwrap(), all.at(frame).unwrap());
            let wanted = all.forces.iter().filter(|&&force| force >= 300.0 && frame % 10 == 0).count();
            assert_eq!(found.len(), wanted, "frame {frame}");
            assert!(found.forces.iter().all(|&force| force >= 300.0));
        }
        assert!(contacts.total() > 0 && contacts.total() < all.total() / 5);
    }
}
