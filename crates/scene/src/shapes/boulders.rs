//! A family of procedural boulders.
//!
//! A boulder begins as points spread over an ellipsoid with the proportions of natural stones. Each point is moved
//! in or out a little, then a few planes cut pieces off, as joints and falls do with rock; what sticks out is
//! pushed back onto the plane. The hull of the points, scaled to the volume of a ball of the drawn radius and moved
//! to its centre of mass, is the boulder. Radii are spread over their distribution: boulder k of n has the radius
//! below which the share (k + ½) / n lies.

use super::{Cook, ShapeKind, hull};
use crate::error::Problem;
use crate::node::Table;
use crate::random::Random;
use crate::sizes::{DISTRIBUTION, Sizes};
use crate::spec::{POSITIVE, Range, SHARE, Spec, Ty, key};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_math::{DVec3, Vec3};
use rockfall_shape::Hull;

const ASPECT: Range = Range { min: 0.1, max: 1.0 };

pub(super) static BOULDERS_KEYS: Spec = Spec {
    name: "boulders",
    about: "A family of convex boulders, no two alike, centred on their centres of mass. A generator picks one of them \
            for each body.",
    example: r#"[shapes.rocks]
kind = "boulders"
count = 48
radius = [0.2, 1]
distribution = "power-law"
"#,
    groups: &[
        &[
            key("count", Ty::Int(1, 4096), "24", "Boulders in the family."),
            key("radius", Ty::Interval(POSITIVE), "[0.3, 1.2]", "Radius of the ball of the same volume, m."),
            key("points", Ty::IntInterval(6, 64), "[12, 20]", "Corners."),
            key(
                "aspect",
                Ty::Interval(ASPECT),
                "[0.6, 0.95]",
                "Ratio of the middle axis to the longest, and of the shortest to the middle one.",
            ),
            key(
                "roughness",
                Ty::Number(SHARE),
                "0.12",
                "How far corners are moved in or out, as a share of the radius.",
            ),
            key("cuts", Ty::Int(0, 16), "3", "Planes that cut a piece off."),
        ],
        DISTRIBUTION,
        LOOK,
    ],
};

pub(super) static BOULDERS: ShapeKind = ShapeKind {
    spec: &BOULDERS_KEYS,
    immovable: false,
    ground: false,
    members: |table| table.int("count"),
    memory: |table| table.int("count") * (64 + 64 * table.ints("points")[1]),
    check: super::nothing_to_check,
    cook,
};

fn cook(table: &Table, context: &Cook) -> Result<Vec<Shape>, Problem> {
    let (min, max) = table.pair("radius");
    let count = table.int("count") as usize;
    let radii = Sizes::read(table, min, max).classes(count);
    let make = |(k, radius): (usize, f64)| {
        let mut random = Random::new(context.seed, &format!("{}.{k}", table.path));
        boulder(table, radius, &mut random).map_err(|e| super::failed(table, "radius", e))
    };
    radii.into_iter().enumerate().map(make).collect()
}

fn boulder(table: &Table, radius: f64, random: &mut Random) -> Result<Shape, rockfall_shape::HullError> {
    let points = table.ints("points");
    let (fewest, most) = (points[0] as usize, points[1] as usize);
    let wanted = fewest + random.below(most - fewest + 1);
    let (low, high) = table.pair("aspect");
    let middle = random.within(low, high);
    let axes = DVec3::new(1.0, middle, middle * random.within(low, high));
    let cuts = table.int("cuts");
    let mut roughness = table.f64("roughness");
    let mut spread = wanted;
    // Points that end up inside the hull are no corners; so another try spreads more points, or roughens less.
    for _ in 0..32 {
        let hull = Hull::from_points(&stone(axes, spread, roughness, cuts, random))?;
        let corners = hull.vertices.len();
        if (fewest..=most).contains(&corners) {
            return finish(&hull, radius);
        }
        spread = if corners < fewest { spread + 1 } else { wanted };
        roughness *= 0.9;
    }
    // Every point of an ellipsoid is a corner.
    finish(&Hull::from_points(&stone(axes, wanted, 0.0, 0, random))?, radius)
}

