//! Gazebo's `collide_spheres` (scpeters/benchmark).

mod common;

use common::{Stage, at, frames, rubs};
use rockfall::Settings;
use rockfall::math::Vec3;

/// Promise: of 24 pairs of balls, of radius 1 mm and 100 mm, their middles 0 to 3 radii apart, those at up to two radii touch, in one point each: sixteen. How far apart
/// they are is what it is to 1e-6 of the radius, and no pair meets another one.
#[test]
fn pairs_of_balls_touch_up_to_two_radii() {
    const APART: [f64; 12] = [0.0, 0.1, 0.5, 1.0, 1.5, 1.8, 1.9, 2.0, 2.1, 2.2, 2.5, 3.0];
    let mut stage = Stage::new(Settings { gravity: Vec3::ZERO, ..frames() }, rubs(0.0, 0.0));
    let mut pairs = Vec::new();
    for (row, radius) in [1e-3_f32, 0.1].into_iter().enumerate() {
        let ball = stage.ball(radius);
        for (i, apart) in APART.into_iter().enumerate() {
            let y = 0.3 * (row * APART.len() + i) as f64;
            let mut put = |x: f64| stage.put(stage.body(ball, at(x, y, 0.5)));
            pairs.push((radius, apart, put(0.0), put(apart * f64::from(radius))));
        }
    }
    stage.steps(1);
    let contacts: Vec<_> = stage.world.contacts().collect();
    let mut touching = 0;
    for (radius, apart, a, b) in pairs {
        let between: Vec<_> = contacts.iter().filter(|c| [(a, b), (b, a)].contains(&(c.a, c.b))).collect();
        assert!(between.len() <= 1, "{radius} {apart}: {between:?}");
        let exact = (apart - 2.0) * f64::from(radius);
        for contact in &between {
            assert!((f64::from(contact.distance) - exact).abs() <= 1e-6 * f64::from(radius), "{contact:?}");
            // What touches to the last digit may be told on either side of it.
            touching += usize::from(exact <= 1e-9 * f64::from(radius));
        }
        assert!(apart > 2.0 || between.len() == 1, "{radius} {apart}");
    }
    assert_eq!(touching, 16);
    assert!(contacts.len() <= 24);
}
