//! Random fill: bodies at random places of a region, none overlapping another.
//!
//! Each body is stood for by the ball around it. Sizes, shapes and orientations are drawn first; then the balls are
//! placed, the largest first (they find room most easily in an empty region), each at the first of up to `attempts` random
//! points where it is clear of the balls before it. Places that other generators use are not looked at.

use super::{GeneratorKind, SHAPED, TURNED};
use crate::body::{MOTION, SURFACE};
use crate::crowd::Crowd;
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::random::Random;
use crate::region::{REGIONS, Region};
use crate::rotation;
use crate::spec::{NOT_NEGATIVE, Spec, Ty, key, required};
use rockfall_math::{Pose, Quat, Vec3, rotation::rotate};

static REGION: Ty = Ty::Kinds(&REGIONS);

pub(super) static FILL_KEYS: Spec = Spec {
    name: "fill",
    about: "Bodies at random places of a region, none overlapping another. When they don't all fit, the scene is \
            refused and says how many did.",
    example: r#"[[generators]]
kind = "fill"
shape = ["ball", "crate"]
count = 500
size = { min = 0.2, max = 0.6 }
region = { min = [-5, -5, 1], max = [5, 5, 20] }
"#,
    groups: &[
        SHAPED,
        &[
            required("count", Ty::Int(1, 4_294_967_295), "Bodies."),
            required("region", REGION, "Where they may be; see below."),
            key("gap", Ty::Number(NOT_NEGATIVE), "0", "Least distance of the balls around the bodies, m."),
            key(
                "attempts",
                Ty::Int(1, 1_000_000),
                "1000",
                "Random places that a body tries before it gives up.",
            ),
        ],
        TURNED,
        SURFACE,
        MOTION,
    ],
};

pub(super) static FILL: GeneratorKind = GeneratorKind {
    spec: &FILL_KEYS,
    count: |table| u128::from(table.int("count")),
    check: |table| table.table("region").map_or(Ok(()), crate::region::check),
    place,
};

/// A body that waits for its place.
struct Waiting {
    shape: u32,
    scale: f32,
    rotation: Quat,
    /// Centre of the ball around the shape, from its origin, in the world's axes, m.
    offset: Vec3,
    radius: f64,
}

/// No packing of equal balls is denser (Kepler's conjecture; Hales 2005), and no random one comes near.
const DENSEST: f64 = 0.7405;

fn place(table: &Table, label: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let template = yard.moving(table);
    let choices = yard.choices(table)?;
    let Some(keys) = table.table("region") else { return Ok(()) };
    let region = Region::read(keys, yard)?;
    let mut random = Random::new(yard.seed, label);
    let fixed = rotation::read(table, "rotation")?;
    let turning = table.text("orientation") == "random";
    let count = table.int("count") as usize;
    let mut bodies = Vec::with_capacity(count);
    for _ in 0..count {
        let (shape, scale) = yard.draw(&choices, table, &mut random)?;
        let rotation = if turning { random.rotation() } else { fixed };
        let (centre, radius) = yard.ball(shape);
        bodies.push(Waiting {
            shape,
            scale,
            rotation,
            offset: rotate(rotation, centre),
            radius: radius.into(),
        });
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| bodies[b].radius.total_cmp(&bodies[a].radius).then(a.cmp(&b)));

    let gap = table.f64("gap");
    let refuse = |fitted: usize, how: &str| {
        let message = format!("`{}`: {how} {fitted} of {count} bodies fit into the region", table.path);
        Problem::at(table.span_of("count"), message)
            .expecting("a larger region, smaller bodies, a smaller `gap`, or a smaller `count`")
    };
    let mut room = DENSEST * region.volume();
    for (k, &i) in order.iter().rev().enumerate() {
        room -= 4.0 / 3.0 * std::f64::consts::PI * bodies[i].radius.powi(3);
        if room < 0.0 {
            return Err(refuse(k, "at most"));
        }
    }

    let mean = bodies.iter().map(|b| b.radius).sum::<f64>() / count as f64;
    let mut crowd = Crowd::new(2.0 * mean, bodies[order[0]].radius);
    let mut places = vec![None; count];
    for (placed, &i) in order.iter().enumerate() {
        let radius = bodies[i].radius;
        let found = (0..table.int("attempts")).find_map(|_| {
            let centre = region.sample(radius, &mut random)?;
            crowd.is_free(centre, radius + gap).then_some(centre)
        });
        let Some(centre) = found else { return Err(refuse(placed, "only")) };
        crowd.add(centre, radius);
        places[i] = Some(centre);
    }
    for (body, centre) in bodies.iter().zip(places) {
        let position = centre.unwrap_or_default() - body.offset.as_dvec3();
        yard.add(template, body.shape, body.scale, Pose { position, rotation: body.rotation });
    }
    Ok(())
}
