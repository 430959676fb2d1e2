//! A world that was saved and loaded goes on with the same bits, step by step, with any number of threads and lanes; and what is not
//! a state of this world is refused.

mod common;

use common::{Numbers, Stage, at, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::shape::{Hull, Mesh};
use rockfall::snapshot::{Error, Reader, Writer};
use rockfall::{Body, BodyId, Integrator, Kind, Material, Settings, Shape, Solver, StepReport, Watch, World};
use std::sync::Arc;

/// A world and what happens to it from outside.
#[derive(Clone, Copy)]
struct Scene {
    settings: Settings,
    /// Bodies along x and y, and layers.
    size: (usize, usize),
    /// A slab as wide as the pile comes down on it, and is split.
    slab: bool,
    /// The ground is a mesh.
    mesh: bool,
    /// Bodies come, go and are put somewhere else; one is kinematic.
    busy: bool,
}

const PLAIN: Scene = Scene { settings: SETTINGS, size: (6, 5), slab: false, mesh: false, busy: false };

const SETTINGS: Settings = Settings {
    gravity: Vec3::new(0.0, 0.0, -9.81),
    rate: 60.0,
    substeps: 4,
    solver: Solver::SoftStep,
    integrator: Integrator::SecondOrder,
    contact_hertz: 60.0,
    contact_damping: 0.5,
    push_speed: 3.0,
    restitution_threshold: 1.0,
    bounce_sweeps: 4,
    sleeping: true,
    sleep_speed: 0.2,
    sleep_time: 0.2,
    continuous: true,
    reuse: true,
    tiles_from: usize::MAX,
    threads: 1,
    lanes: 1,
};

impl Scene {
    fn with(self, threads: usize, lanes: usize) -> Self {
        Scene { settings: Settings { threads, lanes, ..self.settings }, ..self }
    }

    /// The world before its first step.
    fn build(&self) -> World {
        let material = Material { rolling_friction: 0.01, ..rubs(0.5, 0.2) };
        let mut stage = Stage::new(self.settings, material);
        let mut random = Numbers(3);
        let points: Vec<Vec3> = (0..16).map(|_| random.vector().as_vec3().normalize() * 0.3).collect();
        let hull = Hull::from_points(&points).expect("the points span a hull");
        let shapes = [
            stage.cuboid(0.3, 0.25, 0.2),
            stage.shape(Shape::Hull(Arc::new(hull))),
            stage.ball(0.25),
            stage.shape(Shape::Capsule { half_length: 0.2, radius: 0.15 }),
        ];
        let (n, layers) = self.size;
        let half = 0.3 * n as f64;
        let ground =
            if self.mesh { bowl(half as f32) } else { Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 } };
        let ground = stage.shape(ground);
        stage
            .put(Body { name: Some("Boden".into()), ..Body::fixed(ground, stage.material, Pose::default()) });
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            let wall = stage.shape(Shape::HalfSpace { normal, offset: -half as f32 });
            stage.put(Body::fixed(wall, stage.material, Pose::default()));
        }
        for i in 0..n * n * layers {
            let at = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
            let position = (at + DVec3::new(0.5, 0.5, 0.6)) * 0.6 - DVec3::new(half, half, 0.0);
            let pose = Pose { position, rotation: random.rotation() };
            stage
                .put(Body { id: Some(BodyId(100 + i as u64)), ..stage.body(shapes[i % shapes.len()], pose) });
        }
        if self.slab {
            let slab = stage.cuboid(half as f32 - 0.01, half as f32 - 0.01, 0.2);
            stage.put(stage.body(slab, at(0.0, 0.0, 0.6 * layers as f64 + 0.7)));
        }
        if self.busy {
            let paddle = stage.cuboid(half as f32 / 2.0, 0.1, 0.3);
            let body = stage.body(paddle, at(0.0, 0.0, 0.4));
            let kind = Kind::Kinematic;
            stage.put(Body { id: Some(BodyId(99)), kind, angular_velocity: Vec3::Z, ..body });
        }
        stage.world
    }

    /// What happens before a step, and the step.
    fn step(&self, world: &mut World) -> (u64, StepReport) {
        let step = world.report().step;
        if self.busy {
            let near = Body::new(shape(2), material(), at(0.1 * (step % 7) as f64, 0.2, 4.0));
            match step % 10 {
                3 => drop(world.spawn(near).expect("it makes sense")),
                5 => world.remove(BodyId(100 + step)).expect("it is there"),
                7 => world.set_pose(BodyId(101 + step), at(0.3, -0.2, 5.0)).expect("it is there"),
                _ => {}
            }
        }
        world.step();
        let report = StepReport { times: Default::default(), ..world.report().clone() };
        (world.hash(), report)
    }

    /// Runs on for `steps`.
    fn run(&self, world: &mut World, steps: usize) -> Vec<(u64, StepReport)> {
        (0..steps).map(|_| self.step(world)).collect()
    }

    /// Saves at each of the steps `at`, loads with other threads and lanes, and goes on from there: all later steps are those of the run
    /// that was never saved.
    fn goes_on(&self, steps: usize, at: &[usize]) -> Vec<(u64, StepReport)> {
        let whole = self.run(&mut self.build(), steps);
        let others = [(2, 16), (1, 4), (3, 8), (2, 1)];
        let mut world = self.build();
        let mut done = 0;
        for (i, &next) in at.iter().enumerate() {
            assert_eq!(self.run(&mut world, next - done), whole[done..next], "steps {done} to {next}");
            done = next;
            let saved = save(&world);
            let (threads, lanes) = others[i % others.len()];
            let other = self.with(threads, lanes);
            let mut loaded = other.build();
            // What was there before is of no matter.
            other.run(&mut loaded, i);
            load(&mut loaded, &saved).expect("it was saved");
            assert_eq!(loaded.hash(), world.hash());
            assert_eq!(save(&loaded), saved, "saved again at step {next}");
            assert_eq!(other.run(&mut loaded, steps - next), whole[next..], "from step {next} on");
            // And from there with the next.
            world = other.build();
            load(&mut world, &saved).expect("it was saved");
        }
        whole
    }
}

