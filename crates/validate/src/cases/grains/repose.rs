//! Balls run off a shelf until what is left on it stays.

use super::{GROUP, heap};
use crate::Error;
use crate::case::{Case, Source};
use crate::engine::{DEFAULT, Surface, Thing};
use crate::finding::{Figure, Findings};
use crate::stage::{Numbers, Rig, Stage, cuboid};
use rockfall::Mix;
use rockfall::math::{DVec3, Pose, Vec3};

pub(super) const CASE: Case = Case {
    name: "repose",
    group: GROUP,
    title: "Balls run off a shelf and leave a slope",
    source: Source::Published(
        "Zhou, Xu, Yu and Zulli 2001 and 2002: the angle of repose rises with sliding and with rolling friction; balls without the latter make 20° to 25°",
    ),
    setup: "Balls of 1 m, 15 m deep (quick: 9 m) on a shelf of glued balls 30 m long and 8 m wide (16 m, 6 m) between smooth walls; the wall at the end of the shelf goes. When all is at rest, or after 60 s, the straight line \
            through the highest balls over squares of 1.5 m. Rolling friction is a length.",
    engines: DEFAULT,
    long: false,
    run,
};

/// The angle that balls of a surface leave, degrees, and the heights of the slope over x, metres.
pub(super) fn slope(rig: &Rig, surface: Surface) -> Result<(f64, Vec<(f64, f64)>), Error> {
    let (length, width, depth) = if rig.quick { (16.0, 6.0, 9.0) } else { (30.0, 8.0, 15.0) };
    let rubs = Surface { mix: Mix::Minimum, ..surface };
    let smooth = Surface { mix: Mix::Minimum, ..Surface::new(0.0, 0.0) };
    let mut stage = rig.stage(heap::TERMS)?;
    for (normal, offset) in [(Vec3::Y, -0.5 * width), (Vec3::NEG_Y, -0.5 * width), (Vec3::X, 0.0)] {
        stage.wall(normal, offset as f32, smooth)?;
    }
    glue(&mut stage, length, width, rubs)?;
    let high = 3.0 * depth;
    let gate = Thing::new(
        cuboid(1.0, 1.5 * width as f32, high as f32),
        smooth,
        DVec3::new(length + 0.5, 0.0, 0.5 * high - 2.0),
    );
    let gate = stage.put(&gate.driven())?;
    let count = (0.58 * length * width * depth / core::f64::consts::FRAC_PI_6) as usize;
    let low = DVec3::new(0.0, -0.5 * width, 0.5);
    let ids = heap::pour_over(&mut stage, low, [length, width], count, &heap::grain(rubs), 1.0, 5)?;
    heap::settle(&mut stage, &ids, 8.0)?;
    let full = heights(&heap::places(&stage, &ids)?, length, width);
    let top = full.iter().map(|&(_, z)| z).sum::<f64>() / full.len() as f64;
    stage.set_velocity(gate, Vec3::Z * 60.0, Vec3::ZERO)?;
    // Those that ran off the shelf fall for ever.
    let mut left = ids;
    for _ in 0..60 {
        stage.seconds(1.0)?;
        let mut moving = 0.0;
        let mut stay = Vec::with_capacity(left.len());
        for id in left {
            let place = stage.position(id)?;
            if place.x < length && place.z > -1.0 {
                moving += stage.kinetic(id)?;
                stay.push(id);
            }
        }
        left = stay;
        let each = left.first().map_or(1.0, |&id| stage.mass(id)) * stage.terms.g() * heap::R;
        if moving <= 1e-6 * each * left.len() as f64 {
            break;
        }
    }
    let heights = heights(&heap::places(&stage, &left)?, length, width);
    // Neither the rim nor what the slope has not reached.
    let sloping = heights.iter().copied().filter(|&(x, z)| x > 2.0 && x < length - 2.0 && z < 0.8 * top);
    let (gradient, _, _) = super::line::through(&sloping.collect::<Vec<_>>());
    Ok((libm::atan(-gradient).to_degrees(), heights))
}

