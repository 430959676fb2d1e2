//! A ball bounces lower and lower.

use super::GROUP;
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{Surface, Terms, Thing, WITH_FRICTION};
use crate::finding::{Figure, Findings, Points};
use crate::stage::{Rig, ball};
use rockfall::math::DVec3;

pub(super) const CASE: Case = Case {
    name: "bounce",
    group: GROUP,
    title: "A ball bounces lower and lower",
    source: Source::ClosedForm("hₙ = h e²ⁿ, at rest after √(2 h / g) (1 + e) / (1 − e)"),
    setup: "Ball of radius 0.1 m, e = 0.8, falls 1 m, restitution from 0.02 m/s on, 6 s at 1 ms; and at 60 Hz in four sub-steps as it comes.",
    engines: WITH_FRICTION,
    long: false,
    run,
};

/// Heights over time and their peaks, m, and the speed in the end, m/s.
fn heights(rig: &Rig, terms: Terms) -> Result<(Points, Vec<f64>, f64), Error> {
    let surface = Surface::new(0.0, 0.8);
    let mut stage = rig.on_ground(terms, surface)?;
    let id = stage.put(&Thing::new(ball(0.1), surface, DVec3::Z * 1.1))?;
    let (mut curve, mut peaks, mut peak, mut rises) = (vec![(0.0, 1.0)], Vec::new(), 0.0_f64, false);
    for _ in 0..terms.steps_in(6.0) {
        stage.step()?;
        let height = stage.position(id)?.z - 0.1;
        curve.push((stage.time(), height));
        if stage.velocity(id)?.z > 0.0 {
            peak = peak.max(height);
            rises = true;
        } else if rises {
            peaks.push(peak);
            (peak, rises) = (0.0, false);
        }
    }
    let speed = stage.velocity(id)?.length();
    Ok((curve, peaks, speed))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let (curve, peaks, speed) = heights(rig, Terms { threshold: 0.02, ..Terms::FINE })?;
    let at = |peaks: &[f64], n: usize| peaks.get(n - 1).copied().unwrap_or(0.0);
    for n in 1..=5 {
        let exact = 0.64_f64.powi(n as i32);
        findings.near(
            format!("height of bounce {n}, 1 ms"),
            "m",
            at(&peaks, n),
            (exact, 0.01 * exact),
            "1 % at 1 ms",
        );
    }
    let last = curve.iter().rev().find(|(_, height)| *height > 0.01).map_or(0.0, |(time, _)| *time);
    // The tenth bounce is the last that comes above 1 cm: it ends at √(2 h / g) (1 + 2 Σ eⁿ), and falls from its peak for the last part.
    let g = Terms::FINE.g();
    let flights: f64 = (1..=10).map(|n| 2.0 * 0.8_f64.powi(n)).sum();
    let fall = libm::sqrt(2.0 / g);
    let peak = fall * (1.0 + flights - 0.8_f64.powi(10));
    let exact = peak + libm::sqrt(2.0 * (0.64_f64.powi(10) - 0.01) / g);
    findings.near("last seen above 1 cm", "s", last, (exact, 0.01 * exact), "1 % at 1 ms");
    let end = curve.last().map_or(f64::NAN, |&(_, height)| height);
    findings.at_most("height after 6 s", "m", end.abs(), 1e-4, "it has come to rest after 4.0637 s");
    findings.at_most("speed after 6 s", "m/s", speed, 1e-4, "it has come to rest after 4.0637 s");
    let (_, frames, _) = heights(rig, Terms::FRAMES)?;
    for n in 1..=3 {
        let exact = 0.64_f64.powi(n as i32);
        let text = "5 %: peaks are seen once a frame, and lie up to g / (8 · 60²) higher; a film's bounces look right";
        findings.near(
            format!("height of bounce {n}, 60 Hz"),
            "m",
            at(&frames, n),
            (exact, 0.05 * exact),
            text,
        );
    }
    let mut exact = Vec::new();
    let (mut start, mut up) = (-libm::sqrt(2.0 / g), libm::sqrt(2.0 * g));
    while start < 4.0 && up > 0.05 {
        let flight = 2.0 * up / g;
        let parts = (0..=12).map(|i| flight * f64::from(i) / 12.0);
        exact.extend(parts.map(|t| (start + t, up * t - 0.5 * g * t * t)).filter(|(t, _)| *t >= 0.0));
        start += flight;
        up *= 0.8;
    }
    findings.draw(
        Figure::linear("Height at 1 ms", "time, s", "height, m")
            .ours("", curve.into_iter().step_by(10).take(450))
            .expected("formula", exact),
    );
    Ok(findings)
}
