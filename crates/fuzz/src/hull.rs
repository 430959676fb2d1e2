//! Hulls of any points.

use crate::Bytes;
use rockfall_math::{DVec3, Vec3};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;

/// Points from `bytes`: there is an error, or a hull that passes its own check, has a mass, and holds all of the points.
pub fn hull(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let base = bytes.vector();
    // Clusters, copies, points of a plane or a line.
    let way = bytes.byte();
    let squash = match way % 5 {
        0 => Vec3::new(1.0, 1.0, 1e-7),
        1 => Vec3::new(1.0, 1e-7, 1e-7),
        2 => Vec3::splat(1e-6),
        3 => Vec3::splat(1e5),
        _ => Vec3::ONE,
    };
    let mut points = Vec::new();
    while !bytes.is_empty() && points.len() < 400 {
        let point = bytes.vector() * squash;
        points.push(if way & 16 == 0 { point } else { base + point });
        if way & 32 != 0 && points.len() % 3 == 0 {
            points.push(points[points.len() / 2]);
        }
    }
    let Ok(hull) = Hull::from_points(&points) else { return };
    hull.check().expect("a hull that was made passes its check");
    assert!(hull.inner_radius > 0.0 && hull.inner_radius.is_finite());
    // Coplanar to a millionth of the extent, with the rounding of the points.
    let size = points.iter().fold(0.0_f32, |far, p| far.max(p.abs().max_element()));
    let slack = 1e-5 * f64::from(size);
    for (&normal, &offset) in hull.normals.iter().zip(&hull.offsets) {
        for p in &points {
            let height = DVec3::from(*p).dot(normal.into()) - f64::from(offset);
            assert!(height <= slack, "{p} is {height} m outside of a hull of {size} m");
        }
    }
    let shape = Shape::Hull(Arc::new(hull));
    if shape.validate().is_ok() {
        let mass = shape.mass_properties(1000.0).expect("a hull has an inside");
        assert!(mass.mass > 0.0 && mass.center.is_finite(), "{mass:?}");
    }
}
