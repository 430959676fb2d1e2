//! A ladder leans against a wall.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::cases::threshold::Search;
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid, turn};
use rockfall::Mix;
use rockfall::math::{DVec3, Pose, Vec3};

pub(super) const CASE: Case = Case {
    name: "ladder",
    group: GROUP,
    title: "A ladder leans against a wall",
    source: Source::ClosedForm(
        "moments about its foot: tan θ ≥ 1 / (2 μ) at a smooth wall, (1 − μ²) / (2 μ) at a rough one, less what its thickness adds",
    ),
    setup: "Board 3 × 0.5 × 0.06 m at 60°. The least μ at which its foot slips by less than 1 cm in 3 s, by bisection, at 240 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Length and thickness, m; angle off the ground.
const L: f64 = 3.0;
const T: f64 = 0.06;
const ANGLE: f64 = core::f64::consts::FRAC_PI_3;

/// How far the foot slips, m.
fn slip(rig: &Rig, floor: f64, wall: f64) -> Result<f64, Error> {
    let surface = |mu: f64| Surface { mix: Mix::Minimum, ..Surface::new(mu as f32, 0.0) };
    let mut stage = rig.on_ground(Terms { rate: 240.0, substeps: 4, ..Terms::FINE }, surface(floor))?;
    stage.wall(Vec3::NEG_X, 0.0, surface(wall))?;
    // The under face goes from the foot on the floor to the wall; the middle of the board lies half its thickness above.
    let (sin, cos) = libm::sincos(ANGLE);
    let middle = DVec3::new(-0.5 * L * cos - 0.5 * T * sin, 0.0, 0.5 * L * sin + 0.5 * T * cos);
    let pose = Pose { position: middle, rotation: turn(Vec3::Y, -ANGLE) };
    let board = cuboid(L as f32, 0.5, T as f32);
    let board = stage.put(&Thing::new(board, surface(10.0), DVec3::ZERO).pose(pose))?;
    stage.seconds(3.0)?;
    let foot = stage.pose(board)?.point(Vec3::new(-0.5 * L as f32, 0.0, -0.5 * T as f32));
    Ok((foot.x + L * cos).abs())
}

/// The least μ of the floor, where the wall has `rough` times as much: of the moments μ / (1 + μ μ_w) (sin θ + μ_w cos θ) = ½ cos θ − ½ T / L sin θ.
fn limit(rough: f64) -> f64 {
    let (sin, cos) = libm::sincos(ANGLE);
    let weight = 0.5 * cos - 0.5 * T / L * sin;
    let holds = |mu: f64| mu / (1.0 + mu * mu * rough) * (sin + mu * rough * cos) >= weight;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    for (name, rough) in [("smooth", 0.0), ("rough", 1.0)] {
        let exact = limit(rough);
        let found = Search::around(exact).least(|mu| Ok(slip(rig, mu, rough * mu)? < 0.01))?;
        findings.near(
            format!("least μ, {name} wall"),
            "",
            found,
            (exact, 0.01 * exact),
            "1 %, the aim of the project",
        );
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_ladder_has_the_limits_of_the_books() {
        // What the thickness takes off the moment of the weight, put back.
        let thin = |rough: f64| {
            let tan = libm::tan(ANGLE);
            if rough == 0.0 { 1.0 / (2.0 * tan) } else { libm::sqrt(tan * tan + 1.0) - tan }
        };
        for rough in [0.0, 1.0] {
            let (thick, thin) = (limit(rough), thin(rough));
            assert!(thick < thin && thick > 0.95 * thin, "{thick} {thin}");
        }
    }
}
