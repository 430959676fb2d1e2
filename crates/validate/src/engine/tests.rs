//! What every engine of a build has to do alike: Rockfall's solvers as a rule, and the peers where they are built.

use super::*;
use crate::stage::{Rig, Stage, ball, cuboid};
use ::rockfall::math::rotation::to_rotation_vector;
use ::rockfall::shape::{Compound, Hull};
use std::sync::Arc;

const WEIGHTLESS: Terms = Terms { gravity: Vec3::ZERO, ..Terms::FINE };

fn stage(engine: EngineName, terms: Terms) -> Stage {
    Rig { engine, quick: true }.stage(terms).expect("built")
}

/// Those of a list that this build has.
fn built(engines: &[EngineName]) -> impl Iterator<Item = EngineName> {
    EngineName::built().into_iter().filter(|engine| engines.contains(engine))
}

/// Promise: a cube falls by ½ g T², or ½ g T (T + h) by semi-implicit steps, and gets g T; whatever it weighs, and in whatever direction gravity goes.
#[test]
fn things_fall_as_far_as_gravity_says() {
    for engine in built(ALL) {
        let terms = Terms { gravity: Vec3::new(3.0, 0.0, -4.0), ..Terms::FINE };
        let mut stage = stage(engine, terms);
        let cube = Thing::new(cuboid(0.2, 0.2, 0.2), Surface::new(0.5, 0.0), DVec3::ONE).mass(3.0);
        let id = stage.put(&cube).expect("a cube");
        stage.seconds(1.0).expect("steps");
        let g = terms.gravity.as_dvec3();
        let off = stage.position(id).expect("there") - DVec3::ONE - 0.5 * g;
        let late = off.dot(g) / g.length_squared();
        assert!((-1e-5..=0.5e-3 + 1e-5).contains(&late), "{engine:?}: {off}");
        assert!((off - g * late).length() < 1e-4, "{engine:?}: {off}");
        let v = stage.velocity(id).expect("there");
        assert!((v - g).length() < 1e-3, "{engine:?}: {v}");
    }
}

/// Promise: an impulse acts by the mass that a thing was given, at its centre of mass, and a thing turns about that centre, here half a metre off.
#[test]
fn pushes_and_spins_know_mass_and_its_centre() {
    for engine in built(ALL) {
        let mut stage = stage(engine, WEIGHTLESS);
        let surface = Surface::new(0.5, 0.0);
        let off = Compound::new([(ball(0.2), Pose::at(DVec3::X * 0.5))]).expect("one ball");
        let off = Thing::new(Shape::Compound(Arc::new(off)), surface, DVec3::ZERO).mass(2.0);
        let pushed = stage.put(&off).expect("a ball off its frame");
        let turn = off.pose(Pose::at(DVec3::Y * 9.0)).moving(Vec3::ZERO, Vec3::Z * core::f32::consts::PI);
        let turned = stage.put(&turn).expect("another one");
        stage.push(pushed, Vec3::Z * 3.0).expect("an impulse");
        stage.seconds(1.0).expect("steps");
        let (v, w) = (stage.velocity(pushed).expect("there"), stage.spin(pushed).expect("there"));
        assert!((v - DVec3::Z * 1.5).length() < 1e-5 && w.length() < 1e-5, "{engine:?}: {v}, {w}");
        let place = stage.position(turned).expect("there");
        assert!((place - DVec3::new(1.0, 9.0, 0.0)).length() < 0.01, "{engine:?}: {place}");
        let v = stage.velocity(turned).expect("there");
        assert!(v.length() < 1e-5, "{engine:?}: {v}");
    }
}

/// Promise: what is driven goes and turns as it is told, gravity or not, and otherwise from when it is told otherwise.
#[test]
fn what_is_driven_goes_as_it_is_told() {
    for engine in built(ALL) {
        let mut stage = stage(engine, Terms::FINE);
        let door = Thing::new(cuboid(1.0, 0.1, 2.0), Surface::new(0.5, 0.0), DVec3::ZERO);
        let door = stage.put(&door.driven().moving(Vec3::X * 0.5, Vec3::Z)).expect("a door");
        stage.seconds(1.0).expect("steps");
        let (place, turned) = (stage.position(door).expect("there"), stage.rotation(door).expect("there"));
        assert!((place - DVec3::X * 0.5).length() < 1e-3, "{engine:?}: {place}");
        assert!((to_rotation_vector(turned) - Vec3::Z).length() < 2e-3, "{engine:?}: {turned}");
        let (v, w) = (stage.velocity(door).expect("there"), stage.spin(door).expect("there"));
        assert!((v - DVec3::X * 0.5).length() + (w - DVec3::Z).length() < 1e-3, "{engine:?}: {v}, {w}");
        stage.set_velocity(door, Vec3::Y * -2.0, Vec3::ZERO).expect("another velocity");
        stage.seconds(0.5).expect("steps");
        let place = stage.position(door).expect("there");
        assert!((place - DVec3::new(0.5, -1.0, 0.0)).length() < 2e-3, "{engine:?}: {place}");
    }
}

