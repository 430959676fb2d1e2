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

#[cfg(test)]
mod tests {
    use crate::Scene;
    use crate::plan::Plan;
    use crate::shapes::bounding_ball;
    use rockfall::Shape;
    use rockfall_math::DVec3;

    fn plan(text: &str) -> Plan {
        Scene::parse(text, "fill.toml", ".").and_then(|s| s.plan()).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Centre and radius of the ball around each body with such a ball.
    fn balls(plan: &Plan) -> Vec<(DVec3, f64)> {
        let ball = |(row, (_, pose)): (&crate::BodyRow, &(u32, rockfall_math::Pose))| {
            let (centre, radius) = bounding_ball(&plan.shapes[row.shape])?;
            Some((pose.point(centre), f64::from(radius)))
        };
        plan.rows.iter().zip(&plan.placed).filter_map(ball).collect()
    }

    fn assert_apart(balls: &[(DVec3, f64)], gap: f64) {
        for (i, a) in balls.iter().enumerate() {
            for b in &balls[..i] {
                assert!((a.0 - b.0).length() >= a.1 + b.1 + gap - 1e-5);
            }
        }
    }

    const SHAPES: &str = "[shapes.rocks]\nkind = \"boulders\"\nradius = [0.2, 0.6]\n\
        [shapes.log]\nkind = \"capsule\"\nradius = 0.2\nlength = 0.6\n";

    #[test]
    fn bodies_are_in_the_box_and_apart_and_all_there() {
        let text = format!(
            "{SHAPES}[[generators]]\nkind = \"fill\"\nshape = [\"rocks\", \"log\"]\ncount = 300\ngap = 0.05\n\
             size = {{ min = 0.5, max = 1.5 }}\nregion = {{ min = [-6, -6, 2], max = [6, 6, 12] }}\n"
        );
        let plan = plan(&text);
        let balls = balls(&plan);
        assert_eq!(balls.len(), 300);
        assert_apart(&balls, 0.05);
        for (centre, radius) in balls {
            let r = DVec3::splat(radius - 1e-5);
            assert!((centre - r).cmpge(DVec3::new(-6.0, -6.0, 2.0)).all());
            assert!((centre + r).cmple(DVec3::new(6.0, 6.0, 12.0)).all());
        }
        let logs = plan.rows.iter().filter(|r| matches!(plan.shapes[r.shape], Shape::Capsule { .. })).count();
        assert!((100..200).contains(&logs), "each name is as likely");
        assert!(plan.rows.iter().all(|r| (0.5..=1.5).contains(&r.scale)));
    }

    #[test]
    fn another_seed_is_another_fill_and_the_same_seed_the_same() {
        let text = |seed: u32| {
            format!(
                "[world]\nseed = {seed}\n{SHAPES}[[generators]]\nkind = \"fill\"\nshape = \"log\"\ncount = 20\n\
                 region = {{ min = [-6, -6, 2], max = [6, 6, 12] }}\n"
            )
        };
        assert_eq!(balls(&plan(&text(1))), balls(&plan(&text(1))));
        assert_ne!(balls(&plan(&text(1))), balls(&plan(&text(2))));
    }

    #[test]
    fn bodies_above_ground_are_clear_of_it() {
        let text = format!(
            "{SHAPES}[shapes.hill]\nkind = \"height-field\"\n\
             terrain = {{ size = [60, 40], cells = [60, 40], slope = 40, run_out = 20 }}\n\
             [[generators]]\nkind = \"fill\"\nshape = \"rocks\"\ncount = 300\n\
             region = {{ kind = \"above\", shape = \"hill\", position = [5, 0, 3], min = [-20, -15, 0.1], max = [20, 15, 5] }}\n\
             [[bodies]]\nshape = \"hill\"\nposition = [5, 0, 3]\n"
        );
        let plan = plan(&text);
        let ground = plan.shapes.iter().find_map(|s| match s {
            Shape::HeightField(field) => Some(field.clone()),
            _ => None,
        });
        let ground = ground.unwrap();
        let balls = balls(&plan);
        assert_eq!(balls.len(), 300);
        assert_apart(&balls, 0.0);
        for (centre, radius) in balls {
            let local = centre - DVec3::new(5.0, 0.0, 3.0);
            for (k, &height) in ground.heights.iter().enumerate() {
                let (i, j) = (k as u32 % ground.columns, k as u32 / ground.columns);
                let at = DVec3::new(f64::from(i) - 30.0, f64::from(j) - 20.0, height.into());
                assert!((at - local).length() > radius);
            }
        }
    }

    #[test]
    fn bodies_inside_a_mesh_are_clear_of_its_surface() {
        // An octahedron |x| + |y| + |z| = 6, moved and turned.
        let text = "[shapes.ball]\nkind = \"sphere\"\nradius = 0.3\n[shapes.gem]\nkind = \"mesh\"\n\
            vertices = [[6, 0, 0], [-6, 0, 0], [0, 6, 0], [0, -6, 0], [0, 0, 6], [0, 0, -6]]\n\
            triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]\n\
            [[generators]]\nkind = \"fill\"\nshape = \"ball\"\ncount = 300\n\
            region = { kind = \"inside\", shape = \"gem\", position = [10, 0, 0], rotation = [0, 0, 90], margin = 0.1 }\n";
        let plan = plan(text);
        let balls = balls(&plan);
        assert_eq!(balls.len(), 300);
        assert_apart(&balls, 0.0);
        for (centre, _) in &balls {
            let p = (*centre - DVec3::new(10.0, 0.0, 0.0)).abs();
            let depth = (6.0 - p.x - p.y - p.z) / 3f64.sqrt();
            assert!(depth >= 0.4 - 1e-5);
        }
        // They fill it: some are in each of the eight corners.
        for octant in 0..8 {
            let sign = |bit: i32| if octant & bit == 0 { 1.0 } else { -1.0 };
            let corner = DVec3::new(sign(1), sign(2), sign(4));
            let there = |(c, _): &&(DVec3, f64)| ((*c - DVec3::X * 10.0) * corner).min_element() > 0.0;
            assert!(balls.iter().filter(there).count() > 10);
        }
    }
}
