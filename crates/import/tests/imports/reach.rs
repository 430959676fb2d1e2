//! How far bodies reach along directions of the world: what two readers of one file must agree on.

use rockfall_import::{Body, Content, Geometry};
use rockfall_math::{DMat3, DQuat, DVec3, Pose, Vec3};

/// The support of a body along the unit vector `d`, m.
pub(crate) fn reach(content: &Content, body: &Body, d: DVec3) -> f64 {
    let parts = &content.shapes[body.shape as usize];
    let part = |part: &rockfall_import::Part| {
        let geometry = &content.geometries[part.geometry as usize];
        let (inner, outer) = (turn(&part.pose), turn(&body.pose));
        let origin = body.pose.position + outer * part.pose.position;
        d.dot(origin) + local(geometry, (outer * inner).transpose() * d)
    };
    parts.iter().map(part).fold(f64::NEG_INFINITY, f64::max)
}

fn turn(pose: &Pose) -> DMat3 {
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    DMat3::from_quat(DQuat::from_xyzw(x, y, z, w))
}

fn local(geometry: &Geometry, e: DVec3) -> f64 {
    let f = f64::from;
    let across = (e.x * e.x + e.y * e.y).sqrt();
    let farthest =
        |points: &[Vec3]| points.iter().map(|p| e.dot(p.as_dvec3())).fold(f64::NEG_INFINITY, f64::max);
    match geometry {
        Geometry::Sphere { radius } => f(*radius) * e.length(),
        Geometry::Box { half } => half.as_dvec3().dot(e.abs()),
        Geometry::Ellipsoid { half } => (half.as_dvec3() * e).length(),
        Geometry::Capsule { half_length, radius } => f(*half_length) * e.z.abs() + f(*radius) * e.length(),
        Geometry::Cone { half_length, lower, upper } => {
            let end = |z: f64, r: &f32| z * e.z + f(*r) * across;
            end(f(*half_length), upper).max(end(-f(*half_length), lower))
        }
        Geometry::HalfSpace => f64::INFINITY,
        Geometry::Hull(points) => farthest(points),
        Geometry::Mesh(soup) | Geometry::Decomposition { soup, .. } | Geometry::Field { soup, .. } => {
            farthest(&soup.vertices)
        }
    }
}

/// The 26 directions to the neighbours of a cube, x the slowest.
pub(crate) fn directions() -> Vec<DVec3> {
    let step = |k: i32| f64::from(k % 3 - 1);
    let all = (0..27).map(|k| DVec3::new(step(k / 9), step(k / 3), step(k)));
    all.filter(|d| *d != DVec3::ZERO).map(DVec3::normalize).collect()
}
