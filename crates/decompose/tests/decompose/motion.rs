//! Bodies that are hollow: they hold what is in them, nest, and let through what fits.

use crate::cut;
use crate::lathe::{bowl, cup, torus};
use rockfall::{Body, BodyId, Material, MaterialId, Settings, Shape, ShapeId, World};
use rockfall_decompose::Decomposition;
use rockfall_math::{DVec3, Pose, Vec3, rotation};
use rockfall_shape::Mesh;
use std::sync::Arc;

struct Stage {
    world: World,
    material: MaterialId,
}

impl Stage {
    /// With the ground z ≤ 0.
    fn new() -> Self {
        let settings = Settings { sleeping: false, threads: 1, ..Settings::default() };
        let mut world = World::new(settings).expect("good settings");
        let rolling = Material { rolling_friction: 0.01, twisting_friction: 0.01, ..Material::default() };
        let material = world.add_material(rolling).expect("a good material");
        let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }).expect("a plane");
        world.spawn(Body::fixed(ground, material, Pose::default())).expect("the ground");
        Stage { world, material }
    }

    /// A shape of hulls, and how much they fill, metres.
    fn hulls(&mut self, mesh: &Mesh, hulls: u32) -> (ShapeId, f64) {
        let Decomposition { compound, misfit } = cut(mesh, 64, hulls);
        println!("{} hulls, {misfit:?}", compound.parts().len());
        let shape = self.world.add_shape(Shape::Compound(Arc::new(compound))).expect("a good shape");
        (shape, f64::from(misfit.filled))
    }

    /// The body's z axis.
    fn up(&self, id: BodyId) -> Vec3 {
        rotation::rotate(self.world.pose(id).expect("it is there").rotation, Vec3::Z)
    }

    fn drop(&mut self, shape: ShapeId, x: f64, z: f64) -> BodyId {
        let pose = Pose::at(DVec3::new(x, 0.0, z));
        self.world.spawn(Body::new(shape, self.material, pose)).expect("a body")
    }

    fn steps(&mut self, n: usize) {
        (0..n).for_each(|_| {
            self.world.step();
        });
    }

    fn at(&self, id: BodyId) -> DVec3 {
        self.world.pose(id).expect("it is there").position
    }

    fn speed(&self, id: BodyId) -> f32 {
        let (v, w) = self.world.velocity(id).expect("it is there");
        v.length() + w.length()
    }
}

/// Promise: a bowl of hulls holds three balls that are dropped into it: they come to rest in it, below its rim, and it stays upright.
#[test]
fn a_bowl_holds_balls() {
    let mut stage = Stage::new();
    let (shape, _) = stage.hulls(&bowl(), 64);
    let small = stage.world.add_shape(Shape::Sphere { radius: 0.25 }).expect("a ball");
    let bowl = stage.drop(shape, 0.0, 1.02);
    stage.steps(60);
    let balls: Vec<BodyId> =
        (0..3).map(|i| stage.drop(small, 0.2 * f64::from(i) - 0.2, 1.2 + 0.6 * f64::from(i))).collect();
    stage.steps(540);
    let up = stage.up(bowl);
    println!("bowl at {}, up {up}, {} m/s", stage.at(bowl), stage.speed(bowl));
    assert!(up.z > 0.9, "the bowl fell over: {up}");
    for id in balls {
        let off = stage.at(id) - stage.at(bowl);
        println!("{off}, {} m/s", stage.speed(id));
        assert!(
            off.truncate().length() < 0.6 && off.z < 0.1 && off.z > -0.65,
            "a ball at {off} from the bowl"
        );
        assert!(stage.speed(id) < 5e-3, "{} m/s", stage.speed(id));
    }
}

/// Promise: bowls stack in bowls: four with leaning walls that are dropped into one that stands fast nest one over the other, as far
/// apart as their walls say, or further and askew by what the hulls fill, and come to rest.
#[test]
fn bowls_stack() {
    let mut stage = Stage::new();
    let (shape, filled) = stage.hulls(&cup(), 64);
    let first = Body::fixed(shape, stage.material, Pose::default());
    let mut ids = vec![stage.world.spawn(first).expect("a bowl")];
    ids.extend((1..5).map(|i| stage.drop(shape, 0.02 * f64::from(i % 2), 0.5 * f64::from(i))));
    stage.steps(600);
    for pair in ids.windows(2) {
        let off = stage.at(pair[1]) - stage.at(pair[0]);
        println!("{off}, up {}, {} m/s", stage.up(pair[1]), stage.speed(pair[1]));
        // The lower edge, 0.5 m wide, is held where the inner wall is as wide.
        let nested = 0.1 + 0.7 * (0.5 - 0.42) / 0.48;
        assert!(
            off.z > nested - 0.01 && off.z < nested + 2.0 * filled + 0.01,
            "{off} of {nested}, filled {filled}"
        );
        // What the hulls fill is where a bowl may sit askew in the next, whose foot is 0.5 m from its axis.
        let lean = f64::from((stage.up(pair[0]) - stage.up(pair[1])).length());
        assert!(off.truncate().length() < filled && lean < filled / 0.5, "{off}, {lean} of {filled}");
        assert!(stage.speed(pair[1]) < 1e-3, "{}", stage.speed(pair[1]));
    }
}

/// Promise: a capsule that fits through the hole of a torus falls through it, touching it on the way or not; a ball that does not fit lies on it.
#[test]
fn a_torus_lets_through_what_fits() {
    let mut stage = Stage::new();
    let (shape, _) = stage.hulls(&torus(), 32);
    let ring = Body::fixed(shape, stage.material, Pose::at(DVec3::new(0.0, 0.0, 4.0)));
    stage.world.spawn(ring).expect("a ring");
    let thin = stage.world.add_shape(Shape::Capsule { half_length: 0.8, radius: 0.3 }).expect("a capsule");
    let thick = stage.world.add_shape(Shape::Sphere { radius: 0.9 }).expect("a ball");
    let through = [stage.drop(thin, 0.0, 6.0), stage.drop(thin, 0.3, 9.0)];
    stage.steps(200);
    for id in through {
        println!("{}", stage.at(id));
        assert!(stage.at(id).z < 2.0, "a capsule hangs at {}", stage.at(id));
    }
    let held = stage.drop(thick, 0.05, 6.0);
    stage.steps(300);
    let at = stage.at(held);
    println!("{at}, {} m/s", stage.speed(held));
    // On the ring the two middles are 1.2 m apart, across 1 m of which: 0.66 m up.
    assert!((at.z - 4.66).abs() < 0.1 && at.truncate().length() < 0.1, "{at}");
    assert!(stage.speed(held) < 5e-3, "{}", stage.speed(held));
}
