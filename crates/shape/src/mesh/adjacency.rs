//! Which triangles share an edge, and how the surface bends there.

use super::{EdgeKind, MeshReport};
use rockfall_math::{DVec3, Vec3};

/// Two triangles at a smaller angle than this lie in one plane: sine of a thousandth of a radian.
const FLAT: f64 = 1e-3;

/// Kind and neighbour of each edge of each triangle.
pub(super) fn join(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    normals: &[DVec3],
    report: &mut MeshReport,
) -> (Vec<[EdgeKind; 3]>, Vec<[u32; 3]>) {
    let mut kinds = vec![[EdgeKind::Boundary; 3]; triangles.len()];
    let mut neighbours = vec![[u32::MAX; 3]; triangles.len()];
    // Low corner, high corner, triangle and side packed as 3 t + i.
    let mut halves: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (t, c) in triangles.iter().enumerate() {
        halves.extend((0..3).map(|i| {
            let (u, v) = (c[i], c[(i + 1) % 3]);
            (u.min(v), u.max(v), (3 * t + i) as u32)
        }));
    }
    halves.sort_unstable();
    for edge in halves.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let side = |k: usize| (edge[k].2 as usize / 3, edge[k].2 as usize % 3);
        if edge.len() == 1 {
            report.open_edges += 1;
            continue;
        }
        let ((s, i), (t, j)) = (side(0), side(1));
        // Neighbours that agree in orientation run through their edge in opposite directions.
        if edge.len() > 2 || triangles[s][i] == triangles[t][j] {
            report.tangled_edges += 1;
            continue;
        }
        let start = vertices[triangles[s][i] as usize].as_dvec3();
        let end = vertices[triangles[s][(i + 1) % 3] as usize].as_dvec3();
        let kind = bend(normals[s], normals[t], end - start);
        (kinds[s][i], kinds[t][j]) = (kind, kind);
        (neighbours[s][i], neighbours[t][j]) = (t as u32, s as u32);
    }
    (kinds, neighbours)
}

/// How the surface bends at the edge `along`, counter-clockwise around the triangle with normal `n`, towards
/// the one with normal `m`.
fn bend(n: DVec3, m: DVec3, along: DVec3) -> EdgeKind {
    let turn = n.cross(m);
    let sharp = turn.length() > FLAT;
    if n.dot(m) > 0.0 && !sharp {
        EdgeKind::Flat
    } else if sharp && turn.dot(along) < 0.0 {
        EdgeKind::Concave
    } else {
        // Triangles folded back to back meet in a knife's edge.
        EdgeKind::Convex
    }
}
