//! Figures that don't wobble: bytes that a step sweeps over, and bytes that a body takes.

mod common;

use common::columns;

/// Promise: hot bytes per contact are what the blocks say, lanes that are not in use included: at most 10 % more. 200 for four
/// points and 100 for one are the limits.
#[test]
fn bytes_swept_per_contact() {
    for (balls, bytes, limit) in [(false, 164.0, 200.0), (true, 80.0, 100.0)] {
        let mut stage = columns(40, balls);
        stage.steps(2);
        let report = stage.world.report();
        let per_contact = report.swept_bytes as f64 / report.manifolds as f64;
        println!("{per_contact:.1} bytes a contact, {} contacts", report.manifolds);
        assert!(report.manifolds >= 8000);
        assert!((bytes..1.1 * bytes).contains(&per_contact) && per_contact < limit, "{per_contact}");
    }
}

/// Promise: what a world says that it holds per settled body, all in.
#[test]
fn bytes_held_per_body() {
    for (balls, limit) in [(false, 700), (true, 1000)] {
        let mut stage = columns(40, balls);
        stage.steps(70);
        let bytes = stage.world.memory() / stage.world.len();
        println!("{bytes} bytes a body");
        assert!(bytes < limit, "{bytes}");
    }
}
