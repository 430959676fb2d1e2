//! The cut itself: voxels by `parry3d`, hulls by us.

use crate::{DecomposeError, Options};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{Hull, Mesh, Shape};
use std::sync::Arc;

/// A piece whose inner ball is smaller than this share of a voxel is a splinter that the cut left over.
const SPLINTER: f32 = 0.25;

/// The hulls of the pieces of a mesh, at least one. Splinters are left out; what that leaves open is measured with the rest.
/// `volume` is that of the mesh: where it fills its hull, that is all.
pub(crate) fn cut(mesh: &Mesh, volume: f32, options: &Options) -> Result<Vec<Hull>, DecomposeError> {
    if let Ok(hull) = Hull::from_points_at_most(&mesh.vertices, options.max_vertices as usize) {
        let whole = Shape::Hull(Arc::new(hull.clone())).mass_properties(1.0).map_or(0.0, |mass| mass.mass);
        if (whole - volume).abs() <= options.concavity * whole {
            return Ok(vec![hull]);
        }
    }
    // At a size of about 1, so that scale is of no account; by a power of two, so that nothing is rounded.
    let longest = 2.0 * mesh.bounds.half_extents().max_element();
    let scale = power_of_two_below(longest);
    let points: Vec<Vec3> = mesh.vertices.iter().map(|v| *v / scale).collect();
    let pieces = pieces(&points, &mesh.triangles, options).ok_or(DecomposeError::Cut(options.resolution))?;
    let voxel = longest / options.resolution as f32;
    let hull = |points: Vec<Vec3>| {
        let points: Vec<Vec3> = points.into_iter().map(|p| p * scale).collect();
        Hull::from_points_at_most(&points, options.max_vertices as usize).ok()
    };
    let hulls: Vec<Hull> = pieces.into_iter().filter_map(hull).collect();
    let thickest = hulls.iter().fold(0.0_f32, |most, hull| most.max(hull.inner_radius));
    let least = (SPLINTER * voxel).min(thickest);
    let hulls: Vec<Hull> = hulls.into_iter().filter(|hull| hull.inner_radius >= least).collect();
    if hulls.is_empty() { Err(DecomposeError::Flat) } else { Ok(hulls) }
}

/// The points of the surface in each piece.
fn pieces(points: &[Vec3], triangles: &[[u32; 3]], options: &Options) -> Option<Vec<Vec<Vec3>>> {
    let params = VHACDParameters {
        resolution: options.resolution,
        concavity: options.concavity,
        max_convex_hulls: halvings(options.max_hulls),
        ..VHACDParameters::default()
    };
    // It unwraps the hull of a set of voxels, which may be empty or flat: its panic becomes our error.
    let cut = || {
        let whole = VHACD::decompose(&params, points, triangles, true);
        let pieces = whole.compute_primitive_intersections(points, triangles);
        let voxels = whole.voxel_parts().iter();
        // A piece that lies all inside touches no triangle: then its voxels serve.
        pieces
            .into_iter()
            .zip(voxels)
            .map(|(surface, voxels)| {
                let inside = Aabb::from_points(surface.iter().copied());
                if inside.is_valid() { surface } else { voxels.compute_convex_hull(1).0 }
            })
            .collect()
    };
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(cut)).ok()
}

/// The number of hulls to ask for, so that no more than `most` come: it halves once more than that number needs, and merges nothing.
fn halvings(most: u32) -> u32 {
    1 << (most.max(4).ilog2() - 1)
}

/// The largest power of two that is not above `x`.
fn power_of_two_below(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0x7f80_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halvings_keep_to_the_limit() {
        // It makes twice as many as the power of two from the number asked for on, at least 4.
        for (most, asked) in [(4, 2), (5, 2), (8, 4), (16, 8), (31, 8), (32, 16), (1024, 512)] {
            assert_eq!(halvings(most), asked);
        }
    }

    #[test]
    fn powers_of_two() {
        for (x, below) in [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (0.3, 0.25), (1000.0, 512.0)] {
            assert_eq!(power_of_two_below(x), below);
        }
    }
}