fn shape(index: usize) -> rockfall::ShapeId {
    let mut world = World::new(SETTINGS).expect("the settings make sense");
    let mut add = || world.add_shape(Shape::Sphere { radius: 1.0 }).expect("it makes sense");
    (0..index).for_each(|_| {
        add();
    });
    add()
}

fn material() -> rockfall::MaterialId {
    let mut world = World::new(SETTINGS).expect("the settings make sense");
    world.add_material(Material::default()).expect("it makes sense")
}

/// A surface of triangles that rises towards its edges.
fn bowl(half: f32) -> Shape {
    let n = 8;
    let place = |i: u32| (i as f32 / n as f32 * 2.0 - 1.0) * (half + 1.0);
    let corner = |(x, y): (f32, f32)| Vec3::new(x, y, 0.02 * (x * x + y * y));
    let corners: Vec<Vec3> =
        (0..=n).flat_map(|j| (0..=n).map(move |i| (place(i), place(j)))).map(corner).collect();
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let cell = |i: u32, j: u32| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    let triangles: Vec<[u32; 3]> = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
    Shape::Mesh(Arc::new(Mesh::from_triangles(&corners, &triangles).expect("the mesh makes sense")))
}

fn save(world: &World) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes).expect("memory takes it");
    world.save(&mut writer).expect("memory takes it");
    writer.finish().expect("memory takes it");
    bytes
}

fn load(world: &mut World, mut bytes: &[u8]) -> Result<(), Error> {
    let mut reader = Reader::new(&mut bytes)?;
    world.load(&mut reader)?;
    reader.finish()
}

/// Promise: a pile that falls, and a few bodies that come to rest and sleep, and are woken by others.
#[test]
fn piles_go_on_into_their_sleep() {
    PLAIN.goes_on(150, &[0, 1, 40, 64, 65, 128, 140]);
    let scene = Scene { size: (6, 1), ..PLAIN };
    let steps = scene.goes_on(150, &[20, 33, 50, 64, 90, 111, 130]);
    let awake: Vec<usize> = steps.iter().map(|(_, report)| report.awake).collect();
    let wakes = awake.windows(2).filter(|pair| pair[1] > pair[0]).count();
    assert!((1..20).contains(&awake[110]) && wakes > 1, "{awake:?}");
    Scene { busy: true, ..scene }.goes_on(36, &[3, 26, 33]);
}

/// Promise: rows in tiles, and no reuse of what pairs know.
#[test]
fn tiles_go_on() {
    let settings = Settings { tiles_from: 1, sleeping: false, ..SETTINGS };
    Scene { settings, size: (16, 18), ..PLAIN }.goes_on(70, &[1, 30, 63, 66]);
    let settings = Settings { reuse: false, ..SETTINGS };
    Scene { settings, ..PLAIN }.goes_on(60, &[20, 50]);
}

