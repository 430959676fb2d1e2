//! A ball is dropped into a bed of small ones.

use super::{GROUP, heap, repose};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, DENSITY, Surface, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Rig, ball};
use rockfall::math::{DVec3, Vec3};

pub(super) const CASE: Case = Case {
    name: "crater",
    group: GROUP,
    title: "A heavy ball is dropped into a bed of small ones",
    source: Source::Experiment(
        "Uehara, Ambroso, Ojha and Durian 2003: depth 0.14 / μ (ρ_b / ρ_g)^(1/2) D^(2/3) H^(1/3); H the whole drop, the depth included, μ the tangent of the angle of repose, ρ_g of the bed as a whole",
    ),
    setup: "A ball of 5 m (quick: 4 m) on a bed of balls of 1 m, μ = 0.5, 24 m across and 14 m deep (18 m, 11 m) with smooth walls: from 5, 20 and 40 m (5 and 40 m) at 1000 kg/m³, and from 5 m at 4000. How deep its lowest point \
            is below what was the surface, when it is at rest. The angle of repose is that of the case `repose`.",
    engines: DEFAULT,
    long: false,
    run,
};

/// Volume of balls over that of the bed.
const FILLED: f64 = 0.58;

/// Diameter of what is dropped, m.
fn diameter(rig: &Rig) -> f64 {
    if rig.quick { 4.0 } else { 5.0 }
}

/// How deep a ball gets, m, that falls by `height` before it meets the bed.
fn depth(rig: &Rig, height: f64, density: f64) -> Result<f64, Error> {
    let (width, deep) = if rig.quick { (18.0, 11.0) } else { (24.0, 14.0) };
    let (rubs, smooth) = (Surface::new(0.5, 0.0), Surface::new(0.0, 0.0));
    let (mut stage, _) = heap::walls(rig, heap::TERMS, width, smooth)?;
    stage.plane(Vec3::Z, rubs)?;
    let volume = core::f64::consts::FRAC_PI_6;
    let count = (width * width * deep * FILLED / volume) as usize;
    let ids = heap::pour(&mut stage, width, 0.0, count, &heap::grain(rubs), 1.0, 9)?;
    heap::settle(&mut stage, &ids, 10.0)?;
    // The mean of the highest points over squares of 2 m.
    let squares = (0.5 * width) as usize;
    let mut tops = vec![0.0_f64; squares * squares];
    for p in heap::places(&stage, &ids)? {
        let square = |x: f64| ((x + 0.5 * width) / 2.0).clamp(0.0, squares as f64 - 1.0) as usize;
        let top = &mut tops[square(p.x) * squares + square(p.y)];
        *top = top.max(p.z + heap::R);
    }
    let surface = tops.iter().sum::<f64>() / tops.len() as f64;
    let radius = 0.5 * diameter(rig);
    let speed = libm::sqrt(2.0 * stage.terms.g() * height);
    let heavy = 8.0 * radius.powi(3) * volume * density;
    // A little above what stands out of the surface.
    let place = DVec3::Z * (surface + 0.5 + radius);
    let thing = Thing::new(ball(radius as f32), rubs, place).mass(heavy as f32);
    let id = stage.put(&thing.moving(Vec3::Z * -speed as f32, Vec3::ZERO))?;
    stage.seconds(6.0)?;
    Ok(surface - (stage.position(id)?.z - radius))
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let (angle, _) = repose::slope(rig, Surface::new(0.5, 0.0))?;
    let mu = libm::tan(angle.to_radians());
    let light = f64::from(DENSITY);
    let heights: &[f64] = if rig.quick { &[5.0, 40.0] } else { &[5.0, 20.0, 40.0] };
    let mut points = Vec::new();
    for &height in heights {
        let depth = depth(rig, height, light)?;
        points.push((height + depth, depth));
    }
    let heavy = depth(rig, 5.0, 4.0 * light)?;
    let law = |drop: f64, density: f64| {
        let ratio = density / (FILLED * f64::from(DENSITY));
        0.14 / mu * libm::sqrt(ratio) * libm::pow(diameter(rig), 2.0 / 3.0) * libm::cbrt(drop)
    };
    let logarithms: Vec<(f64, f64)> = points.iter().map(|&(h, d)| (libm::log(h), libm::log(d))).collect();
    let (exponent, _, _) = super::line::through(&logarithms);
    let off = |drop: f64, depth: f64, density: f64| 0.14 * depth / law(drop, density);
    let factor = points.iter().map(|&(h, d)| off(h, d, light)).sum::<f64>() / points.len() as f64;
    // The drop of the heavy one is longer, as it gets deeper.
    let drop = 5.0 + heavy;
    let same = points[0].1 * libm::cbrt(drop / points[0].0);
    let density = libm::log(heavy / same) / libm::log(4.0);
    let mut findings = Findings::default();
    findings
        .near(
            "exponent of the drop",
            "",
            exponent,
            (1.0 / 3.0, 0.1),
            "1/3; balls in place of sand, each point once",
        )
        .near("exponent of the density", "", density, (0.5, 0.15), "1/2; two densities")
        .near(
            "factor",
            "",
            factor,
            (0.14, 0.05),
            "0.14 in sand and beads much smaller than the ball; here they are a fifth of it",
        )
        .shown("angle of repose", "°", angle)
        .shown("depth from 5 m", "m", points[0].1)
        .shown("depth from 40 m", "m", points[points.len() - 1].1)
        .shown("depth from 5 m, four times the density", "m", heavy);
    let (first, last) = (points[0].0, points[points.len() - 1].0);
    let curve = (0..=20).map(|i| first + (last - first) * f64::from(i) / 20.0).map(|h| (h, law(h, light)));
    let figure = Figure::logarithmic("Depth", "drop, m", "depth, m")
        .ours("", points)
        .ours("four times the density", [(drop, heavy)])
        .expected("Uehara", curve);
    findings.draw(figure);
    Ok(findings)
}
