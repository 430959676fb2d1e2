//! The same scene gives the same bits: for any number of threads, any number of lanes, and bodies added in any order.

mod common;

use common::{Numbers, Stage, at, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::Hull;
use rockfall::{Body, BodyId, Material, Settings, Shape};
use std::sync::Arc;

/// Dropped bodies of every convex shape, `n` × `n` × `layers` of them, in a pit as wide as they are.
struct Pile {
    n: usize,
    layers: usize,
    steps: usize,
    /// A slab as wide as the pit comes down on the pile.
    slab: bool,
}

/// In what the runs of one pile may differ.
#[derive(Clone, Copy, Debug)]
struct Run {
    threads: usize,
    lanes: usize,
    /// Bodies are added from the last to the first, in two bulks.
    backwards: bool,
}

impl Pile {
    /// The hash after the last step, and the largest number of contacts on the way.
    fn run(&self, run: Run) -> (u64, usize) {
        let settings = Settings { threads: run.threads, lanes: run.lanes, sleeping: true, ..frames() };
        let material = Material { rolling_friction: 0.01, ..rubs(0.5, 0.2) };
        let mut stage = Stage::new(settings, material);
        let mut random = Numbers(3);
        let points: Vec<Vec3> = (0..16).map(|_| random.vector().as_vec3().normalize() * 0.3).collect();
        let hull = Hull::from_points(&points).expect("the points span a hull");
        let shapes = [
            stage.cuboid(0.3, 0.25, 0.2),
            stage.shape(Shape::Hull(Arc::new(hull))),
            stage.cuboid(0.25, 0.25, 0.25),
            stage.ball(0.25),
            stage.shape(Shape::Capsule { half_length: 0.2, radius: 0.15 }),
        ];
        let half = 0.3 * self.n as f64;
        let mut bodies = Vec::new();
        for (i, (normal, offset)) in
            [(Vec3::Z, 0.0), (Vec3::X, half), (Vec3::NEG_X, half), (Vec3::Y, half), (Vec3::NEG_Y, half)]
                .into_iter()
                .enumerate()
        {
            let plane = stage.shape(Shape::HalfSpace { normal, offset: -offset as f32 });
            let id = Some(BodyId(i as u64));
            bodies.push(Body { id, ..Body::fixed(plane, stage.material, Pose::default()) });
        }
        let n = self.n;
        for i in 0..n * n * self.layers {
            let at = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
            let position = (at + DVec3::new(0.5, 0.5, 0.6)) * 0.6 - DVec3::new(half, half, 0.0);
            let pose = Pose { position, rotation: random.rotation() };
            let id = Some(BodyId(100 + i as u64));
            bodies.push(Body { id, ..stage.body(shapes[i % shapes.len()], pose) });
        }
        if self.slab {
            let slab = stage.cuboid(half as f32 - 0.01, half as f32 - 0.01, 0.2);
            let pose = Pose::at(DVec3::new(0.0, 0.0, 0.6 * self.layers as f64 + 0.7));
            bodies.push(Body { id: Some(BodyId(50)), ..stage.body(slab, pose) });
        }
        if run.backwards {
            bodies.reverse();
            let rest = bodies.split_off(bodies.len() / 3);
            stage.world.spawn_all(bodies).expect("the bodies make sense");
            stage.world.spawn_all(rest).expect("the bodies make sense");
        } else {
            stage.world.spawn_all(bodies).expect("the bodies make sense");
        }
        let (mut contacts, mut split) = (0, 0);
        for _ in 0..self.steps {
            let report = stage.world.step();
            (contacts, split) = (contacts.max(report.contacts), split.max(report.split));
        }
        assert!(stage.all_finite());
        assert_eq!(split, usize::from(self.slab));
        (stage.world.hash(), contacts)
    }

    /// Runs all of `runs` and compares each with the first.
    fn same(&self, runs: &[Run], at_least: usize) {
        let (hash, contacts) = self.run(runs[0]);
        println!("{:?}: {hash:016x}, {contacts} contacts", runs[0]);
        assert!(contacts >= at_least, "{contacts} contacts");
        for &run in &runs[1..] {
            let other = self.run(run);
            println!("{run:?}: {:016x}", other.0);
            assert_eq!(other, (hash, contacts), "{run:?}");
        }
    }
}

const FIRST: Run = Run { threads: 1, lanes: 1, backwards: false };

/// A pile whose contacts fill several blocks of every colour.
const SMALL: Pile = Pile { n: 9, layers: 12, steps: 200, slab: false };

/// Promise: 1, 2, 3 and 8 threads (more than the machine may have) give the same hash of all poses and velocities.
#[test]
fn thread_count_determinism() {
    let runs = [1, 2, 3, 8].map(|threads| Run { threads, ..FIRST });
    SMALL.same(&runs, 4000);
}

/// Promise: 1, 4, 8 and 16 lanes give the same hash.
#[test]
fn lane_count_determinism() {
    let runs = [1, 4, 8, 16].map(|lanes| Run { lanes, ..FIRST });
    SMALL.same(&runs, 4000);
}

/// Promise: bodies with the same ids give the same hash in whatever order they are added.
#[test]
fn insertion_order_determinism() {
    let runs = [FIRST, Run { backwards: true, lanes: 8, threads: 2 }];
    SMALL.same(&runs, 4000);
}

/// Promise: the same with a body that has so many contacts that the solver splits it.
#[test]
fn determinism_with_a_split_body() {
    let pile = Pile { n: 16, layers: 4, steps: 150, slab: true };
    let runs = [
        FIRST,
        Run { threads: 2, lanes: 16, backwards: false },
        Run { threads: 3, lanes: 4, backwards: true },
    ];
    pile.same(&runs, 2000);
}

/// Promise: the same in a world so large that the solver cuts its rows into tiles.
#[test]
fn determinism_across_tiles() {
    let pile = Pile { n: 42, layers: 40, steps: 10, slab: false };
    let runs = [
        Run { threads: 2, lanes: 16, backwards: false },
        Run { threads: 1, lanes: 4, backwards: false },
        Run { threads: 3, lanes: 8, backwards: true },
    ];
    pile.same(&runs, 100_000);
}

/// Promise: a world that is large enough for tiles has them also where its bodies come in the very order in which rows are
/// sorted, so that no row ever moves.
#[test]
fn tiles_do_not_depend_on_the_order_of_insertion() {
    let n = 42;
    let run = |order: Option<&[u64]>| {
        let mut stage = Stage::new(Settings { threads: 2, ..frames() }, rubs(0.5, 0.0));
        let ball = stage.ball(0.5);
        let place = |id: u64| {
            let i = id as usize;
            let mut random = Numbers(id);
            let at = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
            Pose::at(at * 0.98 + random.vector() * 0.02)
        };
        let all: Vec<u64> = (0..70_000).collect();
        let ids = order.unwrap_or(&all);
        let body = |&id: &u64| Body { id: Some(BodyId(id)), ..stage.body(ball, place(id)) };
        let bodies: Vec<Body> = ids.iter().map(body).collect();
        stage.world.spawn_all(bodies).expect("the bodies make sense");
        stage.steps(1);
        let rows = stage.world.row_ids()[1..].to_vec();
        stage.steps(4);
        (rows, stage.world.hash())
    };
    let (rows, hash) = run(None);
    let (same_rows, same_hash) = run(Some(&rows));
    assert_eq!(rows, same_rows);
    assert_eq!(hash, same_hash);
}

/// Promise: bodies that come into a world cut into tiles fall with the rest, also those that begin a new tile.
#[test]
fn bodies_that_come_late_have_tiles_too() {
    let mut stage = Stage::new(Settings { threads: 2, ..frames() }, rubs(0.5, 0.0));
    let ball = stage.ball(0.4);
    let place = |i: usize| at((i % 100) as f64, (i / 100 % 100) as f64, (i / 10_000) as f64);
    let all: Vec<Body> = (0..70_000).map(|i| stage.body(ball, place(i))).collect();
    stage.world.spawn_all(all).expect("the bodies make sense");
    stage.steps(2);
    let late: Vec<BodyId> = (70_000..80_000).map(|i| stage.put(stage.body(ball, place(i)))).collect();
    stage.steps(3);
    for id in late {
        let velocity = stage.world.velocity(id).expect("the body is there").0;
        assert!((velocity.z + 3.0 * common::G / 60.0).abs() < 1e-4, "{velocity}");
    }
}

/// Promise: all of it at once over 1,000 steps of a pile with more than 100,000 contacts. Ten minutes on two cores; run it with
/// `cargo test --release -p rockfall --test same_bits -- --ignored`.
#[test]
#[ignore = "ten minutes: cargo test --release -p rockfall --test same_bits -- --ignored"]
fn large_pile_determinism() {
    let pile = Pile { n: 30, layers: 22, steps: 1000, slab: false };
    let runs = [
        Run { threads: 2, lanes: 0, backwards: false },
        Run { threads: 1, lanes: 4, backwards: false },
        Run { threads: 3, lanes: 8, backwards: true },
        Run { threads: 8, lanes: 16, backwards: false },
        Run { threads: 2, lanes: 1, backwards: true },
    ];
    pile.same(&runs, 100_000);
}

/// Promise: threads and lanes also where a world has tiles and more than a million contacts. A quarter of an hour; run it with
/// `cargo test --release -p rockfall --test same_bits -- --ignored a_million`.
#[test]
#[ignore = "a quarter of an hour: cargo test --release -p rockfall --test same_bits -- --ignored a_million"]
fn a_million_contacts_have_the_same_bits() {
    let pile = Pile { n: 72, layers: 30, steps: 90, slab: false };
    let runs = [
        Run { threads: 2, lanes: 0, backwards: false },
        Run { threads: 1, lanes: 8, backwards: true },
        Run { threads: 3, lanes: 4, backwards: false },
        Run { threads: 2, lanes: 1, backwards: false },
    ];
    pile.same(&runs, 1_000_000);
}
