//! The report's two responses, `reflect` and `impulse`, through the world.

mod common;

use common::{Stage, at, fine, frames, rubs};
use rockfall::math::Vec3;
use rockfall::{Body, Settings, Solver};

/// Promise: under `reflect` a ball that falls 1 m comes back to its height, bounce after bounce for 20 s, to 5 % at 1 ms; it does not
/// turn, whatever the friction.
#[test]
fn reflect_bounces_for_ever() {
    let mut stage = Stage::on_ground(Settings { solver: Solver::Reflect, ..fine() }, rubs(0.9, 0.3));
    let ball = stage.ball(0.1);
    let id = stage.put(Body { velocity: Vec3::X, ..stage.body(ball, at(0.0, 0.0, 1.1)) });
    let (mut peak, mut peaks, mut up) = (0.0_f64, Vec::new(), false);
    for _ in 0..20_000 {
        stage.steps(1);
        let rises = stage.velocity(id).0.z > 0.0;
        if up && !rises {
            peaks.push(peak);
            peak = 0.0;
        }
        up = rises;
        peak = peak.max(if rises { stage.position(id).z - 0.1 } else { 0.0 });
    }
    let (v, w) = stage.velocity(id);
    println!("{peaks:?} {v} {w}");
    assert!(peaks.len() >= 20, "{}", peaks.len());
    assert!(peaks.iter().all(|h| (h - 1.0).abs() < 0.05), "{peaks:?}");
    assert_eq!((v.x, w), (1.0, Vec3::ZERO), "no friction");
}

/// Promise: under `reflect` a body slower than the threshold (what gravity makes in two sub-steps) stops being moved: a ball set down
/// 1 mm over the ground rests, to 2 mm of it, for 10 s.
#[test]
fn reflect_lets_the_slow_rest() {
    let mut stage = Stage::on_ground(Settings { solver: Solver::Reflect, ..frames() }, rubs(0.5, 0.0));
    let ball = stage.ball(0.1);
    let id = stage.put(stage.body(ball, at(0.0, 0.0, 0.1001)));
    stage.steps(60);
    let mut highest = 0.0_f64;
    for _ in 0..540 {
        stage.steps(1);
        highest = highest.max((stage.position(id).z - 0.1).abs());
    }
    println!("{highest}");
    assert!(highest < 2e-3, "{highest}");
}

/// Promise: under `impulse` a ball that hits a plane gets v_N' = −μ_N v_N and, at its contact point, v_T' = a v_T with
/// a = max(1 − μ_T (1 + μ_N) ‖v_N‖ / ‖v_T‖, 0): sliding and sticking, to 1e-4.
#[test]
fn impulse_is_the_reports_formula() {
    for (v_t, v_n, e, mu) in [(6.0, 2.0, 0.8, 0.1), (3.0, 4.0, 0.5, 0.6), (1.0, 3.0, 0.0, 0.2_f32)] {
        let settings = Settings { gravity: Vec3::ZERO, solver: Solver::Impulse, ..fine() };
        let mut stage = Stage::on_ground(settings, rubs(mu, e));
        let (ball, r) = (stage.ball(0.5), 0.5);
        let body = stage.body(ball, at(0.0, 0.0, 0.6));
        let id = stage.put(Body { velocity: Vec3::new(v_t, 0.0, -v_n), ..body });
        stage.steps(200);
        let (v, w) = stage.velocity(id);
        let a = (1.0 - mu * (1.0 + e) * v_n / v_t).max(0.0);
        let point = v.x - r * w.y;
        println!("{v} {w}: point {point} of {}", a * v_t);
        assert!((v.z - e * v_n).abs() < 1e-3, "{v}");
        assert!((point - a * v_t).abs() < 2e-3, "{point} {}", a * v_t);
        // The impulse: 2/7 of the change of the point's velocity moves the ball (K = 7/2 / m along the plane).
        assert!((v.x - (v_t - 2.0 / 7.0 * (v_t - a * v_t))).abs() < 2e-3, "{v}");
    }
}

/// Promise: two balls that meet head-on under `impulse` keep their momentum and part with e times their approach, to 1e-5.
#[test]
fn impulse_keeps_momentum() {
    for e in [0.0, 0.5, 1.0] {
        let settings = Settings { gravity: Vec3::ZERO, solver: Solver::Impulse, ..frames() };
        let mut stage = Stage::new(settings, rubs(0.0, e));
        let ball = stage.ball(1.0);
        let a = stage.put(Body { velocity: Vec3::X * 5.0, ..stage.body(ball, at(-2.0, 0.0, 0.0)) });
        let b = stage.put(Body { velocity: Vec3::X * -10.0, ..stage.body(ball, at(2.0, 0.0, 0.0)) });
        stage.steps(60);
        let (a, b) = (stage.velocity(a).0.x, stage.velocity(b).0.x);
        println!("{e}: {a} {b}");
        assert!((a + b + 5.0).abs() < 1e-4 && (b - a - 15.0 * e).abs() < 1e-4, "{a} {b}");
    }
}

/// Promise: a box and a ball at rest stay under `impulse` with μ_N = 0, to 5 mm for 10 s, and don't move.
#[test]
fn impulse_lets_things_rest() {
    let mut stage = Stage::on_ground(Settings { solver: Solver::Impulse, ..frames() }, rubs(0.6, 0.0));
    let (ball, cube) = (stage.ball(0.5), stage.cuboid(0.5, 0.5, 0.5));
    let a = stage.put(stage.body(ball, at(0.0, 0.0, 0.5)));
    let b = stage.put(stage.body(cube, at(3.0, 0.0, 0.5)));
    stage.steps(600);
    for (id, x) in [(a, 0.0), (b, 3.0)] {
        let (p, v) = (stage.position(id), stage.velocity(id).0);
        println!("{p} {v}");
        assert!((p.x - x).abs() < 1e-3 && p.y.abs() < 1e-3 && (p.z - 0.5).abs() < 5e-3, "{p}");
        assert!(v.length() < 0.05, "{v}");
    }
}
