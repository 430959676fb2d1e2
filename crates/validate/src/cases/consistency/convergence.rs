//! How far is a solution from the same engine's own with steps 64 times as short?

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, Slope, Stage, ball, cuboid, turn};
use rockfall::math::{DVec3, Pose, Vec3};
use std::time::Instant;

pub(super) const CASE: Case = Case {
    name: "self-consistency",
    group: GROUP,
    title: "Five scenes against themselves with steps 64 times as short",
    source: Source::Published(
        "the method of Erez, Todorov and Tassa 2015, \"Simulation tools for model-based robotics\"",
    ),
    setup: "A box that tumbles under gravity, a ball that slides and rolls down 15°, a cube that slides and spins to a stop, a pyramid of six cubes whose top one is \
            pushed, and a rod that falls over; 1 s. Root mean square of the distances between the bodies' centres and those of the same engine at 1/64 of a 60th of a second, ten times in the second.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

type Scene = fn(&Rig, Terms) -> Result<Stage, Error>;

const SCENES: [(&str, Scene); 5] = [
    ("tumbling", tumbling),
    ("rolling", rolling),
    ("sliding", sliding),
    ("pyramid", pyramid),
    ("falling rod", rod),
];

fn tumbling(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    let mut stage = rig.stage(terms)?;
    let thing = Thing::new(cuboid(0.1, 0.4, 0.9), Surface::new(0.5, 0.0), DVec3::ZERO);
    stage.put(&thing.moving(Vec3::new(-2.0, 2.0, 8.0), Vec3::new(1.0, 5.0, 1.0)))?;
    Ok(stage)
}

fn rolling(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    let slope = Slope::new(15_f64.to_radians());
    let surface = Surface::new(0.2, 0.0);
    let mut stage = rig.stage(terms)?;
    stage.plane(slope.normal, surface)?;
    let thing = Thing::new(ball(0.25), surface, DVec3::ZERO).pose(slope.pose(0.25));
    stage.put(&thing.moving((slope.down * 3.0).as_vec3(), Vec3::ZERO))?;
    Ok(stage)
}

fn sliding(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    let surface = Surface::new(0.4, 0.0);
    let mut stage = rig.on_ground(terms, surface)?;
    let thing = Thing::new(cuboid(0.5, 0.5, 0.5), surface, DVec3::Z * 0.25);
    stage.put(&thing.moving(Vec3::X * 3.0, Vec3::Z * 6.0))?;
    Ok(stage)
}

fn pyramid(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    let surface = Surface::new(0.5, 0.0);
    let mut stage = rig.on_ground(terms, surface)?;
    for (row, count) in [3, 2, 1].into_iter().enumerate() {
        for i in 0..count {
            let x = 0.55 * (f64::from(i) - 0.5 * f64::from(count - 1));
            let thing =
                Thing::new(cuboid(0.5, 0.5, 0.5), surface, DVec3::new(x, 0.0, 0.25 + 0.5 * row as f64));
            let v = if count == 1 { Vec3::X * 1.5 } else { Vec3::ZERO };
            stage.put(&thing.moving(v, Vec3::ZERO))?;
        }
    }
    Ok(stage)
}

fn rod(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    let surface = Surface::new(0.6, 0.0);
    let mut stage = rig.on_ground(terms, surface)?;
    let angle = 60_f64.to_radians();
    let (sin, cos) = libm::sincos(angle);
    let pose = Pose { position: DVec3::Z * (0.5 * sin + 0.05 * cos), rotation: turn(Vec3::Y, angle) };
    stage.put(&Thing::new(cuboid(1.0, 0.2, 0.1), surface, DVec3::ZERO).pose(pose))?;
    Ok(stage)
}

/// Centres of all bodies ten times in a second, and the time that it took, s.
fn run_scene(rig: &Rig, scene: Scene, rate: f32) -> Result<(Vec<DVec3>, f64), Error> {
    let start = Instant::now();
    let mut stage = scene(rig, Terms { rate, ..Terms::FINE })?;
    let movers: Vec<usize> = stage.movers().collect();
    let mut places = Vec::new();
    for _ in 0..10 {
        stage.seconds(0.1)?;
        for &body in &movers {
            places.push(stage.position(body)?);
        }
    }
    Ok((places, start.elapsed().as_secs_f64()))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut by_step = Figure::logarithmic("Deviation against step", "step, s", "deviation, m");
    let mut by_time = Figure::logarithmic("Deviation against time", "wall-clock time, s", "deviation, m");
    for (name, scene) in SCENES {
        let (reference, _) = run_scene(rig, scene, 60.0 * 64.0)?;
        let (mut steps, mut times) = (Vec::new(), Vec::new());
        for parts in [1.0_f32, 2.0, 4.0, 8.0, 16.0] {
            let (places, seconds) = run_scene(rig, scene, 60.0 * parts)?;
            let squares: f64 = places.iter().zip(&reference).map(|(a, b)| (*a - *b).length_squared()).sum();
            let deviation = libm::sqrt(squares / reference.len() as f64);
            steps.push((1.0 / (60.0 * f64::from(parts)), deviation));
            times.push((seconds, deviation));
        }
        findings.shown(format!("deviation at 1/60 s, {name}"), "m", steps[0].1);
        findings.at_most(
            format!("deviation at 1/960 s over that at 1/240 s, {name}"),
            "",
            steps[4].1 / steps[2].1,
            0.5,
            "a first-order method gets four times as near, and the reference itself is 1/3840 s; half of that where contacts come and go",
        );
        by_step = by_step.ours(name, steps);
        by_time = by_time.ours(name, times);
    }
    findings.draw(by_step).draw(by_time);
    Ok(findings)
}