/// A floor of balls at uneven heights, its surface about z = 0.
fn glue(stage: &mut Stage, length: f64, width: f64, surface: Surface) -> Result<(), Error> {
    let mut random = Numbers(6);
    let (along, across) = (length as usize, width as usize);
    for i in 0..along * across {
        let cell = DVec3::new((i % along) as f64, (i / along) as f64 - 0.5 * width, 0.0);
        let place = cell + DVec3::new(0.5, 0.5, -0.5 - 0.4 * random.next());
        stage.put(&heap::grain(surface).fixed().pose(Pose::at(place)))?;
    }
    Ok(())
}

/// How high the uppermost balls are over strips of the shelf: the mean over the squares of 1.5 m across it.
fn heights(places: &[DVec3], length: f64, width: f64) -> Vec<(f64, f64)> {
    const SIDE: f64 = 1.5;
    let [strips, squares] = [length, width].map(|side| (side / SIDE) as usize);
    let mut tops = vec![f64::NEG_INFINITY; strips * squares];
    for place in places {
        let (x, y) = (place.x / SIDE, (place.y + 0.5 * width) / SIDE);
        if x >= 0.0 && y >= 0.0 && (x as usize) < strips && (y as usize) < squares {
            let top = &mut tops[x as usize * squares + y as usize];
            *top = top.max(place.z);
        }
    }
    let strip = |(i, tops): (usize, &[f64])| {
        let full: Vec<f64> = tops.iter().copied().filter(|z| z.is_finite()).collect();
        let mean = full.iter().sum::<f64>() / full.len() as f64;
        (!full.is_empty()).then_some(((i as f64 + 0.5) * SIDE, mean))
    };
    tops.chunks(squares).enumerate().filter_map(strip).collect()
}

fn run(rig: &Rig) -> Result<Findings, Error> {
    let mut findings = Findings::default();
    let mut picture = Figure::linear("What stays on the shelf", "way from the wall, m", "highest balls, m");
    let mut angle = |mu: f32, rolling: f32| -> Result<f64, Error> {
        let (angle, heights) = slope(rig, Surface { rolling, ..Surface::new(mu, 0.0) })?;
        let name = if rolling > 0.0 { format!("μ = {mu}, {rolling} m") } else { format!("μ = {mu}") };
        picture = picture.clone().ours(&name, heights);
        Ok(angle)
    };
    let mut slides = Vec::new();
    for mu in [0.0_f32, 0.1, 0.3, 0.6] {
        slides.push((f64::from(mu), angle(mu, 0.0)?));
    }
    let mut rolls = vec![(0.0, slides[3].1)];
    for rolling in [0.02_f32, 0.06] {
        rolls.push((f64::from(rolling), angle(0.6, rolling)?));
    }
    let least = |points: &[(f64, f64)]| {
        points.windows(2).map(|pair| pair[1].1 - pair[0].1).fold(f64::INFINITY, f64::min)
    };
    findings
        .at_least("least rise of the angle with μ", "°", least(&slides), 0.0, "it rises")
        .at_least("least rise of the angle with rolling friction", "°", least(&rolls), 0.0, "it rises")
        .near(
            "angle, μ = 0.6",
            "°",
            slides[3].1,
            (22.5, 4.5),
            "20° to 25°, and 2° for a line through some strips",
        )
        .draw(
            Figure::linear("Angle of repose", "μ, or ten times the rolling friction, m", "angle, °")
                .ours("sliding", slides.clone())
                .ours("rolling, μ = 0.6", rolls.iter().map(|&(x, angle)| (10.0 * x, angle))),
        )
        .draw(picture);
    for (mu, angle) in &slides[..3] {
        findings.shown(format!("angle, μ = {mu:.1}"), "°", *angle);
    }
    for (rolling, angle) in &rolls[1..] {
        findings.shown(format!("angle, μ = 0.6, rolling friction {rolling:.2} m"), "°", *angle);
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_of_balls_has_the_angle_that_it_was_laid_with() {
        let (length, width) = (20.0, 5.0);
        let tangent = 0.4;
        let place = |i: usize| {
            let (x, y) = ((i % 40) as f64 * 0.5 + 0.25, (i / 40 % 10) as f64 * 0.5 - 2.25);
            DVec3::new(x, y, 8.0 - tangent * x - (i / 400) as f64)
        };
        let heights = heights(&(0..1200).map(place).collect::<Vec<_>>(), length, width);
        let (gradient, _, _) = super::super::line::through(&heights);
        assert!((gradient + tangent).abs() < 1e-9, "{gradient}");
    }
}
