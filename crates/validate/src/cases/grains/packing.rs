//! How densely do balls lie, and how many touch each?

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Terms};
use crate::finding::{Figure, Findings};
use crate::stage::Rig;
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "packing",
    group: GROUP,
    title: "20,000 balls settle",
    source: Source::Published(
        "random close packing 0.635 (Baranau and Tallarek 2014), six contacts a ball without friction and four with much of it (Silbert 2010), random loose packing 0.55 (Jerkins 2008)",
    ),
    setup: "20,000 balls of 1 m in a box 20 m across fall and settle, for each of four coefficients of friction, under a tenth of gravity, so that contacts give by some 0.01 % of a diameter and not 0.1 %; walls and floor without friction. Only what is five balls away from walls, floor and \
            surface counts. A contact is nearer than 10 µm; balls with fewer than 4 contacts (without friction) or 3 (with) carry nothing and are left out of the mean.",
    engines: DEFAULT,
    long: true,
    run,
};

/// Fraction, contacts of a ball, and how much it still moves.
fn settle(rig: &Rig, mu: f32) -> Result<(f64, f64, f64), Error> {
    let (width, count) = (20.0, 20_000);
    let smooth = Surface::new(0.0, 0.0);
    let terms = Terms { gravity: heap::TERMS.gravity * 0.1, threads: 0, ..heap::TERMS };
    let (mut stage, _) = heap::walls(rig, terms, width, smooth)?;
    stage.plane(Vec3::Z, smooth)?;
    let ids =
        heap::pour(&mut stage, width, 0.0, count, &heap::grain(Surface::new(mu, 0.0)), 2.0 * heap::R, 4)?;
    let unrest = heap::settle(&mut stage, &ids, 45.0)?;
    let places = heap::places(&stage, &ids)?;
    let mut heights: Vec<f64> = places.iter().map(|p| p.z).collect();
    heights.sort_by(f64::total_cmp);
    let top = heights[count - count / 50];
    let half = 0.5 * width - 5.0;
    let bulk = [DVec3::new(-half, -half, 5.0), DVec3::new(half, half, top - 5.0)];
    let counts = heap::contacts(&places, 1e-5);
    let inside = |p: &DVec3| p.cmpgt(bulk[0]).all() && p.cmplt(bulk[1]).all();
    let least = if mu == 0.0 { 4 } else { 3 };
    let carrying =
        places.iter().zip(&counts).filter(|(p, n)| inside(p) && **n >= least).map(|(_, n)| f64::from(*n));
    let carrying: Vec<f64> = carrying.collect();
    let mean = carrying.iter().sum::<f64>() / carrying.len().max(1) as f64;
    Ok((heap::fraction(&places, bulk), mean, unrest))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let (mut fractions, mut counts) = (Vec::new(), Vec::new());
    for mu in [0.0_f32, 0.1, 0.3, 1.0] {
        let (fraction, contacts, unrest) = settle(rig, mu)?;
        fractions.push((f64::from(mu), fraction));
        counts.push((f64::from(mu), contacts));
        let (a, b) = (format!("fraction, μ = {mu}"), format!("contacts of a ball, μ = {mu}"));
        if mu == 0.0 {
            findings.near(a, "", fraction, (0.635, 0.01), "0.634 to 0.64 in the literature").near(
                b,
                "",
                contacts,
                (6.0, 0.2),
                "what carries without friction is isostatic: two contacts for each direction",
            );
        } else if mu == 1.0 {
            findings
                .near(
                    a,
                    "",
                    fraction,
                    (0.57, 0.025),
                    "from random loose packing, 0.55, to what falls rather than is laid down, 0.59",
                )
                .near(
                    b,
                    "",
                    contacts,
                    (4.0, 0.3),
                    "towards isostatic with friction, and what is left of the fall",
                );
        } else {
            findings.shown(a, "", fraction).shown(b, "", contacts);
        }
        findings.shown(format!("mean kinetic energy of a ball over m g R, μ = {mu}"), "", unrest);
    }
    let steps = |points: &[(f64, f64)]| {
        points.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(f64::NEG_INFINITY, f64::max)
    };
    findings
        .at_most("largest rise of the fraction with μ", "", steps(&fractions), 0.0, "it falls")
        .at_most("largest rise of the contacts with μ", "", steps(&counts), 0.0, "they fall")
        .draw(
            Figure::linear("Fraction", "coefficient of friction", "part of the room that is in balls")
                .ours("", fractions)
                .expected("close, without friction", [(0.0, 0.635), (1.0, 0.635)])
                .expected("loose", [(0.0, 0.55), (1.0, 0.55)]),
        )
        .draw(
            Figure::linear("Contacts", "coefficient of friction", "contacts of a ball")
                .ours("", counts)
                .expected("isostatic without friction", [(0.0, 6.0), (1.0, 6.0)])
                .expected("isostatic with friction", [(0.0, 4.0), (1.0, 4.0)]),
        );
    Ok(findings)
}
