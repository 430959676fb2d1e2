//! A ball hits the ground obliquely.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_COULOMB};
use crate::finding::Findings;
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "oblique-impact",
    group: GROUP,
    title: "A ball hits the ground obliquely",
    source: Source::ClosedForm(
        "Walton's law without tangential restitution: the smaller of μ (1 + e) v_n and 2/7 of the contact's slip",
    ),
    setup: "Ball of radius 0.5 m, no gravity, 1 ms; (v_t, v_n, R ω, e, μ) = (3, 4, 0, 0.8, 0.5), which sticks, (6, 2, 0, 0.8, 0.1), which slides, and \
            (0, 4, 5, 0.9, 0.3), which only spins. `impulse` has another law, v_T' = a v_T, and is not asked.",
    engines: WITH_COULOMB,
    long: false,
    run,
};

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    for (name, [v_t, v_n, rw, e, mu], exact) in [
        ("sticks", [3.0_f32, 4.0, 0.0, 0.8, 0.5], [2.142_857, 3.2, 2.142_857]),
        ("slides", [6.0, 2.0, 0.0, 0.8, 0.1], [5.64, 1.6, 0.9]),
        ("spins", [0.0, 4.0, 5.0, 0.9, 0.3], [1.428_571, 3.6, 1.428_571]),
    ] {
        let surface = Surface::new(mu, e);
        let mut stage = rig.on_ground(Terms { gravity: Vec3::ZERO, ..Terms::FINE }, surface)?;
        let thing = Thing::new(ball(0.5), surface, DVec3::Z * 1.5);
        let id = stage.put(&thing.moving(Vec3::new(v_t, 0.0, -v_n), Vec3::Y * (rw / 0.5)))?;
        stage.seconds(0.7)?;
        let (v, w) = (stage.velocity(id)?, stage.spin(id)?);
        for ((what, got), exact) in [("v_t", v.x), ("v_n", v.z), ("R ω", 0.5 * w.y)].into_iter().zip(exact) {
            findings.near(
                format!("{what} of the ball that {name}"),
                "m/s",
                got,
                (exact, 1e-4 * 4.0),
                "1e-4 of the speed",
            );
        }
    }
    Ok(findings)
}
