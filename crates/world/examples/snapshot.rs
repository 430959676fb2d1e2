//! How long it takes to save and load a pile of boxes, and how large it is on disk.
//!
//! `cargo run --release -p rockfall --example snapshot -- [boxes] [steps] [folder]`

use rockfall::math::{DVec3, Pose, Vec3};
use rockfall::snapshot::{Reader, Writer};
use rockfall::{Body, Material, Settings, Shape, World};
use std::error::Error;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let boxes: usize = words.next().map_or(Ok(100_000), |word| word.parse())?;
    let steps: usize = words.next().map_or(Ok(60), |word| word.parse())?;
    let folder = words.next().map_or_else(std::env::temp_dir, PathBuf::from);
    let path = folder.join("rockfall-snapshot-example");
    let mut world = pile(boxes)?;
    (0..steps).for_each(|_| drop(world.step().clone()));
    let step = mean_step(&mut world);

    let start = Instant::now();
    let mut to = BufWriter::with_capacity(1 << 20, File::create(&path)?);
    let mut writer = Writer::new(&mut to)?;
    world.save(&mut writer)?;
    let bytes = writer.finish()?;
    to.flush()?;
    let written = start.elapsed();
    to.get_ref().sync_all()?;
    println!("{boxes} boxes, {} contacts, {:.1} MB", world.report().contacts, bytes as f64 / 1e6);
    println!(
        "saved in {:.3} s, with the disk in {:.3} s",
        written.as_secs_f64(),
        start.elapsed().as_secs_f64()
    );

    let mut other = pile(boxes)?;
    let start = Instant::now();
    let mut from = BufReader::with_capacity(1 << 20, File::open(&path)?);
    let mut reader = Reader::new(&mut from)?;
    other.load(&mut reader)?;
    reader.finish()?;
    let loaded = start.elapsed();
    other.step();
    let stepped = start.elapsed();
    world.step();
    assert_eq!(other.hash(), world.hash());
    println!(
        "loaded in {:.3} s, first step after {:.3} s; a step takes {step:.3} s",
        loaded.as_secs_f64(),
        stepped.as_secs_f64()
    );
    Ok(std::fs::remove_file(path)?)
}

/// Seconds.
fn mean_step(world: &mut World) -> f64 {
    let start = Instant::now();
    (0..10).for_each(|_| drop(world.step().clone()));
    start.elapsed().as_secs_f64() / 10.0
}

/// Boxes in layers, a little apart, above the ground.
fn pile(boxes: usize) -> Result<World, Box<dyn Error>> {
    let mut world = World::new(Settings::default())?;
    let rock = world.add_material(Material::default())?;
    let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
    let cube = world.add_shape(Shape::Box { half: Vec3::splat(0.5) })?;
    world.spawn(Body::fixed(ground, rock, Pose::default()))?;
    let n = (boxes as f64 / 10.0).sqrt().ceil() as usize;
    world.spawn_all((0..boxes).map(|i| {
        let (x, y, z) = (i % n, i / n % n, i / n / n);
        let shift = 0.3 * (z % 2) as f64;
        let at = DVec3::new(1.1 * x as f64 + shift, 1.1 * y as f64 + shift, 0.5 + 1.02 * z as f64);
        Body::new(cube, rock, Pose::at(at))
    }))?;
    Ok(world)
}
