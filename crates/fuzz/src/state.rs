//! Checkpoints of any bytes.

use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::snapshot::{Reader, Writer};
use rockfall::{Body, Material, Settings, Shape, World};

/// A small heap. The same one at each call, so that a state fits it.
fn world() -> World {
    let mut world = World::new(Settings { threads: 1, ..Settings::default() }).expect("good settings");
    let stone = world.add_material(Material::default()).expect("a material");
    let ball = world.add_shape(Shape::Sphere { radius: 0.1 }).expect("a ball");
    let cube = world.add_shape(Shape::Box { half: Vec3::splat(0.1) }).expect("a cube");
    let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }).expect("a plane");
    world.spawn(Body::fixed(ground, stone, Pose::default())).expect("the ground");
    for k in 0..12 {
        let place =
            DVec3::new(0.15 * f64::from(k % 3), 0.15 * f64::from(k / 3 % 2), 0.1 + 0.19 * f64::from(k / 6));
        let shape = if k % 2 == 0 { ball } else { cube };
        world.spawn(Body::new(shape, stone, Pose::at(place))).expect("a body");
    }
    world
}

/// A checkpoint as it should be.
pub fn good_checkpoint() -> Vec<u8> {
    let mut world = world();
    for _ in 0..5 {
        world.step();
    }
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes).expect("memory can be written to");
    world.save(&mut writer).expect("memory can be written to");
    writer.finish().expect("memory can be written to");
    bytes
}

/// Loads a checkpoint from `bytes`: there is an error and the world is as it was, or the world goes on.
pub fn checkpoint(bytes: &[u8]) {
    let mut world = world();
    let before = world.hash();
    let mut from = bytes;
    let mut reader = match Reader::new(&mut from) {
        Ok(reader) => reader,
        Err(_) => return,
    };
    match world.load(&mut reader) {
        Err(_) => assert_eq!(world.hash(), before, "a state that could not be loaded has changed the world"),
        // What stands behind the state may be wrong as well.
        Ok(()) => drop(reader.finish()),
    }
    world.step();
}
