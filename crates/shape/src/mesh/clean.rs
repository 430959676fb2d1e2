//! One vertex per place, no triangle without area, none twice.

use super::MeshReport;
use rockfall_math::{DVec3, Vec3};

/// Height of a triangle over its longest edge, as a part of that edge, below which its normal is rounding.
const THINNEST: f64 = 1e-7;

/// Twice the area along the normal, m².
pub(super) fn doubled_area(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    (b - a).cross(c - a)
}

/// The vertices and triangles that matter, in their order.
pub(super) fn clean(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    report: &mut MeshReport,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let first = weld(vertices);
    let welded: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|c| first[c as usize])).collect();
    let mut keep: Vec<bool> = welded.iter().map(|t| has_area(t.map(|c| vertices[c as usize]))).collect();
    report.degenerate_triangles = keep.iter().filter(|k| !**k).count();
    report.duplicate_triangles = drop_twins(&welded, &mut keep);

    let mut names = vec![u32::MAX; vertices.len()];
    let kept = || welded.iter().zip(&keep).filter(|(_, k)| **k).map(|(t, _)| *t);
    kept().flatten().for_each(|c| names[c as usize] = 0);
    let mut used = Vec::new();
    for (name, vertex) in names.iter_mut().zip(vertices) {
        if *name == 0 {
            *name = used.len() as u32;
            // Adding zero turns -0 into 0.
            used.push(*vertex + Vec3::ZERO);
        }
    }
    report.dropped_vertices = vertices.len() - used.len();
    (used, kept().map(|t| t.map(|c| names[c as usize])).collect())
}

/// For each vertex the first one with the same coordinates.
fn weld(vertices: &[Vec3]) -> Vec<u32> {
    let key = |i: u32| (vertices[i as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (key(i), i));
    let mut first = vec![0; vertices.len()];
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        same.iter().for_each(|&i| first[i as usize] = same[0]);
    }
    first
}

fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    doubled_area(corners).length() > THINNEST * longest
}

/// Unmarks all but the first of triangles with the same corners in the same orientation, and counts the
/// others.
fn drop_twins(triangles: &[[u32; 3]], keep: &mut [bool]) -> usize {
    let key = |t: &[u32; 3]| {
        let mut turned = *t;
        turned.rotate_left((0..3).min_by_key(|&i| t[i]).unwrap_or(0));
        turned
    };
    let mut order: Vec<([u32; 3], u32)> =
        triangles.iter().enumerate().filter(|(i, _)| keep[*i]).map(|(i, t)| (key(t), i as u32)).collect();
    order.sort_unstable();
    let mut twins = 0;
    for pair in order.windows(2).filter(|p| p[0].0 == p[1].0) {
        keep[pair[1].1 as usize] = false;
        twins += 1;
    }
    twins
}