/// Points of a stone of about unit size.
fn stone(axes: DVec3, count: usize, roughness: f64, cuts: u64, random: &mut Random) -> Vec<Vec3> {
    // Evenly spread directions: a spiral whose turns keep the golden angle, with some jitter.
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let step = 2.0 / count as f64;
    let turn = random.within(0.0, std::f64::consts::TAU);
    let mut points: Vec<DVec3> = (0..count)
        .map(|k| {
            let z = (1.0 - step * (k as f64 + random.within(0.2, 0.8))).clamp(-1.0, 1.0);
            let (sin, cos) = libm::sincos(turn + golden * (k as f64 + random.within(-0.3, 0.3)));
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z) * axes * (1.0 + roughness * random.within(-1.0, 1.0))
        })
        .collect();
    for _ in 0..cuts {
        let normal = direction(random);
        let reach = points.iter().map(|p| p.dot(normal)).fold(0.0, f64::max);
        let plane = reach * random.within(0.7, 0.92);
        for p in &mut points {
            let out = p.dot(normal) - plane;
            if out > 0.0 {
                *p -= out * normal;
            }
        }
    }
    points.into_iter().map(DVec3::as_vec3).collect()
}

/// Uniform over the unit sphere.
fn direction(random: &mut Random) -> DVec3 {
    let z = random.within(-1.0, 1.0);
    let (sin, cos) = libm::sincos(random.within(0.0, std::f64::consts::TAU));
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// Scales a hull to the volume of a ball of `radius` around its centre of mass.
fn finish(hull: &Hull, radius: f64) -> Result<Shape, rockfall_shape::HullError> {
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    let scale = radius * libm::cbrt(ball / volume(hull));
    let centre = hull.center.as_dvec3();
    let corners: Vec<Vec3> =
        hull.vertices.iter().map(|v| ((v.as_dvec3() - centre) * scale).as_vec3()).collect();
    hull::cook(&corners, corners.len()).map(Shape::Hull)
}

/// m³, from the tetrahedra between the centre and the triangles of the faces.
fn volume(hull: &Hull) -> f64 {
    let from_centre = |i: u32| (hull.vertices[i as usize] - hull.center).as_dvec3();
    let face = |f: usize| {
        let corners = hull.face(f);
        let first = from_centre(corners[0]);
        corners.windows(2).map(|e| first.dot(from_centre(e[0]).cross(from_centre(e[1])))).sum::<f64>()
    };
    (0..hull.normals.len()).map(face).sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn boulders_have_their_corners_volume_and_centre_and_differ() {
        let text = "[shapes.rocks]\nkind = \"boulders\"\ncount = 40\nradius = [0.5, 2]\npoints = [12, 20]\n\
            [[generators]]\nkind = \"grid\"\nshape = \"rocks\"\ncount = [20, 20, 1]\nspacing = [9, 9, 9]\n";
        let plan = Scene::parse(text, "rocks.toml", ".").unwrap().plan().unwrap();
        assert_eq!(plan.shapes.len(), 40);
        let mut radii = Vec::new();
        for shape in &plan.shapes {
            let Shape::Hull(hull) = shape else { panic!("a boulder is a hull") };
            assert!((12..=20).contains(&hull.vertices.len()), "{}", hull.vertices.len());
            assert!(hull.center.length() < 1e-3);
            radii.push(libm::cbrt(volume(hull) / (4.0 / 3.0 * std::f64::consts::PI)));
            let longest = hull.vertices.iter().map(|v| v.length()).fold(0.0, f32::max);
            assert!(f64::from(longest) < 2.5 * radii[radii.len() - 1], "not a needle");
        }
        radii.sort_by(f64::total_cmp);
        // Uniform over 40 classes: 0.5 + 1.5 (k + ½) / 40.
        for (k, radius) in radii.iter().enumerate() {
            assert!((radius - (0.5 + 1.5 * (k as f64 + 0.5) / 40.0)).abs() < 1e-4);
        }
    }
}
