//! A box is set on a belt, and on a turntable.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::Findings;
use crate::stage::{Rig, cuboid};
use rockfall::Shape;
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "belt",
    group: GROUP,
    title: "A box is carried by a belt and by a turntable",
    source: Source::Suite("MuJoCo's conveyor and turntable"),
    setup: "Box of 0.2 m, 1 kg, μ = 1: on a belt of 0.5 m/s for 2 s, and 0.5 m off the axis of a table that turns at 1 rad/s for 4 s; 60 Hz in four sub-steps.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let surface = Surface::new(1.0, 0.0);
    let cube = |x: f64| Thing::new(cuboid(0.2, 0.2, 0.2), surface, DVec3::new(x, 0.0, 0.1)).mass(1.0);
    let mut stage = rig.stage(Terms::FRAMES)?;
    let belt = Thing::new(cuboid(8.0, 2.0, 0.2), surface, DVec3::Z * -0.1).driven();
    stage.put(&belt.moving(Vec3::X * 0.5, Vec3::ZERO))?;
    let id = stage.put(&cube(0.0))?;
    stage.seconds(2.0)?;
    let off = (stage.velocity(id)? - DVec3::X * 0.5).length();

    let mut stage = rig.stage(Terms::FRAMES)?;
    let table = Shape::Cylinder { half_length: 0.1, radius: 2.0 };
    let table = Thing::new(table, surface, DVec3::Z * -0.1).driven();
    stage.put(&table.moving(Vec3::ZERO, Vec3::Z))?;
    let id = stage.put(&cube(0.5))?;
    stage.seconds(4.0)?;
    let place = stage.position(id)?;
    let carried = DVec3::Z.cross(DVec3::new(place.x, place.y, 0.0));
    let mut findings = Findings::default();
    let reason = "MuJoCo's own limit";
    findings
        .at_most("speed off the belt's after 2 s", "m/s", off, 1e-3, reason)
        .at_most(
            "speed off the table's after 4 s",
            "m/s",
            (stage.velocity(id)? - carried).length(),
            3e-3,
            "MuJoCo's 1e-3, and ω² r h = 2e-3: the box would go along chords of a sub-step",
        )
        .at_most(
            "spin off the table's after 4 s",
            "rad/s",
            (stage.spin(id)? - DVec3::Z).length(),
            1e-3,
            reason,
        );
    Ok(findings)
}
