//! A world of one thread is stepped by its caller. By itself in its program, because a process has one pool of all, and whoever needs it makes it.

mod common;

use common::{Numbers, Stage, frames, rubs};
use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::{Body, Material, Settings, Shape, Watch};

/// Promise: no stage of a step leaves the caller's thread where the world has one, however large it is: with tiles, copies of a slab with a thousand neighbours,
/// fast bodies, events, a sensor, bodies that come and go, and sleep.
#[test]
fn a_world_of_one_thread_asks_no_pool() {
    let settings = Settings { threads: 1, sleeping: true, continuous: true, tiles_from: 1000, ..frames() };
    let material = Material { rolling_friction: 0.01, ..rubs(0.5, 0.2) };
    let mut stage = Stage::new(settings, material);
    let mut random = Numbers(3);
    let shapes = [stage.ball(0.25), stage.cuboid(0.25, 0.25, 0.25), stage.cuboid(0.3, 0.25, 0.2)];
    let floor = stage.shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
    let slab = stage.cuboid(10.0, 10.0, 0.3);
    let mut bodies = vec![Body::fixed(floor, stage.material, Pose::default())];
    for i in 0..3000_usize {
        let place = DVec3::new((i % 30) as f64 - 15.0, (i / 30 % 30) as f64 - 15.0, (i / 900) as f64);
        let pose = Pose { position: place * 0.62 + DVec3::Z * 0.5, rotation: random.rotation() };
        let body = stage.body(shapes[i % shapes.len()], pose);
        bodies.push(Body { velocity: if i % 100 == 0 { Vec3::Z * -200.0 } else { Vec3::ZERO }, ..body });
    }
    bodies.push(stage.body(slab, Pose::at(DVec3::Z * 3.5)));
    let sensor = stage.body(shapes[1], Pose::at(DVec3::Z));
    bodies.push(Body { sensor: true, kind: rockfall::Kind::Static, ..sensor });
    let ids = stage.world.spawn_all(bodies).expect("the bodies make sense");
    stage.world.watch(Watch { contacts: true, forces: true, impulse: Some(1.0) }).expect("it makes sense");
    let (mut split, mut contacts) = (0, 0);
    for step in 0..150 {
        if step == 100 {
            (10..20).for_each(|i| stage.world.remove(ids[i]).expect("it is there"));
        }
        stage.world.step();
        let report = stage.world.report();
        (split, contacts) = (report.split.max(split), report.contacts.max(contacts));
    }
    assert!(split > 0 && contacts > 3000, "{split} bodies split, {contacts} contacts");
    let made = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    assert!(made.is_ok(), "a loop of the step is not shared");
}
