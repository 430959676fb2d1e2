//! Whether a mesh has a clear inside.
//!
//! On which side of the surface a point lies is told by what of it is nearest; where parts of a mesh cross or lie within each other, that part may show its outside within another. How often the whole surface goes
//! around the point knows better. The two are compared an error off the surface, on both sides of each sample.

use super::{FieldError, Samples};
use crate::Mesh;
use rayon::prelude::*;
use rockfall_math::Vec3;

/// Points nearer to the surface than this share of the error, because it bends or is thin there, are left out.
const NEAR: f64 = 0.5;

/// Compares both answers next to all samples.
pub(super) fn check(mesh: &Mesh, samples: &Samples, error: f32) -> Result<(), FieldError> {
    let agree = |p: Vec3| {
        let p = p.as_dvec3();
        let distance = mesh.nearest(p, f64::from(error) * 1.01).map_or(f64::NAN, |near| near.distance);
        // A point that is nowhere near, or that no ray can be cast from, says nothing.
        let says = distance.abs() > NEAR * f64::from(error);
        !says || mesh.winding(p).is_none_or(|turns| turns == i32::from(distance < 0.0))
    };
    let points = samples.points();
    let wrong: Vec<Vec3> = points
        .par_iter()
        .flat_map_iter(|s| [error, -error].map(|off| s.position + off * s.normal))
        .filter(|&p| !agree(p))
        .collect();
    match wrong.first() {
        Some(&at) => Err(FieldError::Crossed { count: wrong.len(), of: 2 * points.len(), at }),
        None => Ok(()),
    }
}