/// Promise: what slides is slowed by μ g, with μ as the rule mixes it, here the lesser of two; and a ball comes back with e times its speed, unless it is slower
/// than the threshold.
#[test]
fn things_rub_and_bounce_by_their_coefficients() {
    for engine in built(WITH_COULOMB) {
        let rubs = |mu: f32| Surface { mix: Mix::Minimum, ..Surface::new(mu, 0.0) };
        let mut sliding = stage(engine, Terms::FINE);
        sliding.plane(Vec3::Z, rubs(0.8)).expect("ground");
        let slab = Thing::new(cuboid(1.0, 1.0, 0.2), rubs(0.3), DVec3::Z * 0.1);
        let slab = sliding.put(&slab.moving(Vec3::X * 3.0, Vec3::ZERO)).expect("a slab");
        sliding.seconds(0.5).expect("steps");
        let (v, exact) = (sliding.velocity(slab).expect("there"), 3.0 - 0.3 * 9.81 * 0.5);
        assert!((v - DVec3::X * exact).length() < 0.02, "{engine:?}: {v}, expected {exact} m/s");

        // Rapier knows no threshold.
        let slow = if engine == EngineName::Rapier { 0.5 } else { 0.0 };
        for (speed, back) in [(4.0, 2.0), (1.0, slow)] {
            let mut bouncing = stage(engine, Terms { threshold: 2.0, ..WEIGHTLESS });
            bouncing.plane(Vec3::Z, Surface::new(0.0, 0.0)).expect("ground");
            // Half a step's way off the ground before the step that it bounces in, since PhysX slows what is within five quarters of one but does not
            // get there.
            let stone = Thing::new(ball(0.1), Surface::new(0.0, 0.5), DVec3::Z * 0.602);
            let stone = bouncing.put(&stone.moving(Vec3::Z * -speed, Vec3::ZERO)).expect("a ball");
            bouncing.seconds(0.6).expect("steps");
            let v = bouncing.velocity(stone).expect("there");
            assert!((v - DVec3::Z * back).length() < 0.05, "{engine:?}: {v}, expected {back} m/s");
        }
    }
}

/// Promise: shapes are as large as ours, and stand as ours do: each comes to rest with its lowest point on the ground, which is a plane off the
/// origin. What an engine lacks it says.
#[test]
fn shapes_stand_as_ours_do() {
    let corners = cuboid(0.4, 0.6, 0.8);
    let Shape::Box { half } = corners else { unreachable!("a box") };
    let corners: Vec<Vec3> = (0..8)
        .map(|i: u32| Vec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 })) * half)
        .collect();
    let hull = Shape::Hull(Arc::new(Hull::from_points(&corners).expect("eight corners")));
    let stone = Compound::new([(cuboid(0.4, 0.4, 0.2), Pose::at(DVec3::Z * 0.3))]).expect("one box");
    let shapes = [
        (ball(0.3), 0.3),
        (cuboid(0.4, 0.6, 0.8), 0.4),
        (Shape::Capsule { half_length: 0.3, radius: 0.2 }, 0.5),
        (Shape::Cylinder { half_length: 0.3, radius: 0.2 }, 0.3),
        (hull, 0.4),
        (Shape::Compound(Arc::new(stone)), -0.2),
    ];
    for engine in built(WITH_FRICTION) {
        for (shape, above) in &shapes {
            let mut stage = stage(engine, Terms::FINE);
            stage.wall(Vec3::Z, -1.0, Surface::new(0.5, 0.0)).expect("ground");
            let thing = Thing::new(shape.clone(), Surface::new(0.5, 0.0), DVec3::Z * (above - 0.99));
            let id = match stage.put(&thing) {
                Ok(id) => id,
                Err(Error::NoShape { .. }) if engine.is_peer() => continue,
                Err(error) => panic!("{engine:?}, {}: {error}", shape.name()),
            };
            stage.seconds(0.25).expect("steps");
            let z = stage.position(id).expect("there").z;
            assert!((z - (above - 1.0)).abs() < 5e-3, "{engine:?}, {}: {z}", shape.name());
        }
    }
}