/// Promise: a body that is split into copies, with and without tiles.
#[test]
fn copies_go_on() {
    for tiles_from in [1, usize::MAX] {
        let settings = Settings { tiles_from, ..SETTINGS };
        let scene = Scene { settings, size: (28, 2), slab: true, ..PLAIN };
        let steps = scene.goes_on(90, &[18, 19, 40, 63, 64, 80]);
        let split: Vec<usize> = steps.iter().map(|(_, report)| report.split).collect();
        assert!(split[18] == 1 && split[39] == 1 && split[89] == 0, "{split:?}");
    }
}

/// Promise: bodies that come, go and are put somewhere else, also between the save and the next step.
#[test]
fn bodies_that_come_and_go_do_so_after_a_load() {
    let scene = Scene { busy: true, ..PLAIN };
    scene.goes_on(80, &[3, 4, 6, 8, 33, 64, 70]);

    let mut world = scene.build();
    scene.run(&mut world, 30);
    let change = |world: &mut World| {
        world.remove(BodyId(140)).expect("it is there");
        let body = Body::new(shape(0), material(), at(0.0, 0.1, 4.0));
        world
            .spawn(Body { id: Some(BodyId(140)), name: Some("neu".into()), ..body })
            .expect("it makes sense");
        world.set_pose(BodyId(150), at(0.0, 0.3, 5.0)).expect("it is there");
    };
    change(&mut world);
    let saved = save(&world);
    let mut loaded = scene.with(2, 8).build();
    load(&mut loaded, &saved).expect("it was saved");
    assert_eq!(loaded.name(BodyId(140)), Some("neu"));
    assert_eq!((loaded.len(), loaded.ids()), (world.len(), world.ids()));
    assert_eq!(scene.run(&mut loaded, 30), scene.run(&mut world, 30));
}

/// Promise: the first step after a load tells of contacts and sensors what it would have told without.
#[test]
fn events_go_on() {
    let scene = Scene { busy: true, ..PLAIN };
    let watch = Watch { contacts: true, forces: true, impulse: Some(0.1) };
    let build = || {
        let mut world = scene.build();
        world.watch(watch).expect("it makes sense");
        let zone = Body {
            sensor: true,
            id: Some(BodyId(98)),
            ..Body::fixed(shape(0), material(), at(0.1, 0.2, 0.3))
        };
        world.spawn(zone).expect("it makes sense");
        world
    };
    let mut world = build();
    scene.run(&mut world, 40);
    let mut loaded = build();
    load(&mut loaded, &save(&world)).expect("it was saved");
    assert!(!world.events().present.is_empty() && !world.events().begun.is_empty());
    for _ in 0..10 {
        assert_eq!(scene.step(&mut loaded), scene.step(&mut world));
        assert_eq!(loaded.events(), world.events());
    }
}

/// Promise: contacts with a mesh, which have several manifolds a pair.
#[test]
fn meshes_go_on() {
    Scene { mesh: true, ..PLAIN }.goes_on(90, &[20, 41, 80]);
}

/// Promise: the two simple solvers.
#[test]
fn all_solvers_go_on() {
    for solver in [Solver::Impulse, Solver::Reflect] {
        let settings = Settings { solver, ..SETTINGS };
        Scene { settings, ..PLAIN }.goes_on(60, &[10, 45]);
    }
}

/// Promise: another world, another engine and another state are told apart, and the world stays as it was.
#[test]
fn what_is_of_another_world_is_refused() {
    let mut world = PLAIN.build();
    PLAIN.run(&mut world, 20);
    let saved = save(&world);
    let refused = |scene: Scene| {
        let mut other = scene.build();
        scene.run(&mut other, 5);
        let before = save(&other);
        let error = load(&mut other, &saved).expect_err("it is another world");
        assert_eq!(save(&other), before);
        error
    };
    let settings = Settings { substeps: 5, ..SETTINGS };
    assert!(matches!(refused(Scene { settings, ..PLAIN }), Error::OtherWorld(_)));
    assert!(matches!(refused(Scene { mesh: true, ..PLAIN }), Error::OtherWorld(_)));
    assert!(matches!(refused(Scene { slab: true, ..PLAIN }), Error::OtherWorld(_)));
    // Other bodies of the same shapes don't make another world: they give way.
    let mut other = Scene { size: (6, 2), ..PLAIN }.build();
    assert_eq!(load(&mut other, &saved), Ok(()));
    assert_eq!(other.hash(), world.hash());
}

/// Promise: no flipped bit goes unnoticed, and none makes the library panic.
#[test]
fn flipped_bits_are_noticed() {
    let scene = Scene { size: (3, 2), busy: true, ..PLAIN };
    let mut world = scene.build();
    scene.run(&mut world, 20);
    let saved = save(&world);
    let mut other = scene.build();
    let before = save(&other);
    let mut random = Numbers(7);
    for _ in 0..2000 {
        let mut bad = saved.clone();
        let at = (random.next() * bad.len() as f64) as usize;
        bad[at] ^= 1 << (random.next() * 8.0) as u32;
        assert!(load(&mut other, &bad).is_err(), "byte {at}");
        assert!(load(&mut other, &saved[..at]).is_err(), "{at} bytes");
    }
    assert_eq!(save(&other), before);
}

/// A column of a snapshot: where its values are, and the size of one.
struct Place {
    values: std::ops::Range<usize>,
    size: usize,
}

/// Finds the columns of a snapshot by the description of the format.
fn columns(bytes: &[u8]) -> Vec<Place> {
    let mut places = Vec::new();
    let mut at = 16;
    loop {
        let mut text = || {
            let len = usize::from(bytes[at]);
            at += 1 + len;
            String::from_utf8(bytes[at - len..at].to_vec()).expect("names are text")
        };
        let (name, _) = (text(), text());
        if name.is_empty() {
            return places;
        }
        let mut number = || {
            at += 8;
            u64::from_ne_bytes(bytes[at - 8..at].try_into().expect("eight bytes")) as usize
        };
        let (count, len) = (number(), number());
        let values = at..at + len;
        let size = len / count.max(1);
        at = values.end + 8;
        places.push(Place { values, size });
    }
}

/// Gives every column the checksum that it should have.
fn seal(bytes: &mut [u8]) {
    let mut before = 0;
    for place in columns(bytes) {
        let end = place.values.end;
        let sum = xxhash_rust::xxh3::xxh3_64(&bytes[before..end]);
        bytes[end..end + 8].copy_from_slice(&sum.to_ne_bytes());
        before = end;
    }
    let end = bytes.len() - 8;
    let sum = xxhash_rust::xxh3::xxh3_64(&bytes[before..end]);
    bytes[end..].copy_from_slice(&sum.to_ne_bytes());
}

/// Promise: a state that was altered on purpose, with the right checksums, is refused or simulated, and never makes the library panic.
#[test]
fn malice_is_an_error_or_another_simulation() {
    let settings = Settings { tiles_from: 1, ..SETTINGS };
    let calm = Scene { size: (12, 3), slab: true, busy: true, ..PLAIN };
    let (mut refused, mut simulated) = (0, 0);
    for scene in [calm, Scene { settings, ..calm }, Scene { mesh: true, size: (4, 3), ..PLAIN }] {
        let mut world = scene.build();
        scene.run(&mut world, 60);
        let saved = save(&world);
        let mut sealed = saved.clone();
        seal(&mut sealed);
        assert_eq!(sealed, saved, "the test knows the format");
        let mut random = Numbers(11);
        let mut pick = |count: usize| (random.next() * count as f64) as usize;
        for place in columns(&saved).iter().filter(|place| !place.values.is_empty()) {
            for _ in 0..12 {
                let mut bad = saved.clone();
                let value = place.values.start + place.size * pick(place.values.len() / place.size);
                match pick(4) {
                    0 => bad[value..value + place.size].fill(0xff),
                    1 => bad[value..value + place.size].fill(0),
                    2 => bad[value + pick(place.size)] ^= 1 << pick(8),
                    // One value in the place of another.
                    _ => {
                        let other = place.values.start + place.size * pick(place.values.len() / place.size);
                        bad.copy_within(other..other + place.size, value);
                    }
                }
                seal(&mut bad);
                let mut other = scene.with(2, 8).build();
                match load(&mut other, &bad) {
                    Err(_) => refused += 1,
                    Ok(()) => {
                        simulated += 1;
                        (0..2).for_each(|_| drop(other.step().clone()));
                    }
                }
            }
            // A value too many or too few, of which the head says so.
            for more in [true, false] {
                let mut bad = saved.clone();
                let head = place.values.start - 16;
                let count = (place.values.len() / place.size) as u64;
                let count = if more { count + 1 } else { count - 1 };
                bad[head..head + 8].copy_from_slice(&count.to_ne_bytes());
                bad[head + 8..head + 16].copy_from_slice(&(count * place.size as u64).to_ne_bytes());
                if more {
                    let end = place.values.end;
                    let last = bad[end - place.size..end].to_vec();
                    bad.splice(end..end, last);
                } else {
                    bad.drain(place.values.end - place.size..place.values.end);
                }
                seal(&mut bad);
                let mut other = scene.with(2, 8).build();
                if load(&mut other, &bad).is_ok() {
                    other.step();
                }
            }
        }
    }
    println!("{refused} refused, {simulated} simulated");
    assert!(refused > 300 && simulated > 300, "{refused} refused, {simulated} simulated");
}
